// run/binodal_lines.cpp: from coexisting phases to lines of a plane.
#include "run/binodal_lines.hpp"

#include <algorithm>
#include <limits>

#include "drover/physics/binodal.hpp"
#include "drover/physics/regimes.hpp"
#include "drover/run/signals.hpp"
#include "run/travelling_start.hpp"

namespace drover::run {

namespace {
using physics::DensityAxis;

constexpr int steps = 32;  // along the plane

/// The component of the density of an axis; -1: not that of a field.
int component_of(const std::string& axis, const physics::Form& form) {
    const DensityAxis density = physics::density_axis(axis);
    return density == DensityAxis::none ? -1 : density == DensityAxis::rods ? form.rod_density : form.bead_density;
}

/// The density at 1 of an axis of densities [1/mm^2].
double density_per_unit(const physics::PlaneAxis& axis, physics::Model model) {
    axis.set(model, 1.0);
    return physics::density_axis(axis.name) == DensityAxis::rods ? model.uniform.rod_density
                                                                 : model.uniform.bead_density;
}

/// The value of the scene on an axis.
double value_of(const physics::PlaneAxis& axis, const physics::Model& model) {
    const DensityAxis density = physics::density_axis(axis.name);
    if (density == DensityAxis::none) {
        physics::Model copy = model;
        return io::model_number(axis.name, {}, model).in(copy);
    }
    return (density == DensityAxis::rods ? model.uniform.rod_density : model.uniform.bead_density) /
           density_per_unit(axis, model);
}

/// The points of both branches, in a plane whose axis `x` is the density of the phases.
struct Branches {
    std::vector<numerics::PlanePoint> low, high;
};

Branches branches_of(const physics::Binodal& binodal, const physics::PlaneAxis& x, const physics::PlaneAxis& y,
                     const physics::Model& model, bool y_is_density) {
    const double per_x = density_per_unit(x, model), per_y = y_is_density ? density_per_unit(y, model) : 1.0;
    Branches branches;
    for (const physics::Coexistence& at : binodal.points) {
        branches.low.push_back({at.low / per_x, y_is_density ? at.other_low / per_y : at.parameter});
        branches.high.push_back({at.high / per_x, y_is_density ? at.other_high / per_y : at.parameter});
    }
    return branches;
}

/// The part of a line within the plane.
model::BoundaryLine line_in(const physics::Plane& plane, const std::vector<numerics::PlanePoint>& points,
                            bool swapped) {
    model::BoundaryLine line;
    const auto inside = [](const physics::PlaneAxis& axis, double value) {
        return value >= axis.from && value <= axis.to;
    };
    for (const numerics::PlanePoint& point : points) {
        const double x = swapped ? point.y : point.x, y = swapped ? point.x : point.y;
        if (inside(plane.x, x) && inside(plane.y, y)) line.points.push_back({.x = x, .y = y});
    }
    return line;
}
}  // namespace

void check_binodal_plane(const io::Scene& scene, const std::string& x, const std::string& y) {
    const physics::Form form = physics::form(scene.model);
    require(component_of(x, form) >= 0 || component_of(y, form) >= 0, io::location_of(scene, "boundary.lines"),
            "boundary.lines has \"binodal\", the densities of coexisting phases, and the axes are {} and {}; expected "
            "the mean density of a field as one axis, such as uniform.rod_density",
            x, y);
}

BinodalLines trace_binodal_lines(const io::Scene& scene, const physics::Plane& plane, Threads& threads) {
    io::Scene line = line_of(scene);
    line.model.weathercock.convention = plane.model.weathercock.convention;
    const physics::Form form = physics::form(line.model);
    const bool swapped = component_of(plane.x.name, form) < 0;
    const physics::PlaneAxis &x = swapped ? plane.y : plane.x, &y = swapped ? plane.x : plane.y;
    const int component = component_of(x.name, form);
    const physics::TravellingProblem problem{.model =
                                                 [model = line.model, set = y.set](double value) {
                                                     check_stop_signal();
                                                     physics::Model changed = model;
                                                     set(changed, value);
                                                     return changed;
                                                 },
                                             .parameter = value_of(y, line.model),
                                             .grid = line.grid,
                                             .dealiasing = line.dealiasing};
    physics::TravellingSolver solver(problem, threads);
    const physics::TravellingState first = find_state(travelling_guess(scene, line, threads), solver);
    const bool y_is_density = component_of(y.name, form) >= 0;
    Branches whole;
    BinodalLines found;
    for (const double last : {y.from, y.to}) {
        const physics::Binodal binodal = physics::trace_binodal(problem, first, component, last, steps, threads);
        if (!binodal.ends.empty())
            found.ends.push_back(text("the binodals end at {} = {:.6g}, before {:.6g}: {}", y.name,
                                      binodal.points.back().parameter, last, binodal.ends));
        const Branches part = branches_of(binodal, x, y, line.model, y_is_density);
        const auto join = [&](std::vector<numerics::PlanePoint>& to, const std::vector<numerics::PlanePoint>& more) {
            std::reverse(to.begin(), to.end());
            to.insert(to.end(), more.begin() + (to.empty() ? 0 : 1), more.end());
        };
        join(whole.low, part.low);
        join(whole.high, part.high);
    }
    for (const std::vector<numerics::PlanePoint>* points : {&whole.low, &whole.high})
        if (model::BoundaryLine one = line_in(plane, *points, swapped); !one.points.empty())
            found.boundary.lines.push_back(std::move(one));
    return found;
}

}  // namespace drover::run
