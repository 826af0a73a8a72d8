// analysis/states.cpp: drover states: guess, solution, curve and profile.
#include "analysis/states.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/states_problem.hpp"
#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "run/signals.hpp"

namespace drover::analysis {

namespace {
using numerics::TravellingState;

/// A state with what is reported of it.
struct Point {
    const TravellingState& at;
    numerics::Fields fields;
    numerics::Fields further;                         ///< as StatesProblem::further
    std::vector<std::complex<double>> perturbations;  ///< without its translation; empty: too many numbers
};

Point point_of(const TravellingState& at, const StatesProblem& problem, numerics::TravellingSolver& solver,
               const numerics::Transform& transform, bool with_perturbations) {
    Point point{.at = at,
                .fields = numerics::Fields(problem.grid, at.state.count()),
                .further = problem.further ? problem.further(at) : numerics::Fields(),
                .perturbations = {}};
    transform.backward(at.state, point.fields);
    if (!with_perturbations) return point;
    constexpr std::size_t shown = 9;
    std::vector<std::complex<double>>& rates = point.perturbations = solver.perturbation_rates(at, shown);
    if (!rates.empty())
        rates.erase(std::min_element(rates.begin(), rates.end(),
                                     [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); }));
    return point;
}

/// The largest part of the variance of a component that is in the shortest waves of the grid.
double tail_of(const TravellingState& at, const StatesProblem& problem) {
    double largest = 0.0;
    for (int c = 0; c < at.state.count(); ++c)
        largest = std::max(largest, measure::tail_of(problem.grid, problem.degree, at.state, c, 1));
    return largest;
}

/// Of the states, where it is too large for their digits to mean anything.
void add_unresolved(const std::vector<TravellingState>& states, const StatesProblem& problem, run::Record& root) {
    constexpr double most = 1e-6;  // waves of a thousandth of the state
    const auto is_less = [&](const auto& a, const auto& b) { return tail_of(a, problem) < tail_of(b, problem); };
    const TravellingState& worst = *std::max_element(states.begin(), states.end(), is_less);
    root.entries.push_back(run::number("spectral_tail", "1",
                                       "largest part of the variance of a component in the shortest waves of the grid",
                                       tail_of(states.front(), problem), 2));
    if (tail_of(worst, problem) <= most) return;
    const std::string where =
        problem.followed ? text(" at {} = {:.6g}", problem.followed->key, worst.parameter) : std::string();
    root.footer.push_back(text(
        "the grid does not resolve the state{}: {:.2g} of the variance of a field is in the shortest waves of the grid "
        "(spectral_tail); expected less than {:.0e}: choose grid.nx = {}",
        where, tail_of(worst, problem), most, 2 * problem.grid.nx));
}

double growth_of(const Point& point) {
    return point.perturbations.empty() ? std::numeric_limits<double>::quiet_NaN() : point.perturbations.front().real();
}

std::vector<run::Entry> state_entries(const Point& point, const StatesProblem& problem) {
    std::vector<run::Entry> entries{{.name = "speed",
                                     .unit = "mm s-1",
                                     .meaning = "velocity of the state along x",
                                     .value = point.at.speed,
                                     .digits = 12,
                                     .rounding = point.at.speed_error}};
    const std::vector<run::Entry> more = problem.entries(point.at, point.fields);
    entries.insert(entries.end(), more.begin(), more.end());
    entries.push_back(run::number("growth_rate", "s-1",
                                  "of the fastest perturbation that depends on x alone; > 0: the state is unstable",
                                  growth_of(point)));
    return entries;
}

run::List perturbation_list(const Point& point) {
    run::List list{.name = "perturbations",
                   .heading = "\nslowest perturbations that depend on x alone, without a translation",
                   .row = "perturbation",
                   .meaning = "perturbations, fastest growth first",
                   .prefix = "perturbation_",
                   .group = "/state",
                   .empty = "the rates of perturbations were not computed: the grid has too many points"};
    for (const std::complex<double>& rate : point.perturbations)
        list.rows.push_back(
            {.entries = {run::number("rate", "s-1", "growth rate", rate.real()),
                         run::number("frequency", "s-1", "angular frequency in the frame of the state", rate.imag())}});
    return list;
}

run::List curve_list(const std::vector<Point>& points, const StatesProblem& problem) {
    const FollowedNumber& followed = *problem.followed;
    run::List list{.name = "curve",
                   .heading = text("\nstates along the curve, {} [{}]", followed.key, followed.unit),
                   .row = "point",
                   .meaning = "states along the curve",
                   .prefix = "curve_",
                   .group = "/curve"};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto at = [&](std::size_t k) { return points[k].at.parameter; };
        const bool turns = i > 0 && i + 1 < points.size() && (at(i) - at(i - 1)) * (at(i + 1) - at(i)) < 0.0;
        run::Record row{.entries = {run::number("parameter", followed.unit, followed.key, at(i), 10),
                                    run::flag("fold", "1: the curve turns here", turns)}};
        std::vector<run::Entry> entries = state_entries(points[i], problem);
        for (run::Entry& entry : entries) entry.digits = 7;
        row.entries.insert(row.entries.end(), entries.begin(), entries.end());
        list.rows.push_back(std::move(row));
    }
    return list;
}

