// analysis/states.cpp: drover states: guess, solution, curve and profile.
#include "analysis/states.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>

#include "base/constants.hpp"
#include "drover/numerics/transform.hpp"
#include "measure/fields.hpp"
#include "model/start.hpp"
#include "numerics/algebra/extremum.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/fields/travelling_start.hpp"
#include "run/loop/signals.hpp"
#include "run/number_lists.hpp"
#include "theory/binodal.hpp"

namespace drover::analysis {

namespace {
/// Sum of the squares of all waves of a component but that of q = 0, and of q = 0.
std::pair<double, double> squares_of(std::span<const numerics::Complex> modes) {
    double waves = 0.0;
    for (std::size_t m = 1; m < modes.size(); ++m) waves += 2.0 * std::norm(modes[m]);
    return {waves, std::norm(modes[0])};
}
}  // namespace

double tail_of(const numerics::TravellingState& at, const numerics::Grid& grid, int degree) {
    constexpr double rounding = 1e-20;  // of squares: what is left of a component that is uniform
    double size = 0.0, largest = 0.0;
    for (int c = 0; c < at.state.count(); ++c) {
        const auto [waves, mean] = squares_of(at.state[c]);
        size = std::max(size, waves + mean);
    }
    for (int c = 0; c < at.state.count(); ++c)
        if (squares_of(at.state[c]).first > rounding * size)
            largest = std::max(largest, measure::tail_of(grid, degree, at.state, c, 1));
    return largest;
}

namespace {
using numerics::TravellingState;

/// The number of the model that --follow names.
struct FollowedNumber {
    std::string key;
    std::string unit = "1";
    double last = 0.0;
};

/// What states are looked for.
struct StatesProblem {
    io::Scene line;                               ///< the scene on one row of points
    std::optional<FollowedNumber> followed = {};  ///< the parameter of the family
    std::function<model::Integrated(double)> at;  ///< what is integrated, by the followed number
    double parameter = 0.0;                       ///< its value in the scene
    model::Integrated here;                       ///< what is integrated there
    int degree = 1;                               ///< that decides which modes are kept
    const numerics::Grid& grid() const { return line.grid; }
};

/// follow: KEY=VALUE of --follow; "": nothing.  Throws an input Error for a key that is not a number of the model.
StatesProblem states_problem(const io::Scene& scene, const std::string& follow) {
    const io::Scene line = run::line_of(scene);
    double parameter = 0.0;
    std::optional<FollowedNumber> followed;
    if (!follow.empty()) {
        const std::string list = "--follow";
        const SourceLocation where{.file = list};
        const auto [key, value] = run::read_assignment(follow, list, run::example_of_number(line), where);
        const run::SceneNumber number = run::number_of(line, list, key, where);
        const double last = run::read_number(value, follow, list, run::example_of_number(line), where);
        parameter = number.value;
        require(last != parameter, where, "{} is {} already; expected another value to follow the state to", key, last);
        followed = FollowedNumber{.key = number.key, .unit = number.unit, .last = last};
    }
    const auto at = [line, key = followed ? followed->key : ""](double value) {
        run::check_stop_signal();
        return run::integrated_of(key.empty() ? line : run::scene_with(line, key, value));
    };
    const model::Integrated here = at(parameter);
    for (const model::Field& field : here.equations.model().fields)
        require(!field.solenoidal || field.left == model::LeftSide::balance, field.where,
                "{} is solenoidal: of a state that depends on x alone its x component is a constant; expected its y "
                "component as a scalar field of its own, for drover states",
                field.symbol);
    return {.line = line,
            .followed = followed,
            .at = at,
            .parameter = parameter,
            .here = here,
            .degree = here.equations.linear_system(line.grid, here.kept_degree).degree};
}

/// What is reported of a scalar, and its name; "": nothing.
struct ScalarNames {
    std::string mean, min, max, low, high, coexistence, width;
};

ScalarNames names_of(const io::Scene& scene, const std::string& field) {
    const auto before = [&](const char* what) { return text("{}_{}", what, field); };
    if (scene.kind == io::SceneKind::model)
        return {before("mean"), before("min"),         before("max"),  before("low"),
                before("high"), before("coexistence"), before("width")};
    const std::string stem = field.substr(0, field.find('_'));  // "rod_density", as archives have it: "rod_low"
    return {field, "", "", stem + "_low", stem + "_high", stem + "_coexistence", stem + "_width"};
}

void add_scalar(const ScalarNames& names, const model::StateComponent& of, double mean, std::span<const double> values,
                double lx, std::vector<run::Entry>& entries) {
    const auto add = [&](const std::string& name, const std::string& unit, const std::string& meaning,
                         const run::EntryValue& value) {
        if (!name.empty())
            entries.push_back({.name = name, .unit = unit, .meaning = meaning, .value = value, .digits = 10});
    };
    const auto [min, max] = std::ranges::minmax_element(values);
    const theory::DensityProfile profile = theory::density_profile(values, lx);
    const std::string words = of.name;
    add(names.mean, of.unit, text("mean of {}", words), mean);
    add(names.min, of.unit, text("smallest {} on a point", words), *min);
    add(names.max, of.unit, text("largest {} on a point", words), *max);
    add(names.low, of.unit, text("{} where it is flattest below the middle of its range", words), profile.low);
    add(names.high, of.unit, text("{} where it is flattest above the middle of its range", words), profile.high);
    add(names.coexistence, "1", text("1: both values of {} are plateaus, of two phases", words),
        profile.low_is_flat && profile.high_is_flat);
    add(names.width, "mm", text("of the part with {} above the middle", words), profile.width);
}

constexpr double mean_rounding = 1e-14;  // of the mean of a component, relative to the largest value of its field

std::vector<run::Entry> entries_of(const numerics::TravellingState& at, const numerics::Fields& fields,
                                   const io::Scene& line, const model::Equations& equations) {
    const std::vector<model::StateComponent> components = model::components_of_state(equations);
    std::vector<run::Entry> entries;
    for (int c = 0; c < fields.count(); ++c) {
        const model::StateComponent& one = components[static_cast<std::size_t>(c)];
        const model::Field& field = equations.model().fields[one.field];
        if (field.spin == 0) {
            add_scalar(names_of(line, one.name), one, at.state[c][0].real(), fields[c], line.grid.lx, entries);
            continue;
        }
        const int x = one.part == 0 ? c : c - 1;
        double largest = 0.0;
        for (std::size_t i = 0; i < fields.size; ++i)
            largest = std::max(largest, std::hypot(fields[x][i], fields[x + 1][i]));
        if (line.kind == io::SceneKind::model) {
            entries.push_back(run::number("mean_" + one.name, one.unit, "mean", at.state[c][0].real(), 10));
            entries.back().rounding = mean_rounding * largest;
        }
        if (one.part == 1)
            entries.push_back(
                run::number("max_" + field.name, one.unit, text("largest |{}| on a point", field.symbol), largest, 10));
    }
    return entries;
}

/// Further fields of the frames, which follow from the others; none where no field is in balance.
numerics::Fields further_fields(const TravellingState& state, const StatesProblem& problem, Threads& threads) {
    if (model::components_in_balance(problem.here.equations).empty()) return {};
    const model::Integrated what = problem.at(state.parameter);
    return model::ExplicitPart(what.equations, what.equations.linear_system(problem.grid(), what.kept_degree), threads)
        .balanced(0.0, state.state);
}

/// A state with what is reported of it.
struct Point {
    const TravellingState& at;
    numerics::Fields fields;
    numerics::Fields further;                         ///< of further_fields()
    std::vector<std::complex<double>> perturbations;  ///< without its translation; empty: too many numbers
};

Point point_of(const TravellingState& at, const StatesProblem& problem, numerics::TravellingSolver& solver,
               const numerics::Transform& transform, bool with_perturbations, Threads& threads) {
    Point point{.at = at,
                .fields = numerics::Fields(problem.grid(), at.state.count()),
                .further = further_fields(at, problem, threads)};
    transform.backward(at.state, point.fields);
    if (!with_perturbations) return point;
    constexpr std::size_t shown = 8;
    std::vector<std::complex<double>>& rates = point.perturbations =
        solver.perturbation_rates(at, numerics::TravellingSolver::max_dense);
    if (!rates.empty())  // of all: many may grow faster than the translation
        rates.erase(
            std::ranges::min_element(rates, [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); }));
    if (rates.size() > shown) rates.resize(shown);
    return point;
}

/// Of the states, where it is too large for their digits to mean anything.
void add_unresolved(const std::vector<TravellingState>& states, const StatesProblem& problem, run::Record& root) {
    const auto tail = [&](const TravellingState& at) { return tail_of(at, problem.grid(), problem.degree); };
    const TravellingState& worst = *std::ranges::max_element(states, {}, tail);
    root.entries.push_back(run::number("spectral_tail", "1",
                                       "largest part of the variance of a component in the shortest waves of the grid",
                                       tail(states.front()), 2));
    if (tail(worst) <= theory::max_state_tail) return;
    const std::string where =
        problem.followed ? text(" at {} = {:.6g}", problem.followed->key, worst.parameter) : std::string();
    root.footer.push_back(text(
        "the grid does not resolve the state{}: {:.2g} of the variance of a field is in the shortest waves of the grid "
        "(spectral_tail); expected less than {:.0e}: choose grid.nx = {}",
        where, tail(worst), theory::max_state_tail, 2 * problem.grid().nx));
}

double growth_of(const Point& point) { return point.perturbations.empty() ? nan : point.perturbations.front().real(); }

std::vector<run::Entry> state_entries(const Point& point, const StatesProblem& problem) {
    std::vector<run::Entry> entries{{.name = "speed",
                                     .unit = "mm s-1",
                                     .meaning = "velocity of the state along x",
                                     .value = point.at.speed,
                                     .digits = 12,
                                     .rounding = point.at.speed_error}};
    const std::vector<run::Entry> more = entries_of(point.at, point.fields, problem.line, problem.here.equations);
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

double distance(const Point& a, const Point& b) {
    double squares = 0.0;
    for (int c = 0; c < a.fields.count(); ++c)
        for (std::size_t i = 0; i < a.fields[c].size(); ++i) squares += std::pow(a.fields[c][i] - b.fields[c][i], 2);
    return std::sqrt(squares);
}

/// Whether the curve turns between the neighbours of a point.
bool turns_at(const std::vector<Point>& points, std::size_t i) {
    const auto at = [&](std::size_t k) { return points[k].at.parameter; };
    return i > 0 && i + 1 < points.size() && (at(i) - at(i - 1)) * (at(i + 1) - at(i)) < 0.0;
}

/// Whether the state of a turn is uniform: on its other side the variation of the fields has the other sign.
bool is_pitchfork(const std::vector<Point>& points, std::size_t i) {
    const numerics::Fields &before = points[i - 1].fields, &after = points[i + 1].fields;
    double sum = 0.0;
    for (int c = 0; c < before.count(); ++c) {
        const auto a = Eigen::Map<const Eigen::ArrayXd>(before[c].data(), static_cast<Eigen::Index>(before.size)),
                   b = Eigen::Map<const Eigen::ArrayXd>(after[c].data(), static_cast<Eigen::Index>(after.size));
        sum += ((a - a.mean()) * (b - b.mean())).sum();
    }
    return sum < 0.0;
}

/// The polynomial through the points (at, values).
double interpolated(const std::vector<double>& at, const std::vector<double>& values, double where) {
    double sum = 0.0;
    for (std::size_t i = 0; i < at.size(); ++i) {
        double part = values[i];
        for (std::size_t k = 0; k < at.size(); ++k)
            if (k != i) part *= (where - at[k]) / (at[i] - at[k]);
        sum += part;
    }
    return sum;
}

/// Where it turns about a point: the extremum of the polynomial through it and so many neighbours on each side, over
/// the distances between them.
double turn_of(const std::vector<Point>& points, std::size_t i, std::size_t neighbours) {
    std::vector<double> at, values;
    double from = 0.0, to = 0.0;  // the places of the nearest neighbours
    for (std::size_t k = i - std::min(i, neighbours); k < std::min(i + neighbours + 1, points.size()); ++k) {
        at.push_back(at.empty() ? 0.0 : at.back() + distance(points[k - 1], points[k]));
        values.push_back(points[k].at.parameter);
        if (k + 1 == i) from = at.back();
        if (k == i + 1) to = at.back();
    }
    const double sign = points[i].at.parameter > points[i - 1].at.parameter ? 1.0 : -1.0;
    const auto height = [&](double part) { return sign * interpolated(at, values, from + part * (to - from)); };
    return sign * height(numerics::golden_maximum(0.0, 1.0, height));
}

run::List turn_list(const std::vector<Point>& points, const StatesProblem& problem) {
    const FollowedNumber& followed = *problem.followed;
    run::List list{.name = "turns",
                   .heading = text("\nwhere the curve turns, by the polynomial through five states"),
                   .row = "turn",
                   .meaning = "turns of the curve",
                   .prefix = "turn_",
                   .group = "/turns",
                   .empty = "the curve does not turn"};
    for (std::size_t i = 0; i < points.size(); ++i)
        if (turns_at(points, i)) {
            const double turn = turn_of(points, i, 2);
            list.rows.push_back(
                {.entries = {run::number("parameter", followed.unit, followed.key, turn),
                             run::number("error", followed.unit, "by how much a parabola through three states differs",
                                         std::abs(turn - turn_of(points, i, 1)), 2),
                             run::flag("pitchfork", "1: it is a pitchfork, of a uniform state; 0: a fold",
                                       is_pitchfork(points, i))}});
        }
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
        const bool turns = turns_at(points, i), is_uniform = turns && is_pitchfork(points, i);
        run::Record row{.entries = {run::number("parameter", followed.unit, followed.key, points[i].at.parameter, 10),
                                    run::flag("fold", "1: the curve turns here, at a fold", turns && !is_uniform),
                                    run::flag("pitchfork", "1: the curve turns here, at a uniform state", is_uniform)}};
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
run::Frames frames_of(const io::Scene& scene, const std::vector<Point>& points) {
    run::Frames frames{.recording = run::frame_recording(scene), .rows = {}};
    frames.recording.time_unit = "1";  // the number of the state
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
    for (const auto& [name, value] : {std::pair{"speed", options.speed}, {"settle", options.settle}})
        require(!value || std::isfinite(*value), {}, "{} = {}; expected a finite number", name, value.value_or(0.0));
    require(options.settle.value_or(0.0) >= 0.0 && options.max_points >= 2, {},
            "settle = {} and points = {}; expected 0 or more, and 2 or more", options.settle.value_or(0.0),
            options.max_points);
    const StatesProblem problem = states_problem(scene, options.follow);
    numerics::TravellingSolver solver(
        theory::travelling_family({problem.at, problem.parameter, problem.grid()}, threads));
    run::TravellingGuess guess = run::travelling_guess(scene, problem.line, threads);
    guess.speed = options.speed;
    guess.time = options.settle;
    std::vector<TravellingState> states{run::find_state(guess, solver)};
    if (problem.followed) states = solver.follow(states.front(), problem.followed->last, options.max_points);
    run::check_stop_signal();  // the curve ends at an error
    const numerics::Transform transform(problem.grid(), problem.degree, threads);
    constexpr std::size_t max_of_curve = 800;  // beyond, the eigenvalues of each point take seconds
    std::vector<Point> points;
    for (const TravellingState& state : states)
        points.push_back(
            point_of(state, problem, solver, transform, points.empty() || solver.unknowns() <= max_of_curve, threads));
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
        root.lists.push_back(turn_list(points, problem));
        add_end_of_curve(states, *problem.followed, options.max_points, root);
    }
    root.entries.push_back(run::data_only(run::words("notes", "", root.footer)));
    return {.root = std::move(root), .attributes = {}, .frames = frames_of(scene, points)};
}

}  // namespace drover::analysis
