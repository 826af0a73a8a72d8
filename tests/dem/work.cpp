// tests/dem/work.cpp: the parts of the energy balance against what they are the work of.
#include <gtest/gtest.h>

#include "dem/scenes.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem::work_tests {
namespace {

TEST(Work, of_gravity_and_constant_forces_is_their_force_times_the_displacements) {
    Threads threads;
    dem::Setup setup = square(12.0);
    setup.cell.shape = CellShape::rectangle;  // whose positions are not wrapped
    setup.gravity.x = 300.0;
    for (const double rod_y : {0.0, 300.0}) {
        setup.forces = {.bead_x = 50.0, .rod_y = rod_y};
        const auto potential = [&](const Bodies& bodies) {
            double total = 0.0;
            const auto add = [&](const auto& body, const Vector& force) {
                const Vector gravity{setup.gravity.x, setup.gravity.y, setup.gravity.z};
                total += dot(bodies.shapes[body.shape].mass * gravity + force, body.position);
            };
            for (const Bead& bead : bodies.beads) add(bead, {50.0, 0.0, 0.0});
            for (const Rod& rod : bodies.rods) add(rod, {0.0, rod_y, 0.0});
            return total;
        };
        Drawn drawn(2);
        World world(setup, mixture(setup, drawn), 2e-5, 1, threads);
        const double before = potential(world.bodies());
        run(world, 0, 10000);
        EXPECT_GT(world.counts().rod_plate, 100);
        EXPECT_GT(world.counts().rod_wall, 0);
        // Rounding of 10^4 steps; overlaps of rods that were removed without being booked made a difference of 1.8e4.
        EXPECT_NEAR(world.balance().gravity, potential(world.bodies()) - before, 1e-9 * world.balance().plates);
    }
}

}  // namespace
}  // namespace drover::dem::work_tests
