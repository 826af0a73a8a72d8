// tests/dem/rod_flight.cpp: rods that overlap the plates after a step, and the random numbers of their kicks.
#include <gtest/gtest.h>

#include <cmath>

#include "dem/scenes.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem::rod_flight_tests {
namespace {

TEST(RodFlight, a_rod_that_turns_far_into_a_plate_within_a_step_is_thrown_back) {
    Threads threads;
    for (const double rate : {500.0, 2000.0, 5000.0}) {  // the ends move by up to 0.2 mm in a step
        dem::Setup setup = square(10.0);
        setup.plates = {.amplitude = 0.0, .gap = 2.0};
        setup.gravity = {};
        setup.restitution.rod_plate = 1.0;
        setup.friction.rod_plate = 0.0;
        setup.kick.strength = 0.0;
        const Shape shape = rod_shape(setup);
        Rod rod = lying_rod(setup, 0.0, 0.0, 0.0);
        rod.position.z = 1.0;
        rod.axis = {std::cos(0.05), 0.0, std::sin(0.05)};
        rod.angular_momentum = {0.0, shape.inertia_across * rate, 0.0};
        World world(setup, {.shapes = {shape}, .beads = {}, .rods = {rod}}, 2e-5, 1, threads);
        const double before = world.energy_kinetic();
        run(world, 0, 5000);
        // From tilt to tilt of at most 0.43 rad it takes at most 0.86/rate; half of it where steps are as long as that.
        EXPECT_GT(static_cast<double>(world.counts().rod_plate), 0.5 * 0.1 * rate / 0.86) << rate;
        EXPECT_NEAR(world.energy_kinetic() - before, sum(world.balance()), 1e-11 * before) << rate;
        EXPECT_NEAR(world.energy_kinetic(), before, 1e-2 * before) << rate;  // increments of impacts are right to 1e-4
    }
}

TEST(RodFlight, rods_with_another_first_kick_have_other_kicks_of_the_same_seed) {
    Threads threads;
    dem::Setup setup = square(20.0);
    setup.kick.strength = 0.1;
    const auto turned = [&](std::int64_t first_kick) {
        Bodies bodies{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.0)}};
        bodies.first_kick = first_kick;
        World world(setup, bodies, 2e-5, 1, threads);
        run(world, 0, 5000);
        EXPECT_GT(world.counts().rod_plate, 0);
        return world.bodies().rods[0].axis.y;
    };
    EXPECT_EQ(turned(0), turned(0));
    EXPECT_NE(turned(0), turned(std::int64_t{1} << 40));
}

}  // namespace
}  // namespace drover::dem::rod_flight_tests
