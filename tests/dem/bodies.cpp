// tests/dem/bodies.cpp: how many bodies a setup asks for, of which shapes, and which bodies a world accepts.
#include "drover/dem/bodies.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/refusal.hpp"
#include "dem/packing_support.hpp"
#include "dem/scenes.hpp"

namespace drover::dem::bodies_tests {
namespace {

TEST(Bodies, of_the_paper_have_its_numbers_and_two_shapes) {
    const Bodies bodies = make_bodies(mixture(247.95, 0.6, 0.11), 1);
    EXPECT_EQ(bodies.beads.size(), 73385U);
    EXPECT_EQ(bodies.rods.size(), 1642U);
    ASSERT_EQ(bodies.shapes.size(), 2U);
    EXPECT_NEAR(bodies.shapes[bodies.beads[0].shape].mass, 0.7238, 5e-5);
    EXPECT_NEAR(bodies.shapes[bodies.rods[0].shape].mass, 26.99, 0.005);
}

TEST(Bodies, of_a_mixture_are_apportioned_by_largest_remainders) {
    auto setup = mixture(45.0, 0.0, 0.0);
    setup.beads.count = 10;
    setup.beads.diameters = {0.6, 0.8, 1.0, 0.8};
    setup.beads.proportions = {1.0, 1.0, 1.0, 0.0};
    const Bodies bodies = make_bodies(setup, 1);
    ASSERT_EQ(bodies.shapes.size(), 3U);
    std::vector<int> counts(3);
    for (const Bead& bead : bodies.beads) ++counts[bead.shape];
    EXPECT_EQ(counts, (std::vector<int>{4, 3, 3}));
    EXPECT_EQ(bodies.shapes[2].radius, std::vector<double>{0.5});
}

TEST(Bodies, of_equal_diameter_share_a_shape) {
    auto setup = mixture(45.0, 0.1, 0.0);
    setup.beads.diameters = {0.8, 0.6, 0.8};
    setup.beads.proportions = {1.0, 2.0, 3.0};
    EXPECT_EQ(make_bodies(setup, 1).shapes.size(), 2U);
}

TEST(Bodies, rods_with_a_size_tolerance_are_scaled_copies_with_that_spread) {
    auto setup = mixture(247.95, 0.0, 0.11);
    setup.rods.size_tolerance = 0.01;
    const Bodies bodies = make_bodies(setup, 1);
    ASSERT_EQ(bodies.shapes.size(), bodies.rods.size());
    double mean = 0.0, square = 0.0;
    const auto count = static_cast<double>(bodies.rods.size());
    for (const Rod& rod : bodies.rods) {
        const Shape& shape = bodies.shapes[rod.shape];
        const double size = (shape.head - shape.tail) / 4.5;
        EXPECT_NEAR(shape.radius.front(), 0.55 * size, 1e-14);
        EXPECT_NEAR(shape.mass / 26.99, size * size * size, 2e-4);  // of a mass given to four digits
        mean += size / count;
        square += (size - 1.0) * (size - 1.0) / count;
    }
    EXPECT_NEAR(mean, 1.0, 0.001);                 // 4 of 0.01/sqrt(1642)
    EXPECT_NEAR(std::sqrt(square), 0.01, 0.0007);  // 4 of 0.01/sqrt(2 1642)
    EXPECT_EQ(make_bodies(setup, 1).shapes[5].mass, bodies.shapes[5].mass);
    EXPECT_NE(make_bodies(setup, 2).shapes[5].mass, bodies.shapes[5].mass);
}

TEST(Bodies, rods_with_a_density_for_each_sphere_have_that_mass_distribution) {
    auto setup = mixture(45.0, 0.0, 0.0);
    setup.rods.count = 1;
    const Shape even = make_bodies(setup, 1).shapes[0];
    setup.rods.densities.assign(13, 8.7);
    EXPECT_NEAR(make_bodies(setup, 1).shapes[0].mass / even.mass, 1.0, 1e-14);
    std::fill(setup.rods.densities.begin() + 7, setup.rods.densities.end(), 1.0);
    const Shape tail_heavy = make_bodies(setup, 1).shapes[0];
    EXPECT_LT(tail_heavy.mass, even.mass);
    EXPECT_GT(tail_heavy.tail, even.tail);  // the centre of mass is nearer to the tail
}

TEST(Bodies, too_thick_for_the_gap_are_rejected) {
    auto setup = mixture(45.0, 0.0, 0.11);
    setup.rods.size_tolerance = 0.1;  // one of 54 rods is larger than 1.09 times its size, almost surely
    try {
        static_cast<void>(make_bodies(setup, 1));
        ADD_FAILURE();
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        EXPECT_NE(std::string(error.what()).find("plates.gap = 1.2 mm with a body 1."), std::string::npos)
            << error.what();
    }
}

TEST(BodiesOfAWorld, with_unknown_shapes_are_rejected) {
    Threads threads;
    Bodies bodies{.shapes = {make_ball(0.8, 2.7)}, .beads = {{.position = {0.0, 0.0, 0.6}, .shape = 1}}, .rods = {}};
    EXPECT_THROW(World(elastic(10.0), bodies, 1e-4, 1, threads), Error);
    bodies.beads.clear();
    bodies.rods = {{.position = {0.0, 0.0, 0.6}, .shape = 1}};
    EXPECT_THROW(World(elastic(10.0), bodies, 1e-4, 1, threads), Error);
}

TEST(BodiesOfAWorld, keep_their_numbers_and_shapes_when_others_are_set) {
    Threads threads;
    const dem::Setup setup = elastic(20.0);
    Rod rod = lying_rod(setup, 5.0, 5.0, 0.0);
    rod.shape = 2;
    World world(setup,
                {.shapes = {make_ball(0.8, 2.7), make_ball(0.9, 2.7), rod_shape(setup)},
                 .beads = {{.position = {-1.0, 0.0, 0.6}}, {.position = {1.0, 0.0, 0.6}, .shape = 1}},
                 .rods = {rod}},
                1e-4, 1, threads);
    const std::vector<double> before = world.save();
    const auto rejects = [&](auto change) {
        Bodies changed = world.bodies();
        change(changed);
        EXPECT_THROW(world.set_bodies(changed, 0), Error);
        EXPECT_EQ(world.save(), before);
    };
    rejects([](Bodies& b) { b.beads.push_back({.position = {-4.0, 0.0, 0.6}}); });
    rejects([](Bodies& b) { b.beads.pop_back(); });
    rejects([](Bodies& b) { b.rods.clear(); });
    rejects([](Bodies& b) { b.beads[0].shape = 77; });
    rejects([](Bodies& b) { b.beads[0].shape = 1; });
    rejects([](Bodies& b) { b.rods[0].shape = 3; });
    Bodies larger = world.bodies();
    larger.shapes[0] = make_ball(0.82, 2.7);
    world.set_bodies(larger, 0);
    EXPECT_EQ(world.save(), before);  // the world keeps its shapes
}

TEST(BodiesOfAWorld, that_overlap_the_plates_or_are_not_finite_are_rejected_at_the_start) {
    Threads threads;
    const dem::Setup setup = square(20.0);  // the base is at 0.08 mm at t = 0, the lid at 1.28 mm
    const auto refused = [&](const Bodies& bodies, double dt = 1e-5) {
        return refusal_of([&] { World(setup, bodies, dt, 1, threads); });
    };
    const auto ball = [](double diameter, const Vector& at, const Vector& velocity = {}) {
        return Bodies{.shapes = {make_ball(diameter, 2.7)},
                      .beads = {{.position = at, .velocity = velocity}},
                      .rods = {}};
    };
    EXPECT_EQ(refused(ball(0.8, {0.0, 0.0, 0.6})), "no refusal");
    EXPECT_EQ(refused(ball(0.8, {0.0, 0.0, 0.3})),
              "bead 0 and the base overlap by 0.18 mm, 0.45 of a radius; expected at most contacts.max_overlap = 0.02");
    EXPECT_NE(refused(ball(0.8, {0.0, 0.0, 30.0})).find("bead 0 and the lid overlap"), std::string::npos);
    EXPECT_NE(refused(ball(3.0, {0.0, 0.0, 0.7})).find("overlap"), std::string::npos);
    EXPECT_NE(refused(ball(0.8, {0.0, 0.0, 0.6}, {NAN, 0.0, 0.0})).find("expected finite values"), std::string::npos);
    Bodies rods{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.0)}};
    rods.rods[0].axis = {3.0, 0.0, 0.0};
    const World world(setup, rods, 1e-5, 1, threads);
    EXPECT_EQ(world.bodies().rods[0].axis.x, 1.0);
    rods.rods[0].axis = {};
    EXPECT_EQ(refused(rods), "the axis of rod 0 is of length 0; expected 1");
    for (const double dt : {0.0, -1e-5, static_cast<double>(NAN), static_cast<double>(INFINITY), 1.0})
        EXPECT_NE(refused(ball(0.8, {0.0, 0.0, 0.6}), dt).find("time.dt = "), std::string::npos) << dt;
}

