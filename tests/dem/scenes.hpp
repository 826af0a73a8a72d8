// tests/dem/scenes.hpp: small particle worlds for tests.
#pragma once
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

/// A sequence of random numbers in (-1, 1).
class Drawn {
public:
    explicit Drawn(std::uint64_t seed) : seed_(seed) {}
    double operator()() {
        double u = 0.0;
        fill_uniform({.seed = seed_, .stream = Stream::test}, next_++, 1, {&u, 1});
        return 2.0 * u - 1.0;
    }
    Vector vector(double size) { return {size * (*this)(), size * (*this)(), size * (*this)()}; }
    Vector direction() {
        Vector v = vector(1.0);
        while (length(v) < 0.1 || length(v) > 1.0) v = vector(1.0);
        return 1.0 / length(v) * v;
    }

private:
    std::uint64_t seed_, next_ = 0;
};

/// The paper's plates about a periodic square of one side.
inline Setup square(double side) {
    Setup setup;
    setup.cell.lx = setup.cell.ly = side;
    return setup;
}

/// Plates that do not move, no gravity, no friction, no loss.
inline Setup elastic(double side) {
    Setup setup = square(side);
    setup.plates.amplitude = 0.0;
    setup.gravity.z = 0.0;
    setup.restitution = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0};
    setup.friction = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    setup.kick.strength = 0.0;
    return setup;
}

/// Beads of one diameter on a square lattice in the middle of the gap, with random velocities.
inline Bodies lattice(const Setup& setup, int columns, int rows, double diameter, double speed, Drawn& drawn) {
    Bodies bodies{.shapes = {make_ball(diameter, setup.beads.density)}, .beads = {}, .rods = {}};
    const double middle = setup.plates.amplitude * 2.0 + 0.5 * setup.plates.gap;
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i)
            bodies.beads.push_back({.position = {(i + 0.5) * setup.cell.lx / columns - 0.5 * setup.cell.lx,
                                                 (j + 0.5) * setup.cell.ly / rows - 0.5 * setup.cell.ly, middle},
                                    .velocity = drawn.vector(speed),
                                    .spin = {},
                                    .shape = 0});
    return bodies;
}

/// The paper's rod, lying along an angle in the middle of the gap.
inline Rod lying_rod(const Setup& setup, double x, double y, double angle, std::uint32_t shape = 0) {
    Rod rod;
    rod.position = {x, y, setup.plates.amplitude * 2.0 + 0.5 * setup.plates.gap};
    rod.axis = {std::cos(angle), std::sin(angle), 0.0};
    rod.shape = shape;
    return rod;
}
inline Shape rod_shape(const Setup& setup) {
    return make_rod(setup.rods.diameters, setup.rods.length, setup.rods.densities.front());
}

/// A few rods among beads on a lattice, all moving.
inline Bodies mixture(const Setup& setup, Drawn& drawn) {
    Bodies bodies = lattice(setup, static_cast<int>(setup.cell.lx / 0.95), static_cast<int>(setup.cell.ly / 0.95), 0.8,
                            30.0, drawn);
    bodies.shapes.push_back(rod_shape(setup));
    const double step = setup.cell.lx / 2.0;
    for (int i = 0; i < 4; ++i) {
        Rod rod = lying_rod(setup, (i % 2 - 0.5) * step, (i / 2 - 0.5) * step, 0.7 * i, 1);
        rod.velocity = drawn.vector(10.0);
        bodies.rods.push_back(rod);
    }
    std::erase_if(bodies.beads, [&](const Bead& bead) {
        for (const Rod& rod : bodies.rods)
            for (const double along : bodies.shapes[1].at) {
                const Vector d = bead.position - rod.position - along * rod.axis;
                if (dot(d, d) < 0.96 * 0.96) return true;
            }
        return false;
    });
    return bodies;
}

inline void run(World& world, std::int64_t from, std::int64_t to) {
    for (std::int64_t step = from; step < to; ++step) world.advance(step);
}

}  // namespace drover::dem
