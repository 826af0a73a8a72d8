// tests/dem/world.cpp: the whole step against exact motion, conservation laws, symmetry, and the traps of event-free
// simulation.
#include "drover/dem/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "dem/bodies/rotation.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::world_tests {
namespace {

double kinetic(const Bodies& bodies) {
    double total = 0.0;
    for (const Bead& bead : bodies.beads) {
        const Shape& shape = bodies.shapes[bead.shape];
        total +=
            0.5 * (shape.mass * dot(bead.velocity, bead.velocity) + shape.inertia_along * dot(bead.spin, bead.spin));
    }
    for (const Rod& rod : bodies.rods) {
        const Shape& shape = bodies.shapes[rod.shape];
        total += 0.5 * shape.mass * dot(rod.velocity, rod.velocity) + rotation_energy(rod, shape);
    }
    return total;
}

Vector momentum(const Bodies& bodies) {
    Vector total;
    for (const Bead& bead : bodies.beads) total = total + bodies.shapes[bead.shape].mass * bead.velocity;
    for (const Rod& rod : bodies.rods) total = total + bodies.shapes[rod.shape].mass * rod.velocity;
    return total;
}

TEST(World, an_elastic_bead_between_resting_plates_follows_the_exact_motion) {
    // Free way gap - d = 0.4 mm at 30 mm/s and no gravity: the height is a triangle wave, for any time step.
    // (Impulses before contact would make the way shorter, and converge in dt nonetheless.)
    Threads threads;
    const dem::Setup setup = elastic(10.0);
    for (const double dt : {1e-5, 1e-4, 1e-3}) {
        Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                      .beads = {{.position = {1.0, 2.0, 0.5}, .velocity = {3.0, 0.0, 30.0}}},
                      .rods = {}};
        World world(setup, bodies, dt, 1, threads);
        const auto steps = std::llround(1.0 / dt);
        run(world, 0, steps);
        const Bead bead = world.bodies().beads.front();
        const double way = std::fmod(0.1 + 30.0, 0.8);  // up and down
        EXPECT_NEAR(bead.position.z, 0.4 + (way < 0.4 ? way : 0.8 - way), 1e-9) << dt;
        EXPECT_NEAR(bead.position.x, 4.0, 1e-9);
        EXPECT_EQ(world.counts().bead_plate, 75) << dt;  // (0.1 + 30)/0.4
    }
}

TEST(World, a_bead_bounces_off_the_moving_plate_at_the_exact_time_and_speed) {
    // One flight, dropped from rest on a moving base, e = 1: the crossing is found by bisection here.  The flight to it
    // is a parabola and the plate a cosine; the step replaces it by a parabola of its own about each moment: dt^3 A
    // omega^3/6 = 1e-8 mm.
    Threads threads;
    dem::Setup setup = square(10.0);
    setup.plates.lid = false;
    setup.restitution.bead_plate = 1.0;
    const double omega = 2.0 * std::numbers::pi * setup.plates.frequency, a = setup.plates.amplitude, start = 0.62;
    const auto gap = [&](double t) { return start - 0.5 * 9810.0 * t * t - 0.4 - a * (1.0 + std::cos(omega * t)); };
    double low = 0.0, high = 0.0;
    while (gap(high) > 0.0) high += 1e-6;
    low = high - 1e-6;
    for (int k = 0; k < 60; ++k) (gap(0.5 * (low + high)) > 0.0 ? low : high) = 0.5 * (low + high);
    const double plate = -a * omega * std::sin(omega * low), after = 2.0 * plate + 9810.0 * low;
    Bodies bodies{.shapes = {make_ball(0.8, 2.7)}, .beads = {{.position = {0.0, 0.0, start}}}, .rods = {}};
    World world(setup, bodies, 2e-5, 1, threads);
    const auto steps = static_cast<std::int64_t>(low / 2e-5) + 5;
    run(world, 0, steps);
    const double since = static_cast<double>(steps) * 2e-5 - low;
    EXPECT_EQ(world.counts().bead_plate, 1);
    EXPECT_NEAR(world.bodies().beads.front().velocity.z, after - 9810.0 * since, 1e-4);
    EXPECT_NEAR(world.bodies().beads.front().position.z,
                0.4 + a * (1.0 + std::cos(omega * low)) + after * since - 0.5 * 9810.0 * since * since, 1e-7);
}

