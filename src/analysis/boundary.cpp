// analysis/boundary.cpp: limits of stability, states and binodals of a scene over a plane of its numbers, as a result.
#include "analysis/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "analysis/boundary_plan.hpp"
#include "analysis/stability.hpp"
#include "analysis/states.hpp"
#include "base/constants.hpp"
#include "base/log.hpp"
#include "model/start.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/fields/travelling_start.hpp"
#include "run/loop/progress.hpp"
#include "run/loop/signals.hpp"
#include "theory/binodal.hpp"

namespace drover::analysis {

namespace {
using theory::Limit;
using theory::MarginState;

/// Of a table at one point, in a plane of area fractions.
void warn_of_fixed_coefficients(const io::Scene& scene, const PlannedBoundary& planned) {
    const io::CalibratedPlan& calibrated = scene.calibrated;
    if (scene.found.filled.empty() || calibrated.coefficients == io::CoefficientsOf::local ||
        !(planned.x.is_fraction || planned.y.is_fraction))
        return;
    log_warning(
        "area fractions of the plane change the densities alone: all coefficients stay those of {} at "
        "calibrated.bead_area_fraction = {} and calibrated.rod_area_fraction = {}; for those at each point give "
        "calibrated.coefficients = \"local\"",
        calibrated.table, calibrated.bead_area_fraction, calibrated.rod_area_fraction);
}

/// What all lines of a plane share.
struct PlaneOfScene {
    const io::Scene& scene;
    const PlannedBoundary& planned;
    const numerics::Rectangle rectangle;
    const std::vector<io::Scene> draws;
    const theory::KnownStates known;                               ///< from which lines of states search theirs
    const std::unique_ptr<run::PointProgress> progress = nullptr;  ///< of models of one's own, whose points take long
};

PlaneModels models_of(const PlaneOfScene& plane, io::Scene base, const std::string& convention,
                      const PlaneModels* like = nullptr) {
    if (!convention.empty()) set_convention(base.model, convention);
    return {std::move(base), plane.planned.x, plane.planned.y, like};
}

/// A margin at the points of a plane.
using MarginAt = std::function<theory::Margin(const PlaneModels&, const numerics::PlanePoint&)>;

theory::MarginOf margin_over(const PlaneOfScene& plane, std::shared_ptr<const PlaneModels> models,
                             const MarginAt& margin) {
    return [&plane, margin, models = std::move(models)](const numerics::PlanePoint& point) {
        run::check_stop_signal();
        if (plane.progress) plane.progress->add();
        return margin(*models, point);
    };
}

std::shared_ptr<const PlaneModels> models_of_scene(const PlaneOfScene& plane, const std::string& convention) {
    return std::make_shared<const PlaneModels>(models_of(plane, plane.scene, convention));
}

/// The margins over a plane, and those of draws of its model.  Draws whose model is not valid are left out.
theory::PlaneMargins margins_over(const PlaneOfScene& plane, const std::string& convention, const MarginAt& margin) {
    const auto models = models_of_scene(plane, convention);
    theory::PlaneMargins result{.at = margin_over(plane, models, margin)};
    for (const io::Scene& one : plane.draws) try {
            result.draws.push_back(theory::where_valid(
                margin_over(plane, std::make_shared<const PlaneModels>(models_of(plane, one, convention, models.get())),
                            margin)));
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
        }
    return result;
}

MarginAt limit_margin(Limit limit) {
    return
        [limit](const PlaneModels& models, const numerics::PlanePoint& point) { return models.margin(point, limit); };
}

/// The states at the corners and middles of a plane, which lead to the others: states differ little over a plane.
theory::KnownStates states_over(const io::Scene& scene, const PlannedBoundary& planned) {
    const numerics::Rectangle plane = planned.rectangle();
    const PlaneModels models(scene, planned.x, planned.y);
    theory::KnownStates known;
    for (const double x : {0.5, 0.0, 1.0})
        for (const double y : {0.5, 0.0, 1.0}) {
            const model::Equations equations =
                models.equations({plane.x0 + x * (plane.x1 - plane.x0), plane.y0 + y * (plane.y1 - plane.y0)});
            const theory::StationaryStates found = theory::stationary_states(equations);
            for (const theory::StationaryState& state : found.states) known.values.push_back(state.values);
            known.ordered = std::max(known.ordered, theory::ordered_states(found));
        }
    return known;
}

/// Margins of states against waves of all lengths.
MarginAt state_margin(const PlaneOfScene& plane, MarginState which) {
    theory::GrowthSearch search = growth_search(plane.scene);
    if (plane.scene.stability.min_wavenumber == 0.0) search.min *= 100.0;  // the limit of long waves covers the rest
    search.wavenumbers = 41;  // the least stable wave is refined: these find it
    search.angles = 18;
    return [=, &plane](const PlaneModels& at, const numerics::PlanePoint& point) {
        return theory::margin(at.equations(point), which, plane.known, search);
    };
}

MarginState state_of(const std::string& line) {
    return line == isotropic_line ? MarginState::isotropic : MarginState::ordered;
}

DescribedLines described_line(const PlannedBoundary& planned, const std::string& name, const std::string& convention) {
    const bool has_states = std::ranges::any_of(planned.lines, is_of_state);
    if (std::ranges::all_of(planned.lines, is_of_state))
        return {.heading = text("the {} state becomes unstable", name),
                .names = {run::data_only(run::choice("state", "the uniform state that becomes unstable", name,
                                                     {isotropic_line, ordered_line}))},
                .shows_angles = name == ordered_line,
                .shows_waves = true};
    DescribedLines described{
        .heading = convention.empty() ? name : text("{} ({} convention of lambda)", name, convention),
        .names = {run::data_only(run::choice(
            "limit", "the instability that begins, or binodal: densities of phases that coexist", name, line_names()))},
        .shows_angles = name == name_of(Limit::oblique) || name == ordered_line,
        .shows_waves = has_states};
    if (!convention.empty())
        described.names.push_back(
            run::data_only(run::choice("convention", "convention of lambda", convention, {"mean", "single-rod"})));
    return described;
}

using PointValues = std::function<std::vector<double>(const numerics::PlanePoint&)>;

/// The regime at a point, and the decay rate of the order.
PointValues regime_at(const PlaneOfScene& plane, const std::string& convention) {
    return [&plane, models = models_of_scene(plane, convention),
            has_order = analysis::has_order(plane.scene)](const numerics::PlanePoint& point) {
        run::check_stop_signal();
        if (plane.progress) plane.progress->add();
        std::vector<double> result;
        models->visit(point, [&](const PlaneModels::MarginOfLimit& margin) {
            const auto value = [&](Limit limit) {  // without a field that turns no order sets in
                return !has_order && limit == Limit::onset ? infinite : margin(limit).value;
            };
            result = {static_cast<double>(theory::regime_of(value)), has_order ? margin(Limit::onset).value : nan};
        });
        return result;
    };
}

PointValues stable_states_at(const std::vector<std::pair<MarginState, theory::MarginOf>>& states) {
    return [states](const numerics::PlanePoint& point) -> std::vector<double> {
        int stable = 0;
        bool found = false;
        for (const auto& [state, margin_of] : states) {
            const double margin = margin_of(point).value;
            found = found || !std::isnan(margin);
            if (margin > 0.0) stable += state == MarginState::isotropic ? 1 : 2;
        }
        return {found ? static_cast<double>(stable) : -1.0};
    };
}

/// Numbers of a point, and what they are.
struct PlaneMap {
    std::vector<files::Quantity> quantities;
    PointValues at;
};

PlaneMap map_of(const PlaneOfScene& plane) {
    const std::vector<std::string> axes{"map_y", "map_x"}, &lines = plane.planned.lines;
    const std::string convention = plane.planned.conventions.front();
    if (!std::ranges::all_of(lines, is_of_state))
        return {.quantities = {{"regime", "1", theory::regime_legend(), axes},
                               {"effective_relaxation", "s-1",
                                "rate at which order decays in the isotropic state; of rods and beads abar = a - c "
                                "sigma - lambda alpha/Gamma",
                                axes}},
                .at = regime_at(plane, convention)};
    const auto models = models_of_scene(plane, convention);
    std::vector<std::pair<MarginState, theory::MarginOf>> states;
    for (const std::string& line : lines)
        states.emplace_back(state_of(line), margin_over(plane, models, state_margin(plane, state_of(line))));
    return {
        .quantities =
            {{"stable_states", "1",
              "-1 no uniform state, 0 neither is stable, 1 isotropic, 2 ordered, 3 both, of the states of the lines",
              axes}},
        .at = stable_states_at(states)};
}

files::ResultTable map_table(const PlaneMap& map, const MapPoints& on, Threads& threads) {
    std::vector<std::vector<double>> values(map.quantities.size(), std::vector<double>(on.points.size()));
    threads.for_chunks(on.points.size(), 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const std::vector<double> found = map.at(on.points[n]);
            for (std::size_t k = 0; k < found.size(); ++k) values[k][n] = found[k];
        }
    });
    return {.group = {}, .axes = on.axes, .quantities = map.quantities, .values = std::move(values)};
}

