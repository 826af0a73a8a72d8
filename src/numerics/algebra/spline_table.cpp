// numerics/algebra/spline_table.cpp: bicubic Hermite patches over a mesh.
#include "numerics/algebra/spline_table.hpp"

#include <gsl/gsl_interp.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
void check_axis(const std::string& name, const std::vector<double>& axis) {
    require(!axis.empty(), {}, "the {} axis of a table is empty; expected at least one number", name);
    for (std::size_t i = 0; i < axis.size(); ++i)
        require(std::isfinite(axis[i]) && (i == 0 || axis[i] > axis[i - 1]), {},
                "the {} axis of a table: number {} is {}; expected finite, ascending numbers", name, i + 1, axis[i]);
}

/// Derivatives at the nodes of the natural cubic spline through them.
std::vector<double> node_slopes(const std::vector<double>& x, const std::vector<double>& y) {
    if (x.size() == 1) return {0.0};
    const gsl_interp_type* kind = x.size() == 2 ? gsl_interp_linear : gsl_interp_cspline;
    const std::unique_ptr<gsl_interp, void (*)(gsl_interp*)> curve(gsl_interp_alloc(kind, x.size()), gsl_interp_free);
    gsl_interp_init(curve.get(), x.data(), y.data(), x.size());
    return mapped(x,
                  [&](double place) { return gsl_interp_eval_deriv(curve.get(), x.data(), y.data(), place, nullptr); });
}

/// The cell of an axis that contains a point, the position within it, and its length (0 for an axis of one node).
struct Cell {
    std::size_t first = 0;
    double part = 0.0, length = 0.0;
    bool inside = true;
};

Cell cell_of(const std::vector<double>& axis, double place) {
    if (axis.size() == 1) return {};
    const bool inside = place >= axis.front() && place <= axis.back();
    const double held = std::clamp(place, axis.front(), axis.back());
    const auto above = std::upper_bound(axis.begin() + 1, axis.end() - 1, held);
    const auto first = static_cast<std::size_t>(above - axis.begin()) - 1;
    const double length = axis[first + 1] - axis[first];
    return {.first = first, .part = (held - axis[first]) / length, .length = length, .inside = inside};
}

/// Weights of (value, slope) at both ends of a cell, for the value and the slope at a point.
struct Hermite {
    std::array<double, 2> value, slope, value_rate, slope_rate;
};

Hermite hermite(const Cell& cell) {
    const double s = cell.part, h = cell.length;
    if (h == 0.0) return {.value = {1, 0}, .slope = {0, 0}, .value_rate = {0, 0}, .slope_rate = {0, 0}};
    const double rise = s * s * (3.0 - 2.0 * s), rise_rate = 6.0 * s * (1.0 - s) / h;
    return {.value = {1.0 - rise, rise},
            .slope = {h * s * (1.0 - s) * (1.0 - s), -h * s * s * (1.0 - s)},
            .value_rate = {-rise_rate, rise_rate},
            .slope_rate = {(1.0 - s) * (1.0 - 3.0 * s), s * (3.0 * s - 2.0)}};
}

/// Weights of the nodes of one axis in the value at a point.
std::vector<double> node_weights(const std::vector<double>& axis, double place) {
    const Cell cell = cell_of(axis, place);
    const Hermite h = hermite(cell);
    std::vector<double> weights(axis.size(), 0.0), one(axis.size(), 0.0);
    for (std::size_t i = 0; i < axis.size(); ++i) {
        one[i] = 1.0;
        const std::vector<double> slopes = node_slopes(axis, one);
        for (std::size_t end = 0; end < (cell.length == 0.0 ? 1u : 2u); ++end)
            weights[i] += h.value[end] * one[cell.first + end] + h.slope[end] * slopes[cell.first + end];
        one[i] = 0.0;
    }
    return weights;
}
}  // namespace

