// dem/packing/packing.cpp: the bodies that a setup asks for, and the area of its cell; random initial positions: rods
// without overlaps, beads outside rods, then relaxation of overlaps.
#include "dem/packing/packing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "dem/bodies/walls.hpp"
#include "dem/packing/overlap_relaxation.hpp"
#include "drover/base/random.hpp"

namespace drover::dem {

namespace {
using std::numbers::pi;

/// Diameter of the largest sphere of a shape [mm].
double thickness(const Shape& shape) { return 2.0 * *std::ranges::max_element(shape.radius); }

/// `count` if it is above 0, or else the number of bodies that have the area fraction.
std::int64_t count_of(int count, double area_fraction, double area_cell, double area_body) {
    if (count > 0) return count;
    return static_cast<std::int64_t>(std::round(area_fraction * area_cell / area_body));
}

/// Whole numbers that sum to `count` in these proportions, by largest remainders.
std::vector<std::int64_t> apportioned(std::int64_t count, const std::vector<double>& proportions) {
    const double sum = std::accumulate(proportions.begin(), proportions.end(), 0.0);
    std::vector<std::int64_t> result;
    std::vector<double> remainder;
    std::int64_t left = count;
    for (const double part : proportions) {
        const double share = static_cast<double>(count) * part / sum;
        result.push_back(static_cast<std::int64_t>(std::floor(share)));
        remainder.push_back(share - std::floor(share));
        left -= result.back();
    }
    for (; left > 0; --left) {
        const auto largest = std::ranges::max_element(remainder);
        ++result[static_cast<std::size_t>(largest - remainder.begin())];
        *largest = -1.0;
    }
    return result;
}

void add_beads(const BeadSupply& supply, double area_cell, const Locate& locate, Bodies& bodies) {
    const std::int64_t count = count_of(supply.count, supply.area_fraction, area_cell, mean_area(supply));
    const std::vector<std::int64_t> counts = apportioned(count, supply.proportions);
    std::vector<double> known;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        if (counts[i] == 0) continue;
        const auto same = std::ranges::find(known, supply.diameters[i]);
        const auto shape = static_cast<std::uint32_t>(same - known.begin());
        if (same == known.end()) {
            known.push_back(supply.diameters[i]);
            bodies.shapes.push_back(make_ball(supply.diameters[i], supply.density, locate("beads.diameters")));
        }
        bodies.beads.insert(bodies.beads.end(), static_cast<std::size_t>(counts[i]), Bead{.shape = shape});
    }
}

void add_rods(const RodSupply& supply, double area_cell, std::uint64_t seed, const Locate& locate, Bodies& bodies) {
    const Shape standard = rod_shape(supply, 1.0, locate);
    const auto count =
        static_cast<std::size_t>(count_of(supply.count, supply.area_fraction, area_cell, standard.projected_area));
    if (count == 0) return;
    const auto first = static_cast<std::uint32_t>(bodies.shapes.size());
    bodies.rods.assign(count, Rod{.shape = first});
    if (supply.size_tolerance == 0.0) {
        bodies.shapes.push_back(standard);
        return;
    }
    std::vector<double> size(count);
    fill_normal({.seed = seed, .stream = Stream::packing}, 0, 1, size);
    for (std::size_t i = 0; i < count; ++i) {
        const double scale = 1.0 + supply.size_tolerance * size[i];
        require(scale > 0.0, locate("rods.size_tolerance"),
                "rods.size_tolerance = {} makes a rod {} times its size; expected less", supply.size_tolerance, scale);
        bodies.shapes.push_back(rod_shape(supply, scale, locate));
        bodies.rods[i].shape = first + static_cast<std::uint32_t>(i);
    }
}

/// A sequence of uniform random numbers in (0, 1).
class Draws {
public:
    Draws(std::uint64_t seed, std::uint32_t substep)
        : key_{.seed = seed, .stream = Stream::packing, .substep = substep} {}
    double operator()() {
        if (at_ == held_.size()) {
            fill_uniform(key_, first_, 1, held_);
            first_ += held_.size();
            at_ = 0;
        }
        return held_[at_++];
    }
    double between(double low, double high) { return low + (high - low) * (*this)(); }

private:
    RandomKey key_;
    std::uint64_t first_ = 0;
    std::array<double, 256> held_{};
    std::size_t at_ = 256;
};
enum : std::uint32_t { draws_of_rods = 1, draws_of_beads = 2 };  // 0: the sizes of rods

/// The range of the spheres of a body.
struct Span {
    std::size_t first = 0, last = 0;
};

/// The rods placed so far.
struct Placed {
    Bins bins;
    std::vector<std::uint32_t> sphere;  ///< by number in the bins
};

Placed no_rods(const OverlapRelaxation& relaxation) {
    double largest = 0.0;
    for (const double radius : relaxation.radius) largest = std::max(largest, radius);
    return {.bins = Bins(relaxation.cell, 2.0 * (1.0 + relaxation.margin) * std::max(largest, 1e-3))};
}

Vector place_in(const OverlapRelaxation& relaxation, double reach, Draws& draws) {
    const double x = half_width(relaxation.cell), y = half_height(relaxation.cell);
    const double px = draws.between(-x, x), py = draws.between(-y, y);
    return {px, py, draws.between(relaxation.floor + reach, relaxation.ceiling - reach)};
}

bool is_inside(const OverlapRelaxation& relaxation, const Span& spheres) {
    WallPoint found[4];
    for (std::size_t s = spheres.first; s < spheres.last; ++s)
        if (relaxation.walls.near(relaxation.centre[s].x, relaxation.centre[s].y, relaxation.reach[s], found) > 0)
            return false;
    return true;
}

/// Whether a rod overlaps its own images.
bool meets_itself(const OverlapRelaxation& relaxation, const Span& spheres) {
    const NearestImage apart(relaxation.cell);
    for (std::size_t a = spheres.first; a < spheres.last; ++a)
        for (std::size_t b = spheres.first; b < a; ++b) {
            const Vector straight = relaxation.centre[b] - relaxation.centre[a],
                         d = apart(relaxation.centre[a], relaxation.centre[b]);
            const bool over_edge = d.x != straight.x || d.y != straight.y;
            if (over_edge && length(d) < relaxation.reach[a] + relaxation.reach[b]) return true;
        }
    return false;
}

bool meets(const OverlapRelaxation& relaxation, const Span& spheres, const Placed& placed) {
    const NearestImage apart(relaxation.cell);
    bool met = false;
    for (std::size_t a = spheres.first; a < spheres.last && !met; ++a)
        placed.bins.for_near(relaxation.centre[a], [&](std::uint32_t n) {
            const std::uint32_t b = placed.sphere[n];
            const Vector d = apart(relaxation.centre[a], relaxation.centre[b]);
            const double reach = relaxation.reach[a] + relaxation.reach[b];
            met = met || dot(d, d) < reach * reach;
        });
    return met;
}

void move_rod(OverlapRelaxation& relaxation, std::size_t rod, const Span& spheres, const Vector& to) {
    const std::size_t body = relaxation.position.size() - relaxation.axis.size() + rod;
    relaxation.position[body] = to;
    for (std::size_t s = spheres.first; s < spheres.last; ++s)
        relaxation.centre[s] = to + relaxation.size * relaxation.at[s] * relaxation.axis[rod];
}

/// Finds a free position for a rod.  The direction is drawn first and only positions are drawn again, so that crowding
/// does not bias directions.  Further directions are tried only if the first fits nowhere, such as across a narrow
/// cell.
bool place_rod(OverlapRelaxation& relaxation, std::size_t rod, const Span& spheres, const Placed& placed,
               Draws& draws) {
    constexpr int directions = 50, places = 2000;
    const double reach = *std::max_element(relaxation.reach.begin() + static_cast<std::ptrdiff_t>(spheres.first),
                                           relaxation.reach.begin() + static_cast<std::ptrdiff_t>(spheres.last));
    for (int d = 0; d < directions; ++d) {
        const double angle = relaxation.turns ? 2.0 * pi * draws() : 0.0;
        relaxation.axis[rod] = relaxation.turns ? Vector{std::cos(angle), std::sin(angle), 0.0} : Vector{1.0, 0.0, 0.0};
        move_rod(relaxation, rod, spheres, {});
        if (meets_itself(relaxation, spheres)) continue;
        for (int n = 0; n < places; ++n) {
            move_rod(relaxation, rod, spheres, place_in(relaxation, reach, draws));
            if (is_inside(relaxation, spheres) && !meets(relaxation, spheres, placed)) return true;
        }
    }
    return false;
}

/// Places all rods, scaled by relaxation.size; false if one fits nowhere.
bool place_rods(OverlapRelaxation& relaxation, Draws& draws, Placed& placed) {
    const std::size_t beads = relaxation.position.size() - relaxation.axis.size();
    set_spheres(relaxation);
    std::size_t sphere = beads;
    for (std::size_t rod = 0; rod < relaxation.axis.size(); ++rod) {
        Span spheres{.first = sphere, .last = sphere};
        while (spheres.last < relaxation.body.size() && relaxation.body[spheres.last] == beads + rod) ++spheres.last;
        sphere = spheres.last;
        if (!place_rod(relaxation, rod, spheres, placed, draws)) return false;
        for (std::size_t s = spheres.first; s < spheres.last; ++s) {
            placed.bins.add(relaxation.centre[s]);
            placed.sphere.push_back(static_cast<std::uint32_t>(s));
        }
    }
    return true;
}

/// Beads may overlap each other, but no centre lies inside a rod, from where it could leave through the other side.
void place_beads(OverlapRelaxation& relaxation, const Placed& placed, Draws& draws, const Locate& locate) {
    constexpr int places = 10000;
    const NearestImage apart(relaxation.cell);
    for (std::size_t bead = 0; bead < relaxation.position.size() - relaxation.axis.size(); ++bead) {
        int inside = 0, n = 0;
        for (bool free = false; n < places && !free; ++n) {
            relaxation.centre[bead] = relaxation.position[bead] = place_in(relaxation, relaxation.reach[bead], draws);
            if (!is_inside(relaxation, {bead, bead + 1})) continue;
            ++inside;
            free = true;
            placed.bins.for_near(relaxation.centre[bead], [&](std::uint32_t k) {
                const Vector d = apart(relaxation.centre[bead], relaxation.centre[placed.sphere[k]]);
                const double reach = relaxation.reach[placed.sphere[k]];
                free = free && dot(d, d) > reach * reach;
            });
        }
        require(
            inside > 0, locate("beads.diameters"),
            "beads.diameters holds {} mm, and the cell is nowhere wide enough for such a bead; expected a smaller one",
            2.0 * relaxation.radius[bead]);
    }
}

/// Places all bodies.  Rods too dense for random sequential placement start smaller.
void place_all(const Setup& setup, const Bodies& bodies, std::uint64_t seed, OverlapRelaxation& relaxation,
               const Locate& locate) {
    constexpr double easy = 0.2, min_size = 0.05;  // area fraction of rods, and size
    double area_of_rods = 0.0;
    for (const Rod& rod : bodies.rods) area_of_rods += bodies.shapes[rod.shape].projected_area;
    relaxation.size = std::min(1.0, std::sqrt(easy * area(setup.cell) / std::max(area_of_rods, 1e-300)));
    Draws draws(seed, draws_of_rods), draws_beads(seed, draws_of_beads);
    Placed placed = no_rods(relaxation);
    for (; !place_rods(relaxation, draws, placed); relaxation.size *= 0.9) {
        require(relaxation.size > min_size, locate("rods.length"),
                "rods.length = {} mm, which do not fit the cell; expected shorter or fewer rods", setup.rods.length);
        placed = no_rods(relaxation);
    }
    place_beads(relaxation, placed, draws_beads, locate);
}

/// Grows rods to their full size in small steps.
void grow(OverlapRelaxation& relaxation) {
    constexpr double by = 1.03, shallow = 0.02;
    constexpr int steps = 300;
    while (relaxation.size < 1.0) {
        relax_overlaps(relaxation, shallow, steps);
        relaxation.size = std::min(1.0, by * relaxation.size);
    }
}

/// Sets the range of heights at t = 0.
void set_heights(const Setup& setup, double thickest, OverlapRelaxation& relaxation) {
    relaxation.floor = 2.0 * setup.plates.amplitude;
    // Without a lid: somewhat more than one layer; high bodies fall.
    relaxation.ceiling =
        relaxation.floor + (setup.plates.lid ? setup.plates.gap : std::max(setup.plates.gap, 1.5 * thickest));
}

/// At most a quarter of the play of the thickest body in the gap.
double margin_of(const Setup& setup, double thickest, double max_margin) {
    return setup.plates.lid && thickest > 0.0 ? std::min(max_margin, 0.25 * (setup.plates.gap / thickest - 1.0))
                                              : max_margin;
}

constexpr int steps_of_round = 500;

/// Relaxes overlaps in rounds; returns the largest overlap after each.  Stops when none is left, when it no longer
/// decreases, or after a number of rounds that takes about a minute at 70,000 beads.
std::vector<double> resolve(OverlapRelaxation& relaxation) {
    constexpr double sphere_steps = 8e8;
    constexpr std::size_t back = 4, min_rounds = 6, max_rounds = 40;
    const double rounds = sphere_steps / steps_of_round / static_cast<double>(relaxation.body.size());
    const std::size_t last = std::clamp(static_cast<std::size_t>(rounds), min_rounds, max_rounds);
    std::vector<double> overlaps;
    while (overlaps.size() < last) {
        relax_overlaps(relaxation, 0.8 * relaxation.margin, steps_of_round);
        overlaps.push_back(largest_overlap(relaxation));
        const std::size_t n = overlaps.size();
        if (overlaps.back() <= 0.0 || (n > back && overlaps.back() > 0.9 * overlaps[n - 1 - back])) break;
    }
    return overlaps;
}

/// Spreads bodies apart by a larger margin.  If all nearly touch, the first stroke of the plates makes one impact of
/// hundreds of contacts.
void loosen(OverlapRelaxation& relaxation, double margin) {
    if (margin <= relaxation.margin) return;
    const OverlapRelaxation before = relaxation;
    set_margin(relaxation, margin);
    relax_overlaps(relaxation, 0.2 * margin, steps_of_round);
    if (largest_overlap(relaxation) > 0.0) relaxation = before;
}

void write_back(const OverlapRelaxation& relaxation, Bodies& bodies) {
    const NearestImage apart(relaxation.cell);
    for (std::size_t i = 0; i < bodies.beads.size(); ++i) bodies.beads[i].position = apart({}, relaxation.position[i]);
    for (std::size_t i = 0; i < bodies.rods.size(); ++i) {
        bodies.rods[i].position = apart({}, relaxation.position[bodies.beads.size() + i]);
        bodies.rods[i].axis = relaxation.axis[i];
    }
}
}  // namespace

