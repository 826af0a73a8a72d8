// run/model_boundary.cpp: the plane of a declared model, its margins, and the map of stable states.
#include "run/model_boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "drover/base/draws.hpp"
#include "drover/run/progress.hpp"
#include "drover/run/signals.hpp"
#include "run/boundary_plan.hpp"
#include "run/boundary_records.hpp"
#include "run/model_coefficients.hpp"
#include "run/number_lists.hpp"
#include "run/stability_problem.hpp"

namespace drover::run {

namespace {
using model::MarginState;

const std::vector<std::string> state_names{"isotropic", "ordered"};

struct UncertainCoefficient {
    std::string name;
    double error = 0.0;
};

struct PlannedModelBoundary {
    KeyRange x, y;
    std::vector<MarginState> states;
    std::vector<UncertainCoefficient> uncertain;
};

KeyRange coefficient_axis(const io::Scene& scene, const std::string& list, const std::string& written) {
    const SourceLocation where = io::location_of(scene, list);
    KeyRange axis = read_axis(list, written, "\"coefficients.a = 0.5:2\"", where);
    axis.key = coefficient_of(scene, list, axis.key, where);
    return axis;
}

std::vector<MarginState> states_of(const io::Scene& scene) {
    const bool has_spin = std::any_of(scene.declared.fields.begin(), scene.declared.fields.end(),
                                      [](const io::DeclaredField& field) { return field.rank != "scalar"; });
    if (scene.boundary.lines == io::BoundaryPlan{}.lines)
        return has_spin ? std::vector{MarginState::isotropic, MarginState::ordered}
                        : std::vector{MarginState::isotropic};
    const SourceLocation where = io::location_of(scene, "boundary.lines");
    std::vector<MarginState> states;
    for (const std::string& name : scene.boundary.lines) {
        const auto found = std::find(state_names.begin(), state_names.end(), name);
        require(found != state_names.end(), where,
                "boundary.lines has \"{}\", a line of rods and beads; expected {} for a model of its own: where that "
                "state becomes unstable",
                name, joined(state_names));
        require(name == "isotropic" || has_spin, where,
                "boundary.lines has \"ordered\", and no field of the model has a direction; expected isotropic");
        states.push_back(name == "isotropic" ? MarginState::isotropic : MarginState::ordered);
    }
    return states;
}

PlannedModelBoundary plan_of(const io::Scene& scene) {
    PlannedModelBoundary plan{.x = coefficient_axis(scene, "boundary.x", scene.boundary.x),
                              .y = coefficient_axis(scene, "boundary.y", scene.boundary.y),
                              .states = states_of(scene)};
    require(plan.x.key != plan.y.key, io::location_of(scene, "boundary.y"),
            "boundary.x is {} and boundary.y is {}; expected two different coefficients", plan.x.key, plan.y.key);
    require(scene.boundary.conventions.empty(), io::location_of(scene, "boundary.conventions"),
            "boundary.conventions is for the equations of rods and beads; expected a scene without it");
    const std::string list = "boundary.errors", example = "\"coefficients.a = 0.02\"";
    const SourceLocation where = io::location_of(scene, list);
    for (const std::string& written : scene.boundary.errors) {
        const Assignment given = read_assignment(written, list, example, where);
        const double error = read_number(given.value, written, list, example, where);
        require(error > 0.0, where, "{} has \"{}\"; expected a standard error > 0", list, written);
        const std::string name = coefficient_of(scene, list, given.key, where);
        require(name != plan.x.key && name != plan.y.key, where,
                "{} names {}, which an axis of the plane sets exactly; expected another coefficient", list, given.key);
        plan.uncertain.push_back({name, error});
    }
    return plan;
}

class ModelPlane {
public:
    ModelPlane(const io::Scene& scene, const PlannedModelBoundary& plan, bool quiet)
        : declared_(scene.declared),
          plan_(plan),
          search_(growth_search(scene)),
          progress_(std::make_unique<PointProgress>(least_points(scene, plan), quiet)) {
        if (scene.stability.min_wavenumber == 0.0) search_.min *= 100.0;  // the limit of long waves covers the rest
        search_.wavenumbers = 41;  // the least stable wave is refined: these find it
        search_.angles = 18;
        for (const double x : {0.5, 0.0, 1.0})
            for (const double y : {0.5, 0.0, 1.0})
                add_guesses(
                    at({plan.x.from + x * (plan.x.to - plan.x.from), plan.y.from + y * (plan.y.to - plan.y.from)}));
    }

    using Changes = std::vector<std::pair<std::string, double>>;

