// tests/measure/particles_support.hpp: bodies at given positions, and their observables.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drover/base/random.hpp"
#include "measure/particles.hpp"

namespace drover::measure {

constexpr double pi = std::numbers::pi;

/// Bodies in a cell: shapes are a bead of 0.8 mm and the rod of the seed paper.
struct ParticleScene {
    dem::Setup setup;
    dem::Bodies bodies;
    dem::EnergyBalance balance;
    dem::Counts counts;
    double energy_kinetic = 0.0;

    explicit ParticleScene(dem::CellShape shape = dem::CellShape::periodic, double lx = 45.0, double ly = 45.0) {
        setup.cell.shape = shape;
        setup.cell.lx = lx;
        setup.cell.ly = ly;
        bodies.shapes = {dem::make_ball(0.8, 2.7), dem::make_rod(dem::RodSupply{}.diameters, 4.5, 8.7)};
    }
    void add_bead(double x, double y, double vx = 0.0, double vy = 0.0) {
        bodies.beads.push_back({.position = {x, y, 0.5}, .velocity = {vx, vy, 0.0}, .shape = 0});
    }
    void add_rod(double x, double y, double angle, double speed = 0.0) {
        const dem::Vector n{std::cos(angle), std::sin(angle), 0.0};
        bodies.rods.push_back({.position = {x, y, 0.6}, .velocity = speed * n, .axis = n, .shape = 1});
    }
    ParticleSetting setting() const { return make_particle_setting(setup, bodies); }
    ParticleMoment moment(const ParticleSetting& at) const {
        return {.setting = at,
                .bodies = bodies,
                .time = 0.0,
                .balance = balance,
                .counts = counts,
                .energy_kinetic = energy_kinetic};
    }
    bool measures(const std::string& name) const { return find_row(particle_observables(setting()), name) != nullptr; }
    /// All values of the observable of that name.
    std::vector<double> all(const std::string& name) const {
        const ParticleSetting at = setting();
        const auto rows = particle_observables(at);
        if (const auto* row = find_row(rows, name)) return measure_one(*row, moment(at));
        ADD_FAILURE() << name << " is not measured";
        return {std::nan("")};
    }
    /// The coordinates on the first axis of the observable of that name.
    std::vector<double> axis(const std::string& name) const {
        return find_row(particle_observables(setting()), name)->axes.front().values;
    }
    double operator()(const std::string& name) const { return all(name).at(0); }
};

inline std::vector<double> uniform_numbers(std::size_t count, std::uint64_t seed, std::uint64_t step = 0) {
    std::vector<double> values(count);
    fill_uniform({.seed = seed, .stream = Stream::test, .step = step}, 0, 1, values);
    return values;
}

inline std::vector<double> normal_numbers(std::size_t count, std::uint64_t seed, std::uint64_t step = 0) {
    std::vector<double> values(count);
    fill_normal({.seed = seed, .stream = Stream::test, .step = step}, 0, 1, values);
    return values;
}

/// Beads and rods at random places, in random directions, with random velocities.
inline ParticleScene random_particles(std::uint64_t seed, std::size_t beads, std::size_t rods,
                                      dem::CellShape shape = dem::CellShape::periodic, double lx = 45.0,
                                      double ly = 45.0) {
    ParticleScene scene(shape, lx, ly);
    const std::vector<double> u = uniform_numbers(2 * beads + 3 * rods, seed),
                              v = normal_numbers(2 * beads + rods, seed);
    for (std::size_t i = 0; i < beads; ++i)
        scene.add_bead(lx * (u[2 * i] - 0.5), ly * (u[2 * i + 1] - 0.5), 5.0 * v[2 * i], 5.0 * v[2 * i + 1]);
    for (std::size_t i = 0; i < rods; ++i) {
        const std::size_t k = 2 * beads + 3 * i;
        scene.add_rod(lx * (u[k] - 0.5), ly * (u[k + 1] - 0.5), 2.0 * pi * u[k + 2], 4.0 + v[2 * beads + i]);
    }
    return scene;
}

}  // namespace drover::measure
