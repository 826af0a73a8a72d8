// dem/packing/overlap_relaxation.cpp: removal of overlaps by minimisation of their energy.
#include "dem/packing/overlap_relaxation.hpp"

#include <algorithm>
#include <cmath>

namespace drover::dem {

OverlapRelaxation make_relaxation(const Setup& setup, const Bodies& bodies, double margin) {
    OverlapRelaxation relaxation{.cell = setup.cell,
                                 .walls = Walls(setup.cell),
                                 .turns = setup.packing.kind != PackingKind::aligned,
                                 .margin = margin};
    for (const Bead& bead : bodies.beads) {
        relaxation.body.push_back(static_cast<std::uint32_t>(relaxation.mass.size()));
        relaxation.at.push_back(0.0);
        relaxation.radius.push_back(bodies.shapes[bead.shape].radius.front());
        relaxation.mass.push_back(1.0);
    }
    for (const Rod& rod : bodies.rods) {
        const Shape& shape = bodies.shapes[rod.shape];
        for (std::size_t i = 0; i < shape.at.size(); ++i) {
            relaxation.body.push_back(static_cast<std::uint32_t>(relaxation.mass.size()));
            relaxation.at.push_back(shape.at[i]);
            relaxation.radius.push_back(shape.radius[i]);
        }
        // Gives a rod about the ratio of stiffness to mass of a bead.
        const double mass = 0.5 + 0.5 * static_cast<double>(shape.at.size()), length = shape.head - shape.tail;
        relaxation.mass.push_back(mass);
        relaxation.inertia.push_back(mass * length * length / 12.0);
    }
    relaxation.position.resize(relaxation.mass.size());
    relaxation.velocity.resize(relaxation.mass.size());
    relaxation.force.resize(relaxation.mass.size());
    relaxation.axis.assign(bodies.rods.size(), {1.0, 0.0, 0.0});
    relaxation.turning.resize(bodies.rods.size());
    relaxation.torque.resize(bodies.rods.size());
    relaxation.centre.resize(relaxation.body.size());
    relaxation.push.resize(relaxation.body.size());
    relaxation.reach.resize(relaxation.body.size());
    return relaxation;
}

void set_spheres(OverlapRelaxation& relaxation) {
    const std::size_t beads = relaxation.position.size() - relaxation.axis.size();
    for (std::size_t s = 0; s < relaxation.body.size(); ++s) {
        const std::size_t body = relaxation.body[s];
        const double size = body < beads ? 1.0 : relaxation.size;
        relaxation.centre[s] = relaxation.position[body];
        if (body >= beads)
            relaxation.centre[s] = relaxation.centre[s] + size * relaxation.at[s] * relaxation.axis[body - beads];
        relaxation.reach[s] = (1.0 + relaxation.margin) * size * relaxation.radius[s];
    }
}

namespace {
/// Pairs of spheres that can come to overlap before one of them has moved by half the skin.
struct Neighbours {
    double skin = 0.0;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    std::vector<Vector> centre;  ///< of the spheres when the list was made
};

/// Spheres of one rod can meet only over the edge of the cell.
bool can_meet(const OverlapRelaxation& relaxation, std::size_t a, std::size_t b, const Vector& apart) {
    if (relaxation.body[a] != relaxation.body[b]) return true;
    const Vector straight = relaxation.centre[b] - relaxation.centre[a];
    return std::abs(straight.x - apart.x) + std::abs(straight.y - apart.y) > 0.5 * relaxation.reach[a];
}

template <class Visit>
void for_pairs(const OverlapRelaxation& relaxation, double skin, const Visit& visit) {
    const double largest = relaxation.reach.empty() ? 1.0 : *std::ranges::max_element(relaxation.reach);
    Bins bins(relaxation.cell, 2.0 * largest + skin);
    const NearestImage apart(relaxation.cell);
    for (std::size_t a = 0; a < relaxation.centre.size(); ++a) {
        bins.for_near(relaxation.centre[a], [&](std::uint32_t b) {
            const Vector d = apart(relaxation.centre[a], relaxation.centre[b]);
            const double reach = relaxation.reach[a] + relaxation.reach[b] + skin;
            if (dot(d, d) < reach * reach && can_meet(relaxation, a, b, d)) visit(static_cast<std::uint32_t>(a), b, d);
        });
        bins.add(relaxation.centre[a]);
    }
}

void list(const OverlapRelaxation& relaxation, Neighbours& neighbours) {
    neighbours.pairs.clear();
    for_pairs(relaxation, neighbours.skin,
              [&](std::uint32_t a, std::uint32_t b, const Vector&) { neighbours.pairs.emplace_back(a, b); });
    neighbours.centre = relaxation.centre;
}

bool is_stale(const OverlapRelaxation& relaxation, const Neighbours& neighbours) {
    const double max_square = 0.25 * neighbours.skin * neighbours.skin;
    for (std::size_t s = 0; s < relaxation.centre.size(); ++s) {
        const Vector moved = relaxation.centre[s] - neighbours.centre[s];
        if (dot(moved, moved) > max_square) return true;
    }
    return false;
}

/// Adds the forces of pairs; returns the deepest overlap relative to the sum of the radii.
double push_pairs(OverlapRelaxation& relaxation, const Neighbours& neighbours) {
    const NearestImage apart(relaxation.cell);
    double deepest = 0.0;
    for (const auto& [a, b] : neighbours.pairs) {
        const Vector d = apart(relaxation.centre[a], relaxation.centre[b]);
        const double reach = relaxation.reach[a] + relaxation.reach[b], square = dot(d, d);
        if (square >= reach * reach) continue;
        const double distance = std::sqrt(square), depth = reach - distance;
        const Vector push = distance > 0.0 ? depth / distance * d : Vector{depth, 0.0, 0.0};
        relaxation.push[a] = relaxation.push[a] - push;
        relaxation.push[b] = relaxation.push[b] + push;
        deepest = std::max(deepest, depth / reach);
    }
    return deepest;
}

/// Adds the forces of plates and walls; returns the deepest overlap relative to the radius.
double push_inside(OverlapRelaxation& relaxation) {
    double deepest = 0.0;
    for (std::size_t s = 0; s < relaxation.centre.size(); ++s) {
        const double reach = relaxation.reach[s];
        const double below = relaxation.floor + reach - relaxation.centre[s].z,
                     above = relaxation.centre[s].z + reach - relaxation.ceiling;
        relaxation.push[s].z += std::max(0.0, below) - std::max(0.0, above);
        deepest = std::max({deepest, below / reach, above / reach});
        WallPoint found[4];
        const int count = relaxation.walls.near(relaxation.centre[s].x, relaxation.centre[s].y, reach, found);
        for (int i = 0; i < count; ++i) {
            const double depth = reach - found[i].distance;
            relaxation.push[s] = relaxation.push[s] + depth * Vector{found[i].nx, found[i].ny, 0.0};
            deepest = std::max(deepest, depth / reach);
        }
    }
    return deepest;
}

/// Forces and torques of the bodies; returns the deepest overlap.
double find_forces(OverlapRelaxation& relaxation, Neighbours& neighbours) {
    set_spheres(relaxation);
    if (is_stale(relaxation, neighbours)) list(relaxation, neighbours);
    std::ranges::fill(relaxation.push, Vector{});
    const double deepest = std::max(push_pairs(relaxation, neighbours), push_inside(relaxation));
    std::ranges::fill(relaxation.force, Vector{});
    std::ranges::fill(relaxation.torque, Vector{});
    const std::size_t beads = relaxation.position.size() - relaxation.axis.size();
    for (std::size_t s = 0; s < relaxation.push.size(); ++s) {
        const std::size_t body = relaxation.body[s];
        relaxation.force[body] = relaxation.force[body] + relaxation.push[s];
        if (body < beads || !relaxation.turns) continue;
        Vector& torque = relaxation.torque[body - beads];
        torque = torque + cross(relaxation.size * relaxation.at[s] * relaxation.axis[body - beads], relaxation.push[s]);
    }
    return deepest;
}

/// State of the minimisation, with the constants of Bitzek et al.
struct Descent {
    static constexpr double max_dt = 0.3, mixing_start = 0.1;
    double dt = 0.1, mixing = mixing_start;
    int downhill = 0;  ///< steps since the power was last negative
};

void stop(OverlapRelaxation& relaxation) {
    std::ranges::fill(relaxation.velocity, Vector{});
    std::ranges::fill(relaxation.turning, Vector{});
}

/// Power of the forces, and squares of velocities and accelerations weighted by mass.
struct Sums {
    double power = 0.0, velocity = 0.0, acceleration = 0.0;
};
void add(const std::vector<Vector>& velocity, const std::vector<Vector>& force, const std::vector<double>& mass,
         Sums& sums) {
    for (std::size_t i = 0; i < velocity.size(); ++i) {
        sums.power += dot(velocity[i], force[i]);
        sums.velocity += mass[i] * dot(velocity[i], velocity[i]);
        sums.acceleration += dot(force[i], force[i]) / mass[i];
    }
}

/// velocity <- kept velocity + gain force / mass.
void accelerate(std::vector<Vector>& velocity, const std::vector<Vector>& force, const std::vector<double>& mass,
                double kept, double gain) {
    for (std::size_t i = 0; i < velocity.size(); ++i) velocity[i] = kept * velocity[i] + gain / mass[i] * force[i];
}

void descend(OverlapRelaxation& relaxation, Descent& descent) {
    Sums sums;
    add(relaxation.velocity, relaxation.force, relaxation.mass, sums);
    add(relaxation.turning, relaxation.torque, relaxation.inertia, sums);
    double turned = 0.0;  // mixing of the velocity towards the force
    if (sums.power > 0.0) {
        turned = descent.mixing * std::sqrt(sums.velocity / sums.acceleration);
        if (++descent.downhill > 5) {
            descent.dt = std::min(1.1 * descent.dt, Descent::max_dt);
            descent.mixing *= 0.99;
        }
    } else {
        descent.dt = std::max(0.5 * descent.dt, 0.05);
        descent.mixing = Descent::mixing_start;
        descent.downhill = 0;
        stop(relaxation);
    }
    const double kept = turned > 0.0 ? 1.0 - descent.mixing : 1.0;
    accelerate(relaxation.velocity, relaxation.force, relaxation.mass, kept, turned + descent.dt);
    accelerate(relaxation.turning, relaxation.torque, relaxation.inertia, kept, turned + descent.dt);
    for (std::size_t i = 0; i < relaxation.position.size(); ++i)
        relaxation.position[i] = relaxation.position[i] + descent.dt * relaxation.velocity[i];
    if (!relaxation.turns) return;
    for (std::size_t i = 0; i < relaxation.axis.size(); ++i) {
        const Vector axis = relaxation.axis[i] + descent.dt * cross(relaxation.turning[i], relaxation.axis[i]);
        relaxation.axis[i] = 1.0 / length(axis) * axis;
    }
}
}  // namespace

double relax_overlaps(OverlapRelaxation& relaxation, double max_overlap, int steps) {
    set_spheres(relaxation);
    double mean = 0.0;
    for (const double reach : relaxation.reach) mean += reach / static_cast<double>(relaxation.reach.size());
    Neighbours neighbours{.skin = 0.5 * mean};
    list(relaxation, neighbours);
    stop(relaxation);
    Descent descent;
    double left = find_forces(relaxation, neighbours);
    for (int n = 0; n < steps && left > max_overlap; ++n) {
        descend(relaxation, descent);
        left = find_forces(relaxation, neighbours);
    }
    return left;
}

void set_margin(OverlapRelaxation& relaxation, double margin) {
    for (double& reach : relaxation.reach) reach *= (1.0 + margin) / (1.0 + relaxation.margin);
    relaxation.margin = margin;
}

double largest_overlap(const OverlapRelaxation& relaxation) {
    const double true_size = 1.0 / (1.0 + relaxation.margin);
    double largest = -1.0;
    for_pairs(relaxation, 0.0, [&](std::uint32_t a, std::uint32_t b, const Vector& d) {
        const double ra = true_size * relaxation.reach[a], rb = true_size * relaxation.reach[b];
        largest = std::max(largest, (ra + rb - length(d)) / std::min(ra, rb));
    });
    for (std::size_t s = 0; s < relaxation.centre.size(); ++s) {
        const double r = true_size * relaxation.reach[s], z = relaxation.centre[s].z;
        largest = std::max({largest, (relaxation.floor + r - z) / r, (z + r - relaxation.ceiling) / r});
        WallPoint found[4];
        if (relaxation.walls.near(relaxation.centre[s].x, relaxation.centre[s].y, r, found) > 0)
            largest = std::max(largest, (r - found[0].distance) / r);
    }
    return largest;
}

}  // namespace drover::dem