/// The samples of each contour, at the corners and centres of its cells, and those of the map.
std::int64_t min_points(const io::Scene& scene, const PlannedBoundary& planned) {
    const std::int64_t cells = scene.boundary.cells, side = scene.boundary.map;
    const auto lines = static_cast<std::int64_t>(planned.lines.size());
    const std::int64_t on_map = std::ranges::all_of(planned.lines, is_of_state) ? lines : 1;
    return lines * ((cells + 1) * (cells + 1) + cells * cells) + on_map * side * side;
}

PlaneOfScene plane_of(const io::Scene& scene, const PlannedBoundary& planned, bool quiet) {
    warn_of_fixed_coefficients(scene, planned);
    std::unique_ptr<run::PointProgress> progress;
    if (scene.kind == io::SceneKind::model)
        progress = std::make_unique<run::PointProgress>(min_points(scene, planned), quiet);
    return {.scene = scene,
            .planned = planned,
            .rectangle = planned.rectangle(),
            .draws = drawn_scenes(scene, planned.errors),
            .known =
                std::ranges::any_of(planned.lines, is_of_state) ? states_over(scene, planned) : theory::KnownStates(),
            .progress = std::move(progress)};
}

constexpr int steps_along_plane = 32;

/// The axes of a plane: the density of the phases, and the other one.
struct BinodalAxes {
    const PlaneAxis &density, &other;
    int component = -1, other_component = -1;  ///< of a state; -1: no density of a field
    bool swapped = false;                      ///< the density is y
};