/// Adds whether a curve reaches the value that it was to follow, and where it ends else.
void add_end_of_curve(const std::vector<TravellingState>& curve, const FollowedNumber& followed, int max_points,
                      run::Record& root) {
    const double first = curve.front().parameter, end = curve.back().parameter,
                 covered = (end - first) / (followed.last - first);
    root.entries.push_back(run::data_only(
        run::flag("curve_is_complete", "1: the curve reaches the value that it was to follow", covered >= 1.0)));
    if (covered >= 1.0) return;
    const bool is_cut = static_cast<int>(curve.size()) >= max_points;
    root.footer.push_back(
        text("the curve ends at {} = {:.6g} and does not reach {:.6g}: {}", followed.key, end, followed.last,
             covered < 0.0 ? "it came back beyond its start"
             : is_cut      ? text("it has {} points; give a larger --points", max_points)
                      : "beyond, Newton's method finds no state that depends on x; it may end in a uniform state"));
}

/// The fields on the points of the scene, the same on every row.
run::Frames frames_of(const io::Scene& scene, const StatesProblem& problem, const std::vector<Point>& points) {
    run::Frames frames{.recording = problem.frames, .rows = {}};
    const auto rows = static_cast<std::size_t>(scene.grid.ny);
    for (const Point& point : points) {
        std::vector<std::vector<double>>& frame = frames.rows.emplace_back();
        for (const numerics::Fields* fields : {&point.fields, &point.further})
            for (int c = 0; c < fields->count(); ++c) {
                std::vector<double>& field = frame.emplace_back();
                for (std::size_t row = 0; row < rows; ++row)
                    field.insert(field.end(), (*fields)[c].begin(), (*fields)[c].end());
            }
    }
    return frames;
}
}  // namespace

run::Result make_states(const io::Scene& scene, const StatesOptions& options, Threads& threads) {
    StatesProblem problem = states_problem(scene, options.follow, threads);
    problem.guess.speed = options.speed;
    problem.guess.time = options.settle;
    numerics::TravellingSolver solver(problem.family, threads);
    std::vector<TravellingState> states{run::find_state(problem.guess, solver)};
    if (problem.followed) states = solver.follow(states.front(), problem.followed->last, options.max_points);
    run::check_stop_signal();  // the curve ends at an error
    const numerics::Transform transform(problem.grid, problem.degree, threads);
    constexpr std::size_t max_of_curve = 800;  // beyond, the eigenvalues of each point take seconds
    std::vector<Point> points;
    for (const TravellingState& state : states)
        points.push_back(
            point_of(state, problem, solver, transform, points.empty() || solver.unknowns() <= max_of_curve));
    run::Record root{.heading = "travelling state along x", .group = "/state"};
    root.entries = state_entries(points.front(), problem);
    root.entries.push_back({.name = "residual",
                            .unit = "1",
                            .meaning = "largest rate of a mode in the moving frame, relative to its linear terms",
                            .value = states.front().residual,
                            .digits = 2,
                            .rounding = 1e-14});
    root.entries.push_back(run::number("change", "1",
                                       "of the fields from their guess, in parts of the variation of the guess",
                                       states.front().change, 2));
    root.entries.push_back(run::count("iterations", "of Newton's method", states.front().iterations));
    root.entries.push_back(run::count("right_hand_sides", "evaluated for the states, and for their perturbations",
                                      solver.right_hand_sides()));
    add_unresolved(states, problem, root);
    root.lists.push_back(perturbation_list(points.front()));
    if (problem.followed) {
        root.lists.push_back(curve_list(points, problem));
        add_end_of_curve(states, *problem.followed, options.max_points, root);
    }
    return {.root = std::move(root), .attributes = {}, .frames = frames_of(scene, problem, points)};
}

}  // namespace drover::analysis
