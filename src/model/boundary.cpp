// model/boundary.cpp: lines on which a margin vanishes, and their errors.
#include "drover/model/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drover::model {

namespace {
using Points = std::vector<BoundaryPoint>;

/// Margins at points of a line, each of the wave that decides there: by how much it differs elsewhere does not matter
/// to first order.
std::vector<double> margins_along(const MarginOf& margin, const Points& line, const ComputeAll& compute) {
    return compute(line.size(), 1, [&](std::size_t i, std::span<double> value) {
        value[0] = margin({line[i].x, line[i].y}, &line[i].at).value;
    });
}

/// d(margin)/d(axis scaled to 1) at each point, by central differences; one-sided at the edge of the plane.
std::vector<double> slopes(const MarginOf& margin, double from, double to, double BoundaryPoint::*place,
                           const Points& line, const ComputeAll& compute) {
    constexpr double part = 1e-6;  // small beside the way to where another mode takes over; rounding 1e-12/part
    const double step = part * (to - from);
    const auto moved = [&](double sign) {
        Points result = line;
        for (BoundaryPoint& point : result)
            point.*place = std::clamp(point.*place + sign * step, std::min(from, to), std::max(from, to));
        return result;
    };
    const Points low = moved(-1.0), high = moved(1.0);
    const std::vector<double> at_low = margins_along(margin, low, compute),
                              at_high = margins_along(margin, high, compute);
    std::vector<double> result;
    for (std::size_t i = 0; i < line.size(); ++i)
        result.push_back((at_high[i] - at_low[i]) / ((high[i].*place - low[i].*place) / (to - from)));
    return result;
}

/// Variance of the margin at each point, the uncertain numbers being independent.
std::vector<double> margin_variances(const Points& line, const std::vector<UncertainMargin>& uncertain,
                                     const ComputeAll& compute) {
    constexpr double part =
        1e-3;  // of a standard error: the slope, on one side of a kink where another mode takes over
    std::vector<double> variances(line.size());
    for (const UncertainMargin& one : uncertain) {
        const std::vector<double> low = margins_along(one(-part), line, compute),
                                  high = margins_along(one(part), line, compute);
        for (std::size_t i = 0; i < line.size(); ++i) {
            const double slope = (high[i] - low[i]) / (2.0 * part);
            variances[i] += slope * slope;
        }
    }
    return variances;
}

/// Fills in where the line would run if the uncertain numbers were off by their errors: margin + slope . shift = 0.
void add_errors(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<UncertainMargin>& uncertain,
                const ComputeAll& compute, Points& line) {
    const std::vector<double> variance = margin_variances(line, uncertain, compute),
                              by_x = slopes(margin, plane.x0, plane.x1, &BoundaryPoint::x, line, compute),
                              by_y = slopes(margin, plane.y0, plane.y1, &BoundaryPoint::y, line, compute);
    for (std::size_t i = 0; i < line.size(); ++i) {
        const double square = by_x[i] * by_x[i] + by_y[i] * by_y[i];
        const double shift = square > 0.0 ? std::sqrt(variance[i]) / square : std::numeric_limits<double>::quiet_NaN();
        line[i].error_x = shift * by_x[i] * (plane.x1 - plane.x0);
        line[i].error_y = shift * by_y[i] * (plane.y1 - plane.y0);
    }
}
}  // namespace

Boundary trace_boundary(const numerics::Rectangle& plane, const MarginOf& margin,
                        const std::vector<UncertainMargin>& uncertain, const numerics::ContourOptions& options,
                        const ComputeAll& compute) {
    const numerics::Contour contour =
        numerics::trace_zero([&](const numerics::PlanePoint& point) { return margin(point, nullptr).value; }, plane,
                             options, compute);
    Boundary result{.lines = {},
                    .singular_points = contour.singular_points,
                    .evaluations = contour.evaluations,
                    .complete = contour.complete};
    for (const numerics::ContourLine& traced : contour.lines) {
        BoundaryLine line{.closed = traced.closed, .points = Points(traced.points.size())};
        constexpr std::size_t width = 5;
        const std::vector<double> found =
            compute(line.points.size(), width, [&](std::size_t i, std::span<double> numbers) {
                const Margin at = margin(traced.points[i], nullptr);
                numbers[0] = at.value, numbers[1] = at.angle, numbers[2] = at.q, numbers[3] = at.frequency;
                numbers[4] = at.is_uniform ? 1.0 : 0.0;
            });
        for (std::size_t i = 0; i < line.points.size(); ++i) {
            const double* at = &found[i * width];
            line.points[i] = {
                .x = traced.points[i].x,
                .y = traced.points[i].y,
                .at = {.value = at[0], .angle = at[1], .q = at[2], .frequency = at[3], .is_uniform = at[4] != 0.0}};
        }
        if (!uncertain.empty()) add_errors(plane, margin, uncertain, compute, line.points);
        result.lines.push_back(std::move(line));
    }
    return result;
}

}  // namespace drover::model