TEST(World, two_colliding_beads_follow_the_impact_law_and_conserve_momentum) {
    Threads threads;
    dem::Setup setup = elastic(10.0);
    setup.restitution.bead_bead = 0.3;
    setup.friction.bead_bead = 0.05;
    for (const double offset : {0.0, 0.2, 0.5, 0.75}) {  // head-on to grazing: sticking and sliding
        Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                      .beads = {{.position = {-1.0, offset, 0.6}, .velocity = {40.0, 0.0, 0.0}},
                                {.position = {1.0, 0.0, 0.6}, .velocity = {-20.0, 0.0, 0.0}, .spin = {0.0, 0.0, 5.0}}},
                      .rods = {}};
        const Vector before = momentum(bodies);
        World world(setup, bodies, 2e-5, 1, threads);
        run(world, 0, 2500);
        const Bodies after = world.bodies();
        const Vector n{-std::sqrt(1.0 - offset * offset / 0.64), offset / 0.8, 0.0}, t{-n.y, n.x, 0.0};
        const Vector u{60.0, 0.0, 0.0};
        const double approach = -dot(u, n), slip = dot(u - cross(0.4 * Vector{0.0, 0.0, 5.0}, n), t);
        const double mass = bodies.shapes[0].mass, normal = 1.3 * approach * mass / 2.0;
        const double response = 2.0 / mass + 2.0 * 0.16 / bodies.shapes[0].inertia_along;
        const double tangential = -std::copysign(std::min(0.05 * normal, std::abs(slip) / response), slip);
        const Vector kick = normal / mass * n + tangential / mass * t;
        EXPECT_EQ(world.counts().bead_bead, 1);
        // The normal is that of the moment of contact: exact for two that fly straight.
        EXPECT_LT(length(after.beads[0].velocity - (Vector{40.0, 0.0, 0.0} + kick)), 1e-9) << offset;
        EXPECT_LT(length(momentum(after) - before), 1e-12 * 30.0);
    }
}

TEST(WorldLong, a_frictionless_elastic_gas_conserves_energy_over_a_million_impacts) {
    Threads threads(2);
    Drawn drawn(1);
    dem::Setup setup = elastic(32.0);
    setup.contacts.max_overlap = 0.1;  // a long step for a short test
    const Bodies bodies = lattice(setup, 32, 32, 0.8, 40.0, drawn);
    World world(setup, bodies, 5e-5, 1, threads);
    const double before = world.energy_kinetic();
    const Vector start = momentum(bodies);
    std::int64_t step = 0;
    while (world.counts().bead_bead + world.counts().bead_plate < 1000000) run(world, step, step + 100), step += 100;
    EXPECT_NEAR(world.energy_kinetic() / before, 1.0, 1e-9);  // 1e6 roundings of 1e-16 walk to 1e-13
    const Vector change = momentum(world.bodies()) - start;
    EXPECT_LT(std::hypot(change.x, change.y), 1e-9 * 1024 * 0.7 * 40.0);
    EXPECT_GT(world.counts().bead_bead, 100000);
}

