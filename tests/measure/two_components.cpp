// tests/measure/two_components.cpp: observables of beads, of their velocity and of pairs, on fields whose values are
// known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "measure/fields_support.hpp"
#include "physics/initial_spectra.hpp"
#include "physics/whole_rate.hpp"

namespace drover::measure::two_components_tests {
namespace {

constexpr double tau = 2.0 * std::numbers::pi;
const numerics::Grid grid{.nx = 32, .ny = 24, .lx = 8.0, .ly = 6.0};

const physics::Model model{.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
                           .uniform = {.rod_density = 2.0, .bead_density = 3.0},
                           .inertia = {.bead_mass = 0.5},
                           .drag = {.coefficient = 2.0},
                           .driving = {.strength = 0.7},
                           .relaxation = {.rate = 0.3, .saturation = 0.2}};

/// One moment of fields given by formulas.
class Fixture {
public:
    explicit Fixture(const model::Start& formulas)
        : threads_(1),
          system_(physics::linear_system(model, grid)),
          spectra_(physics::initial_spectra(formulas, model, system_, 1, threads_)),
          fields_(grid, spectra_.count()),
          energy_(physics::Equations(model).solver(physics::mean_densities(model)), grid, system_.degree, threads_),
          setting_(setting_of(grid, model, system_.degree)) {
        numerics::Transform(grid, system_.degree, threads_).backward(spectra_, fields_);
        setting_.terms = physics::Equations(model).terms();
    }
    std::vector<double> operator()(const std::string& name) const {
        FieldMoment moment = moment_of(setting_, spectra_, fields_);
        moment.energy = energy_.measure(0.0, spectra_);
        const auto rows = field_observables(setting_);
        if (const auto* row = find_row(rows, name)) return measure_one(*row, moment);
        ADD_FAILURE() << name << " is not measured";
        return {};
    }
    const FieldSetting& setting() const { return setting_; }

private:
    Threads threads_;
    numerics::System system_;
    numerics::Spectra spectra_;
    numerics::Fields fields_;
    model::EnergyMeter energy_;
    FieldSetting setting_;
};

constexpr double rounding = 1e-13;  // of sums over 768 cells of numbers of order one

TEST(BeadVelocity, of_a_uniform_flow_with_a_wave_has_the_order_of_the_flow) {
    // v_x = 0.8 + 0.6 sqrt(2) cos: <v^2> = 0.64 + 0.36 = 1.
    const Fixture scene({.kind = model::StartKind::formula,
                         .formulas = {{"bead_velocity_x", {"0.8 + 0.6 * sqrt(2) * cos(2*pi*y/6)"}}}});
    EXPECT_NEAR(scene("bead_velocity_mean_x")[0], 0.8, rounding);
    EXPECT_NEAR(scene("bead_speed")[0], 1.0, rounding);
    EXPECT_NEAR(scene("bead_velocity_order")[0], 0.8, rounding);
}

TEST(FieldObservables, of_rods_and_beads_are_those_of_any_field_as_well) {
    const Fixture scene({.kind = model::StartKind::formula,
                         .formulas = {{"rod_density", {"2 + 0.3 * cos(2*pi*x/8)"}},
                                      {"bead_velocity_x", {"0.3 + 0.1 * cos(2*pi*x/8)"}},
                                      {"bead_velocity_y", {"-0.4"}}}});
    EXPECT_NEAR(scene("mean_rod_density")[0], 2.0, rounding);
    EXPECT_NEAR(scene("rods_total")[0], 96.0, 48.0 * rounding);
    EXPECT_NEAR(scene("mean_bead_velocity_x")[0], 0.3, rounding);
    EXPECT_NEAR(scene("size_mean_bead_velocity")[0], 0.5, rounding);
    EXPECT_NEAR(scene("largest_bead_velocity")[0], std::hypot(0.4, 0.4), rounding);
    EXPECT_NEAR(scene("correlation_rod_density")[0], 4.0 + 0.5 * 0.09, 4.0 * rounding) << "at no distance";
}

TEST(BeadVelocity, across_the_wavevector_is_shear_and_along_it_is_sound) {
    const Fixture shear({.kind = model::StartKind::formula, .formulas = {{"bead_velocity_x", {"cos(4*pi*y/6)"}}}}),
        sound({.kind = model::StartKind::formula, .formulas = {{"bead_velocity_y", {"cos(4*pi*y/6)"}}}});
    const auto sum = [](const std::vector<double>& values) {
        double total = 0.0;
        for (const double value : values) total += value;
        return total;
    };
    EXPECT_GT(sum(shear("structure_factor_velocity_across")), 0.1);
    EXPECT_NEAR(sum(shear("structure_factor_velocity_along")), 0.0, rounding);
    EXPECT_GT(sum(sound("structure_factor_velocity_along")), 0.1);
    EXPECT_NEAR(sum(sound("structure_factor_velocity_across")), 0.0, rounding);
}

TEST(CrossStructureFactor, of_anticorrelated_densities_is_minus_the_geometric_mean) {
    const Fixture scene({.kind = model::StartKind::formula,
                         .formulas = {{"bead_density", {"3 - 0.2 * cos(2*pi*(2*x/8 + y/6))"}},
                                      {"rod_density", {"2 + 0.5 * cos(2*pi*(2*x/8 + y/6))"}}}});
    const auto cross = scene("structure_factor_beads_rods"), beads = scene("structure_factor_beads"),
               rods = scene("structure_factor_rods");
    for (std::size_t n = 0; n < cross.size(); ++n) EXPECT_NEAR(cross[n], -std::sqrt(beads[n] * rods[n]), rounding);
}

TEST(OrderCorrelation, of_a_wave_is_its_average_over_directions) {
    // p_x = c + d cos(q x): G = c^2 + d^2 cos(q x)/2, averaged over the displacements of each bin.
    const double c = 0.5, d = 0.4;
    const Fixture scene(
        {.kind = model::StartKind::formula, .formulas = {{"polar_order_x", {"0.5 + 0.4 * cos(2*pi*x/8)"}}}});
    std::vector<double> expected(scene.setting().separations.size()), weight(expected.size());
    for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
            const double x = 8.0 / 32 * std::min(i, 32 - i), y = 6.0 / 24 * std::min(j, 24 - j);
            const auto bin = static_cast<std::size_t>(std::hypot(x, y) / 0.25 + 0.5);
            if (bin >= expected.size()) continue;
            expected[bin] += c * c + 0.5 * d * d * std::cos(tau * x / 8.0);
            weight[bin] += 1.0;
        }
    const auto found = scene("polar_order_correlation");
    for (std::size_t bin = 0; bin < found.size(); ++bin) EXPECT_NEAR(found[bin], expected[bin] / weight[bin], rounding);
    EXPECT_NEAR(found[0], c * c + 0.5 * d * d, rounding) << "at no distance: the mean square";
}

TEST(SpectralTail, is_the_fraction_of_variance_beyond_two_thirds_of_the_cut) {
    // Degree 3: modes |k| < 32/4 = 8 along x and 24/4 = 6 along y; two thirds: 5.33 and 4.
    const Fixture scene({.kind = model::StartKind::formula,
                         .formulas = {{"bead_density", {"3 + 0.3 * cos(2*pi*2*x/8) + 0.4 * cos(2*pi*6*x/8)"}},
                                      {"rod_density", {"2 + 0.3 * cos(2*pi*5*y/6)"}}}});
    EXPECT_NEAR(scene("spectral_tail_bead_density")[0], 0.16 / 0.25, rounding);
    EXPECT_NEAR(scene("spectral_tail_rod_density")[0], 1.0, rounding);
}

TEST(Energy, of_a_uniform_flock_and_the_powers_of_its_terms_follow_the_formulas) {
    const Fixture scene(
        {.kind = model::StartKind::formula,
         .formulas = {{"bead_velocity_x", {"0.6"}}, {"polar_order_x", {"0.9"}}, {"polar_order_y", {"-0.2"}}}});
    const double area = 48.0, square = 0.81 + 0.04;
    EXPECT_NEAR(scene("energy_flow")[0], 0.5 * 0.5 * 3.0 * 0.36 * area, 1e-12);
    EXPECT_NEAR(scene("energy_order")[0], 0.5 * square * area, 1e-12);
    const auto& terms = *scene.setting().terms;
    const auto power = [&](const std::string& observable, const std::string& term) {
        return scene(observable)[static_cast<std::size_t>(std::find(terms.begin(), terms.end(), term) - terms.begin())];
    };
    EXPECT_NEAR(power("power_flow", "drag.coefficient"), -2.0 * 0.36 * area, 1e-12);
    EXPECT_NEAR(power("power_flow", "driving.strength"), 0.7 * 0.9 * 0.6 * area, 1e-12);
    EXPECT_NEAR(power("power_order", "relaxation.rate"), -0.3 * square * area, 1e-12);
    EXPECT_NEAR(power("power_order", "relaxation.saturation"), -0.2 * square * square * area, 1e-12);
}

}  // namespace
}  // namespace drover::measure::two_components_tests
