// tests/bench/shelf.cpp: a step of each model of models/ beside its own transforms, in one process.
#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "drover/numerics/transform.hpp"
#include "io/scene.hpp"
#include "run/fields/scene_equations.hpp"

namespace drover {
namespace {

/// The scene on 256 by 256 points of the same spacing.
io::Scene large_scene(const std::filesystem::path& file) {
    io::Scene scene = io::read_scene(file);
    constexpr int points = 256;
    scene.grid.lx *= static_cast<double>(points) / scene.grid.nx;
    scene.grid.ly *= static_cast<double>(points) / scene.grid.ny;
    scene.grid.nx = scene.grid.ny = points;
    return scene;
}

/// The references with waves of a hundredth.
numerics::Spectra start_of(const model::Equations& equations, const numerics::Grid& grid) {
    const std::vector<int>& arrays = equations.state_components();
    numerics::Spectra state(grid, static_cast<int>(arrays.size()));
    std::mt19937 random(1);
    std::normal_distribution<double> normal(0.0, 1e-2);
    for (int c = 0; c < state.count(); ++c) {
        state[c][0] = equations.reference()[static_cast<std::size_t>(arrays[static_cast<std::size_t>(c)])];
        for (std::size_t row = 0; row < 4; ++row)
            for (std::size_t column = 1; column < 4; ++column)
                state[c][row * numerics::columns(grid) + column] = numerics::Complex(normal(random), normal(random));
    }
    return state;
}

/// The transforms of a right-hand side and nothing else, products being a copy.
std::function<void()> transforms_of(const model::Integrated& what, const numerics::System& system, Threads& threads) {
    const model::TransformCount count = model::transforms_of(what);
    const auto transform = std::make_shared<numerics::Transform>(system.grid, system.degree, threads);
    const auto from = std::make_shared<numerics::Spectra>(system.grid, count.inverse),
               to = std::make_shared<numerics::Spectra>(system.grid, count.forward);
    return [=] {
        std::vector<const numerics::Complex*> sources;
        std::vector<numerics::Complex*> made;
        for (int c = 0; c < count.inverse; ++c) sources.push_back((*from)[c].data());
        for (int c = 0; c < count.forward; ++c) made.push_back((*to)[c].data());
        transform->products(sources, made, [](const numerics::Strip& strip) {
            for (std::size_t c = 0; c < strip.out.size(); ++c)
                std::copy_n(strip.in[c % strip.in.size()], strip.size, strip.out[c]);
        });
    };
}

/// Counters: a step of ETDRK2 without noise over its transforms, and with noise over that; all three in turns.
void shelf_step(benchmark::State& state, const std::filesystem::path& file) {
    using Clock = std::chrono::steady_clock;
    Threads threads(1);
    const io::Scene scene = large_scene(file);
    const model::Integrated what = run::integrated_of(scene);
    const numerics::System noisy = model::system_of(what, scene.grid, threads);
    numerics::System quiet = noisy;
    quiet.noise = {};
    quiet.product_noise = {};
    numerics::Spectra fields = start_of(what.equations, scene.grid), others = fields;
    const double dt = 1e-3 * (scene.time.dt > 0.0 ? scene.time.dt : 1.0);  // far from any limit
    const numerics::StepperTable& table = numerics::stepper_table("etdrk2");
    numerics::Stepper plain(quiet, table, dt, 1, threads), with_noise(noisy, table, dt, 1, threads);
    const std::function<void()> transforms = transforms_of(what, quiet, threads);
    std::array<double, 3> seconds{};
    std::uint64_t step = 0;
    const std::array<std::function<void()>, 3> parts{[&] { plain.step(0.0, step, fields); },
                                                     [&] { transforms(), transforms(); },
                                                     [&] { with_noise.step(0.0, step, others); }};
    for (const auto& part : parts) part();
    for (auto _ : state) {
        ++step;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            const auto begin = Clock::now();
            parts[k]();
            seconds[k] += std::chrono::duration<double>(Clock::now() - begin).count();
        }
    }
    const model::TransformCount count = model::transforms_of(what);
    state.counters["transforms"] = 2.0 * (count.inverse + count.forward);
    state.counters["step_over_transforms"] = seconds[0] / seconds[1];
    state.counters["noisy_over_step"] = seconds[2] / seconds[0];
}

const bool is_registered = [] {
    for (const auto& entry : std::filesystem::directory_iterator(DROVER_MODELS)) {
        if (entry.path().extension() != ".toml") continue;
        std::ifstream file(entry.path());  // scenes cannot be read before main()
        const std::string text(std::istreambuf_iterator<char>(file), {});
        const bool is_of_line = text.find("ny = 1,") != std::string::npos || text.find("ny = 1\n") != std::string::npos;
        if (is_of_line || text.find("equations") == std::string::npos) continue;
        benchmark::RegisterBenchmark(("shelf_step/" + entry.path().stem().string()).c_str(), shelf_step, entry.path())
            ->Iterations(200)
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
    }
    return true;
}();

}  // namespace
}  // namespace drover