/// Impacts on the plates of each of 100 beads in 0.5 s after 0.2 s: mean and its standard error over the beads.
std::array<double, 2> plate_impacts(double amplitude, double dt) {
    Threads threads;
    Drawn drawn(7);
    dem::Setup setup = square(30.0);
    setup.plates.amplitude = amplitude;
    setup.contacts.max_overlap = 1.0;  // of the longest step
    const Bodies bodies = lattice(setup, 10, 10, 0.8, 30.0, drawn);
    double sum = 0.0, squares = 0.0;
    for (const Bead& bead : bodies.beads) {
        World world(setup, {.shapes = bodies.shapes, .beads = {bead}, .rods = {}}, dt, 1, threads);
        const auto steps = [&](double time) { return std::llround(time / dt); };
        run(world, 0, steps(0.2));
        const std::int64_t before = world.counts().bead_plate;
        run(world, steps(0.2), steps(0.7));
        const auto impacts = static_cast<double>(world.counts().bead_plate - before);
        sum += impacts;
        squares += impacts * impacts;
    }
    const double mean = sum / 100.0;
    return {mean, std::sqrt((squares / 100.0 - mean * mean) / 100.0)};
}

TEST(WorldStatistics, rate_of_impacts_on_the_plates_does_not_depend_on_the_time_step) {
    for (const double amplitude : {0.02, 0.04}) {
        const auto [fine, fine_error] = plate_impacts(amplitude, 2e-5);
        for (const double dt : {1e-4, 2.5e-4}) {
            const auto [rate, error] = plate_impacts(amplitude, dt);
            EXPECT_NEAR(rate, fine, 4.0 * std::hypot(error, fine_error)) << "A " << amplitude << " dt " << dt;
        }
        EXPECT_GT(fine, 25.0);  // impacts of beads in motion are counted
    }
}

TEST(World, the_energy_balance_closes_and_no_group_gains_energy_in_a_shaken_mixture) {
    Threads threads(2);
    dem::Setup setup = square(12.0);
    setup.beads.count = 1;  // the bodies are given below
    setup.forces = {
        .bead_x = 50.0, .rod_y = 300.0, .torque = 2e4, .angle = 0.4, .hold_beads = true, .bead_velocity_x = 2.0};
    setup.gravity.x = 300.0;
    setup.restitution = {0.3, 0.8, 0.1, 0.3, 0.1, 0.3, 0.3};
    Drawn drawn(2);
    World world(setup, mixture(setup, drawn), 2e-5, 1, threads);
    const double before = world.energy_kinetic();
    run(world, 0, 10000);
    const EnergyBalance balance = world.balance();
    EXPECT_NEAR(world.energy_kinetic() - before, sum(balance), 1e-9 * balance.plates);
    EXPECT_NEAR(world.energy_kinetic(), kinetic(world.bodies()), 1e-12 * world.energy_kinetic());
    EXPECT_LT(balance.impact, 0.0);
    EXPECT_LT(balance.friction, 0.0);
    EXPECT_NE(balance.forces, 0.0);
    EXPECT_NE(balance.kicks, 0.0);
    EXPECT_LT(world.worst_overlap().of_radius, 0.01);
    EXPECT_EQ(world.counts().unresolved, 0);
}

TEST(World, hold_beads_keeps_the_mean_velocity_of_the_beads) {
    Threads threads;
    dem::Setup setup = square(12.0);
    setup.beads.count = 1;  // the bodies are given below
    setup.forces = {.hold_beads = true, .bead_velocity_x = 4.0, .bead_velocity_y = -1.0};
    Drawn drawn(3);
    World world(setup, mixture(setup, drawn), 2e-5, 1, threads);
    run(world, 0, 400);
    Vector mean;  // of 100 steps: held at the start of each; within it, plates and rods take some
    for (int step = 400; step < 500; ++step) {
        run(world, step, step + 1);
        const Bodies bodies = world.bodies();
        for (const Bead& bead : bodies.beads)
            mean = mean + 0.01 / static_cast<double>(bodies.beads.size()) * bead.velocity;
    }
    EXPECT_NEAR(mean.x, 4.0, 0.2);
    EXPECT_NEAR(mean.y, -1.0, 0.2);
}

