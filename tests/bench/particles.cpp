// tests/bench/particles.cpp: time of a step of bodies between plates, by sphere and by simulated second.
#include <benchmark/benchmark.h>

#include <cmath>

#include "dem/packing/packing.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {
namespace {

constexpr double default_dt = 2e-5;

Setup setup_of(double side, double beads, double rods) {
    Setup setup;
    setup.cell.lx = setup.cell.ly = side;
    setup.beads.area_fraction = beads;
    setup.rods.area_fraction = rods;
    return setup;
}

/// Times steps, neighbour lists included, of a world that has been shaken for a while.
void time_steps(benchmark::State& state, const Setup& setup, int threads_asked, double shaken) {
    Threads threads(threads_asked);
    World world(setup, pack(setup, 1), default_dt, 1, threads);
    std::int64_t step = 0;
    while (static_cast<double>(step) * default_dt < shaken) world.advance(step++);
    constexpr int batch = 250;  // one period of the plates: 5 ms
    for (auto _ : state)
        for (int i = 0; i < batch; ++i) world.advance(step++);
    const Bodies bodies = world.bodies();
    double spheres = static_cast<double>(bodies.beads.size());
    for (const Rod& rod : bodies.rods) spheres += static_cast<double>(bodies.shapes[rod.shape].at.size());
    const double steps = static_cast<double>(state.iterations()) * batch;
    state.counters["spheres"] = spheres;
    state.counters["sphere_steps_per_s"] = benchmark::Counter(spheres * steps, benchmark::Counter::kIsRate);
    state.counters["seconds_per_simulated_s"] =
        benchmark::Counter(steps * default_dt, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["overlap"] = world.worst_overlap().of_radius;
}

/// Beads alone, shaken, at area fraction .6; argument: side of the cell [mm].
void bead_gas(benchmark::State& state) {
    time_steps(state, setup_of(static_cast<double>(state.range(0)), 0.6, 0.0), static_cast<int>(state.range(1)), 0.25);
}
BENCHMARK(bead_gas)
    ->ArgNames({"mm", "threads"})
    ->Args({30, 1})
    ->Args({90, 1})
    ->Args({90, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void single_rod(benchmark::State& state) {
    Setup setup = setup_of(45.0, 0.0, 0.0);
    setup.rods.count = 1;
    time_steps(state, setup, 1, 0.25);
}
BENCHMARK(single_rod)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The paper's mixture (.60, .11): 3 100, 30 000 and 94 700 spheres.
void mixture(benchmark::State& state) {
    time_steps(state, setup_of(static_cast<double>(state.range(0)) / 100.0, 0.6, 0.11),
               static_cast<int>(state.range(1)), 0.1);
}
BENCHMARK(mixture)
    ->ArgNames({"mm_100", "threads"})
    ->ArgsProduct({{4500, 14000, 24795}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace
}  // namespace drover::dem