SplineTable::SplineTable(std::vector<double> first, std::vector<double> second, std::vector<double> values,
                         Outside outside, std::vector<double> errors)
    : first_(std::move(first)), second_(std::move(second)), errors_(std::move(errors)), outside_(outside) {
    check_axis("first", first_);
    check_axis("second", second_);
    const std::size_t rows = first_.size(), width = second_.size();
    require(values.size() == rows * width, {}, "a table of {} by {} nodes has {} values; expected {}", rows, width,
            values.size(), rows * width);
    for (const double value : values)
        require(std::isfinite(value), {}, "a table contains {}; expected finite numbers", value);
    require(errors_.empty() || errors_.size() == values.size(), {}, "a table of {} values has {} errors; expected {}",
            values.size(), errors_.size(), values.size());
    for (const double error : errors_)
        require(error >= 0.0 && std::isfinite(error), {}, "a table contains the error {}; expected finite numbers >= 0",
                error);
    nodes_ = mapped(values, [](double value) { return Node{.value = value}; });
    /// Along an axis: of the nodes from `begin`, `stride` apart.
    const auto set_slopes = [&](const std::vector<double>& axis, std::size_t begin, std::size_t stride,
                                double Node::*value, double Node::*slope) {
        std::vector<double> y;
        for (std::size_t k = 0; k < axis.size(); ++k) y.push_back(nodes_[begin + k * stride].*value);
        const std::vector<double> slopes = node_slopes(axis, y);
        for (std::size_t k = 0; k < axis.size(); ++k) nodes_[begin + k * stride].*slope = slopes[k];
    };
    for (std::size_t k = 0; k < width; ++k) set_slopes(first_, k, width, &Node::value, &Node::by_first);
    for (std::size_t i = 0; i < rows; ++i) {
        set_slopes(second_, i * width, 1, &Node::value, &Node::by_second);
        set_slopes(second_, i * width, 1, &Node::by_first, &Node::by_both);
    }
}

TableValue SplineTable::at(double at_first, double at_second) const {
    const Cell one = cell_of(first_, at_first), two = cell_of(second_, at_second);
    if ((!one.inside || !two.inside) && outside_ == Outside::refuse) return {nan, nan, nan};
    const Hermite f = hermite(one), g = hermite(two);
    TableValue sum;
    for (std::size_t i = 0; i < (one.length == 0.0 ? 1u : 2u); ++i)
        for (std::size_t k = 0; k < (two.length == 0.0 ? 1u : 2u); ++k) {
            const Node& node = nodes_[(one.first + i) * second_.size() + two.first + k];
            const double along_value = node.value * g.value[k] + node.by_second * g.slope[k],
                         along_slope = node.by_first * g.value[k] + node.by_both * g.slope[k];
            sum.value += f.value[i] * along_value + f.slope[i] * along_slope;
            sum.by_first += f.value_rate[i] * along_value + f.slope_rate[i] * along_slope;
            sum.by_second += f.value[i] * (node.value * g.value_rate[k] + node.by_second * g.slope_rate[k]) +
                             f.slope[i] * (node.by_first * g.value_rate[k] + node.by_both * g.slope_rate[k]);
        }
    if (!one.inside) sum.by_first = 0.0;
    if (!two.inside) sum.by_second = 0.0;
    return sum;
}

double SplineTable::standard_error(double at_first, double at_second) const {
    if (errors_.empty()) return 0.0;
    if (outside_ == Outside::refuse && (!cell_of(first_, at_first).inside || !cell_of(second_, at_second).inside))
        return nan;
    const std::vector<double> one = node_weights(first_, at_first), two = node_weights(second_, at_second);
    double variance = 0.0;
    for (std::size_t i = 0; i < one.size(); ++i)
        for (std::size_t k = 0; k < two.size(); ++k) {
            const double part = one[i] * two[k] * errors_[i * two.size() + k];
            variance += part * part;
        }
    return std::sqrt(variance);
}

}  // namespace drover::numerics
