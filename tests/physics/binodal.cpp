// tests/physics/binodal.cpp: densities of coexisting phases against the exact travelling band.
#include "theory/binodal.hpp"

#include <gtest/gtest.h>

#include "band_model.hpp"
#include "drover/base/error.hpp"
#include "drover/numerics/transform.hpp"
#include "physics/rod_bead_model.hpp"
#include "travelling_problem.hpp"

namespace drover::physics::binodal_tests {
namespace {

constexpr numerics::Grid grid{512, 1, length, height};

/// The exact band at a threshold, its fronts displaced from the points of the grid.
numerics::Spectra exact_state(const Band& band, Threads& threads) {
    numerics::Fields fields(grid, 3);
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double p = band_order(band, length / grid.nx * static_cast<double>(i), 0.13);
        fields[0][i] = band.gas + p / band.c;
        fields[1][i] = p;
    }
    numerics::Spectra state(grid, 3);
    numerics::Transform(grid, 3, threads).forward(fields, state);
    return state;
}

Model model_at(double threshold) {
    Band band{.sigma_c = threshold};
    return model_of(band);
}

TEST(Binodal, of_an_exact_band_follows_the_threshold_at_its_exact_densities_and_speed) {
    // sigma_gas = sigma_c - 2 mu/(9 b c^2), and the band is denser by p_l/c: with the threshold both shift alike.  The
    // tails of the fronts, at most 60 mm from the middle of a phase, leave e^(-0.36*60) = 4e-10 of it.
    Threads threads(1);
    const TravellingProblem problem{.model = model_at, .parameter = 1.1, .grid = grid, .dealiasing = {}};
    const TravellingState first = TravellingSolver(problem, threads).find(exact_state({}, threads));
    const theory::Binodal binodal = theory::trace_binodal(of_model(problem), first, 0, 0.9, 4, threads);
    EXPECT_EQ(binodal.ends, "");
    ASSERT_EQ(binodal.points.size(), 5U);
    EXPECT_EQ(binodal.points.back().parameter, 0.9);
    for (const theory::Coexistence& at : binodal.points) {
        const Band band{.sigma_c = at.parameter};
        EXPECT_NEAR(at.low, band.gas, 1e-8) << at.parameter;
        EXPECT_NEAR(at.high, band.gas + band.order / band.c, 1e-8) << at.parameter;
        EXPECT_NEAR(at.speed, band.c, 1e-8) << at.parameter;
    }
}

TEST(Binodal, ends_with_the_reason_where_the_fronts_become_too_wide_for_the_cell) {
    // Fronts widen as the saturation b grows: p_l falls, and with it kappa ~ p_l sqrt(b).
    Threads threads(1);
    const auto model = [](double saturation) { return model_of({.b = saturation}); };
    const TravellingProblem problem{.model = model, .parameter = 0.8, .grid = grid, .dealiasing = {}};
    const TravellingState first = TravellingSolver(problem, threads).find(exact_state({}, threads));
    const theory::Binodal binodal = theory::trace_binodal(of_model(problem), first, 0, 200.0, 64, threads);
    EXPECT_NE(binodal.ends, "");
    EXPECT_LT(binodal.points.back().parameter, 200.0);
    const Band band{.b = binodal.points.back().parameter};
    EXPECT_NEAR(binodal.points.back().low, band.gas, 1e-3 * band.order / band.c) << "flat to 1e-3 of the range";
}

TEST(Binodal, of_a_state_without_plateaus_is_refused_with_what_it_needs) {
    Threads threads(1);
    const TravellingProblem problem{.model = model_at, .parameter = 1.1, .grid = grid, .dealiasing = {}};
    TravellingState wave{.state = numerics::Spectra(grid, 3), .parameter = 1.1};
    wave.state[0][0] = 1.0;
    wave.state[0][1] = 0.1;
    try {
        theory::trace_binodal(of_model(problem), wave, 0, 0.9, 4, threads);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("no two plateaus"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace drover::physics::binodal_tests
