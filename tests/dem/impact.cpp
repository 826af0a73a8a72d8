// tests/dem/impact.cpp: impacts against closed forms, conservation laws, springs and symmetry.
#include "dem/impact/impact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "dem/impact_support.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::impact_tests {
namespace {

TEST(Impact, of_a_sphere_and_a_wall_has_the_given_restitution_and_friction_at_every_angle) {
    // Rigid sphere: J = (1 + e) m v_n; friction mu J along the slip, or m slip/(1 + m R^2/I) = 2/7 m slip when that is
    // less.
    constexpr double e = 0.3, radius = 0.4;
    for (const double mu : {0.0, 0.05, 0.3, 10.0})
        for (double angle = 0.0; angle < 1.55; angle += 0.05) {
            const Vector before{50.0 * std::sin(angle), 0.0, -50.0 * std::cos(angle)};
            ImpactBody m = impact_body(the_bead);
            m.velocity = before;
            Contact contact{.first = 0,
                            .normal = {0.0, 0.0, 1.0},
                            .arm_first = {0.0, 0.0, -radius},
                            .restitution = e,
                            .friction = mu};
            resolve({&m, 1}, {&contact, 1}, {});
            const double slide = mu * (1.0 + e) * 50.0 * std::cos(angle), stick = 2.0 / 7.0 * before.x;
            EXPECT_NEAR(m.velocity.z, e * 50.0 * std::cos(angle), 1e-12);
            EXPECT_NEAR(m.velocity.x, before.x - std::min(slide, stick), 1e-12);
            EXPECT_NEAR(m.spin.y, the_bead.mass * radius * std::min(slide, stick) / the_bead.inertia_along, 1e-10);
        }
}

/// The planar impact of Stronge in closed form: velocities are linear in the normal impulse while the slip keeps its
/// direction, the work is quadratic.  w: response; u, v: slip and normal velocity before.  Returns slip and normal
/// velocity after.
std::array<double, 2> planar_impact(double nn, double nx, double xx, double u, double v, double e, double mu) {
    double work = 0.0, taken = 0.0;
    bool pressing = true;
    for (int phase = 0; phase < 10; ++phase) {
        double du = 0.0, dv = 0.0;  // per normal impulse
        const double s = u > 1e-13 ? 1.0 : u < -1e-13 ? -1.0 : 0.0;
        if (s == 0.0 && std::abs(nx / xx) <= mu) {
            dv = nn - nx * nx / xx;
        } else {
            const double direction = s != 0.0 ? s : (nx > 0.0 ? 1.0 : -1.0);
            du = nx - direction * mu * xx;
            dv = nn - direction * mu * nx;
        }
        double dp = 1e300;
        if (s != 0.0 && du * s < 0.0) dp = -u / du;
        if (pressing) dp = std::min(dp, -v / dv);
        else dp = std::min(dp, (-v + std::sqrt(v * v + 2.0 * dv * (e * e * taken - work))) / dv);
        const bool ends_phase = pressing ? dp == -v / dv : false;
        const double done = dp * (v + 0.5 * dv * dp);
        u = s != 0.0 && dp == -u / du ? 0.0 : u + du * dp;
        v += dv * dp;
        work += done;
        if (ends_phase) {
            taken = -work;
            work = 0.0;
            v = 0.0;
            pressing = false;
        } else if (!pressing && work >= e * e * taken * (1.0 - 1e-12)) {
            break;
        }
    }
    return {u, v};
}

TEST(Impact, of_a_rod_end_and_a_plate_is_stronges_planar_impact_with_sticking_and_slip_reversal) {
    // The slip keeps its line, and increments end where it stops: to an increment's error of 1e-4 of 20 mm/s.
    const double a = the_rod.at[0], r = the_rod.radius[0], m = the_rod.mass, i = the_rod.inertia_across;
    int reversed = 0, stuck = 0;
    for (const double mu : {0.01, 0.03, 0.1, 0.3, 1.0})
        for (const double e : {0.0, 0.1, 0.5, 1.0})
            for (double slip = -30.0; slip <= 30.0; slip += 2.5) {
                ImpactBody rod = impact_body(the_rod);
                rod.velocity = {slip, 0.0, -20.0};
                Contact contact = on_plate(rod, 0, e, mu);
                // Arm (a, 0, -r): a unit normal impulse turns the rod by -a/I about y, which moves the place of contact
                // along x by a r/I.
                const auto [u, v] =
                    planar_impact(1.0 / m + a * a / i, a * r / i, 1.0 / m + r * r / i, slip, -20.0, e, mu);
                resolve({&rod, 1}, {&contact, 1}, {});
                const Vector after = relative_velocity(contact, {&rod, 1});
                EXPECT_NEAR(after.x, u, 2e-3) << "mu " << mu << " e " << e << " slip " << slip;
                EXPECT_NEAR(after.z, v, 2e-3) << "mu " << mu << " e " << e << " slip " << slip;
                reversed += u * slip < 0.0 ? 1 : 0;
                stuck += std::abs(u) < 1e-9 ? 1 : 0;
            }
    EXPECT_GT(reversed, 20);  // both regimes were met
    EXPECT_GT(stuck, 20);
}

TEST(Impact, without_friction_has_restitution_e_for_every_kind_of_restitution) {
    for (const RestitutionKind kind :
         {RestitutionKind::energetic, RestitutionKind::kinetic, RestitutionKind::kinematic})
        for (const double e : {0.0, 0.1, 0.3, 1.0}) {
            ImpactBody rod = impact_body(the_rod, {0.8, 0.0, 0.6});
            rod.velocity = {3.0, 1.0, -20.0};
            rod.spin = {1.0, 5.0, 2.0};
            Contact contact = on_plate(rod, 12, e, 0.0);
            const double before = relative_velocity(contact, {&rod, 1}).z;
            resolve({&rod, 1}, {&contact, 1}, {.restitution = kind});
            EXPECT_NEAR(relative_velocity(contact, {&rod, 1}).z, -e * before, 1e-11);
        }
}

TEST(Impact, kinds_of_restitution_differ_once_the_slip_turns) {
    // Stronge (2000), fig. 3.9: energetic, kinetic and kinematic agree unless the slip stops or reverses.
    const auto after = [](RestitutionKind kind, double slip) {
        ImpactBody rod = impact_body(the_rod);
        rod.velocity = {slip, 0.0, -20.0};
        Contact contact = on_plate(rod, 0, 0.5, 0.3);
        resolve({&rod, 1}, {&contact, 1}, {.restitution = kind});
        return relative_velocity(contact, {&rod, 1}).z;
    };
    // Slides all the way: the same straight line of (v, p) under all three.
    EXPECT_NEAR(after(RestitutionKind::energetic, 200.0), after(RestitutionKind::kinematic, 200.0), 1e-9);
    EXPECT_NEAR(after(RestitutionKind::kinetic, 200.0), after(RestitutionKind::kinematic, 200.0), 1e-9);
    EXPECT_GT(std::abs(after(RestitutionKind::energetic, 4.0) - after(RestitutionKind::kinematic, 4.0)), 0.05);
}

/// Random bodies and contacts between them, with mixed e and mu, some with moving walls.
struct Heap {
    std::vector<ImpactBody> bodies;
    std::vector<Contact> contacts;
};
Heap heap(Drawn& drawn, std::size_t bodies, std::size_t contacts, bool walls) {
    Heap result;
    for (std::size_t b = 0; b < bodies; ++b) {
        ImpactBody m = impact_body(drawn() > 0.0 ? the_rod : the_bead, drawn.direction());
        m.velocity = drawn.vector(30.0);
        m.spin = drawn.vector(10.0);
        result.bodies.push_back(m);
    }
    const Vector plates =
        drawn.vector(walls ? 50.0 : 0.0);  // all walls move together: two that close in on a body leave it no way out
    for (std::size_t c = 0; c < contacts; ++c) {
        Contact contact{.first = static_cast<int>(c % bodies),
                        .second = walls && c % 3 == 0 ? -1 : static_cast<int>((c + 1 + c / bodies) % bodies)};
        if (contact.second == contact.first) contact.second = -1;
        contact.normal = drawn.direction();
        contact.arm_first = drawn.vector(1.0) - 0.5 * contact.normal;
        contact.arm_second = drawn.vector(1.0) + 0.5 * contact.normal;
        if (contact.second < 0) contact.wall_velocity = plates;
        contact.restitution = 0.5 + 0.5 * drawn();
        contact.friction = drawn() > 0.7 ? 10.0 : 0.3 + 0.3 * drawn();
        result.contacts.push_back(contact);
    }
    return result;
}

TEST(ImpactGroup, gains_energy_only_from_moving_walls_with_mixed_restitution_and_friction) {
    Drawn drawn(1);
    int unresolved = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        Heap h = heap(drawn, 1 + static_cast<std::size_t>(trial % 7), 1 + static_cast<std::size_t>(trial % 11), true);
        double before = 0.0, after = 0.0;
        for (const ImpactBody& m : h.bodies) before += energy_kinetic(m);
        const ImpactOutcome outcome = resolve(h.bodies, h.contacts, {});
        for (const ImpactBody& m : h.bodies) after += energy_kinetic(m);
        const double scale = before + std::abs(outcome.walls);
        EXPECT_LE(outcome.normal, 1e-12 * scale) << trial;
        EXPECT_LE(outcome.friction, 1e-12 * scale) << trial;
        EXPECT_NEAR(after - before, outcome.walls + outcome.normal + outcome.friction, 1e-11 * scale) << trial;
        unresolved += outcome.residual > 1e-3 * outcome.approach ? 1 : 0;
    }
    EXPECT_LE(unresolved,
              40);  // random arms and normals with mu = 10 sometimes jam, and the outcome reports it
}

