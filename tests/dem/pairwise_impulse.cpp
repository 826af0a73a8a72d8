// tests/dem/pairwise_impulse.cpp: the impulse of one contact of the pairwise law against the formulas of a textbook.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "dem/contact/contact_law.hpp"
#include "dem/impact/impact_increment.hpp"
#include "dem/impact_support.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::pairwise_impulse_tests {
namespace {

using Columns = std::array<Vector, 3>;

Vector times(const Columns& k, const Vector& a) { return a.x * k[0] + a.y * k[1] + a.z * k[2]; }
Vector solve(const Columns& k, const Vector& d) {
    const double det = dot(k[0], cross(k[1], k[2]));
    return 1.0 / det * Vector{dot(d, cross(k[1], k[2])), dot(k[0], cross(d, k[2])), dot(k[0], cross(k[1], d))};
}

/// Two bodies, or one and a wall, that approach at a contact.
struct Case {
    std::vector<ImpactBody> bodies;
    Contact contact;

    Vector velocity() const { return relative_velocity(contact, bodies); }
    /// Change of the relative velocity by unit impulses: sum of 1/m + rotation.
    Columns response() const {
        Columns k{};
        const Vector units[] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                const Vector& arm = b == 0 ? contact.arm_first : contact.arm_second;
                const Vector turn = cross(arm, units[j]);
                const double along = dot(turn, bodies[b].axis);
                const Vector spin = bodies[b].across_inverse * (turn - along * bodies[b].axis) +
                                    bodies[b].along_inverse * along * bodies[b].axis;
                k[j] = k[j] + bodies[b].mass_inverse * units[j] + cross(spin, arm);
            }
        return k;
    }
    double energy() const {
        double total = 0.0;
        for (const ImpactBody& body : bodies) total += energy_kinetic(body);
        return total;
    }
};

Case random_case(bool wall, double restitution, double friction, Drawn& drawn) {
    Case made;
    Contact& contact = made.contact;
    const auto sphere = [&] { return static_cast<std::size_t>(6.5 * (1.0 + drawn())); };
    contact.normal = drawn.direction();
    contact.restitution = restitution;
    contact.friction = friction;
    contact.second = wall ? -1 : 1;
    for (const bool first : {true, false}) {
        if (wall && !first) break;
        ImpactBody body = impact_body(the_rod, drawn.direction());
        const std::size_t k = std::min<std::size_t>(12, sphere());
        const Vector arm = the_rod.at[k] * body.axis - (first ? 1.0 : -1.0) * the_rod.radius[k] * contact.normal;
        (first ? contact.arm_first : contact.arm_second) = arm;
        body.velocity = drawn.vector(50.0);
        body.spin = drawn.vector(30.0);
        made.bodies.push_back(body);
    }
    if (wall) contact.wall_velocity = drawn.vector(50.0);
    if (dot(made.velocity(), contact.normal) > 0.0) {  // approach instead
        for (ImpactBody& body : made.bodies) body.velocity = -1.0 * body.velocity, body.spin = -1.0 * body.spin;
        contact.wall_velocity = -1.0 * contact.wall_velocity;
    }
    return made;
}

struct Resolved {
    Vector impulse;
    bool limited = false;
};
template <class Law>
Resolved resolve_by(const Law& law, Case& given) {
    const Frame frame = frame_of(given.contact, given.bodies);
    const Slip slip{velocity_along(given.contact, frame, 0, given.bodies),
                    velocity_along(given.contact, frame, 1, given.bodies),
                    velocity_along(given.contact, frame, 2, given.bodies)};
    const PairwiseImpulse j = law(frame.response, given.contact.restitution, given.contact.friction, slip);
    return {apply(given.contact, frame, j.n, j.x, j.y, given.bodies), j.limited};
}

TEST(PairwiseImpulse, stop_or_slide_is_the_impulse_of_the_textbook_at_every_contact_of_a_pair) {
    Drawn drawn(41);
    int stops = 0, slides = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        const double mu = trial % 2 == 0 ? 0.03 : 0.4;
        Case given = random_case(trial % 3 == 0, 0.1, mu, drawn);
        const Vector n = given.contact.normal, u = given.velocity(), slip = u - dot(u, n) * n;
        const Columns k = given.response();
        const Vector direction = n - mu / length(slip) * slip;
        Vector expected = solve(k, -0.1 * dot(u, n) * n - u);
        const double normal = dot(expected, n);
        const bool holds = normal > 0.0 && length(expected - normal * n) <= mu * normal;
        if (!holds) expected = -1.1 * dot(u, n) / dot(n, times(k, direction)) * direction;
        const Resolved found = resolve_by(stop_or_slide, given);
        if (found.limited) continue;
        ++(holds ? stops : slides);
        EXPECT_LT(length(found.impulse - expected), 1e-12 * length(expected)) << trial;
        EXPECT_NEAR(dot(given.velocity(), n), -0.1 * dot(u, n), 1e-12 * (length(u) + 100.0)) << trial;
    }
    EXPECT_GT(stops, 30);
    EXPECT_GT(slides, 2000);
}