BinodalAxes axes_of(const model::Equations& equations, const PlannedBoundary& planned) {
    const int x = density_component(equations, planned.x), y = density_component(equations, planned.y);
    if (x < 0) return {.density = planned.y, .other = planned.x, .component = y, .other_component = x, .swapped = true};
    return {.density = planned.x, .other = planned.y, .component = x, .other_component = y};
}

/// The points of both branches, in a plane whose first axis is the density of the phases.
struct Branches {
    std::vector<numerics::PlanePoint> low, high;
};

Branches branches_of(const theory::Binodal& binodal, const BinodalAxes& axes) {
    Branches branches;
    for (const theory::Coexistence& at : binodal.points) {
        const auto point = [&](double density, const std::vector<double>& phase) -> numerics::PlanePoint {
            const double other = axes.other_component < 0
                                     ? at.parameter
                                     : phase[static_cast<std::size_t>(axes.other_component)] * axes.other.area;
            return {density * axes.density.area, other};
        };
        branches.low.push_back(point(at.low, at.in_low));
        branches.high.push_back(point(at.high, at.in_high));
    }
    return branches;
}

/// The part of a line within the plane.
theory::BoundaryLine line_in(const numerics::Rectangle& plane, const std::vector<numerics::PlanePoint>& points,
                             bool swapped) {
    theory::BoundaryLine line;
    for (const numerics::PlanePoint& point : points) {
        const double x = swapped ? point.y : point.x, y = swapped ? point.x : point.y;
        if (x >= plane.x0 && x <= plane.x1 && y >= plane.y0 && y <= plane.y1) line.points.push_back({.x = x, .y = y});
    }
    return line;
}

/// Where to go from a value: to both ends of an axis or, from a value outside it, to the farther one.
std::vector<double> ends_from(double value, const PlaneAxis& axis) {
    const double from = axis.from - value, to = axis.to - value;
    if (from * to <= 0.0) return {axis.from, axis.to};
    return {std::abs(from) > std::abs(to) ? axis.from : axis.to};
}