TEST(BodiesOfAWorld, that_overlapped_in_a_step_are_advanced_only_after_others_are_set) {
    Threads threads;
    const dem::Setup setup = elastic(20.0);
    Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                  .beads = {{.position = {-1.0, 0.0, 0.6}}, {.position = {1.0, 0.0, 0.6}}},
                  .rods = {}};
    World world(setup, bodies, 1e-3, 1, threads);
    const std::vector<double> before = world.save();
    bodies.beads[0].velocity.x = 1700.0;  // within one step into the other
    world.set_bodies(bodies, 0);
    EXPECT_NE(refusal_of([&] { world.advance(0); }).find("moves by 1.7 mm in a step"), std::string::npos);
    EXPECT_NE(refusal_of([&] { world.advance(1); }).find("expected set_bodies() or restore() first"),
              std::string::npos);
    world.restore(before);
    EXPECT_NO_THROW(world.advance(0));
    for (const double speed : {1700.0, 1300.0, 1e200, 0.0}) {  // a smaller overlap, and bodies that left the numbers
        bodies.beads[0].velocity.x = speed;
        world.set_bodies(bodies, 0);
        EXPECT_EQ(refusal_of([&] { world.advance(0); }) == "no refusal", speed == 0.0) << speed;
    }
}

TEST(BodiesOfAWorld, that_would_pass_through_others_in_a_step_end_the_run) {
    Threads threads;
    const dem::Setup setup = elastic(20.0);
    for (const double speed : {5000.0, -1e5}) {  // of one that is met head-on, or by nobody
        const Vector velocity{speed, 0.0, 0.0};
        const Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                            .beads = {{.position = {-1.0, 0.0, 0.6}, .velocity = velocity},
                                      {.position = {1.0, 0.0, 0.6}, .velocity = -1.0 * velocity}},
                            .rods = {}};
        World world(setup, bodies, 1e-3, 1, threads);
        EXPECT_NE(refusal_of([&] { world.advance(0); }).find("more than its radius of 0.4 mm"), std::string::npos);
    }
}

}  // namespace
}  // namespace drover::dem::bodies_tests