TEST(World, hold_beads_keeps_a_velocity_wave_and_a_force_wave_collects_beads_at_its_node) {
    Threads threads;
    dem::Setup setup = square(16.0);
    setup.beads.count = 1;  // the bodies are given below
    setup.forces = {.hold_beads = true, .bead_velocity_x = 6.0, .held_waves = 2};
    Drawn drawn(5);
    World world(setup, lattice(setup, 14, 14, 0.8, 10.0, drawn), 2e-5, 1, threads);
    const double wave = 2.0 * std::numbers::pi / 16.0;
    const auto mean = [&](const auto& value) {
        double total = 0.0;
        const Bodies bodies = world.bodies();
        for (const Bead& bead : bodies.beads) total += value(bead) / static_cast<double>(bodies.beads.size());
        return total;
    };
    run(world, 0, 1000);
    // Held at the start of a step; within it, plates and impacts take some.
    EXPECT_NEAR(2.0 * mean([&](const Bead& b) { return b.velocity.x * std::sin(2.0 * wave * b.position.y); }), 6.0,
                0.3);
    // A force f sin(qx) drives beads to where sin falls: x = lx/2, at which cos is -1.
    world.set_forces({.push = 500.0, .push_waves = 1});
    run(world, 1000, 6000);
    EXPECT_LT(mean([&](const Bead& b) { return std::cos(wave * b.position.x); }), -0.1);
    EXPECT_THROW(world.set_forces({.push = 1.0, .push_waves = 0}), Error);
}

TEST(World, the_energy_balance_closes_when_forces_change) {
    Threads threads(2);
    dem::Setup setup = square(12.0);
    setup.beads.count = 1;  // the bodies are given below
    Drawn drawn(6);
    World world(setup, mixture(setup, drawn), 2e-5, 1, threads);
    const double before = world.energy_kinetic();
    const BodyForces all[] = {{.bead_x = 200.0, .torque = 2e4, .push = 300.0, .push_waves = 2},
                              {.bead_y = -100.0, .rod_x = 300.0, .hold_beads = true, .bead_velocity_y = 3.0},
                              {.hold_beads = true, .bead_velocity_x = 5.0, .held_waves = 1}};
    for (std::int64_t part = 0; part < 3; ++part) {
        const EnergyBalance at_change = world.balance();
        world.set_forces(all[part]);
        EXPECT_NEAR(sum(world.balance()), sum(at_change), 1e-9 * std::abs(at_change.plates));  // rounding
        run(world, part * 2000, (part + 1) * 2000);
    }
    EXPECT_NEAR(world.energy_kinetic() - before, sum(world.balance()), 1e-9 * world.balance().plates);
}

bool same_bytes(const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
               return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
           });
}

TEST(World, is_bitwise_equal_for_any_number_of_threads_and_after_a_restart_in_mid_flight) {
    const dem::Setup setup = square(14.0);
    Threads one(1), two(2), three(3);
    const auto make = [&](Threads& threads) {
        Drawn drawn(4);
        return World(setup, mixture(setup, drawn), 2e-5, 7, threads);
    };
    World a = make(one), b = make(two), c = make(three);
    run(a, 0, 2000);
    run(b, 0, 2000);
    EXPECT_TRUE(same_bytes(a.save(), b.save()));
    run(c, 0, 777);
    const std::vector<double> saved = c.save();
    World d = make(two);
    d.restore(saved);
    EXPECT_TRUE(same_bytes(d.save(), saved));
    run(d, 777, 2000);
    EXPECT_TRUE(same_bytes(a.save(), d.save()));
    EXPECT_GT(a.counts().lists, 3);  // lists were made anew on both sides of the restart
    EXPECT_EQ(a.balance().plates, d.balance().plates);
}

