// dem/bodies/walls.cpp: distances to the side walls.
#include "dem/bodies/walls.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace drover::dem {

Flower make_flower(const Cell& cell) {
    Flower flower{.half_turn = std::numbers::pi / cell.petals, .arc_radius = cell.petal_radius};
    flower.half_chord = cell.radius * std::sin(flower.half_turn);
    flower.chord_at = cell.radius * std::cos(flower.half_turn);
    const double square = cell.petal_radius * cell.petal_radius - flower.half_chord * flower.half_chord;
    flower.arc_at = flower.chord_at - std::sqrt(std::max(0.0, square));
    flower.half_angle = std::asin(std::min(1.0, flower.half_chord / cell.petal_radius));
    flower.cosine = std::cos(flower.half_angle);
    flower.sine = std::sin(flower.half_angle);
    for (int k = 0; k < cell.petals; ++k) {
        const double middle = 2.0 * flower.half_turn * k, corner = middle + flower.half_turn;
        flower.middle.push_back({std::cos(middle), std::sin(middle)});
        flower.corner.push_back({cell.radius * std::cos(corner), cell.radius * std::sin(corner)});
    }
    return flower;
}

namespace {
using std::numbers::pi;

/// The nearest points found so far, nearest first.
struct Nearest {
    WallPoint (&found)[4];
    double reach = 0.0;
    int count = 0;

    void add(const WallPoint& point) {
        if (point.distance > reach) return;
        // The common end point of two arcs that join smoothly counts once.
        constexpr double same = 1e-9;
        for (int i = 0; i < count; ++i)
            if (std::abs(found[i].nx - point.nx) < same && std::abs(found[i].ny - point.ny) < same &&
                std::abs(found[i].distance - point.distance) < same * reach)
                return;
        int at = count < 4 ? count++ : 4;
        for (; at > 0 && found[at - 1].distance > point.distance; --at)
            if (at < 4) found[at] = found[at - 1];
        if (at < 4) found[at] = point;
    }
};

void add_rectangle(const Cell& cell, double x, double y, Nearest& nearest) {
    nearest.add({.distance = 0.5 * cell.lx - x, .nx = -1.0, .ny = 0.0});
    nearest.add({.distance = 0.5 * cell.lx + x, .nx = 1.0, .ny = 0.0});
    nearest.add({.distance = 0.5 * cell.ly - y, .nx = 0.0, .ny = -1.0});
    nearest.add({.distance = 0.5 * cell.ly + y, .nx = 0.0, .ny = 1.0});
}

void add_circle(const Cell& cell, double x, double y, Nearest& nearest) {
    const double from_centre = std::hypot(x, y);
    if (from_centre == 0.0) return nearest.add({.distance = cell.radius, .nx = -1.0, .ny = 0.0});
    nearest.add({.distance = cell.radius - from_centre, .nx = -x / from_centre, .ny = -y / from_centre});
}

/// A position in the frame of one petal: from the centre of its arc, x along its middle line.
struct FromArc {
    double c = 1.0, s = 0.0;  ///< direction of the middle line
    double along = 0.0, across = 0.0;

