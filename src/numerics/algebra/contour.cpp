// numerics/algebra/contour.cpp: traces the lines on which a function of the plane changes sign, on a mesh refined about
// them.
#include "numerics/algebra/contour.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "drover/base/error.hpp"
#include "numerics/algebra/bisection_mesh.hpp"
#include "numerics/algebra/bracket.hpp"

namespace drover::numerics {

namespace {

constexpr double straight = 0.9;           // cosine of the turn allowed between neighbouring segments: 26 degrees
constexpr double chord_checked = 0.75;     // of the chord: the line may deviate most beside the middle of a segment
constexpr double bend_checked = 1 / 16.0;  // of the mesh edge: a check at a larger distance may find another line
constexpr double root_error = 1e-12;       // of a vertex along the mesh edge that the line crosses
constexpr double root_seen = 10.0;  // in units of the error of the root: a shorter segment has no reliable direction
constexpr double domain_error = 1.0 / 1024.0;  // a line ends no farther than this from where f is not defined
constexpr double speck = 100.0;                // in units of the finest edge: a smaller island is a singular point

enum class Check : std::uint8_t { due, passed, ragged, bent };  // ragged: f is undefined in part of the triangle

/// The piece of the line in a triangle, the positive side to the left, in the unit square.
struct Segment {
    const MeshEdge *in = nullptr, *out = nullptr;  // null: none
    PlanePoint from, to;
};

/// Triangles with consecutive segments.
struct Chain {
    std::vector<MeshIndex> triangles;
    bool closed = false;
};

struct Tracer {
    const PlaneFunction& f;
    const Rectangle where;
    const ContourOptions options;
    const ComputeAll& compute;
    BisectionMesh mesh;
    std::size_t vertices_known = 0;
    std::vector<Check> checks{};      // of each triangle
    std::vector<Segment> segments{};  // in each triangle
    std::vector<MeshIndex> due{};     // triangles that failed their checks since it was last emptied
    std::size_t evaluations = 0;
};

PlanePoint in_unit_square(const BisectionMesh& mesh, const MeshVertex& vertex) {
    const auto side = static_cast<double>(mesh.side);
    return {static_cast<double>(vertex.i) / side, static_cast<double>(vertex.j) / side};
}

PlanePoint on_edge(const BisectionMesh& mesh, const MeshEdge& edge, double t) {
    const MeshVertex &a = mesh.vertices[edge.end[0]], &b = mesh.vertices[edge.end[1]];
    const auto side =
        static_cast<double>(mesh.side);  // lattice differences are exact: a border edge stays on the border
    return {(static_cast<double>(a.i) + t * static_cast<double>(b.i - a.i)) / side,
            (static_cast<double>(a.j) + t * static_cast<double>(b.j - a.j)) / side};
}

PlanePoint in_rectangle(const Rectangle& where, const PlanePoint& unit) {
    return {std::lerp(where.x0, where.x1, unit.x), std::lerp(where.y0, where.y1, unit.y)};
}

double distance(const PlanePoint& a, const PlanePoint& b) { return std::hypot(b.x - a.x, b.y - a.y); }

double hypotenuse(const Tracer& tracer, MeshIndex triangle) {
    return std::exp2(-0.5 * tracer.mesh.triangles[triangle].level) / tracer.mesh.cells;
}

double value_at(const Tracer& tracer, MeshIndex triangle, std::size_t corner) {
    return tracer.mesh.vertices[tracer.mesh.triangles[triangle].corner[corner % 3]].value;
}

/// Has corners of opposite signs.
bool is_crossed(const Tracer& tracer, MeshIndex triangle) {
    for (std::size_t n = 0; n < 3; ++n)
        if (is_opposite(value_at(tracer, triangle, n), value_at(tracer, triangle, n + 1))) return true;
    return false;
}

MeshEdge& edge_of(Tracer& tracer, MeshIndex triangle, std::size_t n) {
    const auto& corner = tracer.mesh.triangles[triangle].corner;
    return edge_between(tracer.mesh, corner[n % 3], corner[(n + 1) % 3]);
}

/// Evaluates f at the vertices added since the last call.
void evaluate_vertices(Tracer& tracer) {
    auto& vertices = tracer.mesh.vertices;
    const std::size_t known = tracer.vertices_known;
    const std::vector<double> values =
        tracer.compute(vertices.size() - known, 1, [&](std::size_t n, std::span<double> value) {
            value[0] = tracer.f(in_rectangle(tracer.where, in_unit_square(tracer.mesh, vertices[known + n])));
        });
    for (std::size_t n = 0; n < values.size(); ++n) vertices[known + n].value = values[n];
    tracer.evaluations += vertices.size() - known;
    tracer.vertices_known = vertices.size();
}

/// A half of a bisected edge inherits its crossing, where the signs at the ends of the half differ.
void hand_down_crossings(Tracer& tracer) {
    for (const MeshSplit& split : tracer.mesh.splits) {
        const MeshEdge& whole = edge_between(tracer.mesh, split.a, split.b);
        const double t = whole.crossing;
        if (std::isnan(t)) continue;
        const std::size_t side = t <= 0.5 ? 0 : 1;
        MeshEdge& half = edge_between(tracer.mesh, whole.end[side], split.middle);
        const auto& vertices = tracer.mesh.vertices;
        if (!is_opposite(vertices[half.end[0]].value, vertices[half.end[1]].value)) continue;
        half.crossing = side == 0 ? 2.0 * t : 2.0 * (1.0 - t);
        half.searched = true;
    }
    tracer.mesh.splits.clear();
}

/// Finds where the line crosses the edges of the triangles.  Middles of edges must have been evaluated.
void find_crossings(Tracer& tracer, const std::vector<MeshIndex>& triangles) {
    struct Search {
        MeshEdge* edge;
        double middle;
    };
    std::vector<Search> searches;
    for (const MeshIndex triangle : triangles)
        for (std::size_t n = 0; n < 3; ++n) {
            MeshEdge& edge = edge_of(tracer, triangle, n);
            if (edge.searched || !is_opposite(value_at(tracer, triangle, n), value_at(tracer, triangle, n + 1)))
                continue;
            edge.searched = true;
            const MeshIndex middle = middle_between(tracer.mesh, edge.end[0], edge.end[1]);
            searches.push_back({.edge = &edge, .middle = tracer.mesh.vertices[middle].value});
        }
    const BisectionMesh& mesh = tracer.mesh;
    const auto search = [&](std::size_t n, std::span<double> crossing_and_calls) {
        const MeshEdge& edge = *searches[n].edge;
        const MeshVertex &a = mesh.vertices[edge.end[0]], &b = mesh.vertices[edge.end[1]];
        const double length = distance(in_unit_square(mesh, a), in_unit_square(mesh, b));
        const double tolerance = std::max(root_error / length, std::numeric_limits<double>::epsilon());
        const auto along = [&](double t) { return tracer.f(in_rectangle(tracer.where, on_edge(mesh, edge, t))); };
        std::size_t calls = 0;
        crossing_and_calls[0] = sign_change(along, a.value, searches[n].middle, b.value, tolerance, calls);
        crossing_and_calls[1] = static_cast<double>(calls);
    };
    const std::vector<double> found = tracer.compute(searches.size(), 2, search);
    for (std::size_t n = 0; n < searches.size(); ++n) {
        searches[n].edge->crossing = found[2 * n];
        tracer.evaluations += static_cast<std::size_t>(found[2 * n + 1]);
    }
}

/// Empty where a crossing is missing because f is undefined on that edge.
Segment segment_in(Tracer& tracer, MeshIndex triangle) {
    std::size_t odd = 0;  // the corner whose sign differs from the other two
    while (odd < 3 && !(is_opposite(value_at(tracer, triangle, odd), value_at(tracer, triangle, odd + 1)) &&
                        is_opposite(value_at(tracer, triangle, odd), value_at(tracer, triangle, odd + 2))))
        ++odd;
    if (odd == 3) return {};
    const bool is_left = is_positive(value_at(tracer, triangle, odd));
    const MeshEdge& in = edge_of(tracer, triangle, is_left ? odd : odd + 2);
    const MeshEdge& out = edge_of(tracer, triangle, is_left ? odd + 2 : odd);
    if (std::isnan(in.crossing) || std::isnan(out.crossing)) return {};
    return {.in = &in,
            .out = &out,
            .from = on_edge(tracer.mesh, in, in.crossing),
            .to = on_edge(tracer.mesh, out, out.crossing)};
}

/// Check of a crossed triangle by its corners and the middles of its edges.
Check check_middles(Tracer& tracer, MeshIndex triangle) {
    Check check = Check::passed;
    for (std::size_t n = 0; n < 3; ++n) {
        const MeshEdge& edge = edge_of(tracer, triangle, n);
        const double from = tracer.mesh.vertices[edge.end[0]].value, to = tracer.mesh.vertices[edge.end[1]].value;
        const double middle = tracer.mesh.vertices[middle_between(tracer.mesh, edge.end[0], edge.end[1])].value;
        const bool has_crossing = is_opposite(from, to);
        if (std::isnan(from) || std::isnan(middle) || std::isnan(to) || (has_crossing && std::isnan(edge.crossing)))
            return Check::ragged;
        const double expected = has_crossing && edge.crossing < 0.5 ? to : from;
        if (edge.crossing != 0.5 && is_opposite(middle, expected)) check = Check::bent;
    }
    return check;
}

/// Check of a triangle without a crossing; a neighbour may have evaluated the middle of an edge.
Check check_known_middles(const Tracer& tracer, MeshIndex triangle) {
    const auto& corner = tracer.mesh.triangles[triangle].corner;
    Check check = Check::passed;
    for (std::size_t n = 0; n < 3; ++n) {
        if (std::isnan(value_at(tracer, triangle, n))) return Check::passed;
        const MeshIndex middle = known_middle_between(tracer.mesh, corner[n], corner[(n + 1) % 3]);
        if (middle != mesh_none && is_opposite(tracer.mesh.vertices[middle].value, value_at(tracer, triangle, n)))
            check = Check::bent;
    }
    return check;
}

/// The neighbour with the next or the previous segment of the one in a triangle, or mesh_none.
MeshIndex next_of(const Tracer& tracer, MeshIndex triangle) {
    const MeshIndex next = triangle_across(*tracer.segments[triangle].out, triangle);
    return next != mesh_none && tracer.segments[next].in ? next : mesh_none;
}

MeshIndex previous_of(const Tracer& tracer, MeshIndex triangle) {
    const MeshIndex previous = triangle_across(*tracer.segments[triangle].in, triangle);
    return previous != mesh_none && tracer.segments[previous].in ? previous : mesh_none;
}

bool has_direction(const Tracer& tracer, MeshIndex triangle) {
    const Segment& segment = tracer.segments[triangle];
    return segment.in && distance(segment.from, segment.to) > root_seen * root_error;
}

/// Points near the middle of a segment, to its left and right, in the unit square.
std::array<PlanePoint, 2> beside(const Tracer& tracer, MeshIndex triangle) {
    const Segment& segment = tracer.segments[triangle];
    const double off = std::min(chord_checked * tracer.options.chord, bend_checked * hypotenuse(tracer, triangle));
    const double length = distance(segment.from, segment.to);
    const double x = (segment.to.x - segment.from.x) / length, y = (segment.to.y - segment.from.y) / length;
    const PlanePoint middle{std::midpoint(segment.from.x, segment.to.x), std::midpoint(segment.from.y, segment.to.y)};
    return {{{middle.x - off * y, middle.y + off * x}, {middle.x + off * y, middle.y - off * x}}};
}

/// Checks that the line passes between points on the two sides of its segments.
void check_sides(Tracer& tracer, const std::vector<MeshIndex>& triangles) {
    const auto check = [&](std::size_t n, std::span<double> bent_and_calls) {
        bent_and_calls[0] = bent_and_calls[1] = 0.0;
        if (tracer.checks[triangles[n]] != Check::passed || !has_direction(tracer, triangles[n])) return;
        const auto points = beside(tracer, triangles[n]);
        for (const std::size_t side : {0u, 1u}) {
            const PlanePoint& point = points[side];
            if (std::min(point.x, point.y) < 0.0 || std::max(point.x, point.y) > 1.0) continue;
            bent_and_calls[1] += 1.0;
            if (is_opposite(tracer.f(in_rectangle(tracer.where, point)), side == 0 ? 1.0 : -1.0))
                bent_and_calls[0] = 1.0;
        }
    };
    const std::vector<double> found = tracer.compute(triangles.size(), 2, check);
    for (std::size_t n = 0; n < triangles.size(); ++n) {
        if (found[2 * n] != 0.0) tracer.checks[triangles[n]] = Check::bent;
        tracer.evaluations += static_cast<std::size_t>(found[2 * n + 1]);
    }
}

/// Checks the turn to the next segment that has a direction; triangles at a sharp turn are marked bent.
void check_turn(Tracer& tracer, MeshIndex first) {
    if (!has_direction(tracer, first)) return;
    const Segment& before = tracer.segments[first];
    MeshIndex last = next_of(tracer, first);
    while (last != mesh_none && last != first && !has_direction(tracer, last)) last = next_of(tracer, last);
    if (last == mesh_none || last == first) return;
    const Segment& after = tracer.segments[last];
    const double turn = ((after.to.x - after.from.x) * (before.to.x - before.from.x) +
                         (after.to.y - after.from.y) * (before.to.y - before.from.y)) /
                        (distance(after.from, after.to) * distance(before.from, before.to));
    if (turn >= straight) return;
    for (MeshIndex at = first;; at = next_of(tracer, at)) {
        tracer.checks[at] = Check::bent;
        tracer.due.push_back(at);
        if (at == last) return;
    }
}

/// Checks the turns at both ends of a segment.
void check_turns(Tracer& tracer, MeshIndex triangle) {
    check_turn(tracer, triangle);
    MeshIndex before = previous_of(tracer, triangle);
    while (before != mesh_none && before != triangle && !has_direction(tracer, before))
        before = previous_of(tracer, before);
    if (before != mesh_none) check_turn(tracer, before);
}

/// Keeps those of the triangles due that may still be bisected.
void keep_divisible(Tracer& tracer) {
    const auto is_done = [&](MeshIndex triangle) {
        const double size = hypotenuse(tracer, triangle);
        if (tracer.checks[triangle] == Check::ragged) return size <= domain_error;
        const auto is_zero = [&](std::size_t n) { return value_at(tracer, triangle, n) == 0.0; };
        return size < 2.0 * finest_edge || (is_zero(0) && is_zero(1) && is_zero(2));
    };
    tracer.due.erase(std::remove_if(tracer.due.begin(), tracer.due.end(), is_done), tracer.due.end());
}

void refine(Tracer& tracer) {
    std::vector<int> levels;
    for (const MeshIndex triangle : tracer.due) levels.push_back(tracer.mesh.triangles[triangle].level);
    for (std::size_t n = 0; n < levels.size(); ++n)
        if (tracer.mesh.triangles[tracer.due[n]].level == levels[n]) bisect(tracer.mesh, tracer.due[n]);
    tracer.due.clear();
}

/// Updates values, crossings, segments and checks for the present mesh.
void look(Tracer& tracer) {
    evaluate_vertices(tracer);
    hand_down_crossings(tracer);
    tracer.checks.resize(tracer.mesh.triangles.size());
    tracer.segments.resize(tracer.mesh.triangles.size());
    for (const MeshIndex triangle : tracer.mesh.changed) tracer.checks[triangle] = Check::due;
    std::vector<MeshIndex> fresh, uncrossed;
    for (const MeshIndex triangle : tracer.mesh.changed) {
        if (tracer.checks[triangle] != Check::due) continue;
        tracer.checks[triangle] = Check::passed;
        tracer.segments[triangle] = {};
        (is_crossed(tracer, triangle) ? fresh : uncrossed).push_back(triangle);
    }
    tracer.mesh.changed.clear();
    for (const MeshIndex triangle : fresh)
        for (std::size_t n = 0; n < 3; ++n) {
            const MeshEdge& edge = edge_of(tracer, triangle, n);
            middle_between(tracer.mesh, edge.end[0], edge.end[1]);
        }
    evaluate_vertices(tracer);
    find_crossings(tracer, fresh);
    for (const MeshIndex triangle : fresh) {
        tracer.segments[triangle] = segment_in(tracer, triangle);
        tracer.checks[triangle] = check_middles(tracer, triangle);
    }
    check_sides(tracer, fresh);
    for (const MeshIndex triangle : uncrossed) {
        tracer.checks[triangle] = check_known_middles(tracer, triangle);
        if (tracer.checks[triangle] != Check::passed) tracer.due.push_back(triangle);
    }
    for (const MeshIndex triangle : fresh) {
        if (tracer.checks[triangle] != Check::passed) tracer.due.push_back(triangle);
        if (tracer.segments[triangle].in) check_turns(tracer, triangle);
    }
}

/// Lines as chains of segments, open ones first.
std::vector<Chain> chains_of(const Tracer& tracer) {
    std::vector<Chain> chains;
    std::vector<bool> taken(tracer.segments.size());
    for (const bool closed : {false, true})
        for (MeshIndex first = 0; first < taken.size(); ++first) {
            if (!tracer.segments[first].in || taken[first]) continue;
            if (!closed && previous_of(tracer, first) != mesh_none) continue;
            Chain chain{.closed = closed};
            for (MeshIndex at = first; at != mesh_none && !taken[at]; at = next_of(tracer, at)) {
                taken[at] = true;
                chain.triangles.push_back(at);
            }
            chains.push_back(std::move(chain));
        }
    return chains;
}

/// The distinct points of a chain, in the rectangle; the ends of an open chain are kept.
ContourLine line_along(const Tracer& tracer, const Chain& chain) {
    const double apart = root_seen * root_error;
    std::vector<PlanePoint> points{tracer.segments[chain.triangles.front()].from};
    for (const MeshIndex triangle : chain.triangles)
        if (distance(points.back(), tracer.segments[triangle].to) > apart)
            points.push_back(tracer.segments[triangle].to);
    if (chain.closed)
        while (points.size() > 1 && distance(points.front(), points.back()) <= apart) points.pop_back();
    else if (points.size() > 1) points.back() = tracer.segments[chain.triangles.back()].to;
    for (PlanePoint& point : points) point = in_rectangle(tracer.where, point);
    return {.points = std::move(points), .closed = chain.closed};
}

/// Closed and small: an islet found by chance, or the remainder of a tongue too thin for the mesh.
bool is_speck(const Tracer& tracer, const Chain& chain) {
    const PlanePoint& first = tracer.segments[chain.triangles.front()].from;
    const auto is_near = [&](MeshIndex triangle) {
        return distance(tracer.segments[triangle].from, first) < speck * finest_edge;
    };
    return chain.closed && std::ranges::all_of(chain.triangles, is_near);
}

/// Adds to `found` the points of a chain, all or only where it is still bent, that are not near an earlier one.
void add_sharp(const Tracer& tracer, const Chain& chain, bool whole, std::vector<PlanePoint>& found) {
    for (const MeshIndex triangle : chain.triangles) {
        const PlanePoint& from = tracer.segments[triangle].from;
        const auto is_near = [&](const PlanePoint& other) { return distance(other, from) <= tracer.options.chord; };
        if ((whole || tracer.checks[triangle] == Check::bent) && std::ranges::none_of(found, is_near))
            found.push_back(from);
    }
}

void check_input(const Rectangle& where, const ContourOptions& options) {
    const bool is_finite = std::isfinite(where.x1 - where.x0) && std::isfinite(where.y1 - where.y0);
    require(is_finite && where.x0 < where.x1 && where.y0 < where.y1, {},
            "a rectangle from {} to {} by {} to {}; expected finite sides above 0", where.x0, where.x1, where.y0,
            where.y1);
    require(options.cells >= 1 && options.cells <= 2048, {}, "cells = {}; expected 1 to 2048", options.cells);
    require(options.chord > 0.0 && options.chord < 1.0, {}, "chord = {}; expected above 0 and below 1", options.chord);
}

}  // namespace

Contour trace_zero(const PlaneFunction& f, const Rectangle& where, const ContourOptions& options,
                   const ComputeAll& compute) {
    check_input(where, options);
    Tracer tracer{.f = f,
                  .where = where,
                  .options = options,
                  .compute = compute,
                  .mesh = bisection_mesh(options.cells, finest_edge)};
    Contour result;
    evaluate_vertices(tracer);
    const auto share = [&vertices = tracer.mesh.vertices](auto is_one) {
        return static_cast<double>(std::ranges::count_if(vertices, is_one, &MeshVertex::value)) /
               static_cast<double>(vertices.size());
    };
    result.positive = share([](double value) { return value >= 0.0; });
    result.negative = share([](double value) { return value < 0.0; });
    for (;;) {
        look(tracer);
        keep_divisible(tracer);
        result.complete = tracer.due.empty();
        if (tracer.due.empty() || tracer.evaluations >= options.evaluations) break;
        refine(tracer);
    }
    for (const Chain& chain : chains_of(tracer)) {
        ContourLine line = line_along(tracer, chain);
        if (line.points.size() < (chain.closed ? 3 : 2)) continue;
        add_sharp(tracer, chain, is_speck(tracer, chain), result.singular_points);
        if (!is_speck(tracer, chain)) result.lines.push_back(std::move(line));
    }
    for (PlanePoint& point : result.singular_points) point = in_rectangle(where, point);
    result.evaluations = tracer.evaluations;
    return result;
}

}  // namespace drover::numerics
