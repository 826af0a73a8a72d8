// tests/bench/step.cpp: time of a step beside that of its own transforms, in one process.
#include <benchmark/benchmark.h>

#include <chrono>
#include <filesystem>
#include <random>

#include "drover/base/text.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "files/archive.hpp"
#include "physics/initial_spectra.hpp"
#include "physics/whole_rate.hpp"

namespace drover {
namespace {

/// Rods alone, linear.
const physics::Model isotropic{.uniform = {.rod_density = 0.02},
                               .current = {.speed = 3.6},
                               .relaxation = {.rate = 0.2},
                               .elasticity = {.stiffness = 2.0},
                               .pressure = {.rods = 1.8},
                               .diffusion = {.rods = 0.2},
                               .noise = {.order = 0.008, .rods = 0.008}};

/// A noisy flock of rods in beads: every term with constant coefficients, J = u p.
const physics::Model flock{.fields = {.bead_density = true, .rod_density = true, .bead_velocity = "dynamic"},
                           .uniform = {.rod_density = 1.0, .bead_density = 1.0},
                           .current = {.speed = 1.0},
                           .drag = {.coefficient = 10.0},
                           .viscosity = {.shear = 5.0},
                           .driving = {.strength = 10.0},
                           .stiffness = {.beads = 20.0, .rods = 1.0},
                           .relaxation = {.rate = 0.5, .saturation = 1.0},
                           .elasticity = {.stiffness = 1.0},
                           .weathercock = {.strength = 1.0},
                           .advection = {.strength = 0.3},
                           .pressure = {.beads = 0.5, .rods = 0.5},
                           .noise = {.order = 0.001}};

/// The equations of models/band.toml, by built-in terms.
const physics::Model band{.uniform = {.rod_density = 1.02},
                          .current = {.speed = 1.0},
                          .relaxation = {.rate = 1.0, .rate_terms = {"-1 sigma"}, .saturation = 1.0},
                          .elasticity = {.stiffness = 0.5, .splay = 0.5},
                          .advection = {.strength = 1.0},
                          .pressure = {.rods = 1.0}};

/// The same equations as text.
physics::Model band_as_text() {
    physics::Model model{.uniform = band.uniform, .relaxation = {.rate = 0.0}};
    const auto add = [&](const std::string& of, const std::vector<std::string>& value) {
        model.text_terms.push_back({.of = of, .value = {}, .flux = {}, .parameters = {}, .where = {}});
        for (const std::string& one : value) model.text_terms.back().value.push_back({one, {}});
    };
    add("rod_density", {"-div order"});
    add("order", {"-(1 - rod_density + order_x^2 + order_y^2) order_x - d_x rod_density",
                  "-(1 - rod_density + order_x^2 + order_y^2) order_y - d_y rod_density"});
    add("order", {"0.5 lap order_x + 0.5 grad_div_x order", "0.5 lap order_y + 0.5 grad_div_y order"});
    add("order", {"-order_x d_x order_x - order_y d_y order_x", "-order_x d_x order_y - order_y d_y order_y"});
    return model;
}

numerics::Grid grid_of(const benchmark::State& state) {
    const int n = static_cast<int>(state.range(0));
    return {.nx = n, .ny = n, .lx = 0.5 * n, .ly = 0.5 * n};
}

/// A system with its right-hand side, if it has one.
numerics::System system_of(const physics::Model& model, const numerics::Grid& grid, Threads& threads) {
    return model::system_of(physics::integrated(model), grid, threads);
}

/// Of a step of ETDRK2: two right-hand sides.
double transforms_of(const physics::Model& model) {
    const model::TransformCount count = model::transforms_of(physics::integrated(model));
    return 2.0 * (count.inverse + count.forward);
}

void time_steps(benchmark::State& state, const physics::Model& model, bool noisy) {
    Threads threads(static_cast<int>(state.range(1)));
    numerics::System system = system_of(model, grid_of(state), threads);
    if (!noisy) system.noise = {};
    numerics::Stepper stepper(system, numerics::stepper_table("etdrk2"), 0.02, 1, threads);
    numerics::Spectra fields =
        physics::initial_spectra({.kind = model::StartKind::random, .amplitude = 0.01}, model, system, 1, threads);
    std::uint64_t step = 0;
    stepper.step(0.0, step++, fields);  // prepares the noise path
    for (auto _ : state) stepper.step(0.0, step++, fields);
    state.counters["transforms"] = transforms_of(model);
}

void linear_step(benchmark::State& state) { time_steps(state, isotropic, true); }
void flock_step(benchmark::State& state) { time_steps(state, flock, true); }
void flock_step_without_noise(benchmark::State& state) { time_steps(state, flock, false); }

void band_step(benchmark::State& state) { time_steps(state, band, false); }
void band_step_as_text(benchmark::State& state) { time_steps(state, band_as_text(), false); }

/// Steps of an evolution of the flock that estimates the error of its steps, beside one that does not, in turns.  The
/// counter `watch` is the ratio of their times.
void flock_watch(benchmark::State& state) {
    using Clock = std::chrono::steady_clock;
    Threads threads(static_cast<int>(state.range(1)));
    const auto evolution = [&](bool watches) {
        return model::FieldEvolution(physics::integrated(flock), grid_of(state),
                                     {.method = "etdrk2", .dt = 0.02, .tolerance = 0.0, .watches_error = watches}, 1,
                                     threads);
    };
    std::array<model::FieldEvolution, 2> evolutions{evolution(false), evolution(true)};
    std::array<numerics::Spectra, 2> fields;
    for (std::size_t k : {0, 1}) {
        fields[k] = physics::initial_spectra({.kind = model::StartKind::random, .amplitude = 0.01}, flock,
                                             evolutions[k].linear(), 1, threads);
        evolutions[k].start(fields[k]);
    }
    std::array<double, 2> seconds{};
    std::int64_t step = 0;
    constexpr std::int64_t turn = 50, steps = 2000;
    for (auto _ : state)
        for (const std::int64_t end = step + steps; step < end; step += turn)
            for (std::size_t k : {0, 1}) {
                const auto begin = Clock::now();
                for (std::int64_t n = step; n < step + turn; ++n) evolutions[k].advance(n, fields[k]);
                seconds[k] += std::chrono::duration<double>(Clock::now() - begin).count();
            }
    state.counters["watch"] = seconds[1] / seconds[0];
}

/// The transforms that a step of the flock makes, and nothing else: two right-hand sides, products being a copy.
void flock_transforms(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    const model::TransformCount count = model::transforms_of(physics::integrated(flock));
    const numerics::System system = physics::linear_system(flock, grid_of(state));
    const numerics::Transform transform(system.grid, system.degree, threads);
    numerics::Spectra from(system.grid, count.inverse), to(system.grid, count.forward);
    std::vector<const numerics::Complex*> sources;
    std::vector<numerics::Complex*> made;
    for (int c = 0; c < count.inverse; ++c) sources.push_back(from[c].data());
    for (int c = 0; c < count.forward; ++c) made.push_back(to[c].data());
    for (auto _ : state)
        for (int stage = 0; stage < 2; ++stage)
            transform.products(sources, made, [](const numerics::Strip& strip) {
                for (std::size_t c = 0; c < strip.out.size(); ++c) std::copy_n(strip.in[c], strip.size, strip.out[c]);
            });
    state.counters["transforms"] = transforms_of(flock);
}

/// Everything before the second step of a run of the flock: the blocks of each |q|, the initial state, the first step
/// and its repetition in halves.
void flock_start(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    for (auto _ : state) {
        model::FieldEvolution evolution(physics::integrated(flock), grid_of(state), {.method = "etdrk2", .dt = 0.02}, 1,
                                        threads);
        numerics::Spectra fields = physics::initial_spectra({.kind = model::StartKind::random, .amplitude = 0.01},
                                                            flock, evolution.linear(), 1, threads);
        evolution.start(fields);
        evolution.advance(0, fields);
    }
}

/// A frame of the flock: transforms to the grid and compression, without the commit.
void flock_frame(benchmark::State& state) {
    Threads threads(static_cast<int>(state.range(1)));
    const numerics::System system = physics::linear_system(flock, grid_of(state));
    const numerics::Transform transform(system.grid, system.degree, threads);
    const int count = numerics::components(system.layout);
    const numerics::Spectra spectra =
        physics::initial_spectra({.kind = model::StartKind::random, .amplitude = 0.01}, flock, system, 1, threads);
    numerics::Fields fields(system.grid, count);
    const auto axis = [](const char* name, int points) {
        return files::Axis{name, "mm", name, std::vector<double>(static_cast<std::size_t>(points))};
    };
    files::Recording frames{.group = "/",
                            .axes = {axis("y", system.grid.ny), axis("x", system.grid.nx)},
                            .quantities = {},
                            .rows_per_chunk = 1};
    for (int c = 0; c < count; ++c) frames.quantities.push_back({text("field_{}", c), "1", "a field", {"y", "x"}});
    const auto file = std::filesystem::temp_directory_path() / text("drover_bench_{}.h5", std::random_device{}());
    files::Archive archive = files::Archive::create(file, {frames}, {}, true);
    std::vector<std::span<const double>> arrays;
    for (int c = 0; c < count; ++c) arrays.push_back(std::as_const(fields)[c]);
    double time = 0.0;
    for (auto _ : state) {
        transform.backward(spectra, fields);
        archive.append(0, time, arrays);
        time += 1.0;
    }
    std::filesystem::remove(file);
}

void sizes_and_threads(benchmark::internal::Benchmark* benchmark) {
    benchmark->ArgNames({"n", "threads"})
        ->ArgsProduct({{128, 256, 512, 1024}, {1, 2}})
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}
BENCHMARK(flock_step)->Apply(sizes_and_threads);
BENCHMARK(flock_step_without_noise)->Apply(sizes_and_threads);
BENCHMARK(band_step)->Apply(sizes_and_threads);
BENCHMARK(band_step_as_text)->Apply(sizes_and_threads);
BENCHMARK(flock_transforms)->Apply(sizes_and_threads);
BENCHMARK(flock_start)->ArgNames({"n", "threads"})->Args({256, 1})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(flock_frame)
    ->ArgNames({"n", "threads"})
    ->Args({256, 1})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(20)
    ->UseRealTime();
BENCHMARK(flock_watch)
    ->ArgNames({"n", "threads"})
    ->ArgsProduct({{128, 256}, {1}})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->UseRealTime();
BENCHMARK(linear_step)->Apply(sizes_and_threads);

}  // namespace
}  // namespace drover
