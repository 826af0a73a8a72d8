// tests/physics/travelling_state.cpp: exact bands, solitary waves and kinks from poor guesses; folds and stability.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "band_model.hpp"
#include "drover/base/error.hpp"
#include "kink_model.hpp"
#include "physics/rod_bead_model.hpp"
#include "theory/binodal.hpp"
#include "travelling_problem.hpp"

namespace drover::physics::travelling_state_tests {
namespace {

TravellingSolver solver_of(const Model& model, const numerics::Grid& grid, Threads& threads) {
    return {{.model = [model](double) { return model; }, .parameter = 0.0, .grid = grid, .dealiasing = {}}, threads};
}

/// Rods and order on a line, from functions of x.
struct Line {
    numerics::Grid grid;
    int degree = 3;

    double x(std::size_t i) const { return grid.lx / grid.nx * static_cast<double>(i); }
    numerics::Spectra spectra(const numerics::Fields& fields) const {
        Threads threads(1);
        numerics::Spectra state(grid, fields.count());
        numerics::Transform(grid, degree, threads).forward(fields, state);
        return state;
    }
    numerics::Fields fields(const numerics::Spectra& state) const {
        Threads threads(1);
        numerics::Fields result(grid, state.count());
        numerics::Transform(grid, degree, threads).backward(state, result);
        return result;
    }
    /// sigma = mean + amplitude order, p = (order, 0).
    numerics::Fields rods(double mean, double amplitude, const std::function<double(double)>& order) const {
        numerics::Fields fields(grid, 3);
        double sum = 0.0;
        for (std::size_t i = 0; i < fields.size; ++i) sum += fields[1][i] = order(x(i));
        for (std::size_t i = 0; i < fields.size; ++i)
            fields[0][i] = mean + amplitude * (fields[1][i] - sum / static_cast<double>(fields.size));
        return fields;
    }
};

double mean_of(std::span<const double> values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The largest difference of any component once `found` is moved along x by the phase of its first mode.
double distance_up_to_position(const Line& line, const numerics::Spectra& found, const numerics::Spectra& exact,
                               int component) {
    const double turn = std::arg(exact[component][1] / found[component][1]);
    numerics::Spectra moved = found;
    const std::size_t width = numerics::columns(line.grid);
    for (int c = 0; c < moved.count(); ++c)
        for (std::size_t k = 0; k < width; ++k) moved[c][k] *= std::polar(1.0, turn * static_cast<double>(k));
    return largest_difference(line.fields(moved), line.fields(exact));
}

/// A band of another height and other fronts than the exact one, with its rods: found to 1e-10, with both binodals.
void expect_band(const Band& band) {
    Threads threads(1);
    const Line line{{1024, 1, length, 4.0}};
    numerics::Fields exact = line.rods(0.0, 0.0, [&](double x) { return band_order(band, x, 0.0); });
    for (std::size_t i = 0; i < exact.size; ++i) exact[0][i] = band.gas + exact[1][i] / band.c;
    const double mean = mean_of(exact[0]);
    for (const auto& [height, sharpness] : {std::pair{1.2, 0.7}, {0.8, 1.5}, {1.5, 0.3}}) {
        Band poor = band;
        poor.order *= height;
        poor.stiffness /= sharpness * height;
        poor.splay /= sharpness * height;
        TravellingSolver solver = solver_of(model_of(band), line.grid, threads);
        const numerics::Fields guess = line.rods(mean, 0.8, [&](double x) { return band_order(poor, x, 0.0); });
        const TravellingState found = solver.find(line.spectra(guess));
        // GMRES and the rounding of 255 modes leave 1e-13 of the equations; the slowest perturbation decays at
        // 0.008 /s.
        EXPECT_NEAR(found.speed, band.c, 1e-10);
        EXPECT_LT(distance_up_to_position(line, found.state, line.spectra(exact), 1), 1e-10);
        const theory::DensityProfile profile = theory::density_profile(line.fields(found.state)[0], length);
        EXPECT_NEAR(profile.low, band.gas, 1e-6);
        EXPECT_NEAR(profile.high, band.gas + band.order / band.c, 1e-6);
        EXPECT_TRUE(profile.low_is_flat && profile.high_is_flat);
        EXPECT_NEAR(profile.width, 120.0, 2.0);
    }
}

TEST(TravellingState, band_is_found_to_1e_10_from_poor_guesses_with_both_binodals) { expect_band({}); }

TEST(TravellingState, binodals_of_two_thirds_and_seven_sixths_are_found) {
    const Band band{
        .mu = 1.0, .sigma_c = 5.0 / 6.0, .b = 1.0, .pressure = 1.0, .advection = 1.0, .stiffness = 0.5, .splay = 0.5};
    EXPECT_NEAR(band.gas, 2.0 / 3.0, 1e-15);
    EXPECT_NEAR(band.gas + band.order / band.c, 7.0 / 6.0, 1e-15);
    expect_band(band);
}

/// Without advection of order c^2 = B, and sigma = sigma_gas + p/c:  K p'' = a p - (mu/c) p^2 + b p^3  with
/// a = mu (sigma_c - sigma_gas), solved by  p = 3 a/(m (1 + sqrt(1 - 9 a b/(2 m^2)) cosh(sqrt(a/K) x))),  m = mu/c.
struct Soliton {
    Band band{.mu = 1.0, .sigma_c = 1.0, .b = 0.8, .pressure = 1.2, .advection = 0.0, .stiffness = 0.5, .splay = 0.3};
    double gas = 0.9, rate = band.mu * (band.sigma_c - gas), m = band.mu / band.c;
    double operator()(double x) const {
        const double k = band.stiffness + band.splay, depth = std::sqrt(1.0 - 9.0 * rate * band.b / (2.0 * m * m));
        return 3.0 * rate / (m * (1.0 + depth * std::cosh(std::sqrt(rate / k) * x)));
    }
};

TEST(TravellingStateLong, solitary_wave_is_found_to_1e_10_from_a_bump_of_another_height_and_width) {
    Threads threads(1);
    const Soliton wave;
    const double side = 160.0;  // tails of exp(-80 sqrt(a/K)) = 5e-13
    const Line line{{512, 1, side, 4.0}};
    numerics::Fields exact = line.rods(0.0, 0.0, [&](double x) { return wave(x - 80.0); });
    for (std::size_t i = 0; i < exact.size; ++i) exact[0][i] = wave.gas + exact[1][i] / wave.band.c;
    const numerics::Fields guess = line.rods(mean_of(exact[0]), 0.9, [&](double x) {
        return 0.8 * wave(0.0) * std::exp(-std::pow((x - 80.0) / 5.0, 2.0));
    });
    TravellingSolver solver = solver_of(model_of(wave.band), line.grid, threads);
    const TravellingState found = solver.find(line.spectra(guess));
    EXPECT_NEAR(found.speed, wave.band.c, 1e-10);
    EXPECT_LT(distance_up_to_position(line, found.state, line.spectra(exact), 1), 1e-10);
    EXPECT_FALSE(theory::density_profile(line.fields(found.state)[0], side).high_is_flat);
    // It is a critical nucleus: one growing perturbation.
    const auto rates = solver.perturbation_rates(found, 3);
    EXPECT_GT(rates[0].real(), 1e-3);
    EXPECT_LT(std::abs(rates[1]), 1e-5);  // its translation
    EXPECT_LT(rates[2].real(), -1e-4);
}

TEST(TravellingState, lattice_of_kinks_is_found_to_1e_10_from_a_sine_in_a_fluid_with_every_term_but_viscosity) {
    Threads threads(1);
    const Sector sector;
    const KinkLattice lattice(sector);
    Evolution run(sector.model, {256, 1, lattice.period, 3.0});
    const double saturated = sector.saturated();
    const numerics::Spectra guess = run.spectra(sector.fields([&](double x, double) {
        return 0.8 * saturated * std::sin(2.0 * std::numbers::pi * x / lattice.period);
    })),
                            exact = run.spectra(sector.fields([&](double x, double) { return lattice(x); }));
    TravellingSolver solver = solver_of(sector.model, run.grid, threads);
    const TravellingState found = solver.find(guess);
    EXPECT_NEAR(found.speed, 0.0, 1e-10);
    EXPECT_LT(largest_difference(run.fields(found.state), run.fields(exact)), 1e-10);
}

TEST(TravellingStateLong, curve_of_bands_turns_at_a_fold_between_the_binodal_and_the_onset_of_order) {
    Threads threads(1);
    const Band band{.mu = 1.0, .sigma_c = 1.0, .b = 1.0, .pressure = 1.0, .advection = 1.0};
    const double side = 60.0;
    const Line line{{192, 1, side, 4.0}};
    const auto model = [&](double density) {
        Model made = model_of(band);
        made.uniform.rod_density = density;
        return made;
    };
    TravellingSolver solver({.model = model, .parameter = 1.1, .grid = line.grid, .dealiasing = {}}, threads);
    const numerics::Fields guess = line.rods(1.1, 0.8, [&](double x) {
        return band.order / (1.0 + std::exp(band.kappa(1.0) * (x - 46.0))) /
               (1.0 + std::exp(-band.kappa(-1.0) * (x - 14.0)));
    });
    const std::vector<TravellingState> curve = solver.follow(solver.find(line.spectra(guess)), 0.7, 120);
    const auto fold = std::adjacent_find(curve.begin(), curve.end(),
                                         [](const auto& a, const auto& b) { return b.parameter > a.parameter; });
    // A finite cell needs more rods than the binodal of an endless one; without order the gas is stable below sigma_c.
    EXPECT_GT(fold->parameter, band.gas);
    EXPECT_LT(fold->parameter, band.sigma_c);
    ASSERT_GT(curve.end() - fold, 3) << "the curve continues past the fold";
    // It meets the uniform state where the longest wave starts to grow, and goes on to the mirror image of the band.
    const auto onset =
        std::adjacent_find(fold, curve.end(), [](const auto& a, const auto& b) { return b.parameter < a.parameter; });
    EXPECT_NEAR(onset->parameter, band.sigma_c, 1e-3);  // of a wave of 60 mm, and of a step
    EXPECT_GT(curve.back().parameter, curve.front().parameter);
    for (const TravellingState& at : curve) {
        EXPECT_LT(at.residual, 1e-10);
        EXPECT_NEAR(mean_of(line.fields(at.state)[0]), at.parameter, 1e-12);
    }
    // Before the fold bands are stable, behind it they are nuclei that grow or vanish.
    const auto growth = [&](const TravellingState& at) {
        std::vector<std::complex<double>> rates = solver.perturbation_rates(at, 4);
        rates.erase(std::min_element(rates.begin(), rates.end(),
                                     [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); }));
        return rates.front().real();
    };
    EXPECT_LT(growth(curve.front()), 0.0);
    EXPECT_GT(growth(*(fold + 3)), 0.0);
}

TEST(TravellingState, guess_that_does_not_depend_on_x_is_rejected) {
    Threads threads(1);
    const Line line{{64, 1, 20.0, 4.0}};
    TravellingSolver solver = solver_of(model_of({}), line.grid, threads);
    try {
        solver.find(line.spectra(line.rods(1.0, 0.0, [](double) { return 0.3; })));
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("does not depend on x"));
    }
}

TEST(TravellingState, terms_that_depend_on_time_are_rejected) {
    Threads threads(1);
    Model model = model_of({});
    model.text_terms.push_back({.of = "order", .value = {{"0.1 * sin(t)", {}}, {"0", {}}}});
    EXPECT_THROW(solver_of(model, {64, 1, 20.0, 4.0}, threads), Error);
}

}  // namespace
}  // namespace drover::physics::travelling_state_tests
