// tests/theory/binodal.cpp: binodals of a model of any fields against exact ones.
#include "theory/binodal.hpp"

#include <cmath>

#include "drover/numerics/transform.hpp"
#include "theory/models.hpp"

namespace drover::theory::binodal_tests {
namespace {

constexpr numerics::Grid grid{512, 1, 80.0, 1.0};

/// The free energy (phi^2 - c)^2/4, and a second density that phi carries, at the mean m.
model::Integrated at(double c) {
    model::Field phi = scalar("phi", "lap(phi^3 - c phi - lap phi)"), other = scalar("n", "lap n - 0.5 lap phi");
    phi.conserved = other.conserved = true;
    other.reference = 1.0 + c;
    const model::Equations equations(
        model::Model{.fields = {phi, other}, .definitions = {}, .coefficients = {{"c", c}}});
    return {.equations = equations, .kept_degree = equations.degree()};
}

TEST(ModelBinodal, OfCahnAndHilliardIsAtTheMinimaOfTheFreeEnergyAndTheOtherDensityFollows) {
    // phi = +-sqrt(c); n - phi/2 is uniform.  Fronts are tanh(x sqrt(c/2)), each 20 from the middle of a phase: 1e-10.
    Threads threads(1);
    numerics::Fields fields(grid, 2);
    for (std::size_t i = 0; i < fields.size; ++i) {
        const double x = grid.lx / grid.nx * static_cast<double>(i);
        fields[0][i] = std::tanh((x - 20.0) / std::sqrt(2.0)) - std::tanh((x - 60.0) / std::sqrt(2.0)) - 1.0;
        fields[1][i] = 2.0 + 0.5 * fields[0][i];
    }
    numerics::Spectra guess(grid, 2);
    numerics::Transform(grid, 3, threads).forward(fields, guess);
    guess[0][0] = 0.0;
    guess[1][0] = 2.0;
    const TravellingProblem problem{.at = at, .parameter = 1.0, .grid = grid};
    numerics::TravellingSolver solver(travelling_family(problem, threads));
    const numerics::TravellingState first = solver.find(guess, 0.0);
    const Binodal found = trace_binodal(problem, first, 0, 0.81, 3, threads);
    EXPECT_EQ(found.ends, "");
    ASSERT_EQ(found.points.size(), 4U);
    EXPECT_EQ(found.points.back().parameter, 0.81);
    for (const Coexistence& one : found.points) {
        const double phase = std::sqrt(one.parameter);
        EXPECT_NEAR(one.low, -phase, 1e-8) << one.parameter;
        EXPECT_NEAR(one.high, phase, 1e-8) << one.parameter;
        EXPECT_NEAR(one.in_high[1], 1.0 + one.parameter + 0.5 * phase, 1e-8) << one.parameter;
        EXPECT_NEAR(one.speed, 0.0, 1e-9);
    }
}

}  // namespace
}  // namespace drover::theory::binodal_tests
