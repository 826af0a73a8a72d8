// tests/dem/soft_contacts.cpp: the spring-dashpot law against closed forms, the impulse law and conservation laws.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>

#include "dem/contact/contact_law.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::soft_contacts_tests {
namespace {

using std::numbers::pi;

dem::Setup soft(dem::Setup setup, double stiffness, ContactModel model = ContactModel::spring_dashpot) {
    setup.contacts.model = model;
    setup.contacts.stiffness = stiffness;
    setup.contacts.max_overlap = 0.2;
    return setup;
}

/// One bead above the base, without gravity or lid.
Bodies bead_over_base(const Vector& velocity, double gap = 1e-3) {
    return {.shapes = {make_ball(0.8, 2.7)},
            .beads = {{.position = {0.0, 0.0, 0.4 + gap}, .velocity = velocity}},
            .rods = {}};
}

dem::Setup base_only(double e, double mu) {
    dem::Setup setup = elastic(10.0);
    setup.plates.lid = false;
    setup.restitution.bead_plate = e;
    setup.friction.bead_plate = mu;
    return setup;
}

const double mass = make_ball(0.8, 2.7).mass, inertia = make_ball(0.8, 2.7).inertia_along;

/// The bead after one collision with the base, in `steps` steps per elastic contact time.
Bead collided(const dem::Setup& setup, const Vector& velocity, double steps, double gap = 1e-3) {
    Threads threads;
    const double dt = pi * std::sqrt(mass / setup.contacts.stiffness) / steps;
    World world(setup, bead_over_base(velocity, gap), dt, 1, threads);
    std::int64_t step = 0;
    const double time = 2.0 * gap / -velocity.z + 10.0 * steps * dt;
    while (static_cast<double>(step) * dt < time) world.advance(step++);
    return world.bodies().beads.front();
}

/// The largest error of the restitution at 50 steps a contact, and at 400.
void expect_restitution(ContactModel model, double e) {
    const dem::Setup setup = soft(base_only(e, 0.0), 1e9, model);
    const auto error = [&](double steps) {
        // The largest over the phases of the start of the contact within a step.
        double worst = 0.0;
        for (double phase = 0.05; phase < 1.0; phase += 0.005)
            worst = std::max(worst, std::abs(collided(setup, {0.0, 0.0, -20.0}, steps,
                                                      1e-3 + phase * 20.0 * pi * std::sqrt(mass / 1e9) / steps)
                                                     .velocity.z /
                                                 20.0 -
                                             e));
        return worst;
    };
    EXPECT_LT(error(50.0), 0.01) << e;
    EXPECT_LT(error(400.0), error(50.0) / 20.0 + 1e-12) << e;  // 64 at second order, 8 at first
}

TEST(SpringDashpot, a_binary_collision_has_the_given_restitution_to_second_order_in_the_step) {
    for (const double e : {0.1, 0.3, 0.9, 1.0}) expect_restitution(ContactModel::spring_dashpot, e);
}

TEST(RepulsiveSpring, a_binary_collision_has_the_given_restitution_to_second_order_in_the_step) {
    for (const double e : {0.05, 0.3, 0.9, 1.0}) expect_restitution(ContactModel::repulsive_spring, e);
}

TEST(RepulsiveSpring, its_damping_has_the_restitution_of_the_oscillator_that_parts_without_force) {
    // The exact motion x'' = -x - 2 zeta x' from x = 0, x' = 1, at the first time of x'' = 0, found by bisection.
    for (const double zeta : {1e-3, 0.1, 0.5, 0.9, 0.999, 1.001, 1.5, 5.0}) {
        const auto speed_and_force = [&](double t) {
            const double square = 1.0 - zeta * zeta, w = std::sqrt(std::abs(square));
            const double c = square > 0.0 ? std::cos(w * t) : std::cosh(w * t),
                         s = square > 0.0 ? std::sin(w * t) / w : std::sinh(w * t) / w, fall = std::exp(-zeta * t);
            const double x = fall * s, v = fall * (c - zeta * s);
            return std::pair{v, -(x + 2.0 * zeta * v)};
        };
        double before = 1e-9, after = before;
        while (speed_and_force(after).second < 0.0) after += 1e-3;
        for (int k = 0; k < 60; ++k) {
            const double middle = 0.5 * (before + after);
            (speed_and_force(middle).second < 0.0 ? before : after) = middle;
        }
        const double e = -speed_and_force(after).first;
        EXPECT_NEAR(RepulsiveSpring::damping_ratio(e), zeta, 1e-9 * zeta) << e;
    }
}

TEST(RepulsiveSpring, gross_sliding_changes_the_slip_as_the_impulse_law_does) {
    // Damping presses from the first moment, and the tangential spring has to stretch to its limit first: at this slip
    // in less than a step.
    for (const double e : {0.1, 0.9}) {
        const Bead bead =
            collided(soft(base_only(e, 0.05), 1e9, ContactModel::repulsive_spring), {8000.0, 0.0, -20.0}, 500.0);
        EXPECT_NEAR(8000.0 - bead.velocity.x, 0.05 * (1.0 + e) * 20.0, 0.002) << e;
    }
}

TEST(SpringDashpot, two_unequal_spheres_collide_with_their_restitution_and_momentum) {
    Threads threads;
    dem::Setup setup = soft(elastic(10.0), 1e9);
    setup.restitution.bead_bead = 0.4;
    Bodies bodies{.shapes = {make_ball(0.8, 2.7), make_ball(0.5, 7.8)},
                  .beads = {{.position = {-0.5, 0.0, 0.6}, .velocity = {30.0, 0.0, 0.0}, .shape = 0},
                            {.position = {0.5, 0.0, 0.6}, .velocity = {-10.0, 0.0, 0.0}, .shape = 1}},
                  .rods = {}};
    World world(setup, bodies, 2e-7, 1, threads);
    run(world, 0, 100000);
    const Bodies after = world.bodies();
    EXPECT_NEAR(after.beads[1].velocity.x - after.beads[0].velocity.x, 0.4 * 40.0, 2e-3 * 40.0);
    double change = 0.0;
    for (const std::size_t b : {0u, 1u})
        change += bodies.shapes[b].mass * (after.beads[b].velocity.x - bodies.beads[b].velocity.x);
    EXPECT_NEAR(change, 0.0, 1e-12 * 30.0);
    EXPECT_EQ(world.counts().bead_bead, 1);
}

TEST(SpringDashpot, contact_lasts_half_a_period_of_the_damped_oscillator) {
    Threads threads;
    for (const double e : {0.3, 1.0}) {
        const dem::Setup setup = soft(base_only(e, 0.0), 1e9);
        const double damping = -std::log(e), exact = std::sqrt(mass / 1e9 * (pi * pi + damping * damping));
        const double dt = exact / 1000.0;
        World world(setup, bead_over_base({0.0, 0.0, -20.0}), dt, 1, threads);
        std::int64_t step = 0, in_contact = 0;
        for (; step < 10000; ++step) {
            world.advance(step);
            if (world.bodies().beads.front().position.z < 0.4) ++in_contact;
        }
        EXPECT_NEAR(static_cast<double>(in_contact) * dt, exact, 3.0 * dt) << e;
    }
}

TEST(SpringDashpot, gross_sliding_changes_the_slip_as_the_impulse_law_does) {
    // Coulomb's limit follows the elastic force, whose impulse is m (1 + e) u_n.
    for (const double e : {0.3, 0.9}) {
        const Bead bead = collided(soft(base_only(e, 0.05), 1e9), {60.0, 0.0, -20.0}, 500.0);
        EXPECT_NEAR(60.0 - bead.velocity.x, 0.05 * (1.0 + e) * 20.0, 0.002) << e;
        // Torque of friction at the point of contact, a little less than a radius from the centre.
        EXPECT_NEAR(bead.spin.y, mass * 0.4 * 0.05 * (1.0 + e) * 20.0 / inertia, 0.003 * bead.spin.y) << e;
    }
}

TEST(SpringDashpot, a_sticking_contact_turns_the_slip_by_the_phase_of_its_tangential_spring) {
    // Foerster et al., Phys. Fluids 6, 1108 (1994), for the linear spring: u_t' = u_t cos(sqrt(k_t w_t) t_c), w_t = 1/m
    // + R^2/I. At the end the limit mu k delta falls below the force of the spring unless mu is large: hence mu = 1e6.
    for (const double e : {0.5, 1.0})
        for (const double ratio : {0.1, 2.0 / 7.0, 0.6}) {
            dem::Setup setup = soft(base_only(e, 1e6), 1e12);
            setup.contacts.tangential_stiffness_ratio = ratio;
            const double damping = -std::log(e), contact = std::sqrt(mass / 1e12 * (pi * pi + damping * damping));
            const double response = 1.0 / mass + 0.16 / inertia;
            const Bead bead = collided(setup, {1.0, 0.0, -20.0}, 800.0);
            const double slip = bead.velocity.x - 0.4 * bead.spin.y;
            EXPECT_NEAR(slip, std::cos(std::sqrt(ratio * 1e12 * response) * contact), 2e-3) << e << " " << ratio;
        }
}

/// Largest difference of the velocities from those of the impulse law after some time, with 200 steps a contact.
double velocity_from_impulse_law(const dem::Setup& setup, const Bodies& bodies, double stiffness, double time) {
    Threads threads;
    const auto end = [&](const dem::Setup& s, double dt) {
        World world(s, bodies, dt, 1, threads);
        run(world, 0, std::llround(time / dt));
        return world.bodies();
    };
    const double contact = pi * std::sqrt(0.5 * bodies.shapes[0].mass / stiffness);
    const Bodies hard = end(setup, time / 20000.0);
    const Bodies result = end(soft(setup, stiffness), time / std::ceil(time / contact * 200.0));
    double difference = 0.0;
    for (std::size_t b = 0; b < hard.beads.size(); ++b)
        difference = std::max(difference, length(result.beads[b].velocity - hard.beads[b].velocity));
    for (std::size_t r = 0; r < hard.rods.size(); ++r)
        difference = std::max(difference, length(result.rods[r].velocity - hard.rods[r].velocity));
    return difference;
}

TEST(SpringDashpot, a_dropped_bead_approaches_the_impulse_law_as_the_inverse_root_of_the_stiffness) {
    // It slides throughout: a contact that sticks would give back the slip of its spring, which the impulse law does
    // not.
    dem::Setup setup = base_only(0.3, 0.05);
    setup.gravity.z = -9810.0;
    const Bodies bodies = bead_over_base({60.0, 0.0, 0.0}, 0.2);
    const double time = 0.009;  // one bounce, at 0.0064 s; the next would be at 0.0102 s
    const double at_7 = velocity_from_impulse_law(setup, bodies, 1e7, time),
                 at_9 = velocity_from_impulse_law(setup, bodies, 1e9, time);
    EXPECT_LT(at_9, 0.02 * 63.0);
    EXPECT_NEAR(at_7 / at_9, 10.0, 1.0);
}

TEST(SpringDashpot, two_rods_that_meet_approach_the_impulse_law_as_the_inverse_root_of_the_stiffness) {
    dem::Setup setup = elastic(20.0);
    setup.restitution.rod_rod = 0.3;
    Bodies bodies{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.0)}};
    bodies.rods.push_back(lying_rod(setup, 1.5, 2.9, 1.2));
    bodies.rods[1].velocity = {-60.0, -50.0, 0.0};
    const double at_9 = velocity_from_impulse_law(setup, bodies, 1e9, 0.03),
                 at_11 = velocity_from_impulse_law(setup, bodies, 1e11, 0.03);
    EXPECT_LT(at_9, 0.03 * 28.0);
    EXPECT_NEAR(at_9 / at_11, 10.0, 1.0);
    // With friction the slip turns during the impact, and the order of normal and tangential impulses makes a small
    // difference in the limit.
    setup.friction.rod_rod = 0.05;
    EXPECT_LT(velocity_from_impulse_law(setup, bodies, 1e11, 0.03), 0.01 * 28.0);
}

