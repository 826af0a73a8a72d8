// theory/binodal.cpp: states of two phases, followed with their mean density.
#include "theory/binodal.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "base/constants.hpp"
#include "drover/base/error.hpp"
#include "drover/numerics/transform.hpp"
#include "model/start.hpp"

namespace drover::theory {

numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads) {
    struct Kept {  // Newton's method asks for one value many times
        double parameter = 0.0;
        std::optional<model::Integrated> what;
    };
    const auto at = [of = problem.at, kept = std::make_shared<Kept>()](double value) -> const model::Integrated& {
        if (kept->what && value == kept->parameter) return *kept->what;
        kept->what = of(value);
        kept->what->is_quiet = true;
        kept->parameter = value;
        if (const model::TermSummary* placed = kept->what->equations.placed_term())
            fail_input(placed->where,
                       "the term {} depends on position or time; expected terms without: a travelling state has none",
                       placed->text);
        return *kept->what;
    };
    return {.system = [at, line = problem.grid,
                       &threads](double value) { return model::system_of(at(value), line, threads); },
            .mean =
                [at](double value, int component) {
                    const model::Equations& here = at(value).equations;
                    const int place = here.state_components()[static_cast<std::size_t>(component)];
                    return here.reference()[static_cast<std::size_t>(place)];
                },
            .parameter = problem.parameter};
}

namespace {
using numerics::TravellingState;

/// The part of a periodic line above a value, with straight lines between its points.
double share_above(std::span<const double> values, double middle) {
    double points = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double here = values[i] - middle, next = values[(i + 1) % values.size()] - middle;
        if (here > 0.0 && next > 0.0) points += 1.0;
        else if (here > 0.0 || next > 0.0) points += std::max(here, next) / std::abs(here - next);
    }
    return points / static_cast<double>(values.size());
}

/// The references of conserved scalars but one, by component of a state.
std::vector<std::pair<int, double>> other_means(const model::Equations& equations, int component) {
    std::vector<std::pair<int, double>> means;
    int at = 0;
    for (const model::StateComponent& one : model::components_of_state(equations)) {
        const model::Field& field = equations.model().fields[one.field];
        if (field.spin == 0 && field.conserved && at != component) means.emplace_back(at, field.reference);
        ++at;
    }
    return means;
}

/// The state of the next parameter, from that of two phases: both keep their part of the cell.
TravellingState next_state(const TravellingProblem& problem, const TravellingState& at, const Coexistence& here,
                           int component, double part, Threads& threads) {
    numerics::Spectra guess = at.state;
    guess[component][0] = here.low + part * (here.high - here.low);
    const auto before = other_means(problem.at(at.parameter).equations, component),
               now = other_means(problem.at(problem.parameter).equations, component);
    for (std::size_t k = 0; k < now.size(); ++k) guess[now[k].first][0] += now[k].second - before[k].second;
    return numerics::TravellingSolver(travelling_family(problem, threads)).find(guess, at.speed);
}

/// The phases of a state; nothing where a density has no plateaus.  `component`: of the density in question.
std::optional<Coexistence> phases_of(const TravellingProblem& problem, const TravellingState& state, int component,
                                     Threads& threads) {
    const model::Integrated what = problem.at(state.parameter);
    numerics::Fields fields(problem.grid, state.state.count());
    numerics::Transform(problem.grid, what.equations.linear_system(problem.grid, what.kept_degree).degree, threads)
        .backward(state.state, fields);
    const DensityProfile profile = density_profile(fields[component], problem.grid.lx);
    if (!profile.low_is_flat || !profile.high_is_flat) return std::nullopt;
    Coexistence found{.parameter = state.parameter,
                      .low = profile.low,
                      .high = profile.high,
                      .in_low = {},
                      .in_high = {},
                      .speed = state.speed};
    for (int c = 0; c < fields.count(); ++c) {
        found.in_low.push_back(fields[c][profile.low_at]);
        found.in_high.push_back(fields[c][profile.high_at]);
    }
    return found;
}
}  // namespace