struct BinodalLines {
    theory::Boundary boundary;
    std::vector<std::string> notes;  ///< where lines end within the plane, and what they are not
};

/// Of phases that differ in a conserved scalar that is no axis: they coexist at the ends of one tie line, whose place
/// depends on the cell, and a uniform state beside the line may separate at other densities.
std::vector<std::string> tie_line_notes(const theory::Binodal& binodal, const BinodalAxes& axes,
                                        const model::Equations& equations) {
    constexpr double same = 1e-3;      // of the larger value: beyond what plateaus of finite length differ by
    constexpr double rounding = 1e-9;  // of the range of the density: what the solver leaves of a field that is 0
    std::vector<std::string> notes;
    const std::vector<model::StateComponent> components = model::components_of_state(equations);
    for (int c = 0; c < static_cast<int>(components.size()); ++c) {
        const auto at = static_cast<std::size_t>(c);
        const model::Field& field = equations.model().fields[components[at].field];
        if (field.spin != 0 || !field.conserved || c == axes.component || c == axes.other_component) continue;
        const auto differs = std::ranges::find_if(binodal.points, [at](const theory::Coexistence& one) {
            const double larger = std::max(std::abs(one.in_high[at]), std::abs(one.in_low[at]));
            return std::abs(one.in_high[at] - one.in_low[at]) > same * larger + rounding * (one.high - one.low);
        });
        if (differs == binodal.points.end()) continue;
        notes.push_back(text(
            "{0} differs between the phases ({1:.4g} and {2:.4g} at {3} = {4:.6g}): these are the phases of one tie "
            "line, which depends on the cell, and not all densities between them separate; for the edges of "
            "coexistence take uniform.{0} as the other axis",
            field.name, differs->in_low[at], differs->in_high[at], axes.other.name, differs->parameter));
    }
    return notes;
}

/// Of branches over two densities, which end where the mean of the other density reaches the end of the plane.
void note_short_branches(const Branches& branches, const BinodalAxes& axes, std::vector<std::string>& notes) {
    if (axes.other_component < 0) return;
    const double from = std::min(axes.other.from, axes.other.to), to = std::max(axes.other.from, axes.other.to);
    for (const auto* points : {&branches.low, &branches.high})
        if (const double end = points->back().y; end > from && end < to)
            notes.push_back(text(
                "the binodal of the phase of {} {} ends within the plane, at {} = {:.6g}: the mean of the cell is at "
                "the end of the plane there; for the rest take a longer axis",
                points == &branches.low ? "small" : "large", axes.density.name, axes.other.name, end));
}

