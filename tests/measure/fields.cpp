// tests/measure/fields.cpp: observables of single waves, rotated fields and random fields with known statistics.
#include "measure/fields.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "drover/base/random.hpp"
#include "drover/numerics/transform.hpp"
#include "measure/fields_support.hpp"
#include "measure/summary.hpp"

namespace drover::measure::fields_tests {
namespace {

using numerics::Fields;
using numerics::Grid;
using numerics::Spectra;

constexpr double tau = 2.0 * std::numbers::pi;
const Grid oblong{.nx = 24, .ny = 16, .lx = 9.0, .ly = 10.0};  // cells neither square nor alike

/// A run's moment that owns its fields; both forms of the fields hold the kept modes alone.
struct Scene {
    FieldSetting setting;
    Fields fields;
    Spectra spectra;

    explicit Scene(const Grid& grid) : setting(rods_on(grid)), fields(grid, 3), spectra(grid, 3) {}

    void to_spectra() {
        Threads threads(1);
        const numerics::Transform transform(setting.grid, 1, threads);
        transform.forward(fields, spectra);
        transform.backward(spectra, fields);
    }

    /// What the observable of that name gives.
    std::vector<double> operator()(const std::string& name) const {
        const FieldMoment moment = moment_of(setting, spectra, fields);
        const auto rows = field_observables(setting);
        if (const auto* row = find_row(rows, name)) return measure_one(*row, moment);
        ADD_FAILURE() << name << " is not measured";
        return {};
    }
};

Scene random_scene(const Grid& grid, std::uint64_t seed) {
    Scene scene(grid);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, scene.fields.values);
    for (double& sigma : scene.fields[0]) sigma += 4.0;
    for (double& px : scene.fields[1]) px += 0.7;
    scene.to_spectra();
    return scene;
}

/// Adds amplitude cos(q.r - phase) to one component, q of the mode numbers (kx, ky).
void add_wave(Scene& scene, int component, int kx, int ky, double amplitude, double phase = 0.0) {
    const Grid& grid = scene.setting.grid;
    for (int y = 0; y < grid.ny; ++y)
        for (int x = 0; x < grid.nx; ++x)
            scene.fields[component][static_cast<std::size_t>(y * grid.nx + x)] +=
                amplitude *
                std::cos(tau * (kx * static_cast<double>(x) / grid.nx + ky * static_cast<double>(y) / grid.ny) - phase);
}

std::size_t stored_mode(const Grid& grid, int kx, int ky) {
    return static_cast<std::size_t>((ky + grid.ny) % grid.ny) * numerics::columns(grid) + static_cast<std::size_t>(kx);
}

/// All of `found` is zero but one place, where it is `expected`; to rounding.
void expect_only(const std::vector<double>& found, std::size_t place, double expected) {
    for (std::size_t i = 0; i < found.size(); ++i)
        if (!std::isnan(found[i])) {
            EXPECT_NEAR(found[i], i == place ? expected : 0.0, 1e-12) << i << " of " << found.size();
        }
}

/// Modes of the whole plane in the same shell and sector as this one.
double modes_beside(const FieldSetting& setting, std::size_t mode) {
    double count = 0.0;
    for (std::size_t m = 0; m < setting.shells.of_mode.size(); ++m)
        if (setting.shells.of_mode[m] == setting.shells.of_mode[mode] &&
            setting.sectors.of_mode[m] == setting.sectors.of_mode[mode])
            count += numerics::mode_weight(setting.grid, m % numerics::columns(setting.grid));
    return count;
}

TEST(FieldObservables, every_row_has_a_unique_name_a_unit_and_a_formula) {
    std::set<std::string> names;
    for (const auto& row : field_observables(rods_on(oblong))) {
        EXPECT_TRUE(names.insert(row.name).second) << row.name;
        EXPECT_FALSE(row.unit.empty() || row.formula.empty()) << row.name;
    }
}

TEST(UnitProduct, adds_exponents_and_keeps_what_it_cannot_read_in_brackets) {
    EXPECT_EQ(unit_product({"mm s-1", "mm s-1", "mm2"}), "mm4 s-2");
    EXPECT_EQ(unit_product({"mm-2", "mm2"}), "1");
    EXPECT_EQ(unit_product({"1", "1"}), "1");
    EXPECT_EQ(unit_product({"1/mm^2", "1/mm^2", "mm2"}), "(1/mm^2)^2 mm2");
    EXPECT_EQ(unit_product({"1/mm^2", "1", "mm2"}), "(1/mm^2) mm2");
    EXPECT_EQ(unit_product({"mm/s", "K", "mm2"}), "(mm/s) (K) mm2");
}

TEST(FieldObservables, have_as_many_values_as_their_axes) {
    const Scene scene = random_scene(oblong, 1);
    const FieldMoment moment = moment_of(scene.setting, scene.spectra, scene.fields);
    for (const auto& row : field_observables(scene.setting))
        EXPECT_EQ(row.measure(moment).size(), size_of(row.axes)) << row.name;
}

TEST(FieldObservables, of_a_uniform_flock_are_its_density_and_order) {
    Scene scene(oblong);
    std::fill(scene.fields[0].begin(), scene.fields[0].end(), 5.0);
    std::fill(scene.fields[1].begin(), scene.fields[1].end(), 3.0);
    std::fill(scene.fields[2].begin(), scene.fields[2].end(), -4.0);
    scene.to_spectra();
    const double rounding = 1e-13;
    EXPECT_NEAR(scene("rods_total")[0], 450.0, 450.0 * rounding);
    EXPECT_NEAR(scene("polar_order")[0], 1.0, rounding);
    EXPECT_NEAR(scene("polar_order_mean_x")[0], 3.0, 3.0 * rounding);
    EXPECT_NEAR(scene("polar_order_mean_y")[0], -4.0, 4.0 * rounding);
    EXPECT_NEAR(scene("polar_order_largest")[0], 5.0, 5.0 * rounding);
    EXPECT_NEAR(scene("min_rod_density")[0], 5.0, 5.0 * rounding);
    EXPECT_NEAR(scene("max_rod_density")[0], 5.0, 5.0 * rounding);
    for (const char* name : {"structure_factor_rods", "structure_factor_order_along", "rod_number_variance"})
        for (const double value : scene(name)) EXPECT_NEAR(value, 0.0, rounding) << name;
}

TEST(FieldObservables, extremes_are_those_of_the_grid) {
    Scene scene(oblong);
    std::fill(scene.fields[0].begin(), scene.fields[0].end(), 1.0);
    scene.fields[0][37] = -2.0;
    scene.fields[0][101] = 7.0;
    scene.fields[1][12] = 3.0;  // |p| = 3.0 here,
    scene.fields[1][90] = 2.9;  // but 3.05 there
    scene.fields[2][90] = -0.95;
    EXPECT_EQ(scene("min_rod_density")[0], -2.0);
    EXPECT_EQ(scene("max_rod_density")[0], 7.0);
    EXPECT_NEAR(scene("polar_order_largest")[0], std::hypot(2.9, 0.95), 1e-15);  // rounding
}

TEST(StructureFactor, of_one_wave_of_rods_is_nonzero_only_in_its_shell_and_sector) {
    for (const auto& [kx, ky] : {std::pair{3, 0}, {0, 3}, {4, -2}, {1, 5}}) {
        Scene scene(oblong);
        std::fill(scene.fields[0].begin(), scene.fields[0].end(), 2.0);
        add_wave(scene, 0, kx, ky, 0.5, 0.3);
        scene.to_spectra();
        const FieldSetting& setting = scene.setting;
        const std::size_t mode = stored_mode(oblong, kx, ky);
        ASSERT_GE(setting.shells.of_mode[mode], 0);
        const auto shell = static_cast<std::size_t>(setting.shells.of_mode[mode]);
        const auto sector = static_cast<std::size_t>(setting.sectors.of_mode[mode]);
        const double both = 90.0 * 2.0 * 0.0625;  // area |a_q|^2 of q and of -q, a_q = 0.5/2
        expect_only(scene("structure_factor_rods"), shell, both / setting.shells.weight[shell]);
        expect_only(scene("structure_factor_rods_direction"), sector * setting.shells.q.size() + shell,
                    both / modes_beside(setting, mode));
        for (const double value : scene("structure_factor_order_direction"))
            EXPECT_TRUE(std::isnan(value) || value < 1e-28) << "more than the square of a rounding";
        for (const BoxFamily& family : box_families()) {
            const std::vector<double> variance = scene(std::string("rod_number_variance") + family.ending);
            const std::vector<int>& sides = setting.*family.sides;
            ASSERT_EQ(variance.size(), sides.size());
            for (std::size_t b = 0; b < variance.size(); ++b) {
                const auto side = [](int cells, int k, int n,
                                     double length) {  // of the sum of a wave over a row of cells
                    return k == 0 ? cells * length / n
                                  : length / n * std::sin(tau / 2.0 * k * cells / n) / std::sin(tau / 2.0 * k / n);
                };
                const double amplitude = 0.5 * side(family.along_x * sides[b], kx, oblong.nx, oblong.lx) *
                                         side(family.along_y * sides[b], ky, oblong.ny, oblong.ly);
                EXPECT_NEAR(variance[b], amplitude * amplitude / 2.0, 1e-12);  // rounding
            }
        }
    }
}

TEST(StructureFactor, resolves_waves_of_order_along_and_across_q) {
    for (const auto& [kx, ky] : {std::pair{2, 0}, {0, 4}, {3, 2}, {2, -3}}) {
        const double qx = tau * kx / oblong.lx, qy = tau * ky / oblong.ly, q = std::hypot(qx, qy);
        const auto shell = static_cast<std::size_t>(rods_on(oblong).shells.of_mode[stored_mode(oblong, kx, ky)]);
        for (const bool is_along : {true, false}) {
            Scene scene(oblong);
            add_wave(scene, 1, kx, ky, is_along ? qx / q : -qy / q);
            add_wave(scene, 2, kx, ky, is_along ? qy / q : qx / q);
            scene.to_spectra();
            const double expected = 90.0 * 2.0 * 0.25 / scene.setting.shells.weight[shell];
            expect_only(scene("structure_factor_order_along"), shell, is_along ? expected : 0.0);
            expect_only(scene("structure_factor_order_across"), shell, is_along ? 0.0 : expected);
            double both = 0.0;  // the sum over directions does not distinguish them
            for (const double value : scene("structure_factor_order_direction"))
                both += std::isnan(value) ? 0.0 : value;
            EXPECT_NEAR(both, 45.0 / modes_beside(scene.setting, stored_mode(oblong, kx, ky)), 1e-12);  // rounding
        }
    }
}

TEST(StructureFactor, cross_is_negative_where_a_wave_of_rods_grows) {
    // d_t sigma = -div p: with sigma = cos(q.r), p = -q/|q| sin(q.r), so that -div p = |q| cos(q.r), sigma grows, and
    // d_t |sigma_q|^2/2 = -|q| Re(sigma_q^* i p_along): the cross structure factor is negative.
    Scene scene(oblong);
    const double qx = tau * 2 / oblong.lx, qy = tau * -3 / oblong.ly, q = std::hypot(qx, qy);
    add_wave(scene, 0, 2, -3, 1.0);
    add_wave(scene, 1, 2, -3, -qx / q, tau / 4.0);
    add_wave(scene, 2, 2, -3, -qy / q, tau / 4.0);
    scene.to_spectra();
    const auto shell = static_cast<std::size_t>(scene.setting.shells.of_mode[stored_mode(oblong, 2, -3)]);
    expect_only(scene("structure_factor_cross"), shell, -90.0 * 2.0 * 0.25 / scene.setting.shells.weight[shell]);
}

TEST(StructureFactor, of_a_field_rotated_by_90_degrees_has_its_sectors_rotated) {
    const Grid grid{.nx = 16, .ny = 16, .lx = 7.0, .ly = 7.0};
    const Scene scene = random_scene(grid, 4);
    Scene turned(grid);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const auto to = static_cast<std::size_t>(x * 16 + (16 - y) % 16),
                       from = static_cast<std::size_t>(y * 16 + x);
            turned.fields[0][to] = scene.fields[0][from];  // (x, y) goes to (-y, x)
            turned.fields[1][to] = -scene.fields[2][from];
            turned.fields[2][to] = scene.fields[1][from];
        }
    turned.to_spectra();
    const std::size_t shells = scene.setting.shells.q.size();
    for (const char* name : {"structure_factor_rods_direction", "structure_factor_order_direction"}) {
        const std::vector<double> before = scene(name), after = turned(name);
        for (std::size_t s = 0; s < 8; ++s)
            for (std::size_t n = 0; n < shells; ++n) {
                const double expected = before[s * shells + n], found = after[(s + 4) % 8 * shells + n];
                EXPECT_EQ(std::isnan(expected), std::isnan(found));
                if (std::isnan(expected)) continue;
                EXPECT_NEAR(found, expected, 1e-12) << name << s << " " << n;  // rounding
            }
    }
    for (const char* name : {"structure_factor_order_along", "structure_factor_order_across", "structure_factor_cross",
                             "rod_number_variance", "polar_order"})
        for (std::size_t n = 0; n < scene(name).size(); ++n)
            EXPECT_NEAR(turned(name)[n], scene(name)[n], 1e-12) << name << n;  // rounding
}

