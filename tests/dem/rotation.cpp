// tests/dem/rotation.cpp: free tops against conservation laws and Euler's equations.
#include "dem/bodies/rotation.hpp"

#include <gtest/gtest.h>

#include "drover/dem/bodies.hpp"

namespace drover::dem::rotation_tests {
namespace {

const Shape rod = make_rod({1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 0.88, 0.88, 0.88, 0.72, 0.72, 0.72}, 4.5, 8.7);
const Vector start{0.48, 0.64, 0.6};

Rod turning(const Vector& axis, const Vector& momentum) { return {.axis = axis, .angular_momentum = momentum}; }

TEST(FreeTop, conserves_energy_and_the_tilt_of_its_axis_over_a_million_steps) {
    // L is what is stored, and stays to the last bit.  Rounding of the axis: a walk of 1e6 steps of 1e-16 is 1e-13.
    const Vector momentum{300.0, -120.0, 900.0};
    Vector axis = start;
    const double energy = rotation_energy(turning(axis, momentum), rod), tilt = dot(momentum, axis);
    for (int n = 0; n < 1000000; ++n) axis = turned_freely(axis, momentum, rod.inertia_across, 1e-4 * (1 + n % 3));
    EXPECT_NEAR(rotation_energy(turning(axis, momentum), rod) / energy, 1.0, 1e-11);
    EXPECT_NEAR(dot(momentum, axis) / tilt, 1.0, 1e-11);
    EXPECT_NEAR(length(axis), 1.0, 1e-15);
}

TEST(FreeTop, rotates_with_its_angular_velocity) {
    // dn/dt = omega x n, by a central difference over 1e-4 s: error (omega dt)^2/6 = 1e-7.
    const Vector momentum{30.0, -12.0, 90.0};
    constexpr double dt = 1e-4;
    const Vector rate = 0.5 / dt *
                        (turned_freely(start, momentum, rod.inertia_across, dt) -
                         turned_freely(start, momentum, rod.inertia_across, -dt));
    const Vector expected = cross(angular_velocity(turning(start, momentum), rod), start);
    EXPECT_LT(length(rate - expected), 1e-7 * length(expected));
}

TEST(FreeTop, is_exact_for_any_step) {
    const Vector momentum{30.0, -12.0, 90.0};
    Vector many = start;
    for (int n = 0; n < 1000; ++n) many = turned_freely(many, momentum, rod.inertia_across, 0.01);
    EXPECT_LT(length(many - turned_freely(start, momentum, rod.inertia_across, 10.0)), 1e-12);
}

TEST(FreeTop, at_rest_stays_at_rest) {
    const Vector axis = turned_freely(start, {}, rod.inertia_across, 1.0);
    EXPECT_EQ(axis.x, start.x);
    EXPECT_EQ(axis.y, start.y);
    EXPECT_EQ(axis.z, start.z);
}

TEST(AngularVelocity, of_a_body_across_and_along_its_axis_is_momentum_over_inertia) {
    const Vector axis{1.0, 0.0, 0.0};
    EXPECT_NEAR(angular_velocity(turning(axis, {3.0, 0.0, 0.0}), rod).x, 3.0 / rod.inertia_along, 1e-15);
    EXPECT_NEAR(angular_velocity(turning(axis, {0.0, 3.0, 0.0}), rod).y, 3.0 / rod.inertia_across, 1e-15);
}

}  // namespace
}  // namespace drover::dem::rotation_tests