/// The binodal of each phase: from the state of two phases next to the initial fields of the scene, along the other
/// axis of the plane to both its ends.  convention: of lambda; "": none.  Throws a run Error where no such state is
/// found.
BinodalLines trace_binodal_lines(const io::Scene& scene, const PlannedBoundary& planned, const std::string& convention,
                                 Threads& threads) {
    io::Scene line = run::line_of(scene);
    if (!convention.empty()) set_convention(line.model, convention);
    const BinodalAxes axes = axes_of(run::equations_of(line), planned);
    const run::TravellingGuess guess = run::travelling_guess(scene, line, threads);
    if (axes.other_component >= 0)  // the parameter is the mean of the cell, which formulas may give
        axes.other.set(line, guess.fields[axes.other_component][0].real() * axes.other.area);
    const model::Integrated here = run::integrated_of(line);
    const int degree = here.equations.linear_system(line.grid, here.kept_degree).degree;
    const theory::TravellingProblem problem{.at =
                                                [line, other = axes.other](double value) {
                                                    run::check_stop_signal();
                                                    io::Scene changed = line;
                                                    other.set(changed, value);
                                                    return run::integrated_of(changed);
                                                },
                                            .parameter = axes.other.in(line),
                                            .grid = line.grid,
                                            .tail =
                                                [grid = line.grid, degree](const numerics::TravellingState& state) {
                                                    return tail_of(state, grid, degree);
                                                }};
    numerics::TravellingSolver solver(theory::travelling_family(problem, threads));
    const numerics::TravellingState first = run::find_state(guess, solver);
    Branches whole;
    BinodalLines found;
    double tail = 0.0;
    for (const double last : ends_from(problem.parameter, axes.other)) {
        const theory::Binodal binodal =
            theory::trace_binodal(problem, first, axes.component, last, steps_along_plane, threads);
        const Branches part = branches_of(binodal, axes);
        if (!binodal.ends.empty())
            found.notes.push_back(text("the binodals end at {} = {:.6g}, before {:.6g}: {}", axes.other.name,
                                       binodal.points.back().parameter, last, binodal.ends));
        else note_short_branches(part, axes, found.notes);
        for (std::string& note : tie_line_notes(binodal, axes, here.equations))
            if (std::ranges::find(found.notes, note) == found.notes.end()) found.notes.push_back(std::move(note));
        tail = std::max(tail, binodal.tail);
        const auto join = [&](std::vector<numerics::PlanePoint>& to, const std::vector<numerics::PlanePoint>& more) {
            std::ranges::reverse(to);
            to.insert(to.end(), more.begin() + (to.empty() ? 0 : 1), more.end());
        };
        join(whole.low, part.low);
        join(whole.high, part.high);
    }
    if (tail > theory::max_state_tail)
        found.notes.push_back(
            text("the grid does not resolve all states of the binodals: up to {:.2g} of the variance of a "
                 "field is in the shortest waves of the grid; expected less than {:.0e}: choose "
                 "grid.nx = {}",
                 tail, theory::max_state_tail, 2 * line.grid.nx));
    for (const std::vector<numerics::PlanePoint>* points : {&whole.low, &whole.high})
        if (theory::BoundaryLine one = line_in(planned.rectangle(), *points, axes.swapped); !one.points.empty())
            found.boundary.lines.push_back(std::move(one));
    return found;
}
}  // namespace

void check_boundary(const io::Scene& scene) {
    // An axis that is missing may be given with the command.
    if (!scene.boundary.x.empty() && !scene.boundary.y.empty()) static_cast<void>(plan_boundary(scene));
}

run::Result make_boundary(const io::Scene& scene, Threads& threads, const BoundaryWork& work) {
    PlannedBoundary planned = plan_boundary(scene);
    const PlaneOfScene plane = plane_of(scene, planned, work.quiet);
    if (!plane.draws.empty()) planned.draws = static_cast<std::size_t>(scene.boundary.draws);
    const bool has_map = scene.boundary.map > 0 && !work.lines_alone;
    const PlaneMap map = has_map ? map_of(plane) : PlaneMap{};
    const ComputeAll compute = work.compute ? work.compute : on_threads(threads);
    run::List traced{.name = "traced"};
    BandMaps bands(planned);
    bool complete = true;
    for (const std::string& convention : planned.conventions)
        for (const std::string& name : planned.lines) {
            const DescribedLines described = described_line(planned, name, convention);
            if (name == binodal_name) {
                if (work.lines_alone) continue;
                const BinodalLines found = trace_binodal_lines(scene, planned, convention, threads);
                traced.rows.push_back(traced_record(planned, described, found.boundary));
                traced.rows.back().entries.push_back(run::data_only(run::words("notes", "", found.notes)));
                for (const std::string& note : found.notes) log_warning("binodals: {}", note);
                complete = complete && found.notes.empty();
                continue;
            }
            const theory::PlaneMargins margins =
                margins_over(plane, convention,
                             is_of_state(name) ? state_margin(plane, state_of(name))
                                               : limit_margin(value_named<Limit>(name).value()));
            const theory::Boundary boundary =
                theory::trace_boundary(plane.rectangle, margins.at, margins.draws,
                                       {.cells = scene.boundary.cells, .chord = scene.boundary.chord}, compute);
            complete = complete && boundary.complete;
            traced.rows.push_back(traced_record(planned, described, boundary));
            bands.add(described, boundary);
        }
    run::Result result{.root = plane_record(planned, complete, std::move(traced)),
                       .attributes = {{"boundary_x", planned.x.name}, {"boundary_y", planned.y.name}}};
    bands.add_to(result.root);
    if (has_map)
        result.root.parts.push_back({"map",
                                     {.group = "/map",
                                      .maps = map_table(map, map_points(planned, scene.boundary.map), threads),
                                      .shown = {.text = false}}});
    return result;
}

}  // namespace drover::analysis