TEST(PairwiseImpulse, decoupled_friction_is_the_impulse_of_the_textbook_at_every_contact_of_a_pair) {
    Drawn drawn(42);
    for (int trial = 0; trial < 4000; ++trial) {
        const double mu = trial % 2 == 0 ? 0.03 : 0.4;
        Case given = random_case(trial % 3 == 0, 0.1, mu, drawn);
        const Vector n = given.contact.normal, u = given.velocity(), slip = u - dot(u, n) * n;
        const Vector t = 1.0 / length(slip) * slip;
        const Columns k = given.response();
        const double normal = -1.1 * dot(u, n) / dot(n, times(k, n));
        const Vector expected = normal * n - std::min(mu * normal, length(slip) / dot(t, times(k, t))) * t;
        const Resolved found = resolve_by(decoupled, given);
        if (found.limited) continue;
        EXPECT_LT(length(found.impulse - expected), 1e-12 * length(expected)) << trial;
    }
}

/// Extremes of restitution and friction: the energy, less the work of a moving wall, never grows.
template <class Law>
int expect_no_gain(const Law& law, std::uint64_t seed) {
    Drawn drawn(seed);
    int limited = 0;
    for (const double e : {0.0, 0.1, 0.9, 1.0 - 1e-9, 1.0})
        for (const double mu : {0.0, 0.05, 1.0, 100.0})
            for (int trial = 0; trial < 500; ++trial) {
                Case given = random_case(trial % 2 == 0, e, mu, drawn);
                const double before = given.energy();
                const Vector wall = given.contact.second < 0 ? given.contact.wall_velocity : Vector{};
                const Resolved found = resolve_by(law, given);
                const double gain = given.energy() - before - dot(found.impulse, wall);
                EXPECT_TRUE(std::isfinite(gain));
                // Rounding of the energies before and after, which a moving wall can make much smaller than its work.
                const double scale = before + given.energy() + std::abs(dot(found.impulse, wall));
                EXPECT_LT(gain, 1e-12 * scale) << "e " << e << " mu " << mu << " trial " << trial;
                EXPECT_GT(dot(found.impulse, given.contact.normal), 0.0);
                limited += found.limited;
                EXPECT_FALSE(mu == 0.0 && found.limited);
            }
    return limited;
}

TEST(PairwiseImpulse, never_creates_energy_and_counts_where_friction_along_the_slip_before_would) {
    EXPECT_GT(expect_no_gain(stop_or_slide, 43), 0);
    EXPECT_GT(expect_no_gain(decoupled, 44), 0);
}

TEST(PairwiseImpulse, needs_no_limit_with_the_friction_and_restitution_of_the_paper) {
    // mu |K_nt| J_n is a hundredth of the loss along the normal.
    Drawn drawn(45);
    for (int trial = 0; trial < 4000; ++trial) {
        const bool plate = trial % 2 == 0;
        Case given = random_case(plate, plate ? 0.1 : 0.3, plate ? 0.03 : 0.05, drawn), other = given;
        EXPECT_FALSE(resolve_by(stop_or_slide, given).limited) << trial;
        EXPECT_FALSE(resolve_by(decoupled, other).limited) << trial;
    }
}

TEST(PairwiseImpulse, conserves_momentum_and_angular_momentum_of_a_pair) {
    Drawn drawn(46);
    for (int trial = 0; trial < 500; ++trial) {
        Case given = random_case(false, 0.3, 0.3, drawn);
        const Case before = given;
        resolve_by(stop_or_slide, given);
        Vector momentum, angular;
        for (std::size_t b = 0; b < 2; ++b) {
            const Vector change =
                1.0 / given.bodies[b].mass_inverse * (given.bodies[b].velocity - before.bodies[b].velocity);
            // The point of contact is the origin: a body's centre is at minus its arm.
            const Vector centre = -1.0 * (b == 0 ? given.contact.arm_first : given.contact.arm_second);
            momentum = momentum + change;
            angular = angular + cross(centre, change) + momentum_angular(given.bodies[b]) -
                      momentum_angular(before.bodies[b]);
        }
        const double size = 27.0 * 50.0;
        EXPECT_LT(length(momentum), 1e-12 * size);
        EXPECT_LT(length(angular), 1e-11 * size);
    }
}

}  // namespace
}  // namespace drover::dem::pairwise_impulse_tests