Shape rod_shape(const RodSupply& rods, double scale, const Locate& locate) {
    std::vector<double> diameters = rods.diameters;
    for (double& diameter : diameters) diameter *= scale;
    if (rods.densities.size() == 1)
        return make_rod(diameters, scale * rods.length, rods.densities.front(), locate("rods.length"));
    require(rods.densities.size() == diameters.size(), locate("rods.densities"),
            "rods.densities has {} numbers beside {} of rods.diameters; expected one, or one for each sphere",
            rods.densities.size(), diameters.size());
    const Shape even = make_rod(diameters, scale * rods.length, 1.0, locate("rods.length"));
    std::vector<AxisSphere> spheres;
    for (std::size_t i = 0; i < diameters.size(); ++i)
        spheres.push_back({.at = even.at[i], .radius = even.radius[i], .density = rods.densities[i]});
    return make_shape(std::move(spheres), locate("rods.densities"));
}

double mean_area(const BeadSupply& beads) {
    double areas = 0.0, weights = 0.0;
    for (std::size_t i = 0; i < beads.diameters.size(); ++i) {
        areas += beads.proportions[i] * pi / 4.0 * beads.diameters[i] * beads.diameters[i];
        weights += beads.proportions[i];
    }
    return areas / weights;
}

Bodies make_bodies(const Setup& setup, std::uint64_t seed, const Locate& locate) {
    Bodies bodies;
    const double area_cell = area(setup.cell);
    if (setup.beads.any()) add_beads(setup.beads, area_cell, locate, bodies);
    if (setup.rods.any()) add_rods(setup.rods, area_cell, seed, locate, bodies);
    if (!setup.plates.lid) return bodies;
    for (const Shape& shape : bodies.shapes)
        require(
            thickness(shape) < setup.plates.gap, locate("plates.gap"),
            "plates.gap = {} mm with a body {:.6g} mm thick; expected a gap that every body fits, those made larger by "
            "rods.size_tolerance = {} too",
            setup.plates.gap, thickness(shape), setup.rods.size_tolerance);
    return bodies;
}