    double distance() const { return std::sqrt(along * along + across * across); }
};

/// Index of a petal, modulo their number.
std::size_t index_of(const Flower& flower, int petal) {
    const int petals = static_cast<int>(flower.middle.size());
    return static_cast<std::size_t>((petal % petals + petals) % petals);
}

FromArc from_arc(const Flower& flower, int petal, double x, double y) {
    const auto [c, s] = flower.middle[index_of(flower, petal)];
    return {.c = c, .s = s, .along = c * x + s * y - flower.arc_at, .across = c * y - s * x};
}

/// Whether the nearest point of an arc's circle belongs to the arc.
bool faces(const Flower& flower, const FromArc& place) { return place.along >= flower.cosine * place.distance(); }

/// Adds the arc if the position faces it.
void add_arc(const Flower& flower, const FromArc& place, Nearest& nearest) {
    if (!faces(flower, place)) return;
    const double from_centre = place.distance();
    const double ux = from_centre > 0.0 ? place.along / from_centre : 1.0;
    const double uy = from_centre > 0.0 ? place.across / from_centre : 0.0;
    nearest.add({.distance = flower.arc_radius - from_centre,
                 .nx = -(place.c * ux - place.s * uy),
                 .ny = -(place.s * ux + place.c * uy)});
}

/// Adds the corner after a petal; sign: 1 for a position inside the cell, -1 outside.
void add_corner(const Flower& flower, int petal, double x, double y, double sign, Nearest& nearest) {
    const auto& corner = flower.corner[index_of(flower, petal)];
    const double dx = x - corner[0], dy = y - corner[1], distance = std::sqrt(dx * dx + dy * dy);
    if (distance == 0.0) return;  // the arcs give the contact
    nearest.add({.distance = sign * distance, .nx = sign * dx / distance, .ny = sign * dy / distance});
}

/// Whether the distance increases from the corner after a petal along both arcs that end there.
bool faces_corner(const Flower& flower, const FromArc& before, const FromArc& after) {
    const double c = flower.cosine, s = flower.sine;
    return c * before.across - s * before.along > 0.0 && c * after.across + s * after.along < 0.0;
}

/// Contacts are the local minima of the distance along the outline.
void add_flower(const Cell& cell, const Flower& flower, double x, double y, Nearest& nearest) {
    const double clear = std::min(cell.radius, flower.arc_at + flower.arc_radius) - nearest.reach;
    if (clear > 0.0 && x * x + y * y < clear * clear) return;
    const int petal = static_cast<int>(std::lround(std::atan2(y, x) / (2.0 * flower.half_turn)));
    // Outside: in the sector of a petal that is beyond its arc, or, where petals are flat, beyond a corner.
    const FromArc own = from_arc(flower, petal, x, y);
    const bool facing = faces(flower, own), beyond = own.distance() > flower.arc_radius;
    if (facing && beyond) return add_arc(flower, own, nearest);
    if (!facing && beyond && flower.arc_at < 0.0)
        return add_corner(flower, own.across > 0.0 ? petal : petal - 1, x, y, -1.0, nearest);
    // Points nearer than half a chord belong to this petal or to an adjacent one.
    const bool all = cell.petals <= 3 || nearest.reach >= flower.half_chord;
    const int first = all ? petal - cell.petals / 2 : petal - 1, last = all ? first + cell.petals - 1 : petal + 1;
    for (int k = first; k <= last; ++k) {
        const FromArc here = from_arc(flower, k, x, y), next = from_arc(flower, k + 1, x, y);
        // A position beyond the arc of another petal does not face that arc.
        if (here.distance() <= flower.arc_radius) add_arc(flower, here, nearest);
        if ((all || k < last) && faces_corner(flower, here, next)) add_corner(flower, k, x, y, 1.0, nearest);
    }
}

/// Extent of a flower in a direction from its origin.
double reach_of_flower(const Cell& cell, double direction) {
    const Flower flower = make_flower(cell);
    double reach = 0.0;
    for (int k = 0; k < cell.petals; ++k) {
        const double away = std::remainder(direction - 2.0 * flower.half_turn * k, 2.0 * pi);
        reach = std::max(reach, cell.radius * std::cos(away - flower.half_turn));
        if (std::abs(away) <= flower.half_angle)
            reach = std::max(reach, flower.arc_at * std::cos(away) + flower.arc_radius);
    }
    return reach;
}

/// Half the extent of a cell of this side along two opposite directions.
double half_size(const Cell& cell, double side, double forwards, double backwards) {
    if (cell.shape == CellShape::circle) return cell.radius;
    if (cell.shape != CellShape::flower) return 0.5 * side;
    return std::max(reach_of_flower(cell, forwards), reach_of_flower(cell, backwards));
}
}  // namespace

Walls::Walls(const Cell& cell) : cell_(cell) {
    if (cell.shape == CellShape::flower) flower_ = make_flower(cell);
}

int Walls::near(double x, double y, double radius, WallPoint (&found)[4]) const {
    Nearest nearest{.found = found, .reach = radius};
    if (cell_.shape == CellShape::rectangle) add_rectangle(cell_, x, y, nearest);
    if (cell_.shape == CellShape::circle) add_circle(cell_, x, y, nearest);
    if (cell_.shape == CellShape::flower) add_flower(cell_, flower_, x, y, nearest);
    return nearest.count;
}

double half_width(const Cell& cell) { return half_size(cell, cell.lx, 0.0, pi); }

double half_height(const Cell& cell) { return half_size(cell, cell.ly, 0.5 * pi, -0.5 * pi); }

}  // namespace drover::dem
