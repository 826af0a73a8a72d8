// tests/bench/model.cpp: equations as text (model/) beside the built-in terms, evaluated in turns in one process.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <random>

#include "drover/numerics/stepper.hpp"
#include "drover/physics/evaluation_cost.hpp"
#include "model/rod_bead.hpp"
#include "physics/full_model.hpp"

namespace drover {
namespace {
using numerics::Spectra;
constexpr int pairs = 41;  // of blocks, of both equations

struct Case {
    std::string name;
    physics::Model model;
    numerics::Grid grid;
};

/// Every form with the dependences of its coefficients on densities and without, and a band on a line.
std::vector<Case> cases() {
    const numerics::Grid square{.nx = 256, .ny = 256, .lx = 64.0, .ly = 64.0};
    std::vector<Case> result;
    for (const auto& [name, model] : physics::all_forms()) {
        result.push_back({name, model, square});
        physics::Model constant = model;
        constant.drag.coefficient_terms = constant.driving.strength_terms = {};
        constant.relaxation.rate_terms = constant.relaxation.saturation_terms = {};
        constant.weathercock.strength_terms = {};
        constant.driving.cubic = constant.advection.divergence = constant.advection.gradient = 0.0;
        constant.inertia.advection = false;
        result.push_back({name + ", few terms", constant, square});
    }
    const physics::Model band{.uniform = {.rod_density = 1.02},
                              .current = {.speed = 1.0},
                              .relaxation = {.rate = 1.0, .rate_terms = {"-1 sigma"}, .saturation = 1.0},
                              .elasticity = {.stiffness = 0.5, .splay = 0.5},
                              .advection = {.strength = 1.0},
                              .pressure = {.rods = 1.0}};
    result.push_back({"band on a line", band, {.nx = 4096, .ny = 1, .lx = 1024.0, .ly = 1.0}});
    return result;
}

/// Waves of many lengths about the uniform state.
Spectra random_state(const physics::Model& model, const numerics::Grid& grid) {
    const physics::Form form = physics::form(model);
    const int components = numerics::components(physics::linear_system(model, grid).layout);
    Spectra state(grid, components);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < components; ++c)
        for (std::size_t j = 0; j < static_cast<std::size_t>(std::min(grid.ny, 10)); ++j)
            for (std::size_t i = 1; i < 10; ++i)
                state[c][j * width + i] = 0.003 * numerics::Complex(normal(random), normal(random));
    if (form.bead_density >= 0) state[form.bead_density][0] = model.uniform.bead_density;
    if (form.rod_density >= 0) state[form.rod_density][0] = model.uniform.rod_density;
    return state;
}

/// Of this thread: other processes do not count.
double core_seconds() {
    std::timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}
template <class Work>
double seconds_of(int repetitions, Work work) {
    const double begin = core_seconds();
    for (int i = 0; i < repetitions; ++i) work();
    return core_seconds() - begin;
}

/// Adds the median of the ratios of text to built-in terms, their quartiles, and the least times of one call.
template <class Text, class BuiltIn>
void compare(benchmark::State& state, const std::string& name, Text text_form, BuiltIn built_in) {
    constexpr double block = 0.01;
    built_in();
    text_form();
    const int repetitions = std::max(1, static_cast<int>(block / std::max(1e-6, seconds_of(1, built_in))));
    std::vector<double> ratios, texts, built;
    for (int i = 0; i < pairs; ++i) {
        const bool text_first = i % 2 == 0;
        if (text_first) texts.push_back(seconds_of(repetitions, text_form));
        built.push_back(seconds_of(repetitions, built_in));
        if (!text_first) texts.push_back(seconds_of(repetitions, text_form));
        ratios.push_back(texts.back() / built.back());
    }
    std::sort(ratios.begin(), ratios.end());
    state.counters[name] = ratios[pairs / 2];
    state.counters[name + "_low"] = ratios[pairs / 4];
    state.counters[name + "_high"] = ratios[pairs - 1 - pairs / 4];
    state.counters[name + "_ms"] = 1e3 * *std::min_element(built.begin(), built.end()) / repetitions;
    state.counters[name + "_text_ms"] = 1e3 * *std::min_element(texts.begin(), texts.end()) / repetitions;
}

void text_beside_built_in(benchmark::State& state, const Case& one) {
    Threads threads(1);
    const physics::Equations terms(one.model);
    const physics::WholeRate whole(terms, one.grid, physics::reference(one.model.uniform), threads);
    const model::Equations equations(model::rod_bead(one.model));
    const numerics::System text_system = equations.system(one.grid, threads);
    const Spectra fields = random_state(one.model, one.grid);
    Spectra rate(one.grid, fields.count()), text_rate = rate;
    for (auto _ : state) {
        compare(
            state, "evaluation", [&] { text_system.nonlinear(0.0, fields, text_rate); },
            [&] { whole.system.nonlinear(0.0, fields, rate); });
        const double dt = 1e-9;  // the fields stay as they are
        numerics::Stepper stepper(whole.system, numerics::stepper_table("etdrk2"), dt, 1, threads);
        numerics::Stepper text_stepper(text_system, numerics::stepper_table("etdrk2"), dt, 1, threads);
        Spectra stepped = fields, text_stepped = fields;
        std::uint64_t step = 0, text_step = 0;
        compare(
            state, "step", [&] { text_stepper.step(0.0, text_step++, text_stepped); },
            [&] { stepper.step(0.0, step++, stepped); });
    }
    const physics::TransformCount count = physics::transform_count(terms);
    const model::TransformCount text_count = equations.transforms();
    state.counters["transforms"] = count.inverse + count.forward;
    state.counters["text_transforms"] = text_count.inverse + text_count.forward;
}

const bool are_registered = [] {
    for (const Case& one : cases())
        benchmark::RegisterBenchmark(("text/" + one.name).c_str(), [one](benchmark::State& state) {
            text_beside_built_in(state, one);
        })->Iterations(1);
    return true;
}();

}  // namespace
}  // namespace drover
