// run/states.cpp: drover states: guess, solution, curve and profile.
#include "drover/run/states.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/numerics/transform.hpp"
#include "drover/physics/density_profile.hpp"
#include "drover/physics/right_hand_side.hpp"
#include "drover/physics/travelling_problem.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/signals.hpp"
#include "run/number_lists.hpp"
#include "run/travelling_start.hpp"

namespace drover::run {

namespace {
using physics::TravellingState;

/// What --follow names.
struct Followed {
    std::string key;
    std::string unit = "1";
    double last = 0.0;
};

struct Family {
    physics::TravellingProblem problem;
    std::optional<Followed> followed;
};

Family family_of(const io::Scene& line, const std::string& follow) {
    Family family{.problem = {.model = [model = line.model](double) { return model; },
                              .parameter = 0.0,
                              .grid = line.grid,
                              .dealiasing = line.dealiasing},
                  .followed = std::nullopt};
    if (follow.empty()) return family;
    const std::string list = "--follow", example = "\"relaxation.rate = 1.2\"";
    const SourceLocation where{.file = list};
    const auto [key, value] = read_assignment(follow, list, example, where);
    const io::ModelNumber number = io::model_number(key, where, line.model);
    const double last = read_number(value, follow, list, example, where);
    physics::Model model = line.model;
    family.problem.parameter = number.in(model);
    require(last != family.problem.parameter, where, "{} is {} already; expected another value to follow the state to",
            key, last);
    family.problem.model = [model, in = number.in](double parameter) {
        check_stop_signal();
        physics::Model changed = model;
        in(changed) = parameter;
        return changed;
    };
    family.followed = Followed{.key = key, .unit = number.unit.empty() ? "1" : number.unit, .last = last};
    return family;
}

/// A state with what is reported of it.
struct Point {
    const TravellingState& at;
    numerics::Fields fields;
    numerics::Fields slaved_velocity;                 ///< of a slaved form
    std::vector<std::complex<double>> perturbations;  ///< without its translation; empty: too many numbers
};

struct Density {
    std::string name;
    int component;
};
std::vector<Density> densities_of(const physics::Form& form) {
    std::vector<Density> densities;
    if (form.bead_density >= 0) densities.push_back({"bead", form.bead_density});
    if (form.rod_density >= 0) densities.push_back({"rod", form.rod_density});
    return densities;
}

Point point_of(const TravellingState& at, const physics::TravellingProblem& problem, physics::TravellingSolver& solver,
               const numerics::Transform& transform, bool with_perturbations) {
    Point point{.at = at,
                .fields = numerics::Fields(problem.grid, at.state.count()),
                .slaved_velocity = {},
                .perturbations = {}};
    transform.backward(at.state, point.fields);
    if (const physics::Equations equations(problem.model(at.parameter));
        equations.form.velocity == physics::Velocity::slaved)
        point.slaved_velocity =
            physics::slaved_velocity(equations,
                                     physics::linear_system(equations, problem.grid,
                                                            physics::reference(equations.model.uniform),
                                                            problem.dealiasing),
                                     0.0, at.state);
    if (!with_perturbations) return point;
    constexpr std::size_t shown = 9;
    std::vector<std::complex<double>>& rates = point.perturbations = solver.perturbation_rates(at, shown);
    if (!rates.empty())
        rates.erase(std::min_element(rates.begin(), rates.end(),
                                     [](const auto& a, const auto& b) { return std::abs(a) < std::abs(b); }));
    return point;
}

double growth_of(const Point& point) {
    return point.perturbations.empty() ? std::numeric_limits<double>::quiet_NaN() : point.perturbations.front().real();
}

void add_densities(const Point& point, const physics::Form& form, double lx, std::vector<Entry>& entries) {
    for (const Density& density : densities_of(form)) {
        const physics::DensityProfile profile = physics::density_profile(point.fields[density.component], lx);
        const auto add = [&](const char* what, const char* unit, const std::string& meaning, const EntryValue& value) {
            entries.push_back({.name = text("{}_{}", density.name, what),
                               .unit = unit,
                               .meaning = meaning,
                               .value = value,
                               .digits = 10});
        };
        add("density", "mm-2", text("mean {} density", density.name), point.at.state[density.component][0].real());
        add("low", "mm-2", text("{} density where it is flattest below the middle of its range", density.name),
            profile.low);
        add("high", "mm-2", text("{} density where it is flattest above the middle of its range", density.name),
            profile.high);
        add("coexistence", "1", text("1: both {} densities are plateaus, of two phases", density.name),
            profile.low_is_flat && profile.high_is_flat);
        add("width", "mm", text("of the part with a {} density above the middle", density.name), profile.width);
    }
}

std::vector<Entry> state_entries(const Point& point, const physics::Form& form, double lx) {
    std::vector<Entry> entries{{.name = "speed",
                                .unit = "mm s-1",
                                .meaning = "velocity of the state along x",
                                .value = point.at.speed,
                                .digits = 12,
                                .rounding = point.at.speed_error}};
    add_densities(point, form, lx, entries);
    double largest = 0.0;
    for (std::size_t i = 0; i < point.fields.size; ++i)
        largest =
            std::max(largest, std::hypot(point.fields[form.polar_order][i], point.fields[form.polar_order + 1][i]));
    entries.push_back({.name = "max_polar_order",
                       .unit = physics::component_names(form)[static_cast<std::size_t>(form.polar_order)].unit,
                       .meaning = "largest |p|",
                       .value = largest,
                       .digits = 10});
    entries.push_back({.name = "growth_rate",
                       .unit = "s-1",
                       .meaning = "of the fastest perturbation that depends on x alone; > 0: the state is unstable",
                       .value = growth_of(point)});
    return entries;
}

List perturbation_list(const Point& point) {
    List list{.name = "perturbations",
              .heading = "\nslowest perturbations that depend on x alone, without a translation",
              .row = "perturbation",
              .meaning = "perturbations, fastest growth first",
              .prefix = "perturbation_",
              .group = "/state",
              .empty = "the rates of perturbations were not computed: the grid has too many points"};
    for (const std::complex<double>& rate : point.perturbations)
        list.rows.push_back(
            {.entries = {{.name = "rate", .unit = "s-1", .meaning = "growth rate", .value = rate.real()},
                         {.name = "frequency",
                          .unit = "s-1",
                          .meaning = "angular frequency in the frame of the state",
                          .value = rate.imag()}}});
    return list;
}

List curve_list(const std::vector<Point>& points, const Followed& followed, const physics::Form& form, double lx) {
    List list{.name = "curve",
              .heading = text("\nstates along the curve, {} [{}]", followed.key, followed.unit),
              .row = "point",
              .meaning = "states along the curve",
              .prefix = "curve_",
              .group = "/curve"};
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto at = [&](std::size_t k) { return points[k].at.parameter; };
        const bool turns = i > 0 && i + 1 < points.size() && (at(i) - at(i - 1)) * (at(i + 1) - at(i)) < 0.0;
        Record row{
            .entries = {
                {.name = "parameter", .unit = followed.unit, .meaning = followed.key, .value = at(i), .digits = 10},
                {.name = "fold", .unit = "1", .meaning = "1: the curve turns here", .value = turns}}};
        std::vector<Entry> entries = state_entries(points[i], form, lx);
        for (Entry& entry : entries) entry.digits = 7;
        row.entries.insert(row.entries.end(), entries.begin(), entries.end());
        list.rows.push_back(std::move(row));
    }
    return list;
}

/// The fields on the points of the scene, the same on every row.
Frames frames_of(const io::Scene& scene, const std::vector<Point>& points) {
    Frames frames{.recording = frame_recording(scene), .rows = {}};
    const auto rows = static_cast<std::size_t>(scene.grid.ny);
    for (const Point& point : points) {
        std::vector<std::vector<double>>& frame = frames.rows.emplace_back();
        for (const numerics::Fields* fields : {&point.fields, &point.slaved_velocity})
            for (int c = 0; c < fields->count(); ++c) {
                std::vector<double>& field = frame.emplace_back();
                for (std::size_t row = 0; row < rows; ++row)
                    field.insert(field.end(), (*fields)[c].begin(), (*fields)[c].end());
            }
    }
    return frames;
}
}  // namespace