    /// Margins of one state, with other values of these coefficients.
    model::MarginOf margin(MarginState state, const Changes& others = {}) const {
        return [=, this](const numerics::PlanePoint& point) {
            check_stop_signal();
            progress_->add();
            Changes changes = at(point);
            changes.insert(changes.end(), others.begin(), others.end());
            return model::margin(equations_with(declared_, changes), state, guesses_, search_);
        };
    }
    /// The same with the uncertain coefficients drawn within their errors; NaN where a draw has no such state.
    std::vector<model::MarginOf> draws(MarginState state, std::size_t count) const {
        std::vector<Changes> drawn(plan_.uncertain.empty() ? 0 : count);
        for (std::size_t n = 0; n < plan_.uncertain.size(); ++n) {
            const auto& [name, error] = plan_.uncertain[n];
            const std::vector<double> normal = normal_draws(n, 0, count);
            for (std::size_t k = 0; k < drawn.size(); ++k)
                drawn[k].emplace_back(name, declared_.coefficients.at(name) + normal[k] * error);
        }
        std::vector<model::MarginOf> result;
        for (const Changes& one : drawn)
            result.emplace_back([of = margin(state, one)](const numerics::PlanePoint& point) -> model::Margin {
                try {
                    return of(point);
                } catch (const Error& error) {
                    if (!is_of_scene(error.fault())) throw;  // such as a signal
                    return {.value = std::numeric_limits<double>::quiet_NaN()};
                }
            });
        return result;
    }

private:
    /// The samples of each contour, at the corners and centres of its cells, and those of the map.
    static std::int64_t least_points(const io::Scene& scene, const PlannedModelBoundary& plan) {
        const std::int64_t cells = scene.boundary.cells, side = scene.boundary.map;
        return static_cast<std::int64_t>(plan.states.size()) *
               ((cells + 1) * (cells + 1) + cells * cells + side * side);
    }

    Changes at(const numerics::PlanePoint& point) const { return {{plan_.x.key, point.x}, {plan_.y.key, point.y}}; }
    /// States differ little over a plane: those of its corners and middles lead to the others.
    void add_guesses(const Changes& changes) {
        for (const model::StationaryState& state : model::stationary_states(equations_with(declared_, changes)).states)
            guesses_.push_back(state.values);
    }

    io::DeclaredModel declared_;
    PlannedModelBoundary plan_;
    model::GrowthSearch search_;
    std::vector<model::UniformState> guesses_;
    std::unique_ptr<PointProgress> progress_;
};

DescribedAxis described(const KeyRange& axis) {
    return {.name = "coefficients." + axis.key, .unit = "1", .udunits = "1", .from = axis.from, .to = axis.to};
}

DescribedLines lines_of(const std::string& state) {
    return {.heading = text("the {} state becomes unstable", state),
            .names = {{.name = "state",
                       .unit = "",
                       .meaning = "the uniform state that becomes unstable",
                       .value = state,
                       .choices = state_names,
                       .shown = {.text = false}}},
            .shows_angles = state == "ordered",
            .shows_waves = true};
}

/// What is stable at the points of a plane.
files::ResultTable state_map(const ModelPlane& plane, const PlannedModelBoundary& plan, const DescribedPlane& described,
                             int side, Threads& threads) {
    const MapPoints map = map_points(described, side);
    std::vector<double> codes(map.points.size());
    threads.for_chunks(codes.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            int stable = 0, found = 0;
            for (const MarginState state : plan.states) {
                const double margin = plane.margin(state)(map.points[n]).value;
                if (!std::isnan(margin)) found = 1;
                if (margin > 0.0) stable += state == MarginState::isotropic ? 1 : 2;
            }
            codes[n] = found == 0 ? -1 : stable;
        }
    });
    return {.group = {},
            .axes = map.axes,
            .quantities = {{"stable_states",
                            "1",
                            "-1 no uniform state, 0 none is stable, 1 isotropic, 2 ordered, 3 both",
                            {"map_y", "map_x"}}},
            .values = {codes}};
}
}  // namespace

void check_model_boundary(const io::Scene& scene) { plan_of(scene); }

Result make_model_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work) {
    const PlannedModelBoundary plan = plan_of(scene);
    const ModelPlane plane(scene, plan, work.quiet);
    const ComputeAll compute = compute_of(work, threads);
    const DescribedPlane described_plane{.x = described(plan.x),
                                         .y = described(plan.y),
                                         .draws = plan.uncertain.empty()
                                                      ? 0
                                                      : static_cast<std::size_t>(scene.boundary.draws),
                                         .cells = scene.boundary.cells};
    const numerics::Rectangle rectangle{.x0 = plan.x.from, .x1 = plan.x.to, .y0 = plan.y.from, .y1 = plan.y.to};
    List traced{.name = "traced"};
    BandMaps bands(described_plane);
    bool complete = true;
    for (const MarginState state : plan.states) {
        const model::Boundary boundary =
            model::trace_boundary(rectangle, plane.margin(state), plane.draws(state, described_plane.draws),
                                  {.cells = scene.boundary.cells, .chord = scene.boundary.chord}, compute);
        complete = complete && boundary.complete;
        const DescribedLines described_lines = lines_of(state_names[static_cast<std::size_t>(state)]);
        traced.rows.push_back(traced_record(described_plane, described_lines, boundary));
        bands.add(described_lines, boundary);
    }
    Result result{.root = plane_record(described_plane, complete, std::move(traced)),
                  .attributes = {{"boundary_x", described_plane.x.name}, {"boundary_y", described_plane.y.name}}};
    bands.add_to(result.root);
    if (scene.boundary.map > 0 && !work.lines_alone)
        result.root.parts.push_back({"map",
                                     {.group = "/map",
                                      .maps = state_map(plane, plan, described_plane, scene.boundary.map, threads),
                                      .shown = {.text = false}}});
    return result;
}

}  // namespace drover::run
