// tests/calibrate/system_factory.cpp: tiny assays on the particle world: finite, reproducible and of the right sign.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "calibrate/catalogue.hpp"
#include "drover/base/error.hpp"

namespace drover::calibrate::system_factory_tests {
namespace {

/// Two rods among 80 beads.
Conditions tiny() {
    Conditions conditions{.setup = {}, .seed = 3};
    conditions.setup.cell.lx = conditions.setup.cell.ly = 10.0;
    conditions.setup.beads.count = 80;
    conditions.setup.rods.count = 2;
    return conditions;
}

/// Every assay with trials of about a tenth of a second.
std::vector<Assay> brief_assays() {
    return {relaxation({.warm_up = 0.02, .frame = 0.005, .time = 0.1, .max_lag = 0.05}),
            weathercock({.speeds = {5.0, 10.0}, .distance = 0.2, .warm_up = 0.02, .align = 0.01, .settle = 0.005}),
            drag({.torques = {1000.0, 10000.0}, .warm_up = 0.02, .time = 0.04, .windows = 2, .frame = 0.005}),
            damping({.warm_up = 0.02, .hold = 0.01, .time = 0.05, .frame = 0.005}),
            shear({.waves = {1, 2}, .warm_up = 0.02, .hold = 0.01, .releases = 1, .time = 0.04, .frame = 0.005}),
            propulsion({.warm_up = 0.02, .time = 0.1}),
            stiffness({.waves = 1, .warm_up = 0.02, .settle = 0.01, .time = 0.02, .frame = 0.005}),
            diffusion({.warm_up = 0.02, .frame = 0.005, .time = 0.06, .min_lag = 0.01, .max_lag = 0.04})};
}

TEST(WorldSystem, gives_every_assay_finite_and_reproducible_numbers_that_differ_between_trials) {
    const SystemFactory make = system_factory(2e-5);
    for (const Assay& assay : brief_assays()) {
        const Trial one = run_trial(assay, make, tiny(), 0), again = run_trial(assay, make, tiny(), 0);
        const Trial other = run_trial(assay, make, tiny(), 1);
        EXPECT_TRUE(std::all_of(one.begin(), one.end(), [](double x) { return std::isfinite(x); })) << assay.name;
        ASSERT_EQ(one.size(), again.size());
        for (std::size_t i = 0; i < one.size(); ++i)
            EXPECT_EQ(std::bit_cast<std::uint64_t>(one[i]), std::bit_cast<std::uint64_t>(again[i])) << assay.name;
        EXPECT_EQ(one.size(), other.size());
        EXPECT_NE(one, other) << assay.name;
        EXPECT_EQ(measurement_of(assay, std::vector<Trial>{one, other}).estimates.size(), assay.quantities.size());
    }
}

TEST(WorldSystem, applies_forces_and_measures_their_effect) {
    dem::Setup setup = tiny().setup;
    setup.packing.kind = dem::PackingKind::aligned;
    setup.forces = {.torque = 2e4, .hold_beads = true, .bead_velocity_y = 4.0};
    const auto system = system_factory(2e-5)(setup, 1);
    system->advance_to(0.02);
    for (const RodPose& rod : system->rods()) EXPECT_LT(std::abs(rod.angle), 0.3);
    const BeadMotion start = system->beads();
    EXPECT_NEAR(start.vy, 4.0, 0.2);
    system->advance_to(0.03);
    EXPECT_NEAR((system->beads().y - start.y) / 0.01, 4.0, 0.1);
    system->impose({.hold_beads = true, .bead_velocity_x = -7.0, .held_waves = 2});
    system->advance_to(0.035);
    EXPECT_NEAR(system->shear_wave(2), -7.0, 0.2);
    system->impose({.push = 300.0, .push_waves = 1});
    system->advance_to(0.12);
    EXPECT_LT(system->density_wave(1), -0.1);  // beads gather at half of the cell, where the force vanishes
}

TEST(WorldSystem, rejects_steps_times_and_waves_that_give_no_numbers) {
    for (const double dt : {0.0, -2e-5, static_cast<double>(NAN), 1.0})
        EXPECT_THROW(system_factory(dt)(tiny().setup, 1), Error);
    const auto system = system_factory(2e-5)(tiny().setup, 1);
    system->advance_to(0.001);
    for (const double time : {0.0005, -1.0, static_cast<double>(NAN), static_cast<double>(INFINITY)})
        EXPECT_THROW(system->advance_to(time), Error);
    EXPECT_THROW(static_cast<void>(system->shear_wave(0)), Error);
    EXPECT_THROW(static_cast<void>(system->density_wave(0)), Error);
}

}  // namespace
}  // namespace drover::calibrate::system_factory_tests
