// run/declared_problem.cpp: a run of the fields of a declared model.
#include <cmath>
#include <numbers>

#include "drover/run/warnings.hpp"
#include "run/field_problem.hpp"
#include "run/growing_waves.hpp"

namespace drover::run {

namespace {
/// A quarter above the largest wavenumber at which the state of the references is unstable: patterns have such waves,
/// and errors of a pattern that is not resolved would seem to grow without limit.
double shortest_of_patterns(const model::Equations& equations, const numerics::Grid& grid, int degree) {
    const numerics::System system = equations.linear_system(grid, degree);
    const auto cut = [&](int points, double length) {
        return points > 1 ? 2.0 * std::numbers::pi / length * points / (system.degree + 1) : 0.0;
    };
    const double most = std::hypot(cut(grid.nx, grid.lx), cut(grid.ny, grid.ly));
    return 1.25 * largest_growing(system, most);
}

std::string likely_cause(const numerics::Grid& grid, double dt, double tail) {
    const bool coarse = tail > max_spectral_tail;
    return text(
        "the time step is too long for the products, {}no term of the equations limits its growth: choose "
        "time.dt = {}{}",
        coarse ? text("the grid is too coarse ({:.2g} of the variance is in the shortest waves), or ", tail) : "or ",
        0.5 * dt, coarse ? text(", or {}", grid_keys(grid, 2)) : "");
}

}  // namespace

void complete_declared(const io::Scene& scene, FieldProblem& problem) {
    const model::Equations& equations = problem.integrated.equations;
    problem.integrated.shortest = shortest_of_patterns(equations, scene.grid, problem.integrated.kept_degree);
    problem.sizes.assign(problem.components.size(), 0.0);
    problem.likely_cause = [grid = scene.grid, dt = scene.time.dt](const numerics::System&, double tail) {
        return likely_cause(grid, dt, tail);
    };
    problem.term_not_finite = [](double, const numerics::Spectra&) { return std::string(); };
}

}  // namespace drover::run
