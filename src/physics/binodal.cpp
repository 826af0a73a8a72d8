// physics/binodal.cpp: states of two phases, followed with their mean density.
#include "drover/physics/binodal.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/error.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/density_profile.hpp"

namespace drover::physics {

namespace {
int other_density(const Form& form, int component) {
    return component == form.rod_density ? form.bead_density : form.rod_density;
}

double other_mean(const Model& model, int component) {
    return component == form(model).rod_density ? model.uniform.bead_density : model.uniform.rod_density;
}
}  // namespace

std::optional<Coexistence> phases_of(const TravellingProblem& problem, const TravellingState& state, int component,
                                     Threads& threads) {
    const Model model = problem.model(state.parameter);
    numerics::Fields fields(problem.grid, state.state.count());
    numerics::Transform(problem.grid, linear_system(model, problem.grid, problem.dealiasing).degree, threads)
        .backward(state.state, fields);
    const DensityProfile profile = density_profile(fields[component], problem.grid.lx);
    if (!profile.low_is_flat || !profile.high_is_flat) return std::nullopt;
    Coexistence found{.parameter = state.parameter, .low = profile.low, .high = profile.high, .speed = state.speed};
    if (const int other = other_density(form(model), component); other >= 0) {
        found.other_low = fields[other][profile.low_at];
        found.other_high = fields[other][profile.high_at];
    }
    return found;
}

Binodal trace_binodal(const TravellingProblem& problem, const TravellingState& first, int component, double last,
                      int steps, Threads& threads) {
    constexpr int most_halvings = 6;
    const std::optional<Coexistence> start = phases_of(problem, first, component, threads);
    if (!start)
        fail_run(
            "the state does not consist of two phases: its density has no two plateaus; expected a cell that is much "
            "longer than both of its fronts, and a mean density between those of the phases");
    Binodal binodal{.points = {*start}, .ends = {}};
    TravellingState at = first;
    const double whole = (last - first.parameter) / steps;
    const double part = (first.state[component][0].real() - start->low) / (start->high - start->low);
    double step = whole;
    while (at.parameter != last) {
        const bool is_last = std::abs(last - at.parameter) <= 1.000001 * std::abs(step);
        const double next = is_last ? last : at.parameter + step;
        const Coexistence& here = binodal.points.back();
        try {
            TravellingProblem moved = problem;
            moved.parameter = next;
            numerics::Spectra guess = at.state;
            guess[component][0] = here.low + part * (here.high - here.low);
            const Model model = problem.model(next);
            if (const int other = other_density(form(model), component); other >= 0)
                guess[other][0] += other_mean(model, component) - other_mean(problem.model(at.parameter), component);
            TravellingState found = TravellingSolver(moved, threads).find(guess, at.speed);
            const std::optional<Coexistence> phases = phases_of(moved, found, component, threads);
            if (!phases)
                fail_run("one of the two phases has no plateau any more: the fronts are too wide for the cell");
            binodal.points.push_back(*phases);
            at = std::move(found);
            step = std::copysign(std::min(std::abs(2.0 * step), std::abs(whole)), whole);
        } catch (const Error& error) {
            if (error.fault() != Fault::run) throw;
            step *= 0.5;
            if (std::abs(step) > std::abs(whole) * std::exp2(-most_halvings)) continue;
            binodal.ends = error.what();
            break;
        }
    }
    return binodal;
}

}  // namespace drover::physics