TEST(SpringDashpot, the_energy_balance_of_a_shaken_mixture_closes_to_second_order_in_the_step) {
    Threads threads;
    const auto residual = [&](double dt) {
        dem::Setup setup = soft(square(12.0), 1e8);
        setup.beads.count = 1;  // the bodies are given below
        setup.forces = {.bead_x = 50.0, .rod_y = 300.0, .torque = 2e4, .angle = 0.4, .push = 100.0};
        Drawn drawn(2);
        World world(setup, mixture(setup, drawn), dt, 1, threads);
        const double before = world.energy_kinetic();
        double worst = 0.0;
        for (std::int64_t step = 0; step < std::llround(0.01 / dt); ++step) {
            world.advance(step);
            worst = std::max(worst, std::abs(world.energy_kinetic() - before - sum(world.balance())));
        }
        const EnergyBalance balance = world.balance();
        EXPECT_LT(balance.impact, 0.0);
        EXPECT_LT(balance.friction, 0.0);
        EXPECT_NE(balance.kicks, 0.0);
        EXPECT_NE(balance.forces, 0.0);
        EXPECT_GT(world.counts().rod_plate, 10);
        EXPECT_GT(world.counts().bead_bead, 5);
        return worst / -balance.impact;
    };
    const double coarse = residual(8e-6), fine = residual(1e-6);
    EXPECT_LT(coarse, 0.02);
    EXPECT_LT(fine, coarse / 20.0);  // 64 at second order, 8 at first
}

