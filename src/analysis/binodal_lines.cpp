// analysis/binodal_lines.cpp: from coexisting phases to lines of a plane.
#include "analysis/binodal_lines.hpp"

#include <algorithm>
#include <limits>

#include "run/scene_equations.hpp"
#include "run/signals.hpp"
#include "run/travelling_start.hpp"
#include "theory/binodal.hpp"

namespace drover::analysis {

namespace {
constexpr int steps_along_plane = 32;

/// The axes of a plane: the density of the phases, and the other one.
struct BinodalAxes {
    const PlaneNumber &density, &other;
    int component = -1, other_component = -1;  ///< of a state; -1: no density of a field
    bool swapped = false;                      ///< the density is y
};

BinodalAxes axes_of(const model::Equations& equations, const PlannedBoundary& planned) {
    const int x = density_component(equations, planned.x_number), y = density_component(equations, planned.y_number);
    if (x < 0)
        return {.density = planned.y_number,
                .other = planned.x_number,
                .component = y,
                .other_component = x,
                .swapped = true};
    return {.density = planned.x_number, .other = planned.y_number, .component = x, .other_component = y};
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

/// The scene with another value of a number of its model.
io::Scene scene_at(const io::Scene& scene, const PlaneNumber& number, double value) {
    SceneModel changed = scene_model(scene);
    number.set(changed, value);
    io::Scene result = scene;
    result.model = std::move(changed.model);
    result.declared = std::move(changed.declared);
    return result;
}
}  // namespace

BinodalLines trace_binodal_lines(const io::Scene& scene, const PlannedBoundary& planned, const std::string& convention,
                                 Threads& threads) {
    io::Scene line = run::line_of(scene);
    if (!convention.empty()) set_convention(line.model, convention);
    const BinodalAxes axes = axes_of(run::equations_of(line), planned);
    const theory::TravellingProblem problem{.at =
                                                [line, other = axes.other](double value) {
                                                    run::check_stop_signal();
                                                    return run::integrated_of(scene_at(line, other, value));
                                                },
                                            .parameter = axes.other.get(scene_model(line)),
                                            .grid = line.grid};
    numerics::TravellingSolver solver(theory::travelling_family(problem, threads));
    const numerics::TravellingState first = run::find_state(run::travelling_guess(scene, line, threads), solver);
    const DescribedAxis& along = axes.swapped ? planned.x : planned.y;
    Branches whole;
    BinodalLines found;
    for (const double last : {along.from, along.to}) {
        const theory::Binodal binodal =
            theory::trace_binodal(problem, first, axes.component, last, steps_along_plane, threads);
        if (!binodal.ends.empty())
            found.ends.push_back(text("the binodals end at {} = {:.6g}, before {:.6g}: {}", along.name,
                                      binodal.points.back().parameter, last, binodal.ends));
        const Branches part = branches_of(binodal, axes);
        const auto join = [&](std::vector<numerics::PlanePoint>& to, const std::vector<numerics::PlanePoint>& more) {
            std::reverse(to.begin(), to.end());
            to.insert(to.end(), more.begin() + (to.empty() ? 0 : 1), more.end());
        };
        join(whole.low, part.low);
        join(whole.high, part.high);
    }
    for (const std::vector<numerics::PlanePoint>* points : {&whole.low, &whole.high})
        if (theory::BoundaryLine one = line_in(planned.rectangle(), *points, axes.swapped); !one.points.empty())
            found.boundary.lines.push_back(std::move(one));
    return found;
}

}  // namespace drover::analysis