std::vector<Shape> shapes_of(const Setup& setup, const Locate& locate) {
    std::vector<Shape> shapes;
    if (setup.beads.any())
        for (const double diameter : setup.beads.diameters)
            shapes.push_back(make_ball(diameter, setup.beads.density, locate("beads.diameters")));
    if (setup.rods.any()) shapes.push_back(rod_shape(setup.rods, 1.0, locate));
    return shapes;
}

double area(const Cell& cell) {
    if (cell.shape == CellShape::circle) return pi * cell.radius * cell.radius;
    if (cell.shape != CellShape::flower) return cell.lx * cell.ly;
    const Flower flower = make_flower(cell);
    const double segment = flower.arc_radius * flower.arc_radius * flower.half_angle -
                           flower.half_chord * (flower.chord_at - flower.arc_at);
    return cell.petals * (flower.half_chord * flower.chord_at + segment);
}

Bodies pack(const Setup& setup, std::uint64_t seed, const Locate& locate) {
    check(setup, locate);
    require(setup.packing.kind != PackingKind::file, locate("packing.kind"),
            "packing.kind = \"file\": a packing cannot be made from a file; expected "
            "\"random\" or \"aligned\" here");
    Bodies bodies = make_bodies(setup, seed, locate);
    if (bodies.beads.empty() && bodies.rods.empty()) return bodies;
    double thickest = 0.0;
    for (const Shape& shape : bodies.shapes) thickest = std::max(thickest, thickness(shape));
    OverlapRelaxation relaxation = make_relaxation(setup, bodies, margin_of(setup, thickest, 2e-3));
    set_heights(setup, thickest, relaxation);
    place_all(setup, bodies, seed, relaxation, locate);
    grow(relaxation);
    const std::vector<double> overlaps = resolve(relaxation);
    if (overlaps.back() > 0.0)
        fail_run(
            "no packing without overlaps was found for {} beads and {} rods: after {} rounds of {} steps two still "
            "overlap by {:.3g} of a radius; expected 0: ask for fewer, or give them a larger gap",
            bodies.beads.size(), bodies.rods.size(), overlaps.size(), steps_of_round, overlaps.back());
    loosen(relaxation, margin_of(setup, thickest, 0.04));
    write_back(relaxation, bodies);
    return bodies;
}

}  // namespace drover::dem
