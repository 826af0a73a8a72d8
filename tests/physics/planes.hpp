// tests/physics/planes.hpp: lines and margins of planes of rods and beads.
#pragma once
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "base/draws.hpp"
#include "physics/rod_bead_model.hpp"
#include "theory/limits.hpp"
#include "uniform_points.hpp"

namespace drover::physics {

using theory::Boundary;
using theory::BoundaryLine;
using theory::BoundaryPoint;
using theory::Limit;
using theory::Margin;

/// One axis of a plane of models.
struct PlaneAxis {
    std::string name, unit = "1";
    double from = 0.0, to = 1.0;
    std::function<void(Model&, double)> set;
    bool is_density = false;  ///< changes only the uniform densities; the compiled coefficients remain valid
};
struct Plane {
    Model model;
    PlaneAxis x, y;
};

/// A parameter with a standard error; errors of different parameters are independent.
struct Uncertain {
    double error = 0.0;
    std::function<void(Model&, double)> add;
};

inline std::vector<Uncertain> table_errors(const Model& model) {
    std::vector<Uncertain> result;
    for (const auto& [key, column] : model.table.columns)
        for (std::size_t i = 0; i < column.errors.size(); ++i)
            result.push_back({.error = column.errors[i], .add = [key = key, i](Model& m, double change) {
                                  m.table.columns.at(key).values[i] += change;
                              }});
    return result;
}

inline void draw_errors(const std::vector<Uncertain>& uncertain, std::vector<Model>& models) {
    for (std::size_t n = 0; n < uncertain.size(); ++n) {
        const std::vector<double> draws = normal_draws(random_ranks(n, 0, models.size()));
        for (std::size_t k = 0; k < models.size(); ++k) uncertain[n].add(models[k], draws[k] * uncertain[n].error);
    }
}

/// The margins of one limit over a plane; where both axes are densities, of one compiled model.
inline theory::MarginOf margin_over(const Plane& plane, Limit limit) {
    Model middle = plane.model;
    plane.x.set(middle, 0.5 * (plane.x.from + plane.x.to));
    plane.y.set(middle, 0.5 * (plane.y.from + plane.y.to));
    middle.uniform = plane.model.uniform;
    const auto base = std::make_shared<const Equations>(middle);
    return [plane, limit, base](const numerics::PlanePoint& point) -> Margin {
        Model model = plane.model;
        plane.x.set(model, point.x);
        plane.y.set(model, point.y);
        const model::UniformState means =
            values_of(*base, {.bead_density = model.uniform.bead_density, .rod_density = model.uniform.rod_density});
        if (plane.x.is_density && plane.y.is_density) return theory::PointMargins(base->theory(), means, {}).at(limit);
        if (!base->theory().rates(means).allFinite()) return {.value = std::numeric_limits<double>::quiet_NaN()};
        try {
            return theory::PointMargins(Equations(model, *base).theory(), means, {}).at(limit);
        } catch (const Error& error) {
            fail_input({}, "at {} = {}, {} = {}: {}", plane.x.name, point.x, plane.y.name, point.y, error.what());
        }
    };
}

inline Boundary trace_boundary(const Plane& plane, Limit limit, const std::vector<Model>& draws,
                               const numerics::ContourOptions& options, const ComputeAll& compute) {
    std::vector<theory::MarginOf> others;
    for (const Model& one : draws) {
        Plane changed = plane;
        changed.model = one;
        others.push_back(theory::where_valid(margin_over(changed, limit)));
    }
    return theory::trace_boundary({.x0 = plane.x.from, .x1 = plane.x.to, .y0 = plane.y.from, .y1 = plane.y.to},
                                  margin_over(plane, limit), others, options, compute);
}

inline std::vector<Margin> margins(const Plane& plane, const std::vector<numerics::PlanePoint>& points, Limit limit) {
    const theory::MarginOf over = margin_over(plane, limit);
    std::vector<Margin> result;
    for (const numerics::PlanePoint& point : points) result.push_back(over(point));
    return result;
}

}  // namespace drover::physics