TEST(StructureFactor, summed_over_all_modes_is_the_variance_in_real_space) {
    const Scene scene = random_scene(oblong, 6);
    const std::vector<FieldPowers> powers = moment_of(scene.setting, scene.spectra, scene.fields).powers;
    const auto total = [&](const std::vector<double>& power) {
        double sum = 0.0;
        for (std::size_t m = 1; m < power.size(); ++m)
            sum += numerics::mode_weight(oblong, m % numerics::columns(oblong)) * power[m];
        return sum;
    };
    const auto variance = [&](int component) {
        double mean = 0.0, sum = 0.0;
        for (const double value : scene.fields[component]) mean += value / static_cast<double>(scene.fields.size);
        for (const double value : scene.fields[component]) sum += (value - mean) * (value - mean);
        return sum / static_cast<double>(scene.fields.size);
    };
    EXPECT_NEAR(total(powers[0].along), variance(0), 1e-12);  // rounding
    EXPECT_NEAR(total(powers[1].along) + total(powers[1].across), variance(1) + variance(2), 1e-12);
}

TEST(StructureFactor, of_independent_rods_is_their_density) {
    // Each cell holds a number of rods of variance and mean n: sigma has the variance n/cell^2 and S = n/cell at every
    // q.
    const Grid grid{.nx = 64, .ny = 96, .lx = 4.0, .ly = 9.0};
    Scene scene(grid);
    const double cell = numerics::area(grid) / static_cast<double>(numerics::points(grid)), rods_per_cell = 3.0;
    fill_normal({.seed = 9, .stream = Stream::test}, 0, 1, scene.fields[0]);
    for (double& sigma : scene.fields[0]) sigma = (rods_per_cell + std::sqrt(rods_per_cell) * sigma) / cell;
    scene.to_spectra();
    const std::vector<double> found = scene("structure_factor_rods");
    for (std::size_t n = 0; n < found.size(); ++n) {
        // |a_q|^2 is exponential, q and -q being one: relative deviation sqrt(2/modes); five of them.
        EXPECT_NEAR(found[n] * cell / rods_per_cell, 1.0, 5.0 * std::sqrt(2.0 / scene.setting.shells.weight[n])) << n;
    }
}

TEST(FieldObservables, of_a_form_without_a_field_are_those_of_the_others) {
    const FieldSetting setting = setting_of(oblong, model_of({.rod_density = false}, "order"), 3);
    const Spectra spectra(oblong, 2);
    const Fields fields(oblong, 2);
    const FieldMoment moment = moment_of(setting, spectra, fields);
    EXPECT_FALSE(field_observables(setting).empty());
    for (const auto& row : field_observables(setting)) {
        for (const double value : measure_one(row, moment)) EXPECT_TRUE(value == 0.0 || std::isnan(value)) << row.name;
    }
}

}  // namespace
}  // namespace drover::measure::fields_tests