TEST(World, is_bitwise_equal_for_any_number_of_threads_and_after_a_restart_with_changed_forces) {
    const dem::Setup setup = [] {
        dem::Setup with_bead = square(14.0);
        with_bead.beads.count = 1;  // the bodies are given below
        return with_bead;
    }();
    const BodyForces forces{
        .bead_x = 40.0, .hold_beads = true, .bead_velocity_x = 3.0, .held_waves = 1, .push = 200.0, .push_waves = 2};
    Threads one(1), three(3);
    const auto make = [&](Threads& threads) {
        Drawn drawn(4);
        return World(setup, mixture(setup, drawn), 2e-5, 7, threads);
    };
    World a = make(one), b = make(three), c = make(three);
    for (World* world : {&a, &b}) {
        run(*world, 0, 500);
        world->set_forces(forces);
        run(*world, 500, 1000);
    }
    EXPECT_TRUE(same_bytes(a.save(), b.save()));
    c.set_forces(forces);
    c.restore(a.save());
    run(a, 1000, 1500);
    run(c, 1000, 1500);
    EXPECT_TRUE(same_bytes(a.save(), c.save()));
}

TEST(World, a_state_of_another_world_is_rejected) {
    const dem::Setup setup = square(14.0);
    Threads threads;
    Drawn drawn(4);
    World world(setup, mixture(setup, drawn), 2e-5, 7, threads);
    EXPECT_THROW(world.restore(std::vector<double>(10)), Error);
}

/// Position and direction of a single rod after some time, from a start turned by quarters of a circle and mirrored at
/// the x axis.
Rod flown(int quarters, bool mirrored, double time) {
    Threads threads;
    dem::Setup setup = square(20.0);
    setup.kick.strength = 0.0;
    const auto turn = [&](Vector v, bool axial) {
        if (mirrored) v = axial ? Vector{-v.x, v.y, -v.z} : Vector{v.x, -v.y, v.z};
        for (int k = 0; k < quarters; ++k) v = {-v.y, v.x, v.z};
        return v;
    };
    Rod rod = lying_rod(setup, 1.0, 2.0, 0.3);
    rod.position = turn(rod.position, false);
    rod.axis = turn(rod.axis, false);
    rod.velocity = turn({2.0, 3.0, -10.0}, false);
    rod.angular_momentum = turn({1.0, 20.0, 5.0}, true);
    World world(setup, {.shapes = {rod_shape(setup)}, .beads = {}, .rods = {rod}}, 2e-5, 1, threads);
    run(world, 0, std::llround(time / 2e-5));
    return world.bodies().rods.front();
}

TEST(World, mirrored_and_rotated_scenes_have_mirrored_and_rotated_trajectories) {
    // The arithmetic is the same but for the order of some sums: rounding, multiplied by some ten impacts that hardly
    // spread it.
    const Rod plain = flown(0, false, 0.05);
    const Rod quarter = flown(1, false, 0.05), half = flown(2, false, 0.05), mirror = flown(0, true, 0.05);
    EXPECT_LT(length(quarter.position - Vector{-plain.position.y, plain.position.x, plain.position.z}), 1e-8);
    EXPECT_LT(length(half.position - Vector{-plain.position.x, -plain.position.y, plain.position.z}), 1e-8);
    EXPECT_LT(length(mirror.position - Vector{plain.position.x, -plain.position.y, plain.position.z}), 1e-8);
    EXPECT_LT(length(mirror.axis - Vector{plain.axis.x, -plain.axis.y, plain.axis.z}), 1e-8);
    EXPECT_GT(length(plain.position - Vector{1.0, 2.0, plain.position.z}), 0.1);  // it did move
}