TEST(ImpactGroup, without_restitution_and_with_strong_friction_stays_finite_and_gains_no_energy) {
    // Friction can press a contact that has just turned: with e = 0 there is no work to give back, and none is divided
    // by e^2.
    Drawn drawn(12);
    for (int trial = 0; trial < 2000; ++trial) {
        Heap h = heap(drawn, 1 + static_cast<std::size_t>(trial % 5), 2 + static_cast<std::size_t>(trial % 7), true);
        for (Contact& contact : h.contacts) {
            contact.restitution = 0.0;
            contact.friction = 0.5 + 0.5 * static_cast<double>(trial % 4);
        }
        double before = 0.0, after = 0.0;
        for (const ImpactBody& body : h.bodies) before += energy_kinetic(body);
        const ImpactOutcome outcome = resolve(h.bodies, h.contacts, {});
        for (const ImpactBody& body : h.bodies) after += energy_kinetic(body);
        ASSERT_TRUE(std::isfinite(after)) << trial;
        const double scale = before + std::abs(outcome.walls);
        EXPECT_LE(outcome.normal, 1e-12 * scale) << trial;
        EXPECT_LE(outcome.friction, 1e-12 * scale) << trial;
        EXPECT_NEAR(after - before, outcome.walls + outcome.normal + outcome.friction, 1e-11 * scale) << trial;
    }
}

