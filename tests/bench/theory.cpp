// tests/bench/theory.cpp: time of maps of modes and of phase boundaries, beside the eigenvalues that they cannot do
// without.
#include <benchmark/benchmark.h>

#include <Eigen/Eigenvalues>
#include <numbers>

#include "physics/linear_modes.hpp"
#include "physics/planes.hpp"
#include "physics/symbols.hpp"
#include "theory/instabilities.hpp"

namespace drover {
namespace {

const physics::Model flock{.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
                           .uniform = {.rod_density = 0.02, .bead_density = 0.8},
                           .current = {.speed = 3.6, .kind = "density-order"},
                           .inertia = {.bead_mass = 2.1},
                           .drag = {.coefficient = 33.6},
                           .viscosity = {.shear = 67.2},
                           .driving = {.strength = 33.6},
                           .stiffness = {.beads = 168.0, .rods = 420.0},
                           .relaxation = {.rate = 0.4, .saturation = 0.4},
                           .elasticity = {.stiffness = 2.0},
                           .weathercock = {.strength = 0.6},
                           .pressure = {.beads = 1.0, .rods = 40.0},
                           .noise = {.order = 0.1}};

constexpr int side = 200;

std::vector<double> steps(double first, double last) {
    std::vector<double> result;
    for (int k = 0; k < side; ++k) result.push_back(first + (last - first) * k / (side - 1));
    return result;
}

/// 200 by 200 wavenumbers and angles: rates, shapes and duals of six modes, branches followed.
void mode_map(benchmark::State& state) {
    const physics::Equations equations(flock);
    const physics::StationaryState about = physics::stationary_states(equations).states.at(1);
    Threads threads(static_cast<int>(state.range(0)));
    for (auto _ : state)
        benchmark::DoNotOptimize(theory::mode_map(*physics::linearised(equations, about.point), steps(0.01, 3.0),
                                                  steps(0.0, std::numbers::pi / 2.0), threads));
    state.counters["transforms"] = 0;
}

/// The eigenvectors of as many matrices, ready made: the floor of the map.
void eigenvectors(benchmark::State& state) {
    const physics::Equations equations(flock);
    const physics::StationaryState about = physics::stationary_states(equations).states.at(1);
    const physics::Symbol m = physics::linear_symbol(equations, about.point, {.x = 0.3, .y = 0.4});
    Eigen::ComplexEigenSolver<physics::Symbol> solver;
    for (auto _ : state)
        for (int n = 0; n < side * side; ++n) benchmark::DoNotOptimize(solver.compute(m));
    state.counters["transforms"] = 0;
}

/// Structure factors of every kept mode of a grid of 256 squared about a flock.
void flock_structure_factors(benchmark::State& state) {
    const physics::Equations equations(flock);
    const physics::StationaryState about = physics::stationary_states(equations).states.at(1);
    Threads threads(static_cast<int>(state.range(0)));
    for (auto _ : state)
        benchmark::DoNotOptimize(theory::structure_factors(*physics::linearised(equations, about.point),
                                                           {256, 256, 256.0, 256.0}, 3, threads));
    state.counters["transforms"] = 0;
}

/// One kind of line in the plane of both densities, alpha and a from a table of 4 by 3 nodes, 24 of them with errors.
void boundary(benchmark::State& state, physics::Limit limit) {
    physics::Plane plane{.model = flock,
                         .x = {.name = "rho",
                               .from = 0.42,
                               .to = 1.49,
                               .set = [](physics::Model& m, double v) { m.uniform.bead_density = v; },
                               .is_density = true},
                         .y = {.name = "sigma",
                               .from = 0.005,
                               .to = 0.039,
                               .set = [](physics::Model& m, double v) { m.uniform.rod_density = v; },
                               .is_density = true}};
    plane.model.table = {.bead_density = {0.4, 0.8, 1.2, 1.5},
                         .rod_density = {0.004, 0.02, 0.04},
                         .columns = {{"relaxation.rate",
                                      {{0.45, 0.40, 0.36, 0.40, 0.36, 0.30, 0.33, 0.30, 0.24, 0.28, 0.24, 0.2},
                                       std::vector<double>(12, 0.01)}},
                                     {"driving.strength",
                                      {{10, 12, 15, 16, 20, 24, 24, 30, 36, 28, 36, 42},
                                       std::vector<double>(12, 0.5)}}}};
    std::vector<physics::Model> draws(20, plane.model);
    physics::draw_errors(physics::table_errors(plane.model), draws);
    Threads threads(static_cast<int>(state.range(0)));
    for (auto _ : state)
        benchmark::DoNotOptimize(physics::trace_boundary(plane, limit, draws, {}, on_threads(threads)));
    state.counters["transforms"] = 0;
}
void boundary_onset(benchmark::State& state) { boundary(state, physics::Limit::onset); }
void boundary_banding(benchmark::State& state) { boundary(state, physics::Limit::banding); }
void boundary_oblique(benchmark::State& state) { boundary(state, physics::Limit::oblique); }

void threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgName("threads")->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK(mode_map)->Apply(threads);
BENCHMARK(eigenvectors)->ArgName("threads")->Arg(1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(flock_structure_factors)->Apply(threads);
BENCHMARK(boundary_onset)->Apply(threads);
BENCHMARK(boundary_banding)->Apply(threads);
BENCHMARK(boundary_oblique)->Apply(threads);

}  // namespace
}  // namespace drover
