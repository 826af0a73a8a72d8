// physics/predictions.cpp: structure factors and number fluctuations of a run by linear theory.
#include "drover/physics/predictions.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "drover/numerics/shells.hpp"

namespace drover::physics {

namespace {
using std::numbers::pi;

/// Directions of the mean order in a run and their shares of its samples; p and -p are equivalent, since S(q) is the
/// same for both.
struct Direction {
    double angle = 0.0, share = 0.0;
};
std::vector<Direction> directions(const std::vector<Eigen::Vector2d>& orders) {
    constexpr int bins = 16;  // of 11 degrees, each represented by its mean
    std::array<Eigen::Vector2d, bins> sums;
    std::array<int, bins> counts{};
    sums.fill(Eigen::Vector2d::Zero());
    for (const Eigen::Vector2d& order : orders) {
        double angle = std::atan2(order.y(), order.x());
        if (angle < 0.0) angle += pi;
        if (angle >= pi) angle -= pi;
        const auto bin = static_cast<std::size_t>(angle / pi * bins) % bins;
        sums[bin] += Eigen::Vector2d(std::cos(angle), std::sin(angle));
        ++counts[bin];
    }
    std::vector<Direction> result;
    for (std::size_t bin = 0; bin < bins; ++bin)
        if (counts[bin] > 0)
            result.push_back({.angle = std::atan2(sums[bin].y(), sums[bin].x()),
                              .share = counts[bin] / static_cast<double>(orders.size())});
    return result;
}

std::vector<StructureFactor> flock_modes(const Equations& equations, const StationaryState& flock,
                                         const numerics::Grid& grid, int degree,
                                         const std::vector<Eigen::Vector2d>& orders, Threads& threads) {
    const auto about = [&](double angle) {
        UniformPoint point = flock.point;
        if (flock.free_direction) {
            const Eigen::Rotation2D<double> turn(angle - direction_of(point));
            point.order = turn * point.order;
            point.velocity = turn * point.velocity;
        }
        return structure_factors(equations, point, grid, degree, threads);
    };
    if (!flock.free_direction) return about(0.0);
    std::vector<StructureFactor> sum(numerics::modes(grid));
    for (const Direction& direction : directions(orders)) {
        const std::vector<StructureFactor> part = about(direction.angle);
        for (std::size_t m = 0; m < sum.size(); ++m) add_scaled(part[m], direction.share, sum[m]);
    }
    return sum;
}
}  // namespace

const StationaryState* nearest_state(const StationaryStates& found, const std::vector<Eigen::Vector2d>& orders) {
    double size = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& one : orders) {
        size += one.norm() / static_cast<double>(orders.size());
        mean += one / static_cast<double>(orders.size());
    }
    const bool is_fixed = std::none_of(found.states.begin(), found.states.end(),
                                       [](const auto& state) { return state.point.order.norm() == 0.0; });
    const auto distance = [&](const StationaryState& state) {
        return is_fixed ? (state.point.order - mean).norm() : std::abs(state.point.order.norm() - size);
    };
    const StationaryState* nearest = nullptr;
    for (const StationaryState& state : found.states)
        if (!nearest || distance(state) < distance(*nearest)) nearest = &state;
    return nearest;
}

PredictedStructure predicted_structure(const Equations& equations, const numerics::Grid& grid,
                                       const Dealiasing& dealiasing, const std::vector<Eigen::Vector2d>& orders,
                                       Threads& threads) {
    PredictedStructure result;
    const numerics::System system = linear_system(equations, grid, reference(equations.model.uniform), dealiasing);
    if (!system.noise) {
        result.no_prediction = "without noise the stationary state of the linear theory is uniform";
        return result;
    }
    if (const std::string name = nonuniform_term(equations); !name.empty()) {
        result.no_prediction = name + " depends on position or time: there is no uniform state";
        return result;
    }
    const StationaryStates states = stationary_states(equations);
    const StationaryState* state = nearest_state(states, orders);
    if (state == nullptr) {
        result.no_prediction = "there is no uniform stationary state: " + states.no_order;
        return result;
    }
    const std::string about = text("the state \"{}\", |p| = {:.4g} and |v| = {:.4g} mm/s", state->name,
                                   state->point.order.norm(), state->point.velocity.norm());
    // Else all directions of q are computed.
    const bool isotropic = is_isotropic(state->point) && terms_beyond_propagator(equations).empty();
    try {
        result.modes = isotropic
                           ? structure_factors(system, equations.form)
                           : flock_modes(equations, *state, grid, kept_degree(equations, dealiasing), orders, threads);
        result.about = about;
        result.about_flock = state->point.order.norm() > 0.0;
    } catch (const Error& error) {
        std::string remedy = "; see drover stability";
        if (isotropic) {
            const FastestGrowth growth = fastest_growth(system);
            remedy = text(" (fastest rate {:.3g} /s at |q| = {:.3g} /mm)", growth.rate, growth.q);
        }
        result.no_prediction = text("the linear theory about {} has {}{}", about, error.what(), remedy);
    }
    return result;
}

PredictedBoxes predicted_boxes(const numerics::Grid& grid, const std::vector<double>& structure_factor,
                               const std::vector<int>& sides, int along_x, int along_y) {
    std::vector<double> power = structure_factor;
    for (double& value : power) value /= numerics::area(grid);
    PredictedBoxes boxes;
    std::vector<double> areas;
    for (const int side : sides) {
        const numerics::BoxCells box = numerics::box_cells(grid, side, along_x, along_y);
        boxes.variance.push_back(numerics::box_variance(grid, power, box.x, box.y));
        areas.push_back(static_cast<double>(box.x) * box.y);
    }
    for (std::size_t b = 0; b < sides.size(); ++b) {
        boxes.deviation.push_back(std::sqrt(boxes.variance[b]));
        boxes.exponent.push_back(b + 1 < sides.size() ? 0.5 * std::log(boxes.variance[b + 1] / boxes.variance[b]) /
                                                            std::log(areas[b + 1] / areas[b])
                                                      : std::numeric_limits<double>::quiet_NaN());
    }
    return boxes;
}

}  // namespace drover::physics