TEST(SpringDashpot, a_frictionless_elastic_gas_keeps_its_energy_to_second_order_in_the_step) {
    Threads threads;
    const auto drift = [&](double dt) {
        Drawn drawn(1);
        const dem::Setup setup = soft(elastic(8.0), 1e8);
        World world(setup, lattice(setup, 8, 8, 0.8, 40.0, drawn), dt, 1, threads);
        const double before = world.energy_kinetic();
        double worst = 0.0;
        for (std::int64_t step = 0; step < std::llround(0.02 / dt); ++step) {
            world.advance(step);
            worst = std::max(worst, std::abs(world.energy_kinetic() - world.balance().elastic - before) / before);
        }
        EXPECT_GT(world.counts().bead_bead, 50);
        EXPECT_EQ(world.balance().impact, 0.0);
        return worst;
    };
    const double coarse = drift(8e-6), fine = drift(1e-6);
    EXPECT_LT(coarse, 0.02);
    EXPECT_LT(fine, coarse / 20.0);
}

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
               return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
           });
}

TEST(SpringDashpot, is_bitwise_equal_for_any_number_of_threads_and_after_a_restart_in_mid_contact) {
    for (const CellShape shape : {CellShape::periodic, CellShape::rectangle}) {
        dem::Setup setup = soft(square(12.0), 1e8);
        setup.cell.shape = shape;
        Threads one(1), two(2);
        const auto make = [&](Threads& threads) {
            Drawn drawn(4);
            Bodies bodies = mixture(setup, drawn);
            for (Bead& bead : bodies.beads) bead.velocity = 2.0 * bead.velocity;
            if (setup.cell.shape == CellShape::rectangle)
                std::erase_if(bodies.beads, [](const Bead& bead) {
                    return std::max(std::abs(bead.position.x), std::abs(bead.position.y)) > 5.5;
                });
            return World(setup, bodies, 5e-6, 7, threads);
        };
        World a = make(one), b = make(two);
        run(a, 0, 3000);
        run(b, 0, 1501);
        EXPECT_LT(b.balance().elastic, 0.0) << "expected contacts at the time of the checkpoint";
        const std::vector<double> saved = b.save();
        World c = make(two);
        c.restore(saved);
        EXPECT_TRUE(same_bytes(c.save(), saved));
        run(c, 1501, 3000);
        EXPECT_TRUE(same_bytes(a.save(), c.save())) << name_of(shape);
        EXPECT_GT(a.counts().lists, 0);
    }
}

