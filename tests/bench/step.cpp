// tests/bench/step.cpp: time of a noisy linear step beside the transforms of its fields, in one process.
#include <benchmark/benchmark.h>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover {
namespace {

const physics::Model model{.uniform = {.rod_density = 0.02},
                           .current = {.speed = 3.6},
                           .relaxation = {.rate = 0.2},
                           .elasticity = {.stiffness = 2.0},
                           .pressure = {.rods = 1.8},
                           .diffusion = {.rods = 0.2},
                           .noise = {.order = 0.008, .rods = 0.008}};

numerics::Grid grid_of(const benchmark::State& state) {
    const int n = static_cast<int>(state.range(0));
    return {.nx = n, .ny = n, .lx = 0.5 * n, .ly = 0.5 * n};
}

void noisy_step(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    const numerics::System system = physics::linear_system(model, grid_of(state));
    numerics::Stepper stepper(system, numerics::stepper_table("etdrk2"), 0.25, 1, threads);
    numerics::Spectra fields(system.grid, 3);
    std::uint64_t step = 0;
    for (auto _ : state) stepper.step(0.0, step++, fields);
}

void step_without_noise(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    numerics::System system = physics::linear_system(model, grid_of(state));
    system.noise = {};
    numerics::Stepper stepper(system, numerics::stepper_table("etdrk2"), 0.25, 1, threads);
    numerics::Spectra fields(system.grid, 3);
    std::uint64_t step = 0;
    for (auto _ : state) stepper.step(0.0, step++, fields);
}

/// Both ways, three fields.
void transforms(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    const numerics::Grid grid = grid_of(state);
    const numerics::Transform transform(grid, 1, threads);
    numerics::Fields fields(grid, 3);
    numerics::Spectra spectra(grid, 3);
    for (auto _ : state) {
        transform.forward(fields, spectra);
        transform.backward(spectra, fields);
    }
}

void sizes_and_threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"n", "threads"})
        ->ArgsProduct({{128, 256, 512, 1024}, {1, 2}})
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}
BENCHMARK(noisy_step)->Apply(sizes_and_threads);
BENCHMARK(step_without_noise)->Apply(sizes_and_threads);
BENCHMARK(transforms)->Apply(sizes_and_threads);

}  // namespace
}  // namespace drover