TEST(World, a_head_tail_symmetric_rod_does_not_drift) {
    // Without kicks, and lying flat, nothing tells its ends apart: both strike together, and the impact must not know
    // which is named first. With kicks and starts of any tilt the drift is zero on average: 12 rods for 3 s.
    Threads threads(2);
    dem::Setup setup = square(200.0);
    setup.kick.strength = 0.0;
    const Shape cylinder = make_rod(std::vector<double>(13, 1.1), 4.5, 8.7);
    World flat(setup, {.shapes = {cylinder}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.0)}}, 2e-5, 1, threads);
    run(flat, 0, 25000);
    EXPECT_LT(std::abs(flat.bodies().rods.front().position.x), 1e-6);
    EXPECT_GT(flat.counts().rod_plate, 100);

    setup.kick.strength = 0.015;
    Drawn drawn(11);
    Bodies bodies{.shapes = {make_rod({1.1, 1.1, 0.9, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.9, 1.1, 1.1}, 4.5, 8.7)},
                  .beads = {},
                  .rods = {}};
    for (int i = 0; i < 12; ++i) {
        Rod rod = lying_rod(setup, (i % 4 - 1.5) * 40.0, (i / 4 - 1.0) * 40.0, drawn() * std::numbers::pi);
        const double tilt = 0.02 * drawn();
        rod.axis = {rod.axis.x * std::cos(tilt), rod.axis.y * std::cos(tilt), std::sin(tilt)};
        rod.velocity = {0.0, 0.0, 20.0 * drawn()};
        bodies.rods.push_back(rod);
    }
    World world(setup, bodies, 2e-5, 1, threads);
    std::vector<double> along(12, 0.0);
    std::vector<Rod> before = world.bodies().rods;
    for (int frame = 0; frame < 120; ++frame) {
        run(world, frame * 1250, (frame + 1) * 1250);
        const std::vector<Rod> now = world.bodies().rods;
        for (std::size_t r = 0; r < 12; ++r)
            along[r] += dot(now[r].position - before[r].position, before[r].axis) / 3.0;
        before = now;
    }
    double mean = 0.0, square_sum = 0.0;
    for (const double v : along) mean += v / 12.0;
    for (const double v : along) square_sum += (v - mean) * (v - mean);
    EXPECT_LT(std::abs(mean), 3.0 * std::sqrt(square_sum / 11.0 / 12.0) + 1e-3) << "mm/s";
}

TEST(World, a_single_rod_and_no_body_at_all_can_be_run) {
    Threads threads;
    const dem::Setup setup = square(5.0);
    World none(setup, {.shapes = {make_ball(0.8, 2.7)}, .beads = {}, .rods = {}}, 2e-5, 1, threads);
    run(none, 0, 100);
    EXPECT_EQ(none.energy_kinetic(), 0.0);
    World one(setup, {.shapes = {rod_shape(setup)}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.0)}}, 2e-5, 1,
              threads);
    run(one, 0, 1000);
    EXPECT_GT(one.counts().rod_plate, 0);
}

TEST(World, a_rod_in_a_cell_of_its_length_collides_with_its_image) {
    // Cell of 4.6 by 3 mm: turning, the rod becomes parallel to its image 3 mm above at a distance of 3 cos(angle) mm,
    // and meets it at 68 degrees.
    Threads threads(2);
    dem::Setup setup = square(4.6);
    setup.cell.ly = 3.0;
    Rod rod = lying_rod(setup, 0.0, 0.0, 0.0);
    rod.angular_momentum = {0.0, 0.0, 2000.0};  // turns about z at 56 rad/s
    World world(setup, {.shapes = {rod_shape(setup)}, .beads = {}, .rods = {rod}}, 1e-5, 1, threads);
    const double before = world.energy_kinetic();
    run(world, 0, 20000);
    EXPECT_GT(world.counts().rod_rod, 0);
    EXPECT_NEAR(world.energy_kinetic() - before, sum(world.balance()), 1e-9 * world.balance().plates);
    EXPECT_LT(world.worst_overlap().of_radius, 0.01);
}