TEST(ImpactGroup, conserves_momentum_and_angular_momentum) {
    // Places of contact that both bodies share: momentum about the origin is kept too.
    Drawn drawn(2);
    for (int trial = 0; trial < 200; ++trial) {
        Heap h = heap(drawn, 4, 6, false);
        std::vector<Vector> centres;
        for (std::size_t b = 0; b < 4; ++b) centres.push_back(drawn.vector(3.0));
        std::erase_if(h.contacts, [](const Contact& c) { return c.second < 0; });
        for (Contact& c : h.contacts)
            c.arm_second =
                centres[static_cast<std::size_t>(c.first)] + c.arm_first - centres[static_cast<std::size_t>(c.second)];
        const auto total = [&] {
            std::array<Vector, 2> sums;
            for (std::size_t b = 0; b < 4; ++b) {
                const Vector p = 1.0 / h.bodies[b].mass_inverse * h.bodies[b].velocity;
                sums[0] = sums[0] + p;
                sums[1] = sums[1] + momentum_angular(h.bodies[b]) + cross(centres[b], p);
            }
            return sums;
        };
        const auto before = total();
        resolve(h.bodies, h.contacts, {});
        const auto after = total();
        EXPECT_LT(length(after[0] - before[0]), 1e-12 * 3000.0);  // 4 bodies of 27 mg at 30 mm/s
        EXPECT_LT(length(after[1] - before[1]), 1e-12 * 10000.0);
    }
}

/// Springs in time, with a step far below any of their periods: the same bodies and stiffnesses, an independent method.
void springs(std::vector<ImpactBody>& bodies, const std::vector<Contact>& contacts) {
    std::vector<double> force(contacts.size(), 0.0);
    constexpr double h = 2e-4;
    for (int step = 0; step < 2000000; ++step) {
        bool any = false;
        for (std::size_t c = 0; c < contacts.size(); ++c) {
            const double v = dot(relative_velocity(contacts[c], bodies), contacts[c].normal);
            const double e2 = contacts[c].restitution * contacts[c].restitution;
            force[c] = std::max(0.0, force[c] - h * v / (v < 0.0 ? 1.0 : e2));
            any = any || force[c] > 1e-6 || v < -1e-3;
        }
        if (!any) return;
        for (std::size_t c = 0; c < contacts.size(); ++c) {
            ImpactBody& a = bodies[static_cast<std::size_t>(contacts[c].first)];
            const Vector p = h * force[c] * contacts[c].normal;
            a.velocity = a.velocity + a.mass_inverse * p;
            if (contacts[c].second < 0) continue;
            ImpactBody& b = bodies[static_cast<std::size_t>(contacts[c].second)];
            b.velocity = b.velocity - b.mass_inverse * p;
        }
    }
    FAIL() << "the springs did not come to rest";
}