TEST(SpringDashpotLong, mean_work_of_the_kicks_is_that_of_the_impulse_law) {
    // Kicks are per impact: epsilon v at the start of a contact.  Sixteen rods, 0.3 s; mean squares of some 16 x 60
    // kicks.
    Threads threads(2);
    const auto kicks = [&](dem::Setup setup, double dt) {
        setup.kick.strength = 0.05;
        Bodies bodies{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {}};
        Drawn drawn(8);
        for (int i = 0; i < 16; ++i) {
            Rod rod = lying_rod(setup, (i % 4 - 1.5) * 10.0, (i / 4 - 1.5) * 10.0, drawn() * pi);
            rod.velocity = {0.0, 0.0, 20.0 * drawn()};
            bodies.rods.push_back(rod);
        }
        World world(setup, bodies, dt, 1, threads);
        run(world, 0, std::llround(0.3 / dt));
        return world.balance().kicks;
    };
    EXPECT_NEAR(kicks(soft(square(40.0), 1e11), 8e-7) / kicks(square(40.0), 2e-5), 1.0, 0.4);
}

TEST(SpringDashpot, an_overlap_with_a_plate_beyond_the_limit_is_an_error_that_names_it) {
    Threads threads;
    dem::Setup setup = soft(base_only(1.0, 0.0), 1e6);
    setup.contacts.max_overlap = 0.05;
    World world(setup, bead_over_base({0.0, 0.0, -60.0}), 1e-6, 1, threads);
    try {
        run(world, 0, 2000);
        FAIL() << "expected an error";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("bead 0 and the base overlap by"), std::string::npos) << error.what();
    }
}

