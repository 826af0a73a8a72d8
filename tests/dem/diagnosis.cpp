// tests/dem/diagnosis.cpp: the messages of failed worlds name what failed first and its cause.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "dem/scenes.hpp"
#include "drover/base/error.hpp"

namespace drover::dem::diagnosis_tests {
namespace {
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// The message with which a world fails within some steps.
std::string failure_of(const dem::Setup& setup, const Bodies& bodies, double dt, int steps) {
    Threads threads;
    try {
        World world(setup, bodies, dt, 1, threads);
        run(world, 0, steps);
    } catch (const Error& error) {
        return error.what();
    }
    return "none";
}

Bodies two_beads(double distance, const Vector& first, const Vector& second) {
    return {.shapes = {make_ball(0.8, 2.7)},
            .beads = {{.position = {0.0, 0.0, 0.6}, .velocity = first},
                      {.position = {distance, 0.0, 0.6}, .velocity = second}},
            .rods = {}};
}

TEST(Diagnosis, of_a_velocity_that_is_not_a_number_names_the_body_and_not_the_time_step) {
    const Bodies bodies = two_beads(2.0, {}, {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0});
    EXPECT_THAT(failure_of(square(10.0), bodies, 2e-5, 3), AllOf(HasSubstr("bead 1"), Not(HasSubstr("time.dt"))));
}

TEST(Diagnosis, of_huge_kicks_names_them_and_not_the_time_step) {
    dem::Setup setup = square(10.0);
    setup.kick.strength = 1e300;
    Bodies bodies{.shapes = {rod_shape(setup)}, .beads = {}, .rods = {lying_rod(setup, 0.0, 0.0, 0.3)}};
    EXPECT_THAT(failure_of(setup, bodies, 2e-5, 2000),
                AllOf(HasSubstr("kicks (kick.strength)"), Not(HasSubstr("time.dt"))));
}

TEST(Diagnosis, of_an_impulse_that_is_not_finite_names_the_contact_and_its_coefficients) {
    dem::Setup setup = elastic(10.0);
    setup.friction.bead_bead = 0.5;
    const Bodies bodies = two_beads(0.8 * (1.0 - 1e-9), {1e200, 1e200, 0.0}, {-1e200, 0.0, 0.0});
    EXPECT_THAT(failure_of(setup, bodies, 1e-215, 1),
                AllOf(HasSubstr("bead 0 and bead 1 is not finite (restitution 1, friction 0.5"),
                      Not(HasSubstr("time.dt"))));
}

TEST(Diagnosis, of_an_overlap_of_fast_bodies_gives_the_time_step_that_would_do) {
    const Bodies bodies = two_beads(0.81, {2000.0, 0.0, 0.0}, {});
    // 0.02 of a radius of 0.4 mm, half of it a step at 2000 mm/s.
    EXPECT_THAT(failure_of(square(10.0), bodies, 2e-5, 1),
                AllOf(HasSubstr("bead 0 and bead 1 overlap"), HasSubstr("choose time.dt <= 2e-06")));
}

TEST(Diagnosis, of_an_overlap_of_soft_bodies_that_are_pressed_gives_their_stiffness_as_the_cause) {
    dem::Setup setup = square(10.0);
    setup.plates.amplitude = 0.0;
    setup.contacts.model = ContactModel::spring_dashpot;
    setup.contacts.stiffness = 1e5;  // at rest a bead sinks by m g/k = 0.07 mm into the base
    Bodies bodies = two_beads(2.0, {}, {});
    for (Bead& bead : bodies.beads) bead.position.z = 0.4 + 1e-6;
    EXPECT_THAT(failure_of(setup, bodies, 1e-5, 100000), AllOf(HasSubstr("the base"), HasSubstr("too soft")));
}

}  // namespace
}  // namespace drover::dem::diagnosis_tests
