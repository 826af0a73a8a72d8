// tests/numerics/curves.hpp: parametric curves, and the distances between them and a traced line in both directions.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include "numerics/algebra/contour.hpp"

namespace drover::numerics {

inline double distance(const PlanePoint& a, const PlanePoint& b) { return std::hypot(b.x - a.x, b.y - a.y); }

inline double distance_to_piece(const PlanePoint& p, const PlanePoint& a, const PlanePoint& b) {
    const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
    const double along = square > 0.0 ? ((p.x - a.x) * dx + (p.y - a.y) * dy) / square : 0.0;
    const double t = std::clamp(along, 0.0, 1.0);
    return distance(p, {a.x + t * dx, a.y + t * dy});
}

inline double distance_to_lines(const PlanePoint& p, const Contour& contour) {
    double least = std::numeric_limits<double>::infinity();
    for (const ContourLine& line : contour.lines)
        for (std::size_t n = line.closed ? 0 : 1; n < line.points.size(); ++n)
            least = std::min(least, distance_to_piece(p, line.points[n == 0 ? line.points.size() - 1 : n - 1],
                                                      line.points[n]));
    return least;
}

/// A rotated and shifted frame for a curve, so that no part of it is aligned with the lattice.
struct Frame {
    double x = 0.0, y = 0.0, angle = 0.0;
    PlanePoint inward(const PlanePoint& p) const {
        const double c = std::cos(angle), s = std::sin(angle);
        return {c * (p.x - x) + s * (p.y - y), -s * (p.x - x) + c * (p.y - y)};
    }
    PlanePoint outward(const PlanePoint& p) const {
        const double c = std::cos(angle), s = std::sin(angle);
        return {x + c * p.x - s * p.y, y + s * p.x + c * p.y};
    }
};

/// A curve by its parameter, and samples of it.
struct Curve {
    std::function<PlanePoint(double)> at;
    std::vector<double> parameters;
    std::vector<PlanePoint> samples;
};

inline Curve curve(const std::function<PlanePoint(double)>& at, double from, double to, int count = 3000) {
    Curve result{.at = at};
    for (int n = 0; n <= count; ++n) result.parameters.push_back(from + (to - from) * n / count);
    for (const double t : result.parameters) result.samples.push_back(at(t));
    return result;
}

/// From the nearest sample by golden section between its neighbours.
inline double distance_to_curve(const PlanePoint& p, const Curve& curve) {
    std::size_t nearest = 0;
    for (std::size_t n = 1; n < curve.samples.size(); ++n)
        if (distance(p, curve.samples[n]) < distance(p, curve.samples[nearest])) nearest = n;
    double a = curve.parameters[nearest == 0 ? 0 : nearest - 1];
    double b = curve.parameters[std::min(nearest + 1, curve.parameters.size() - 1)];
    const double ratio = std::numbers::phi - 1.0;
    while (std::abs(b - a) > 1e-14) {
        const double lower = b - ratio * (b - a), upper = a + ratio * (b - a);
        if (distance(p, curve.at(lower)) < distance(p, curve.at(upper))) b = upper;
        else a = lower;
        if (lower >= upper) break;
    }
    return distance(p, curve.at(0.5 * (a + b)));
}

inline double distance_to_curves(const PlanePoint& p, const std::vector<Curve>& curves) {
    double least = std::numeric_limits<double>::infinity();
    for (const Curve& one : curves) least = std::min(least, distance_to_curve(p, one));
    return least;
}

struct Misses {
    double vertices = 0.0, pieces = 0.0, covering = 0.0;
    double turn = 0.0;  // between two pieces [rad]
};

/// Farthest distances of the vertices and of the middles and quarters of the pieces from the curves, and of the samples
/// of the curves from the pieces, and the sharpest turn, where `counts` says so.
template <class Counts>
Misses misses(const Contour& contour, const std::vector<Curve>& curves, const Counts& counts) {
    Misses worst;
    for (const ContourLine& line : contour.lines)
        for (std::size_t n = 0; n < line.points.size(); ++n) {
            const PlanePoint& a = line.points[n];
            if (counts(a)) worst.vertices = std::max(worst.vertices, distance_to_curves(a, curves));
            if (!line.closed && n + 1 == line.points.size()) continue;
            const PlanePoint& b = line.points[(n + 1) % line.points.size()];
            if (line.closed || n + 2 < line.points.size()) {
                const PlanePoint& c = line.points[(n + 2) % line.points.size()];
                const double turn = std::remainder(std::atan2(c.y - b.y, c.x - b.x) - std::atan2(b.y - a.y, b.x - a.x),
                                                   2.0 * std::numbers::pi);
                if (counts(b)) worst.turn = std::max(worst.turn, std::abs(turn));
            }
            for (const double part : {0.25, 0.5, 0.75}) {
                const PlanePoint p{std::lerp(a.x, b.x, part), std::lerp(a.y, b.y, part)};
                if (counts(p)) worst.pieces = std::max(worst.pieces, distance_to_curves(p, curves));
            }
        }
    for (const Curve& one : curves)
        for (const PlanePoint& p : one.samples)
            if (counts(p)) worst.covering = std::max(worst.covering, distance_to_lines(p, contour));
    return worst;
}

}  // namespace drover::numerics
