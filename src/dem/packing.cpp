// dem/packing.cpp: random places without overlaps: rods side by side, beads anywhere, and then pushed apart.
#include "drover/dem/packing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "dem/crowd.hpp"
#include "dem/supply.hpp"
#include "drover/base/random.hpp"
#include "drover/dem/wall.hpp"

namespace drover::dem {

namespace {
using std::numbers::pi;

/// Uniform numbers in (0, 1), one after the other.
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

/// The spheres of a body in the lists of a crowd.
struct Span {
    std::size_t first = 0, last = 0;
};

/// Rods that have their places, for those that come next.
struct Placed {
    Bins bins;
    std::vector<std::uint32_t> sphere;  ///< of each number of the bins
};

Placed no_rods(const Crowd& crowd) {
    double largest = 0.0;
    for (const double radius : crowd.radius) largest = std::max(largest, radius);
    return {.bins = Bins(crowd.cell, 2.0 * (1.0 + crowd.margin) * std::max(largest, 1e-3)), .sphere = {}};
}

Vector place_in(const Crowd& crowd, double reach, Draws& draws) {
    const double x = half_width(crowd.cell), y = half_height(crowd.cell);
    const double px = draws.between(-x, x), py = draws.between(-y, y);
    return {px, py, draws.between(crowd.floor + reach, crowd.ceiling - reach)};
}

bool is_inside(const Crowd& crowd, const Span& spheres) {
    WallPoint found[4];
    for (std::size_t s = spheres.first; s < spheres.last; ++s)
        if (walls_near(crowd.cell, crowd.centre[s].x, crowd.centre[s].y, crowd.reach[s], found) > 0) return false;
    return true;
}

/// Whether a rod as it lies meets its own images.
bool meets_itself(const Crowd& crowd, const Span& spheres) {
    const NearestImage apart(crowd.cell);
    for (std::size_t a = spheres.first; a < spheres.last; ++a)
        for (std::size_t b = spheres.first; b < a; ++b) {
            const Vector straight = crowd.centre[b] - crowd.centre[a], d = apart(crowd.centre[a], crowd.centre[b]);
            const bool over_edge = d.x != straight.x || d.y != straight.y;
            if (over_edge && length(d) < crowd.reach[a] + crowd.reach[b]) return true;
        }
    return false;
}

bool meets(const Crowd& crowd, const Span& spheres, const Placed& placed) {
    const NearestImage apart(crowd.cell);
    bool met = false;
    for (std::size_t a = spheres.first; a < spheres.last && !met; ++a)
        placed.bins.for_near(crowd.centre[a], [&](std::uint32_t n) {
            const std::uint32_t b = placed.sphere[n];
            const Vector d = apart(crowd.centre[a], crowd.centre[b]);
            const double reach = crowd.reach[a] + crowd.reach[b];
            met = met || dot(d, d) < reach * reach;
        });
    return met;
}

void move_rod(Crowd& crowd, std::size_t rod, const Span& spheres, const Vector& to) {
    const std::size_t body = crowd.place.size() - crowd.axis.size() + rod;
    crowd.place[body] = to;
    for (std::size_t s = spheres.first; s < spheres.last; ++s)
        crowd.centre[s] = to + crowd.size * crowd.at[s] * crowd.axis[rod];
}

/// A free place for a rod.  Its direction is drawn once and only places are tried again: what is hard to place then has no say in
/// the directions.  A further direction is for cells where the first has no place at all, such as across a narrow one.
bool place_rod(Crowd& crowd, std::size_t rod, const Span& spheres, const Placed& placed, Draws& draws) {
    constexpr int directions = 50, places = 2000;
    const double reach = *std::max_element(crowd.reach.begin() + static_cast<std::ptrdiff_t>(spheres.first),
                                           crowd.reach.begin() + static_cast<std::ptrdiff_t>(spheres.last));
    for (int d = 0; d < directions; ++d) {
        const double angle = crowd.turns ? 2.0 * pi * draws() : 0.0;
        crowd.axis[rod] = crowd.turns ? Vector{std::cos(angle), std::sin(angle), 0.0} : Vector{1.0, 0.0, 0.0};
        move_rod(crowd, rod, spheres, {});
        if (meets_itself(crowd, spheres)) continue;
        for (int n = 0; n < places; ++n) {
            move_rod(crowd, rod, spheres, place_in(crowd, reach, draws));
            if (is_inside(crowd, spheres) && !meets(crowd, spheres, placed)) return true;
        }
    }
    return false;
}

/// All rods, at the size that crowd.size says; false when one found no place.
bool place_rods(Crowd& crowd, Draws& draws, Placed& placed) {
    const std::size_t beads = crowd.place.size() - crowd.axis.size();
    set_spheres(crowd);
    std::size_t sphere = beads;
    for (std::size_t rod = 0; rod < crowd.axis.size(); ++rod) {
        Span spheres{.first = sphere, .last = sphere};
        while (spheres.last < crowd.body.size() && crowd.body[spheres.last] == beads + rod) ++spheres.last;
        sphere = spheres.last;
        if (!place_rod(crowd, rod, spheres, placed, draws)) return false;
        for (std::size_t s = spheres.first; s < spheres.last; ++s) {
            placed.bins.add(crowd.centre[s]);
            placed.sphere.push_back(static_cast<std::uint32_t>(s));
        }
    }
    return true;
}

/// Beads overlap each other here, but no centre lies in a rod: from there the way out could be through its other side.
void place_beads(Crowd& crowd, const Placed& placed, Draws& draws, const LocationOf& place) {
    constexpr int places = 10000;
    const NearestImage apart(crowd.cell);
    for (std::size_t bead = 0; bead < crowd.place.size() - crowd.axis.size(); ++bead) {
        int inside = 0, n = 0;
        for (bool free = false; n < places && !free; ++n) {
            crowd.centre[bead] = crowd.place[bead] = place_in(crowd, crowd.reach[bead], draws);
            if (!is_inside(crowd, {bead, bead + 1})) continue;
            ++inside;
            free = true;
            placed.bins.for_near(crowd.centre[bead], [&](std::uint32_t k) {
                const Vector d = apart(crowd.centre[bead], crowd.centre[placed.sphere[k]]);
                const double reach = crowd.reach[placed.sphere[k]];
                free = free && dot(d, d) > reach * reach;
            });
        }
        require(inside > 0, place("beads.diameters"),
                "beads.diameters holds {} mm, and no place of the cell is wide enough for such a bead; expected less",
                2.0 * crowd.radius[bead]);
    }
}

double area_of_rods(const Bodies& bodies) {
    double sum = 0.0;
    for (const Rod& rod : bodies.rods) sum += bodies.shapes[rod.shape].projected_area;
    return sum;
}

/// Places for all.  Where rods lie too densely to be dropped one after the other they begin smaller.
void place_all(const Setup& setup, const Bodies& bodies, std::uint64_t seed, Crowd& crowd, const LocationOf& place) {
    constexpr double easy = 0.2, least = 0.05;  // area fraction of rods, and size
    crowd.size = std::min(1.0, std::sqrt(easy * area(setup.cell) / std::max(area_of_rods(bodies), 1e-300)));
    Draws draws(seed, draws_of_rods), draws_beads(seed, draws_of_beads);
    Placed placed = no_rods(crowd);
    for (; !place_rods(crowd, draws, placed); crowd.size *= 0.9) {
        require(crowd.size > least, place("rods.length"),
                "rods.length = {} mm, and the cell has no room for such rods; expected shorter or fewer ones",
                setup.rods.length);
        placed = no_rods(crowd);
    }
    place_beads(crowd, placed, draws_beads, place);
}

/// Grows rods to their size in steps that leave no overlap to speak of.
void grow(Crowd& crowd) {
    constexpr double by = 1.03, shallow = 0.02;
    constexpr int steps = 300;
    while (crowd.size < 1.0) {
        push_apart(crowd, shallow, steps);
        crowd.size = std::min(1.0, by * crowd.size);
    }
}

/// Between which heights the spheres have to be at t = 0.
void set_heights(const Setup& setup, double thickest, Crowd& crowd) {
    crowd.floor = 2.0 * setup.plates.amplitude;
    // Without a lid a little more room than one layer needs; what lies high falls.
    crowd.ceiling = crowd.floor + (setup.plates.lid ? setup.plates.gap : std::max(setup.plates.gap, 1.5 * thickest));
}

/// No larger than what the gap leaves to the thickest.
double margin_of(const Setup& setup, double thickest, double most) {
    return setup.plates.lid && thickest > 0.0 ? std::min(most, 0.25 * (setup.plates.gap / thickest - 1.0)) : most;
}

constexpr int steps_of_round = 500;

/// Pushes bodies apart in rounds until none overlap; the overlap after each.  Ends early when the rounds are used up, about a minute at the
/// paper's size, or bring no more.
std::vector<double> resolve(Crowd& crowd) {
    constexpr double sphere_steps = 8e8;
    constexpr std::size_t back = 4, least = 6, most = 40;
    const double rounds = sphere_steps / steps_of_round / static_cast<double>(crowd.body.size());
    const std::size_t last = std::clamp(static_cast<std::size_t>(rounds), least, most);
    std::vector<double> overlaps;
    while (overlaps.size() < last) {
        push_apart(crowd, 0.8 * crowd.margin, steps_of_round);
        overlaps.push_back(largest_overlap(crowd));
        const std::size_t n = overlaps.size();
        if (overlaps.back() <= 0.0 || (n > back && overlaps.back() > 0.9 * overlaps[n - 1 - back])) break;
    }
    return overlaps;
}

/// Spreads bodies that do not overlap as far from each other as a larger margin brings them: from a start in which all nearly touch, the first
/// stroke of the plates would be one impact of hundreds.
void loosen(Crowd& crowd, double margin) {
    if (margin <= crowd.margin) return;
    const Crowd before = crowd;
    set_margin(crowd, margin);
    push_apart(crowd, 0.2 * margin, steps_of_round);
    if (largest_overlap(crowd) > 0.0) crowd = before;
}

void write_back(const Crowd& crowd, Bodies& bodies) {
    const NearestImage apart(crowd.cell);
    for (std::size_t i = 0; i < bodies.beads.size(); ++i) bodies.beads[i].position = apart({}, crowd.place[i]);
    for (std::size_t i = 0; i < bodies.rods.size(); ++i) {
        bodies.rods[i].position = apart({}, crowd.place[bodies.beads.size() + i]);
        bodies.rods[i].axis = crowd.axis[i];
    }
}
}  // namespace

Packed pack(const Setup& setup, std::uint64_t seed, const LocationOf& place) {
    check(setup, place);
    require(setup.packing.kind != "file", place("packing.kind"),
            "packing.kind = \"file\" asks for bodies of a file, which are read where the run begins; expected "
            "\"random\" or \"aligned\" here");
    Packed packed{.bodies = make_bodies(setup, seed, place)};
    if (packed.bodies.beads.empty() && packed.bodies.rods.empty()) return packed;
    double thickest = 0.0;
    for (const Shape& shape : packed.bodies.shapes) thickest = std::max(thickest, thickness(shape));
    Crowd crowd = make_crowd(setup, packed.bodies, margin_of(setup, thickest, 2e-3));
    set_heights(setup, thickest, crowd);
    place_all(setup, packed.bodies, seed, crowd, place);
    grow(crowd);
    const std::vector<double> overlaps = resolve(crowd);
    packed.rounds = static_cast<int>(overlaps.size());
    if (overlaps.back() > 0.0)
        fail_run(
            "no packing without overlaps was found for {} beads and {} rods: after {} rounds of {} steps two still "
            "overlap by {:.3g} of a radius; expected 0: ask for fewer, or give them a larger gap",
            packed.bodies.beads.size(), packed.bodies.rods.size(), packed.rounds, steps_of_round, overlaps.back());
    loosen(crowd, margin_of(setup, thickest, 0.04));
    write_back(crowd, packed.bodies);
    return packed;
}

}  // namespace drover::dem