namespace {
/// What is expected of the grid, for messages.
std::string unresolved(double tail) {
    return text(
        "a grid that resolves the fronts: {:.2g} of the variance of a field is in its shortest waves, where at most "
        "{:.0e} should be; choose a larger grid.nx",
        tail, max_state_tail);
}
}  // namespace

Binodal trace_binodal(const TravellingProblem& problem, const TravellingState& first, int component, double last,
                      int steps, Threads& threads) {
    constexpr int max_halvings = 6;
    const std::optional<Coexistence> start = phases_of(problem, first, component, threads);
    const auto tail_of = [&](const TravellingState& state) { return problem.tail ? problem.tail(state) : 0.0; };
    Binodal binodal{.points = {}, .ends = {}, .tail = tail_of(first)};
    if (!start)
        fail_run(
            "the state does not consist of two phases: its density has no two plateaus; expected {}",
            binodal.tail > max_state_tail
                ? unresolved(binodal.tail)
                : "a cell that is much longer than both of its fronts, and a mean density between those of the phases");
    binodal.points.push_back(*start);
    TravellingState at = first;
    const double whole = (last - first.parameter) / steps;
    const double part = (first.state[component][0].real() - start->low) / (start->high - start->low);
    double step = whole;
    while (at.parameter != last) {
        const bool is_last = std::abs(last - at.parameter) <= 1.000001 * std::abs(step);
        try {
            TravellingProblem moved = problem;
            moved.parameter = is_last ? last : at.parameter + step;
            TravellingState found = next_state(moved, at, binodal.points.back(), component, part, threads);
            const std::optional<Coexistence> phases = phases_of(moved, found, component, threads);
            const double tail = tail_of(found);
            if (!phases)
                fail_run("one of the two phases has no plateau any more: {}",
                         tail > max_state_tail ? "expected " + unresolved(tail)
                                               : "the fronts are too wide for the cell");
            binodal.tail = std::max(binodal.tail, tail);
            binodal.points.push_back(*phases);
            at = std::move(found);
            step = std::copysign(std::min(std::abs(2.0 * step), std::abs(whole)), whole);
        } catch (const Error& error) {
            if (error.fault() != Fault::run) throw;
            step *= 0.5;
            if (std::abs(step) > std::abs(whole) * std::exp2(-max_halvings)) continue;
            binodal.ends = error.what();
            break;
        }
    }
    return binodal;
}

DensityProfile density_profile(std::span<const double> density, double lx) {
    const auto [min, max] = std::ranges::minmax_element(density);
    const double middle = 0.5 * (*min + *max), range = *max - *min;
    constexpr double rounding = 1e-12;
    if (range <= rounding * std::abs(middle)) return {.low = middle, .high = middle};  // uniform
    const std::size_t n = density.size();
    const auto above = static_cast<std::size_t>(std::ranges::count_if(density, [&](double d) { return d > middle; }));
    DensityProfile profile{.width = lx * share_above(density, middle)};
    constexpr double flat = 1e-3;  // of the range, over a quarter of the part
    const auto flattest = [&](bool is_high, std::size_t& place, bool& is_flat) {
        const std::size_t reach = (is_high ? above : n - above) / 8;
        double smallest = infinite;
        for (std::size_t i = 0; i < n; ++i) {
            if ((density[i] > middle) != is_high) continue;
            double deviation = 0.0;
            for (std::size_t k = n - reach; k <= n + reach; ++k)
                deviation = std::max(deviation, std::abs(density[(i + k) % n] - density[i]));
            if (deviation >= smallest) continue;
            smallest = deviation;
            place = i;
        }
        is_flat = reach > 1 && smallest < flat * range;
    };
    flattest(false, profile.low_at, profile.low_is_flat);
    flattest(true, profile.high_at, profile.high_is_flat);
    profile.low = density[profile.low_at];
    profile.high = density[profile.high_at];
    return profile;
}

}  // namespace drover::theory
