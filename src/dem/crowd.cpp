// dem/crowd.cpp: removal of overlaps by minimisation of their energy.
#include "dem/crowd.hpp"

#include <algorithm>
#include <cmath>

#include "walls.hpp"

namespace drover::dem {

Crowd make_crowd(const Setup& setup, const Bodies& bodies, double margin) {
    Crowd crowd{.cell = setup.cell, .turns = setup.packing.kind != "aligned", .margin = margin};
    for (const Bead& bead : bodies.beads) {
        crowd.body.push_back(static_cast<std::uint32_t>(crowd.mass.size()));
        crowd.at.push_back(0.0);
        crowd.radius.push_back(bodies.shapes[bead.shape].radius.front());
        crowd.mass.push_back(1.0);
    }
    for (const Rod& rod : bodies.rods) {
        const Shape& shape = bodies.shapes[rod.shape];
        for (std::size_t i = 0; i < shape.at.size(); ++i) {
            crowd.body.push_back(static_cast<std::uint32_t>(crowd.mass.size()));
            crowd.at.push_back(shape.at[i]);
            crowd.radius.push_back(shape.radius[i]);
        }
        // As stiff beside its mass as a bead, which touches about one of its spheres at a time.
        const double mass = 0.5 + 0.5 * static_cast<double>(shape.at.size()), length = shape.head - shape.tail;
        crowd.mass.push_back(mass);
        crowd.inertia.push_back(mass * length * length / 12.0);
    }
    crowd.place.resize(crowd.mass.size());
    crowd.velocity.resize(crowd.mass.size());
    crowd.force.resize(crowd.mass.size());
    crowd.axis.assign(bodies.rods.size(), {1.0, 0.0, 0.0});
    crowd.turning.resize(bodies.rods.size());
    crowd.torque.resize(bodies.rods.size());
    crowd.centre.resize(crowd.body.size());
    crowd.push.resize(crowd.body.size());
    crowd.reach.resize(crowd.body.size());
    return crowd;
}

void set_spheres(Crowd& crowd) {
    const std::size_t beads = crowd.place.size() - crowd.axis.size();
    for (std::size_t s = 0; s < crowd.body.size(); ++s) {
        const std::size_t body = crowd.body[s];
        const double size = body < beads ? 1.0 : crowd.size;
        crowd.centre[s] = crowd.place[body];
        if (body >= beads) crowd.centre[s] = crowd.centre[s] + size * crowd.at[s] * crowd.axis[body - beads];
        crowd.reach[s] = (1.0 + crowd.margin) * size * crowd.radius[s];
    }
}

namespace {
/// Pairs of spheres that can touch before one of them has moved by half the skin.
struct Neighbours {
    double skin = 0.0;
    std::vector<std::uint32_t> first, second;
    std::vector<Vector> centre;  ///< of the spheres when the list was made
};

/// Spheres of one rod are a pair only over the edge of the cell.
bool can_meet(const Crowd& crowd, std::size_t a, std::size_t b, const Vector& apart) {
    if (crowd.body[a] != crowd.body[b]) return true;
    const Vector straight = crowd.centre[b] - crowd.centre[a];
    return std::abs(straight.x - apart.x) + std::abs(straight.y - apart.y) > 0.5 * crowd.reach[a];
}

template <class Visit>
void for_pairs(const Crowd& crowd, double skin, const Visit& visit) {
    const double largest = crowd.reach.empty() ? 1.0 : *std::max_element(crowd.reach.begin(), crowd.reach.end());
    Bins bins(crowd.cell, 2.0 * largest + skin);
    const NearestImage apart(crowd.cell);
    for (std::size_t a = 0; a < crowd.centre.size(); ++a) {
        bins.for_near(crowd.centre[a], [&](std::uint32_t b) {
            const Vector d = apart(crowd.centre[a], crowd.centre[b]);
            const double reach = crowd.reach[a] + crowd.reach[b] + skin;
            if (dot(d, d) < reach * reach && can_meet(crowd, a, b, d)) visit(static_cast<std::uint32_t>(a), b, d);
        });
        bins.add(crowd.centre[a]);
    }
}

void list(const Crowd& crowd, Neighbours& neighbours) {
    neighbours.first.clear();
    neighbours.second.clear();
    for_pairs(crowd, neighbours.skin, [&](std::uint32_t a, std::uint32_t b, const Vector&) {
        neighbours.first.push_back(a);
        neighbours.second.push_back(b);
    });
    neighbours.centre = crowd.centre;
}

bool is_stale(const Crowd& crowd, const Neighbours& neighbours) {
    const double most = 0.25 * neighbours.skin * neighbours.skin;
    for (std::size_t s = 0; s < crowd.centre.size(); ++s) {
        const Vector moved = crowd.centre[s] - neighbours.centre[s];
        if (dot(moved, moved) > most) return true;
    }
    return false;
}

/// Pushes of pairs; returns the deepest overlap beside the distance at which the two touch.
double push_pairs(Crowd& crowd, const Neighbours& neighbours) {
    const NearestImage apart(crowd.cell);
    double deepest = 0.0;
    for (std::size_t p = 0; p < neighbours.first.size(); ++p) {
        const std::uint32_t a = neighbours.first[p], b = neighbours.second[p];
        const Vector d = apart(crowd.centre[a], crowd.centre[b]);
        const double reach = crowd.reach[a] + crowd.reach[b], square = dot(d, d);
        if (square >= reach * reach) continue;
        const double distance = std::sqrt(square), depth = reach - distance;
        const Vector push = distance > 0.0 ? depth / distance * d : Vector{depth, 0.0, 0.0};
        crowd.push[a] = crowd.push[a] - push;
        crowd.push[b] = crowd.push[b] + push;
        deepest = std::max(deepest, depth / reach);
    }
    return deepest;
}

/// Pushes of plates and walls.
double push_inside(Crowd& crowd) {
    double deepest = 0.0;
    const Walls walls(crowd.cell);
    for (std::size_t s = 0; s < crowd.centre.size(); ++s) {
        const double reach = crowd.reach[s];
        const double below = crowd.floor + reach - crowd.centre[s].z, above = crowd.centre[s].z + reach - crowd.ceiling;
        crowd.push[s].z += std::max(0.0, below) - std::max(0.0, above);
        deepest = std::max({deepest, below / reach, above / reach});
        WallPoint found[4];
        const int count = walls.near(crowd.centre[s].x, crowd.centre[s].y, reach, found);
        for (int i = 0; i < count; ++i) {
            const double depth = reach - found[i].distance;
            crowd.push[s] = crowd.push[s] + depth * Vector{found[i].nx, found[i].ny, 0.0};
            deepest = std::max(deepest, depth / reach);
        }
    }
    return deepest;
}

/// Forces and torques of the bodies; returns the deepest overlap.
double find_forces(Crowd& crowd, Neighbours& neighbours) {
    set_spheres(crowd);
    if (is_stale(crowd, neighbours)) list(crowd, neighbours);
    std::fill(crowd.push.begin(), crowd.push.end(), Vector{});
    const double deepest = std::max(push_pairs(crowd, neighbours), push_inside(crowd));
    std::fill(crowd.force.begin(), crowd.force.end(), Vector{});
    std::fill(crowd.torque.begin(), crowd.torque.end(), Vector{});
    const std::size_t beads = crowd.place.size() - crowd.axis.size();
    for (std::size_t s = 0; s < crowd.push.size(); ++s) {
        const std::size_t body = crowd.body[s];
        crowd.force[body] = crowd.force[body] + crowd.push[s];
        if (body < beads || !crowd.turns) continue;
        Vector& torque = crowd.torque[body - beads];
        torque = torque + cross(crowd.size * crowd.at[s] * crowd.axis[body - beads], crowd.push[s]);
    }
    return deepest;
}

/// State of the minimisation; its numbers are those of Bitzek et al.
struct Descent {
    static constexpr double max_dt = 0.3, mixing_start = 0.1;
    double dt = 0.1, mixing = mixing_start;
    int downhill = 0;  ///< steps since it last went uphill
};

void stop(Crowd& crowd) {
    std::fill(crowd.velocity.begin(), crowd.velocity.end(), Vector{});
    std::fill(crowd.turning.begin(), crowd.turning.end(), Vector{});
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

void descend(Crowd& crowd, Descent& descent) {
    Sums sums;
    add(crowd.velocity, crowd.force, crowd.mass, sums);
    add(crowd.turning, crowd.torque, crowd.inertia, sums);
    double turned = 0.0;  // towards the forces
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
        stop(crowd);
    }
    const double kept = turned > 0.0 ? 1.0 - descent.mixing : 1.0;
    accelerate(crowd.velocity, crowd.force, crowd.mass, kept, turned + descent.dt);
    accelerate(crowd.turning, crowd.torque, crowd.inertia, kept, turned + descent.dt);
    for (std::size_t i = 0; i < crowd.place.size(); ++i)
        crowd.place[i] = crowd.place[i] + descent.dt * crowd.velocity[i];
    if (!crowd.turns) return;
    for (std::size_t i = 0; i < crowd.axis.size(); ++i) {
        const Vector axis = crowd.axis[i] + descent.dt * cross(crowd.turning[i], crowd.axis[i]);
        crowd.axis[i] = 1.0 / length(axis) * axis;
    }
}
}  // namespace

double push_apart(Crowd& crowd, double deepest, int steps) {
    set_spheres(crowd);
    double mean = 0.0;
    for (const double reach : crowd.reach) mean += reach / static_cast<double>(crowd.reach.size());
    Neighbours neighbours{.skin = 0.5 * mean};
    list(crowd, neighbours);
    stop(crowd);
    Descent descent;
    double left = find_forces(crowd, neighbours);
    for (int n = 0; n < steps && left > deepest; ++n) {
        descend(crowd, descent);
        left = find_forces(crowd, neighbours);
    }
    return left;
}

void set_margin(Crowd& crowd, double margin) {
    for (double& reach : crowd.reach) reach *= (1.0 + margin) / (1.0 + crowd.margin);
    crowd.margin = margin;
}

double largest_overlap(const Crowd& crowd) {
    const double true_size = 1.0 / (1.0 + crowd.margin);
    double largest = -1.0;
    for_pairs(crowd, 0.0, [&](std::uint32_t a, std::uint32_t b, const Vector& d) {
        const double ra = true_size * crowd.reach[a], rb = true_size * crowd.reach[b];
        largest = std::max(largest, (ra + rb - length(d)) / std::min(ra, rb));
    });
    for (std::size_t s = 0; s < crowd.centre.size(); ++s) {
        const double r = true_size * crowd.reach[s], z = crowd.centre[s].z;
        largest = std::max({largest, (crowd.floor + r - z) / r, (z + r - crowd.ceiling) / r});
        WallPoint found[4];
        if (walls_near(crowd.cell, crowd.centre[s].x, crowd.centre[s].y, r, found) > 0)
            largest = std::max(largest, (r - found[0].distance) / r);
    }
    return largest;
}

}  // namespace drover::dem
