// physics/phase_boundary.cpp: margins of stability over a plane of models, and the lines where they vanish.
#include "drover/physics/phase_boundary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "base/constants.hpp"
#include "drover/base/draws.hpp"

namespace drover::physics {

namespace {
constexpr double none = std::numeric_limits<double>::quiet_NaN();

constexpr std::array limits{std::pair{Limit::onset, "onset"}, std::pair{Limit::phase_separation, "phase-separation"},
                            std::pair{Limit::banding, "banding"}, std::pair{Limit::oblique, "oblique"}};

bool has_values(const Equations& e, double beads, double rods) {
    for (const auto& [key, coefficient] : named(e))
        if (!std::isfinite(coefficient->at(beads, rods).value)) return false;
    return true;
}

/// The minimum margin over angles from p0: sampled, then refined about the smallest sample.
Margin least_over_angles(const LongWaves& waves, double direction, bool quarter) {
    const int samples = quarter ? 18 : 36;  // every 5 degrees of a quarter or of half a turn
    const double step = right_angle / 18.0;
    const auto at = [&](double angle) { return slow_growth(waves, direction + angle).margin(); };
    Margin least{.value = std::numeric_limits<double>::infinity(), .angle = step};
    for (int n = 1; n <= samples; ++n)
        if (const double value = at(n * step); value < least.value) least = {.value = value, .angle = n * step};
    double width = 0.5 * step;
    // Closing in by halves; a kink between two modes does no harm.
    for (int i = 0; i < 16 && width > 1e-6; ++i, width *= 0.5)
        for (const double angle : {least.angle - width, least.angle + width}) {
            if (quarter && (angle <= 0.0 || angle > right_angle)) continue;
            if (const double value = at(angle); value < least.value) least = {.value = value, .angle = angle};
        }
    return least;
}
}  // namespace

std::string limit_name(Limit limit) {
    for (const auto& [which, name] : limits)
        if (which == limit) return name;
    return "";
}

Limit limit_of(const std::string& name) {
    std::vector<std::string> names;
    for (const auto& [which, known] : limits) {
        if (name == known) return which;
        names.emplace_back(known);
    }
    fail_input({}, "unknown stability boundary \"{}\"; expected one of {}", name, joined(names));
}

Margin margin(const Equations& e, double bead_density, double rod_density, Limit limit) {
    if (!has_values(e, bead_density, rod_density)) return {.value = none};
    const bool flock = limit == Limit::banding || limit == Limit::oblique;
    const double abar = flock ? none : effective_relaxation(e, bead_density, rod_density);
    if (limit == Limit::phase_separation && !(abar > 0.0)) return {.value = none};
    // The flock: the largest order.  With a field from outside there is no isotropic state, and nothing sets in.
    const StationaryStates found = stationary_states(e, bead_density, rod_density);
    const StationaryState* state = nullptr;
    for (const StationaryState& one : found.states)
        if (flock == (one.point.order.norm() > 0.0) && (!state || one.point.order.norm() > state->point.order.norm()))
            state = &one;
    if (!state) return {.value = none};
    if (limit == Limit::onset) return {.value = abar};
    const LongWaves waves = long_waves(e, *state);
    if (!waves.why_none.empty() || waves.right.cols() == 0) return {.value = none};
    const double direction = direction_of(state->point);
    if (limit == Limit::oblique) return least_over_angles(waves, direction, is_mirrored(state->point));
    return {.value = slow_growth(waves, direction).margin()};
}

std::vector<Uncertain> table_errors(const Model& model) {
    std::vector<Uncertain> result;
    for (const auto& [key, column] : model.table.columns)
        for (std::size_t i = 0; i < column.errors.size(); ++i)
            if (const double error = column.errors[i]; error != 0.0)
                result.push_back(
                    {.name = text("table.{}[{}]", key, i),
                     .error = error,
                     .add = [key = key, i](Model& m, double change) { m.table.columns.at(key).values[i] += change; }});
    return result;
}

void draw_errors(const std::vector<Uncertain>& uncertain, std::vector<Model>& models) {
    for (std::size_t n = 0; n < uncertain.size(); ++n) {
        const std::vector<double> draws = normal_draws(n, 0, models.size());
        for (std::size_t k = 0; k < models.size(); ++k) uncertain[n].add(models[k], draws[k] * uncertain[n].error);
    }
}

namespace {
/// The model at a point; its densities are those of the point.
Model model_at(const Plane& plane, const numerics::PlanePoint& point) {
    Model model = plane.model;
    plane.x.set(model, point.x);
    plane.y.set(model, point.y);
    return model;
}

/// A valid initial model: the centre of the plane.
Model middle_model(const Plane& plane) {
    Model model = model_at(plane, {.x = 0.5 * (plane.x.from + plane.x.to), .y = 0.5 * (plane.y.from + plane.y.to)});
    // Where the middle lies beyond a table the coefficients themselves still serve the rest of the plane.
    model.uniform = plane.model.uniform;
    return model;
}
/// The models of a plane: compiled at each point, or once if both axes are densities.
class PlaneModels {
public:
    explicit PlaneModels(const Plane& plane) : plane_(plane), base_(middle_model(plane)) {}
    PlaneModels(const Plane& plane, const PlaneModels& like) : plane_(plane), base_(middle_model(plane), like.base_) {}

    Margin margin(const numerics::PlanePoint& point, Limit limit) const {
        if (plane_.x.is_density && plane_.y.is_density) {
            Model densities{.uniform = plane_.model.uniform};
            plane_.x.set(densities, point.x);
            plane_.y.set(densities, point.y);
            return physics::margin(base_, densities.uniform.bead_density, densities.uniform.rod_density, limit);
        }
        const Model model = model_at(plane_, point);
        if (!has_values(base_, model.uniform.bead_density, model.uniform.rod_density)) return {.value = none};
        try {
            return physics::margin(Equations(model, base_), model.uniform.bead_density, model.uniform.rod_density,
                                   limit);
        } catch (const Error& error) {
            fail_input({}, "at {} = {}, {} = {}: {}", plane_.x.name, point.x, plane_.y.name, point.y, error.what());
        }
    }

private:
    Plane plane_;
    Equations base_;
};

}  // namespace

model::PlaneMargins margins_over(const Plane& plane, Limit limit, const std::vector<Model>& draws) {
    const auto models = std::make_shared<const PlaneModels>(plane);
    model::PlaneMargins result{.at = [models, limit](
                                         const numerics::PlanePoint& point) { return models->margin(point, limit); },
                               .draws = {}};
    for (const Model& one : draws) try {
            Plane changed = plane;
            changed.model = one;
            result.draws.push_back(
                model::where_valid([of = PlaneModels(changed, *models), limit](const numerics::PlanePoint& point) {
                    return of.margin(point, limit);
                }));
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
        }
    return result;
}

}  // namespace drover::physics