Result make_states(const io::Scene& scene, const StatesOptions& options, Threads& threads) {
    const io::Scene line = line_of(scene);
    const physics::Form form = physics::form(line.model);
    Family family = family_of(line, options.follow);
    physics::TravellingSolver solver(family.problem, threads);
    std::vector<TravellingState> states{
        find_state(scene, line, {.speed = options.speed, .settle = options.settle}, solver, threads)};
    if (family.followed) states = solver.follow(states.front(), family.followed->last, options.max_points);
    check_stop_signal();  // the curve ends at an error
    const numerics::Transform transform(line.grid,
                                        physics::linear_system(line.model, line.grid, line.dealiasing).degree, threads);
    constexpr std::size_t max_of_curve = 800;  // beyond, the eigenvalues of each point take seconds
    std::vector<Point> points;
    for (const TravellingState& state : states)
        points.push_back(
            point_of(state, family.problem, solver, transform, points.empty() || solver.unknowns() <= max_of_curve));
    Record root{.heading = "travelling state along x", .group = "/state"};
    root.entries = state_entries(points.front(), form, line.grid.lx);
    root.entries.push_back({.name = "residual",
                            .unit = "1",
                            .meaning = "largest rate of a mode in the moving frame, relative to its linear terms",
                            .value = states.front().residual,
                            .digits = 2,
                            .rounding = 1e-14});
    root.entries.push_back({.name = "iterations",
                            .unit = "1",
                            .meaning = "of Newton's method",
                            .value = std::int64_t{states.front().iterations}});
    root.entries.push_back({.name = "right_hand_sides",
                            .unit = "1",
                            .meaning = "evaluated for the states, and for their perturbations",
                            .value = solver.right_hand_sides()});
    root.lists.push_back(perturbation_list(points.front()));
    if (family.followed) root.lists.push_back(curve_list(points, *family.followed, form, line.grid.lx));
    return {.root = std::move(root), .attributes = {}, .frames = frames_of(scene, points)};
}

}  // namespace drover::run