TEST(World, the_energy_balance_closes_at_extremes_of_restitution_friction_size_and_shaking) {
    Threads threads;
    const auto closes = [&](const dem::Setup& setup, Bodies bodies, double dt) {
        World world(setup, std::move(bodies), dt, 1, threads);
        const double before = world.energy_kinetic();
        run(world, 0, 3000);
        const EnergyBalance balance = world.balance();
        const double scale = std::abs(balance.plates) + std::abs(balance.gravity) - balance.impact - balance.friction;
        EXPECT_NEAR(world.energy_kinetic() - before, sum(balance), 1e-9 * scale);
        EXPECT_TRUE(std::isfinite(world.energy_kinetic()));
    };
    for (const double e : {0.0, 1.0})
        for (const double mu : {0.0, 10.0}) {
            dem::Setup setup = square(12.0);
            setup.restitution = {e, e, e, 0.3, 0.1, e, e};
            setup.friction = {mu, mu, mu, mu, mu, mu, mu};
            Drawn drawn(5);
            closes(setup, mixture(setup, drawn), 1e-5);
        }
    dem::Setup inelastic = square(12.0);
    inelastic.restitution = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    Drawn drawn(6);
    closes(inelastic, mixture(inelastic, drawn), 2e-5);
    dem::Setup still = square(12.0);
    still.plates.amplitude = 0.0;
    closes(still, mixture(still, drawn), 2e-5);
    dem::Setup strong = square(12.0);
    strong.plates.amplitude = 0.4;  // 64 g
    strong.contacts.max_overlap = 0.1;
    closes(strong, mixture(strong, drawn), 5e-6);
    dem::Setup sizes = square(12.0);  // a bead of 1.1 mm among beads of 0.11 mm
    Bodies bodies = lattice(sizes, 30, 30, 0.11, 20.0, drawn);
    bodies.shapes.push_back(make_ball(1.1, 2.7));
    std::erase_if(bodies.beads, [](const Bead& b) { return std::hypot(b.position.x, b.position.y) < 0.7; });
    bodies.beads.push_back({.position = {0.0, 0.0, 0.68}, .velocity = {10.0, 0.0, 0.0}, .spin = {}, .shape = 1});
    closes(sizes, bodies, 5e-6);
}

TEST(World, a_step_too_long_fails_with_the_names_of_the_pair) {
    Threads threads;
    dem::Setup setup = elastic(10.0);
    Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                  .beads = {{.position = {-1.0, 0.0, 0.6}, .velocity = {400.0, 0.0, 0.0}},
                            {.position = {1.0, 0.0, 0.6}}},
                  .rods = {}};
    World world(setup, bodies, 5e-4, 1, threads);
    try {
        run(world, 0, 100);
        FAIL() << "expected an error";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::run);
        const std::string words = error.what();
        for (const char* part : {"bead 0", "bead 1", "overlap by", "step", "time.dt"})
            EXPECT_NE(words.find(part), std::string::npos) << words;
    }
}

TEST(WorldLong, work_of_kicks_does_not_depend_on_the_step) {
    // <omega_z^2> gains eps^2 v^2 at each hit: the variance is a property of the impacts, not of the steps.  Sixteen
    // rods, 1 s; the turn of omega by friction is common to all.  Mean squares of 16 x 16 kicks spread by sqrt(2/16) =
    // 0.35 each.
    Threads threads(2);
    const auto work_of_kicks = [&](double dt) {
        dem::Setup setup = square(40.0);
        setup.kick.strength = 0.05;
        setup.contacts.substep = dt;
        Bodies bodies{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {}};
        Drawn drawn(8);
        for (int i = 0; i < 16; ++i) {
            Rod rod = lying_rod(setup, (i % 4 - 1.5) * 10.0, (i / 4 - 1.5) * 10.0, drawn() * std::numbers::pi);
            rod.velocity = {0.0, 0.0, 20.0 * drawn()};
            bodies.rods.push_back(rod);
        }
        World world(setup, bodies, dt, 1, threads);
        run(world, 0, std::llround(1.0 / dt));
        return world.balance().kicks;
    };
    const double fine = work_of_kicks(5e-6), coarse = work_of_kicks(4e-5);
    EXPECT_NEAR(coarse / fine, 1.0, 0.25);
}

}  // namespace
}  // namespace drover::dem::world_tests
