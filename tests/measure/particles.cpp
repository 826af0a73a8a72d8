// tests/measure/particles.cpp: order, motion and energy balance of particles in configurations with known values.
#include "measure/particles.hpp"

#include <gtest/gtest.h>

#include <set>

#include "dem/bodies/rotation.hpp"
#include "measure/particles_support.hpp"

namespace drover::measure::particles_tests {
namespace {

constexpr double rounding = 1e-12;  // some hundred additions of numbers of order 1

TEST(ParticleOrder, of_a_perfect_flock_is_one_in_its_direction) {
    ParticleScene scene;
    for (int i = 0; i < 100; ++i) scene.add_rod(0.3 * i, 0.0, 2.0, 3.0);
    EXPECT_NEAR(scene("polar_order"), 1.0, rounding);
    EXPECT_NEAR(scene("rod_direction_mean_x"), std::cos(2.0), rounding);
    EXPECT_NEAR(scene("polar_order_direction"), 2.0, rounding);
    EXPECT_NEAR(scene("nematic_order"), 1.0, rounding);
    EXPECT_NEAR(scene("rod_velocity_along"), 3.0, 3.0 * rounding);
    EXPECT_NEAR(scene("rod_velocity_along_deviation"), 0.0, 1e-7);  // the root of rounding
}

TEST(ParticleOrder, of_antiparallel_rods_is_only_nematic_and_of_a_star_zero) {
    ParticleScene lines, star;
    for (int i = 0; i < 8; ++i) {
        lines.add_rod(i, 0.0, i % 2 == 0 ? 0.4 : 0.4 + pi);
        star.add_rod(i, 0.0, pi * i / 4.0);
    }
    EXPECT_NEAR(lines("polar_order"), 0.0, rounding);
    EXPECT_NEAR(lines("nematic_order"), 1.0, rounding);
    EXPECT_NEAR(star("polar_order"), 0.0, rounding);
    EXPECT_NEAR(star("nematic_order"), 0.0, rounding);
}

TEST(ParticleOrder, does_not_shrink_when_rods_tilt) {
    ParticleScene scene;
    scene.add_rod(0.0, 0.0, 0.0);
    scene.bodies.rods[0].axis = {0.96, 0.0, 0.28};
    EXPECT_NEAR(scene("polar_order"), 1.0, rounding);
    EXPECT_NEAR(scene("rod_tilt"), 0.28, rounding);
}

TEST(ParticleOrder, in_a_round_cell_is_that_of_the_local_frame) {
    for (const dem::CellShape shape : {dem::CellShape::circle, dem::CellShape::flower}) {
        ParticleScene scene(shape);
        for (int i = 0; i < 12; ++i) {
            const double place = pi * i / 6.0;
            scene.add_rod(9.0 * std::cos(place), 9.0 * std::sin(place),
                          place + pi / 2.0 + 0.3);  // mostly counter-clockwise
        }
        EXPECT_NEAR(scene("polar_order"), 0.0, rounding);
        EXPECT_NEAR(scene("polar_order_local"), 1.0, rounding);
        EXPECT_NEAR(scene("polar_order_azimuthal"), std::cos(0.3), rounding);
        EXPECT_NEAR(scene("polar_order_radial"), -std::sin(0.3), rounding);
    }
}

TEST(ParticleMotion, of_rigid_rotation_is_azimuthal) {
    ParticleScene scene(dem::CellShape::circle);
    const double turning = -0.7;  // [rad/s], clockwise
    double mean_r = 0.0, mean_square = 0.0;
    for (int i = 0; i < 60; ++i) {
        const double r = 1.0 + 0.3 * i, place = 2.0 * pi * (i % 6) / 6.0, x = r * std::cos(place),
                     y = r * std::sin(place);
        scene.add_bead(x, y, -turning * y, turning * x);
        scene.add_rod(x, y, place, 2.0);
        mean_r += r / 60.0;
        mean_square += r * r / 60.0;
    }
    EXPECT_NEAR(scene("bead_velocity_azimuthal"), turning * mean_r, 10.0 * rounding);
    EXPECT_NEAR(scene("bead_velocity_radial"), 0.0, 10.0 * rounding);
    EXPECT_NEAR(scene("bead_direction_order_local"), 1.0, rounding);
    EXPECT_NEAR(scene("bead_speed"), -turning * std::sqrt(mean_square), 10.0 * rounding);
    EXPECT_NEAR(scene("rod_velocity_radial"), 2.0, 10.0 * rounding);
    EXPECT_NEAR(scene("rod_velocity_azimuthal"), 0.0, 10.0 * rounding);
}

TEST(ParticleMotion, of_beads_with_equal_velocities_has_order_one) {
    ParticleScene scene;
    for (int i = 0; i < 10; ++i) scene.add_bead(i, 0.0, 3.0, 4.0);
    scene.add_rod(0.0, 5.0, pi / 2.0);
    EXPECT_NEAR(scene("bead_velocity_size"), 5.0, 10.0 * rounding);
    EXPECT_NEAR(scene("bead_velocity_order"), 1.0, rounding);
    EXPECT_NEAR(scene("bead_direction_order"), 1.0, rounding);
    EXPECT_NEAR(scene("bead_velocity_along_order"), 4.0, 10.0 * rounding);
    EXPECT_NEAR(scene("bead_temperature_horizontal"), 0.0, rounding);
}

TEST(ParticleMotion, of_beads_with_unequal_speeds_has_the_order_of_the_root_mean_square) {
    ParticleScene scene;
    scene.add_bead(0.0, 0.0, 1.0, 0.0);
    scene.add_bead(2.0, 0.0, 7.0, 0.0);  // |<v>| = <|v|> = 4, sqrt(<v^2>) = 5
    EXPECT_NEAR(scene("bead_speed"), 5.0, 10.0 * rounding);
    EXPECT_NEAR(scene("bead_velocity_order"), 0.8, rounding);
}

TEST(ParticleMotion, of_bodies_at_rest_has_order_zero) {
    ParticleScene scene;
    scene.add_bead(0.0, 0.0);
    EXPECT_EQ(scene("bead_velocity_order"), 0.0);
    EXPECT_EQ(scene("bead_direction_order"), 0.0);
}

TEST(ParticleMotion, has_temperatures_that_exclude_the_drift) {
    ParticleScene scene;
    for (int i = 0; i < 8; ++i) {
        scene.add_bead(i, 0.0, 100.0 + (i % 2 == 0 ? 3.0 : -3.0), i % 4 < 2 ? 1.0 : -1.0);
        scene.bodies.beads.back().velocity.z = i < 4 ? 7.0 : 3.0;
        scene.add_rod(i, 5.0, 0.5 * i, 0.0);
        dem::Rod& rod = scene.bodies.rods.back();
        rod.angular_momentum = {0.0, 0.0, 2.0 * scene.bodies.shapes[1].inertia_across};  // omega_z = 2 rad/s
    }
    const double mass = scene.bodies.shapes[0].mass;
    EXPECT_NEAR(scene("bead_temperature_horizontal"), mass * 0.5 * (9.0 + 1.0), 1e-10);  // drift 100 against rounding
    EXPECT_NEAR(scene("bead_temperature_vertical"), mass * 4.0, 1e-10);
    EXPECT_NEAR(scene("rod_temperature_turning"), 4.0 * scene.bodies.shapes[1].inertia_across, 1e-10);
    EXPECT_NEAR(scene("bead_height"), 0.5, rounding);
    EXPECT_NEAR(scene("rod_height"), 0.6, rounding);
}

TEST(ParticleMotion, has_the_unbiased_deviation_among_rods) {
    ParticleScene scene;
    scene.add_rod(0.0, 0.0, 1.0, 2.0);
    EXPECT_EQ(scene("rod_velocity_along_deviation"), 0.0);  // of one rod
    scene.add_rod(5.0, 0.0, -2.0, 6.0);
    EXPECT_NEAR(scene("rod_velocity_along"), 4.0, 10.0 * rounding);
    EXPECT_NEAR(scene("rod_velocity_along_deviation"), std::sqrt(8.0), 10.0 * rounding);
}

/// The scene turned by +90 degrees.
ParticleScene turned(const ParticleScene& scene) {
    ParticleScene result = scene;
    const auto turn = [](dem::Vector& v) { v = {-v.y, v.x, v.z}; };
    std::swap(result.setup.cell.lx, result.setup.cell.ly);
    for (dem::Bead& bead : result.bodies.beads) turn(bead.position), turn(bead.velocity);
    for (dem::Rod& rod : result.bodies.rods)
        turn(rod.position), turn(rod.velocity), turn(rod.axis), turn(rod.angular_momentum);
    return result;
}

TEST(ParticleObservables, of_a_rotated_scene_are_rotated) {
    const std::set<std::string> not_scalars{"rod_direction_mean_x", "rod_direction_mean_y", "polar_order_direction",
                                            "rod_velocity_mean_x",  "rod_velocity_mean_y",  "bead_velocity_mean_x",
                                            "bead_velocity_mean_y"};
    for (const dem::CellShape shape : {dem::CellShape::periodic, dem::CellShape::rectangle, dem::CellShape::circle}) {
        const ParticleScene scene = random_particles(5, 600, 40, shape, 45.0, 30.0), other = turned(scene);
        for (const auto& row : particle_observables(scene.setting())) {
            if (not_scalars.contains(row.name)) continue;
            const std::vector<double> here = scene.all(row.name), there = other.all(row.name);
            ASSERT_EQ(here.size(), there.size()) << row.name;
            for (std::size_t k = 0; k < here.size(); ++k)  // sums in another order; temperatures are some 100
                EXPECT_NEAR(here[k], there[k], 1e-11 * (1.0 + std::abs(here[k])))
                    << drover::name_of(shape) << " " << row.name << " " << k;
        }
        EXPECT_NEAR(other("rod_direction_mean_y"), scene("rod_direction_mean_x"), rounding);
        EXPECT_NEAR(other("bead_velocity_mean_x"), -scene("bead_velocity_mean_y"), rounding);
        EXPECT_NEAR(std::remainder(other("polar_order_direction") - scene("polar_order_direction") - pi / 2.0,
                                   2.0 * pi),
                    0.0, rounding);
    }
}

TEST(ParticleObservables, in_a_periodic_cell_do_not_depend_on_the_image_of_a_body) {
    const ParticleScene scene = random_particles(6, 500, 30, dem::CellShape::periodic, 45.0, 30.0);
    ParticleScene moved = scene;
    for (std::size_t i = 0; i < moved.bodies.beads.size(); ++i)
        moved.bodies.beads[i].position.x += 45.0 * (static_cast<double>(i % 7) - 3.0);
    for (std::size_t i = 0; i < moved.bodies.rods.size(); ++i)
        moved.bodies.rods[i].position.y += 30.0 * (static_cast<double>(i % 5) - 2.0);
    for (const auto& row : particle_observables(scene.setting())) {
        const std::vector<double> here = scene.all(row.name), there = moved.all(row.name);
        for (std::size_t k = 0; k < here.size(); ++k)  // positions lose some digits when they are wrapped
            EXPECT_NEAR(here[k], there[k], 1e-9 * (1.0 + std::abs(here[k]))) << row.name << " " << k;
    }
}

TEST(ParticleObservables, are_those_defined_for_the_bodies_and_have_unique_names) {
    const ParticleScene only_beads = random_particles(1, 50, 0), only_rods = random_particles(1, 0, 5),
                        round = random_particles(1, 50, 5, dem::CellShape::circle);
    EXPECT_FALSE(only_beads.measures("polar_order"));
    EXPECT_FALSE(only_beads.measures("flow_density"));
    EXPECT_FALSE(only_rods.measures("hexatic_order"));
    EXPECT_FALSE(only_rods.measures("polar_order_local"));
    EXPECT_TRUE(only_rods.measures("pair_correlation_rods"));
    EXPECT_FALSE(round.measures("pair_correlation_beads"));
    EXPECT_FALSE(round.measures("rod_number_variance"));
    EXPECT_TRUE(round.measures("rod_pairs_order"));
    EXPECT_TRUE(round.measures("impacts_bead_wall"));
    EXPECT_FALSE(only_rods.measures("impacts_rod_wall"));
    EXPECT_TRUE(particle_observables(ParticleScene().setting()).empty());
    for (const ParticleScene* scene : {&only_beads, &only_rods, &round}) {
        std::set<std::string> names;
        for (const auto& row : particle_observables(scene->setting())) {
            EXPECT_TRUE(names.insert(row.name).second) << row.name;
            EXPECT_FALSE(row.unit.empty() || row.formula.empty()) << row.name;
            for (const double value : scene->all(row.name)) EXPECT_TRUE(std::isfinite(value)) << row.name;
        }
        for (const Quotient& row : particle_recording(scene->setting(), {}).quotients)
            EXPECT_TRUE(names.contains(row.sum) && names.contains(row.weight) && names.insert(row.name).second)
                << row.name;
    }
}

TEST(ParticleBalance, is_the_kinetic_energy_less_all_work) {
    ParticleScene scene;
    scene.add_bead(0.0, 0.0);
    scene.add_rod(5.0, 0.0, 0.0);
    scene.add_rod(5.0, 5.0, 0.0);
    scene.energy_kinetic = 100.0;
    scene.balance = {.gravity = 1.0, .plates = 64.0, .forces = 2.0, .kicks = 4.0, .impact = -8.0, .friction = -16.0};
    scene.counts.bead_bead = 3;
    scene.counts.rod_bead = 5;
    scene.counts.rod_rod = 7;
    EXPECT_EQ(scene("energy_balance"), 53.0);  // exact: whole numbers
    EXPECT_EQ(scene("work_plates"), 64.0);
    EXPECT_EQ(scene("impacts_bead_bead"), 6.0);  // each involves two beads
    EXPECT_EQ(scene("impacts_rod_bead"), 2.5);
    EXPECT_EQ(scene("impacts_rod_rod"), 7.0);
    for (const auto& row : particle_observables(scene.setting()))
        EXPECT_EQ(row.averaging == Averaging::rate, row.name.starts_with("impacts_") || row.name.starts_with("work_"))
            << row.name;
    EXPECT_TRUE(find_row(particle_observables(scene.setting()), "overlap_largest")->averaging == Averaging::maximum);
}

TEST(ParticleBalance, rates_are_differences_over_the_spacing) {
    const std::vector<double> counted{1.0, 3.0, 3.0, 7.0};
    EXPECT_EQ(rates(counted, 0.5), (std::vector{4.0, 0.0, 8.0}));
    EXPECT_TRUE(rates(std::span(counted).first(1), 0.5).empty());
    EXPECT_TRUE(rates({}, 0.5).empty());
}

}  // namespace
}  // namespace drover::measure::particles_tests
