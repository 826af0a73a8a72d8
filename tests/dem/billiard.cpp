// tests/dem/billiard.cpp: an elastic bead in cells with walls, against the exact billiard.
#include <gtest/gtest.h>

#include <cmath>

#include "dem/scenes.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem::billiard_tests {
namespace {

struct Flight {
    double x, y, vx, vy;
};

/// The exact billiard of a point in a circle of this radius about the origin.
Flight in_circle(Flight at, double radius, double time) {
    while (true) {
        const double square = at.vx * at.vx + at.vy * at.vy, along = at.x * at.vx + at.y * at.vy;
        const double hit =
            (-along + std::sqrt(along * along + square * (radius * radius - at.x * at.x - at.y * at.y))) / square;
        const double flown = std::min(hit, time);
        at.x += flown * at.vx;
        at.y += flown * at.vy;
        if (hit >= time) return at;
        time -= hit;
        const double outward = (at.x * at.vx + at.y * at.vy) / (radius * radius);
        at.vx -= 2.0 * outward * at.x;
        at.vy -= 2.0 * outward * at.y;
    }
}

/// Of a frictionless elastic bead of diameter 0.8 after this time.
Flight of_bead(const Cell& cell, GroupLaw law, const Flight& start, double dt, double time) {
    Threads threads;
    dem::Setup setup = elastic(10.0);
    setup.cell = cell;
    setup.contacts.law = law;
    const Bodies bodies{.shapes = {make_ball(0.8, 2.7)},
                        .beads = {{.position = {start.x, start.y, 0.6}, .velocity = {start.vx, start.vy, 0.0}}},
                        .rods = {}};
    World world(setup, bodies, dt, 1, threads);
    run(world, 0, std::llround(time / dt));
    const Bead bead = world.bodies().beads.front();
    return {bead.position.x, bead.position.y, bead.velocity.x, bead.velocity.y};
}

double angular_momentum(const Flight& at) { return at.x * at.vy - at.y * at.vx; }

TEST(Billiard, in_a_circle_is_exact_for_any_step) {
    const Cell circle{.shape = CellShape::circle, .radius = 5.0};
    for (const Flight& start : {Flight{1.0, -2.0, 130.0, 45.0}, {3.0, 1.0, 40.0, -90.0}})
        for (const GroupLaw law : {GroupLaw::simultaneous, GroupLaw::first_to_last})
            for (const double dt : {5e-6, 2.5e-5}) {
                const Flight exact = in_circle(start, 5.0 - 0.4, 2.0);
                const Flight found = of_bead(circle, law, start, dt, 2.0);
                // Each of 40 hits turns by twice the error of its angle: rounding grows in proportion to them squared.
                EXPECT_NEAR(angular_momentum(found), angular_momentum(start), 1e-10 * 400.0) << name_of(law) << dt;
                EXPECT_NEAR(found.x, exact.x, 1e-9) << name_of(law) << dt;
                EXPECT_NEAR(found.y, exact.y, 1e-9) << name_of(law) << dt;
            }
}

TEST(Billiard, in_a_rectangle_unfolds_to_a_straight_line) {
    const Cell box{.shape = CellShape::rectangle, .lx = 10.0, .ly = 7.0};
    const Flight start{1.0, -2.0, 130.0, 45.0};
    const auto folded = [](double place, double half) {  // a triangle wave
        const double way = std::fmod(std::abs(place + half), 4.0 * half);
        return way < 2.0 * half ? way - half : 3.0 * half - way;
    };
    for (const double dt : {5e-6, 2.5e-5}) {
        const Flight found = of_bead(box, GroupLaw::simultaneous, start, dt, 2.0);
        EXPECT_NEAR(found.x, folded(start.x + 2.0 * start.vx, 4.6), 1e-9) << dt;
        EXPECT_NEAR(found.y, folded(start.y + 2.0 * start.vy, 3.1), 1e-9) << dt;
    }
}

TEST(Billiard, in_petals_that_form_a_circle_is_that_of_the_circle) {
    const Cell petals{.shape = CellShape::flower, .radius = 5.0, .petals = 8, .petal_radius = 5.0};
    const Flight start{1.0, -2.0, 130.0, 45.0};
    const Flight exact = in_circle(start, 5.0 - 0.4, 1.0),
                 found = of_bead(petals, GroupLaw::simultaneous, start, 2e-5, 1.0);
    EXPECT_NEAR(found.x, exact.x, 1e-9);
    EXPECT_NEAR(found.y, exact.y, 1e-9);
}

}  // namespace
}  // namespace drover::dem::billiard_tests
