// theory/boundary.cpp: lines on which a margin vanishes.
#include "theory/boundary.hpp"
#include "base/constants.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace drover::theory {

namespace {
using Points = std::vector<numerics::PlanePoint>;

/// Vertices of a line so that the others lie within `chord` of the polyline through them, which has no longer edge than
/// 1/64 of the plane: near a corner the contour has thousands.
Points thinned(const Points& line, const numerics::Rectangle& plane, double chord) {
    constexpr double longest = 1.0 / 64.0;
    constexpr std::size_t ahead = 256;
    const double width = plane.x1 - plane.x0, height = plane.y1 - plane.y0;
    const auto lies_on = [&](std::size_t first, std::size_t last) {
        const double along_x = (line[last].x - line[first].x) / width,
                     along_y = (line[last].y - line[first].y) / height, length = std::hypot(along_x, along_y);
        if (length > longest) return false;
        for (std::size_t i = first + 1; i < last; ++i) {
            const double x = (line[i].x - line[first].x) / width, y = (line[i].y - line[first].y) / height;
            const double part =
                length > 0.0 ? std::clamp((x * along_x + y * along_y) / (length * length), 0.0, 1.0) : 0.0;
            if (std::hypot(x - part * along_x, y - part * along_y) > chord) return false;
        }
        return true;
    };
    Points kept{line.front()};
    for (std::size_t first = 0; first + 1 < line.size();) {
        std::size_t last = first + 1;
        while (last + 1 < line.size() && last - first < ahead && lies_on(first, last + 1)) ++last;
        kept.push_back(line[last]);
        first = last;
    }
    return kept;
}

/// Fills in the least stable waves.
void add_margins(const MarginOf& margin, const ComputeAll& compute, BoundaryLine& line) {
    constexpr std::size_t width = 5;
    const std::vector<double> found = compute(line.points.size(), width, [&](std::size_t i, std::span<double> numbers) {
        const Margin at = margin({line.points[i].x, line.points[i].y});
        const std::array all{at.value, at.angle, at.q, at.frequency, at.is_uniform ? 1.0 : 0.0};
        std::ranges::copy(all, numbers.begin());
    });
    for (std::size_t i = 0; i < line.points.size(); ++i) {
        const double* at = &found[i * width];
        line.points[i].at = {
            .value = at[0], .angle = at[1], .q = at[2], .frequency = at[3], .is_uniform = at[4] != 0.0};
    }
}
/// Whether the margin diverges at each vertex: it is far larger there than beside the line.
std::vector<bool> are_poles(const numerics::Rectangle& plane, const MarginOf& margin, const ComputeAll& compute,
                            const BoundaryLine& line) {
    constexpr double beside = 1e-4, larger = 100.0;  // beside a pole of first order: 1e9 and more
    const double width = plane.x1 - plane.x0, height = plane.y1 - plane.y0;
    const std::vector<double> found = compute(line.points.size(), 1, [&](std::size_t i, std::span<double> number) {
        const BoundaryPoint &from = line.points[i == 0 ? 0 : i - 1],
                            &to = line.points[std::min(i + 1, line.points.size() - 1)], &at = line.points[i];
        const double x = (to.x - from.x) / width, y = (to.y - from.y) / height,
                     length = std::max(std::hypot(x, y), 1e-300);
        number[0] = nan;
        for (const double side : {beside, -beside}) {
            const numerics::PlanePoint off{at.x - side * width * y / length, at.y + side * height * x / length};
            if (off.x < plane.x0 || off.x > plane.x1 || off.y < plane.y0 || off.y > plane.y1) continue;
            number[0] = std::fmax(number[0], std::abs(margin(off).value));
        }
    });
    std::vector<bool> poles;
    for (std::size_t i = 0; i < found.size(); ++i)
        poles.push_back(std::abs(line.points[i].at.value) > larger * found[i] || std::isinf(line.points[i].at.value));
    return poles;
}

/// The parts of a line between its poles.
std::vector<BoundaryLine> without_poles(BoundaryLine line, const std::vector<bool>& poles) {
    if (std::ranges::find(poles, true) == poles.end()) return {std::move(line)};
    std::vector<BoundaryLine> parts(1);
    for (std::size_t i = 0; i < poles.size(); ++i) {
        if (!poles[i]) parts.back().points.push_back(line.points[i]);
        else if (!parts.back().points.empty()) parts.emplace_back();
    }
    std::erase_if(parts, [](const BoundaryLine& part) { return part.points.size() < 2; });
    return parts;
}
}  // namespace

MarginOf where_valid(MarginOf margin) {
    return [of = std::move(margin)](const numerics::PlanePoint& point) -> Margin {
        try {
            return of(point);
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;  // such as a signal
            return {.value = nan};
        }
    };
}

Boundary trace_boundary(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<MarginOf>& draws,
                        const numerics::ContourOptions& options, const ComputeAll& compute) {
    numerics::ContourOptions fine = options;
    fine.chord = 0.5 * options.chord;
    const numerics::Contour contour =
        numerics::trace_zero([&](const numerics::PlanePoint& point) { return margin(point).value; }, plane, fine,
                             compute);
    Boundary result{.lines = {},
                    .singular_points = contour.singular_points,
                    .stable = contour.positive,
                    .unstable = contour.negative,
                    .evaluations = contour.evaluations,
                    .complete = contour.complete};
    if (!draws.empty()) result.field = draw_field(plane, margin, draws, options.cells, compute);
    for (const numerics::ContourLine& traced : contour.lines) {
        BoundaryLine line{.closed = traced.closed, .points = {}};
        const Points places = thinned(traced.points, plane, fine.chord);
        for (const numerics::PlanePoint& point : places) line.points.push_back({.x = point.x, .y = point.y});
        add_margins(margin, compute, line);
        if (result.field) {
            const std::vector<BandEnds> ends = band_ends(plane, *result.field, draws, places, compute);
            for (std::size_t i = 0; i < ends.size(); ++i) line.points[i].band = ends[i];
        }
        const std::vector<bool> poles = are_poles(plane, margin, compute, line);
        result.poles += static_cast<std::size_t>(std::ranges::count(poles, true));
        std::ranges::move(without_poles(std::move(line), poles), std::back_inserter(result.lines));
    }
    return result;
}

}  // namespace drover::theory