TEST(ImpactGroup, of_frictionless_balls_in_a_row_agrees_with_springs_of_equal_stiffness) {
    for (const double e : {1.0, 0.5, 0.2}) {
        std::vector<ImpactBody> bodies(5, impact_body(the_bead));
        bodies[0].velocity = {-40.0, 0.0, 0.0};
        bodies[4].velocity = {25.0, 0.0, 0.0};
        std::vector<Contact> contacts;
        for (int c = 0; c < 4; ++c)
            contacts.push_back({.first = c,
                                .second = c + 1,
                                .normal = {1.0, 0.0, 0.0},
                                .arm_first = {-0.4, 0.0, 0.0},
                                .arm_second = {0.4, 0.0, 0.0},
                                .restitution = e});
        auto expected = bodies;
        springs(expected, contacts);
        // Sweeps of second order, some ten for the shortest quarter of a period: a part in a hundred.
        resolve(bodies, contacts, {.increments = 64, .inelastic_threshold = 0.0});
        for (std::size_t b = 0; b < bodies.size(); ++b)
            EXPECT_NEAR(bodies[b].velocity.x, expected[b].velocity.x, 0.01 * 40.0) << "ball " << b << " e " << e;
    }
}

TEST(ImpactGroup, does_not_depend_on_the_order_of_the_contacts) {
    // A rod on its tail and its middle, and a bead on it: all orders against the first, within the second order of an
    // increment.
    Drawn drawn(3);
    double worst = 0.0;
    for (int trial = 0; trial < 50; ++trial) {
        ImpactBody rod = impact_body(the_rod);
        rod.velocity = drawn.vector(10.0) - Vector{0.0, 0.0, 20.0};
        rod.spin = drawn.vector(3.0);
        ImpactBody bead = impact_body(the_bead);
        bead.velocity = {0.0, 0.0, -30.0};
        std::vector<Contact> contacts{on_plate(rod, 0, 0.1, 0.03), on_plate(rod, 6, 0.1, 0.03)};
        contacts.push_back({.first = 1,
                            .second = 0,
                            .normal = {0.0, 0.0, 1.0},
                            .arm_first = {0.0, 0.0, -0.4},
                            .arm_second = {1.0, 0.0, 0.36},
                            .restitution = 0.3,
                            .friction = 0.05});
        std::vector<int> order{0, 1, 2};
        std::vector<ImpactBody> first;
        do {
            std::vector<ImpactBody> bodies{rod, bead};
            std::vector<Contact> shuffled;
            for (const int c : order) shuffled.push_back(contacts[static_cast<std::size_t>(c)]);
            resolve(bodies, shuffled, {});
            if (first.empty()) first = bodies;
            for (std::size_t b = 0; b < 2; ++b) worst = std::max(worst, length(bodies[b].velocity - first[b].velocity));
        } while (std::next_permutation(order.begin(), order.end()));
    }
    EXPECT_LT(worst, 0.02 * 50.0);  // 2 % of the largest approach; one contact after another differs by tens of percent
}

TEST(ImpactGroup, with_default_increments_stays_close_to_many_increments) {
    // A rod on a plate between two beads, one of which comes.  Energies of the difference and of what the impact
    // changed, over many: eight increments and the end of slow approaches cost a few percent of a velocity; another law
    // costs tens.
    Drawn drawn(5);
    const auto apart = [&](const ImpactLaw& law) {
        double difference = 0.0, change = 0.0;
        for (int trial = 0; trial < 200; ++trial) {
            ImpactBody rod = impact_body(the_rod), one = impact_body(the_bead), two = impact_body(the_bead);
            rod.velocity = drawn.vector(10.0) - Vector{0.0, 0.0, 20.0};
            rod.spin = drawn.vector(3.0);
            one.velocity = Vector{-30.0, 0.0, 0.0} + drawn.vector(10.0);
            std::vector<Contact> contacts{on_plate(rod, 0, 0.1, 0.03), on_plate(rod, 6, 0.1, 0.03)};
            for (const int bead : {1, 2}) {
                const double side = bead == 1 ? 1.0 : -1.0, along = 2.0 * drawn();
                const Vector normal{0.0, side, 0.0};
                contacts.push_back({.first = bead,
                                    .second = 0,
                                    .normal = normal,
                                    .arm_first = -0.4 * normal,
                                    .arm_second = Vector{along, 0.5 * side, 0.0},
                                    .restitution = 0.3,
                                    .friction = 0.05});
            }
            one.velocity.y = -30.0;
            const std::vector<ImpactBody> before{rod, one, two};
            std::vector<ImpactBody> fine = before, plain = before;
            std::vector<Contact> again = contacts;
            resolve(fine, contacts, {.increments = 128, .inelastic_threshold = 0.0});
            resolve(plain, again, law);
            const auto energy = [](ImpactBody a, const ImpactBody& b) {
                a.velocity = a.velocity - b.velocity;
                a.spin = a.spin - b.spin;
                return energy_kinetic(a);
            };
            for (std::size_t b = 0; b < before.size(); ++b) {
                difference += energy(plain[b], fine[b]);
                change += energy(fine[b], before[b]);
            }
        }
        return std::sqrt(difference / change);
    };
    EXPECT_LT(apart({}), 0.03);
    EXPECT_GT(apart({.group = GroupLaw::first_to_last}), 0.06);
}