std::string message_of(const dem::Setup& setup, double dt) {
    Threads threads;
    try {
        World world(setup, bead_over_base({}), dt, 1, threads,
                    [](const std::string& key) { return SourceLocation{.file = "at " + key}; });
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(SpringDashpot, a_step_too_long_for_the_contact_time_or_no_restitution_is_rejected_with_the_remedy) {
    const dem::Setup setup = soft(base_only(0.3, 0.0), 1e8);
    const double contact = pi * std::sqrt(0.5 * mass / 1e8);
    EXPECT_EQ(message_of(setup, contact / 20.0), "");
    const std::string too_long = message_of(setup, contact / 10.0);
    EXPECT_EQ(too_long.find("at time.dt: time.dt = "), 0u) << too_long;
    EXPECT_NE(too_long.find(" is 10 steps of the shortest contact"), std::string::npos) << too_long;
    const std::string remedy = "choose time.dt <= ";
    ASSERT_NE(too_long.find(remedy), std::string::npos) << too_long;
    const double recommended = std::stod(too_long.substr(too_long.find(remedy) + remedy.size()));
    EXPECT_EQ(message_of(setup, recommended), "");
    EXPECT_GT(recommended, 0.9 * contact / 20.0);  // rounded down to two digits
    const std::string inelastic = message_of(soft(base_only(0.0, 0.0), 1e8), 1e-7);
    EXPECT_EQ(inelastic.find("at restitution.bead_plate: restitution.bead_plate = 0 with contacts.model"), 0u)
        << inelastic;
}

}  // namespace
}  // namespace drover::dem::soft_contacts_tests
