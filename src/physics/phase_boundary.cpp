// physics/phase_boundary.cpp: margins of stability over a plane of models, and the lines where they vanish.
#include "drover/physics/phase_boundary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace drover::physics {

namespace {
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double right_angle = std::numbers::pi / 2.0;

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

namespace {
/// The margin, at all angles of the limit or at a single angle.
Margin margin_at(const Equations& e, double bead_density, double rod_density, Limit limit, const double* one_angle) {
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
    if (!waves.undefined.empty() || waves.right.cols() == 0) return {.value = none};
    const double direction = direction_of(state->point);
    if (one_angle) return {.value = slow_growth(waves, direction + *one_angle).margin(), .angle = *one_angle};
    if (limit == Limit::oblique) return least_over_angles(waves, direction, is_mirrored(state->point));
    return {.value = slow_growth(waves, direction).margin()};
}
}  // namespace

Margin margin(const Equations& equations, double bead_density, double rod_density, Limit limit) {
    return margin_at(equations, bead_density, rod_density, limit, nullptr);
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

    Margin margin(const numerics::PlanePoint& point, Limit limit, const double* one_angle = nullptr) const {
        if (plane_.x.is_density && plane_.y.is_density) {
            Model densities{.uniform = plane_.model.uniform};
            plane_.x.set(densities, point.x);
            plane_.y.set(densities, point.y);
            return margin_at(base_, densities.uniform.bead_density, densities.uniform.rod_density, limit, one_angle);
        }
        const Model model = model_at(plane_, point);
        if (!has_values(base_, model.uniform.bead_density, model.uniform.rod_density)) return {.value = none};
        try {
            return margin_at(Equations(model, base_), model.uniform.bead_density, model.uniform.rod_density, limit,
                             one_angle);
        } catch (const Error& error) {
            fail_input({}, "at {} = {}, {} = {}: {}", plane_.x.name, point.x, plane_.y.name, point.y, error.what());
        }
    }

private:
    Plane plane_;
    Equations base_;
};

std::vector<Margin> margins_at(const PlaneModels& models, const std::vector<numerics::PlanePoint>& points, Limit limit,
                               Threads& threads) {
    std::vector<Margin> result(points.size());
    threads.for_chunks(points.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) result[i] = models.margin(points[i], limit);
    });
    return result;
}

/// Margins at points of a line, each at the angle that decides there: by how much it differs elsewhere does not matter
/// to first order.
std::vector<double> margins_along(const PlaneModels& models, const std::vector<BoundaryPoint>& line, Limit limit,
                                  Threads& threads) {
    std::vector<double> result(line.size());
    threads.for_chunks(line.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            result[i] = models.margin({line[i].x, line[i].y}, limit, &line[i].angle).value;
    });
    return result;
}

/// d(margin)/d(axis scaled to 1) at each point, by central differences; one-sided at the edge of the plane.
std::vector<double> slopes(const PlaneModels& models, const PlaneAxis& axis, double BoundaryPoint::*place,
                           const std::vector<BoundaryPoint>& line, Limit limit, Threads& threads) {
    constexpr double part = 1e-6;  // small beside the way to where another mode takes over; rounding 1e-12/part
    const double step = part * (axis.to - axis.from);
    const auto moved = [&](double sign) {
        std::vector<BoundaryPoint> result = line;
        for (BoundaryPoint& point : result)
            point.*place =
                std::clamp(point.*place + sign * step, std::min(axis.from, axis.to), std::max(axis.from, axis.to));
        return result;
    };
    const std::vector<BoundaryPoint> low = moved(-1.0), high = moved(1.0);
    const std::vector<double> at_low = margins_along(models, low, limit, threads),
                              at_high = margins_along(models, high, limit, threads);
    std::vector<double> result;
    for (std::size_t i = 0; i < line.size(); ++i)
        result.push_back((at_high[i] - at_low[i]) / ((high[i].*place - low[i].*place) / (axis.to - axis.from)));
    return result;
}

/// Variance of the margin at each point, the uncertain numbers being independent.
std::vector<double> margin_variances(const Plane& plane, const PlaneModels& models,
                                     const std::vector<BoundaryPoint>& line, Limit limit,
                                     const std::vector<Uncertain>& uncertain, Threads& threads) {
    constexpr double part =
        1e-3;  // of a standard error: the slope, on one side of a kink where another mode takes over
    std::vector<double> variances(line.size());
    for (const Uncertain& one : uncertain) {
        std::array<std::vector<double>, 2> sides;
        for (const int side : {0, 1}) {
            Plane changed = plane;
            one.add(changed.model, (side == 0 ? -part : part) * one.error);
            sides[static_cast<std::size_t>(side)] = margins_along(PlaneModels(changed, models), line, limit, threads);
        }
        for (std::size_t i = 0; i < line.size(); ++i) {
            const double slope = (sides[1][i] - sides[0][i]) / (2.0 * part);
            variances[i] += slope * slope;
        }
    }
    return variances;
}

/// Fills in where the line would run if the uncertain numbers were off by their errors: margin + slope . shift = 0.
void add_errors(const Plane& plane, const PlaneModels& models, Limit limit, const std::vector<Uncertain>& uncertain,
                Threads& threads, std::vector<BoundaryPoint>& line) {
    const std::vector<double> variance = margin_variances(plane, models, line, limit, uncertain, threads),
                              by_x = slopes(models, plane.x, &BoundaryPoint::x, line, limit, threads),
                              by_y = slopes(models, plane.y, &BoundaryPoint::y, line, limit, threads);
    for (std::size_t i = 0; i < line.size(); ++i) {
        const double square = by_x[i] * by_x[i] + by_y[i] * by_y[i];
        const double shift = square > 0.0 ? std::sqrt(variance[i]) / square : none;
        line[i].error_x = shift * by_x[i] * (plane.x.to - plane.x.from);
        line[i].error_y = shift * by_y[i] * (plane.y.to - plane.y.from);
    }
}
}  // namespace

std::vector<Margin> margins(const Plane& plane, const std::vector<numerics::PlanePoint>& points, Limit limit,
                            Threads& threads) {
    return margins_at(PlaneModels(plane), points, limit, threads);
}

Boundary trace_boundary(const Plane& plane, Limit limit, const std::vector<Uncertain>& uncertain,
                        const numerics::ContourOptions& options, Threads& threads) {
    const PlaneModels models(plane);
    const numerics::Contour contour =
        numerics::trace_zero([&](const numerics::PlanePoint& point) { return models.margin(point, limit).value; },
                             {.x0 = plane.x.from, .x1 = plane.x.to, .y0 = plane.y.from, .y1 = plane.y.to}, options,
                             threads);
    Boundary result{.singular_points = contour.singular_points,
                    .evaluations = contour.evaluations,
                    .complete = contour.complete};
    for (const numerics::ContourLine& traced : contour.lines) {
        BoundaryLine line{.limit = limit, .closed = traced.closed};
        const std::vector<Margin> at = margins_at(models, traced.points, limit, threads);
        for (std::size_t i = 0; i < at.size(); ++i)
            line.points.push_back({.x = traced.points[i].x, .y = traced.points[i].y, .angle = at[i].angle});
        if (!uncertain.empty()) add_errors(plane, models, limit, uncertain, threads, line.points);
        result.lines.push_back(std::move(line));
    }
    return result;
}

}  // namespace drover::physics