TEST(ImpactGroup, of_two_contacts_is_the_same_in_either_order) {
    Drawn drawn(9);
    for (int trial = 0; trial < 50; ++trial) {
        const Heap h = heap(drawn, 3, 2, true);
        Heap one = h, other = h;
        std::swap(other.contacts[0], other.contacts[1]);
        resolve(one.bodies, one.contacts, {});
        resolve(other.bodies, other.contacts, {});
        for (std::size_t b = 0; b < 3; ++b) {
            EXPECT_LT(length(one.bodies[b].velocity - other.bodies[b].velocity), 1e-10);
            EXPECT_LT(length(one.bodies[b].spin - other.bodies[b].spin), 1e-10);
        }
    }
}

TEST(ImpactGroup, mirrored_and_rotated_impacts_have_mirrored_and_rotated_results) {
    const auto turned = [](const Vector& v) { return Vector{-v.y, v.x, v.z}; };
    const auto mirrored = [](const Vector& v) { return Vector{v.x, -v.y, v.z}; };
    const auto mirrored_axial = [](const Vector& v) { return Vector{-v.x, v.y, -v.z}; };
    Drawn drawn(4);
    for (int trial = 0; trial < 100; ++trial) {
        const Heap h = heap(drawn, 3, 4, true);
        Heap plain = h, turn = h, mirror = h;
        for (std::size_t b = 0; b < 3; ++b) {
            for (Vector ImpactBody::*v : {&ImpactBody::velocity, &ImpactBody::spin, &ImpactBody::axis})
                turn.bodies[b].*v = turned(h.bodies[b].*v);
            mirror.bodies[b].velocity = mirrored(h.bodies[b].velocity);
            mirror.bodies[b].axis = mirrored(h.bodies[b].axis);
            mirror.bodies[b].spin = mirrored_axial(h.bodies[b].spin);
        }
        for (std::size_t c = 0; c < h.contacts.size(); ++c)
            for (Vector Contact::*v :
                 {&Contact::normal, &Contact::arm_first, &Contact::arm_second, &Contact::wall_velocity}) {
                turn.contacts[c].*v = turned(h.contacts[c].*v);
                mirror.contacts[c].*v = mirrored(h.contacts[c].*v);
            }
        resolve(plain.bodies, plain.contacts, {});
        resolve(turn.bodies, turn.contacts, {});
        resolve(mirror.bodies, mirror.contacts, {});
        for (std::size_t b = 0; b < 3; ++b) {
            EXPECT_LT(length(turn.bodies[b].velocity - turned(plain.bodies[b].velocity)), 1e-9);
            EXPECT_LT(length(mirror.bodies[b].velocity - mirrored(plain.bodies[b].velocity)), 1e-9);
            EXPECT_LT(length(mirror.bodies[b].spin - mirrored_axial(plain.bodies[b].spin)), 1e-9);
        }
    }
}

TEST(Impact, without_approach_changes_nothing) {
    ImpactBody rod = impact_body(the_rod);
    rod.velocity = {3.0, 0.0, 1.0};
    Contact contact = on_plate(rod, 0, 0.3, 0.3);
    const ImpactOutcome outcome = resolve({&rod, 1}, {&contact, 1}, {});
    EXPECT_EQ(rod.velocity.z, 1.0);
    EXPECT_EQ(outcome.approach, 0.0);
    EXPECT_EQ(length(contact.impulse), 0.0);
}

}  // namespace
}  // namespace drover::dem::impact_tests
