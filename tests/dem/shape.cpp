// tests/dem/shape.cpp: mass, centre and inertia of unions of spheres against closed forms, published numbers and
// sampling.
#include "drover/dem/bodies.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace drover::dem::shape_tests {
namespace {

using std::numbers::pi;

const std::vector<double> tapered{1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 0.88, 0.88, 0.88, 0.72, 0.72, 0.72};

TEST(Shape, of_one_sphere_has_the_mass_and_inertia_of_a_ball) {
    const Shape ball = make_ball(0.8, 2.7);
    const double mass = 2.7 * pi / 6.0 * 0.8 * 0.8 * 0.8;
    EXPECT_NEAR(ball.mass, mass, 1e-15);
    EXPECT_NEAR(ball.mass, 0.7238, 5e-5);  // a bead of the experiment, to four digits
    EXPECT_NEAR(ball.inertia_along, 0.4 * mass * 0.16, 1e-15);
    EXPECT_NEAR(ball.inertia_across, 0.4 * mass * 0.16, 1e-15);
    EXPECT_NEAR(ball.projected_area, pi * 0.16, 1e-15);
    EXPECT_NEAR(ball.head, 0.4, 1e-15);
}

TEST(Shape, of_the_tapered_rod_has_its_published_mass_centre_and_inertia) {
    const Shape rod = make_rod(tapered, 4.5, 8.7);
    EXPECT_NEAR(rod.mass, 26.99, 0.005);
    EXPECT_NEAR(-rod.tail, 1.942, 0.0005);
    EXPECT_NEAR(rod.inertia_along, 3.376, 0.0005);
    EXPECT_NEAR(rod.inertia_across, 35.445, 0.0005);
    EXPECT_NEAR(rod.projected_area, 4.118, 0.0005);
    EXPECT_NEAR(rod.head - rod.tail, 4.5, 1e-14);
    EXPECT_NEAR(rod.at[1] - rod.at[0], 0.2992, 5e-5);
}

TEST(Shape, agrees_with_a_sum_over_thin_slices) {
    // Overlapping, nested and separate spheres of several densities.  Slices 1.7e-5 wide: a jump of density is that far
    // off.
    const std::vector<AxisSphere> spheres{{.at = 0.0, .radius = 0.5, .density = 2.0},
                                          {.at = 0.3, .radius = 0.6, .density = 1.0},
                                          {.at = 0.35, .radius = 0.2, .density = 9.0},  // inside another
                                          {.at = 1.1, .radius = 0.4, .density = 3.0},
                                          {.at = 2.6, .radius = 0.3, .density = 0.0}};
    const Shape shape = make_shape(spheres);
    constexpr int slices = 200000;
    const double low = -0.5, high = 2.9, dz = (high - low) / slices;
    double mass = 0.0, first = 0.0, along = 0.0, second = 0.0, fourth = 0.0, area = 0.0;
    for (int n = 0; n < slices; ++n) {
        const double z = low + (n + 0.5) * dz;
        double square = 0.0, density = 0.0;
        for (const AxisSphere& s : spheres)
            if (const double here = s.radius * s.radius - (z - s.at) * (z - s.at); here > square)
                square = here, density = s.density;
        mass += density * pi * square * dz;
        first += density * pi * square * z * dz;
        second += density * pi * square * z * z * dz;
        fourth += density * pi * square * square * dz;
        area += 2.0 * std::sqrt(square) * dz;
    }
    along = 0.5 * fourth;
    const double centre = first / mass;
    EXPECT_NEAR(shape.mass, mass, 2e-5);
    EXPECT_NEAR(shape.at[0], -centre, 2e-5);
    EXPECT_NEAR(shape.inertia_along, along, 2e-5);
    EXPECT_NEAR(shape.inertia_across, 0.25 * fourth + second - mass * centre * centre, 2e-5);
    EXPECT_NEAR(shape.projected_area, area, 1e-4);
}

TEST(Shape, of_a_reversed_rod_is_its_mirror_image) {
    const std::vector<double> back(tapered.rbegin(), tapered.rend());
    const Shape rod = make_rod(tapered, 4.5, 8.7), turned = make_rod(back, 4.5, 8.7);
    EXPECT_NEAR(turned.tail, -rod.head, 1e-13);
    EXPECT_NEAR(turned.inertia_across, rod.inertia_across, 1e-12);
}

TEST(Shape, that_is_impossible_is_rejected) {
    EXPECT_THROW(make_shape({}), Error);
    EXPECT_THROW(make_ball(0.0, 1.0), Error);
    EXPECT_THROW(make_ball(1.0, 0.0), Error);
    EXPECT_THROW(make_ball(1.0, -1.0), Error);
    EXPECT_THROW(make_rod({1.1, 0.7}, 0.9, 8.7), Error);
    // The sphere in the middle would reach from 0 to 2, beyond the tips at 0.25 and 1.75.
    EXPECT_THROW(make_rod({0.5, 2.0, 0.5}, 1.5, 8.7), Error);
    EXPECT_NO_THROW(make_rod({0.5, 2.0, 0.5}, 2.0, 8.7));
}

}  // namespace
}  // namespace drover::dem::shape_tests
