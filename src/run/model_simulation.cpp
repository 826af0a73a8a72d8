// run/model_simulation.cpp: the fields of a declared model: state, stepper and recordings.
#include "drover/run/model_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "drover/measure/model_fields.hpp"
#include "drover/numerics/block.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/numerics/watched_stepper.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/warnings.hpp"
#include "numerics/coarse_error.hpp"
#include "run/grid_run.hpp"
#include "run/growing_waves.hpp"
#include "run/sample_recording.hpp"
#include "run/start_file.hpp"
#include "run/step_bias.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

/// A quarter above the largest wavenumber at which the state of the references is unstable: patterns have such waves,
/// and errors of a pattern that is not resolved would seem to grow without limit.
double shortest_of_patterns(const model::Equations& equations, const numerics::Grid& grid, int degree) {
    const numerics::System system = equations.linear_system(grid, degree);
    const auto cut = [&](int points, double length) {
        return points > 1 ? 2.0 * std::numbers::pi / length * points / (system.degree + 1) : 0.0;
    };
    const double most = std::hypot(cut(grid.nx, grid.lx), cut(grid.ny, grid.ly));
    return 1.25 * largest_growing(system, most);
}

/// Whether the steps make an error that the run estimates.
bool watches_error(const io::Scene& scene, const model::Equations& equations) {
    return scene.time.max_error > 0.0 && equations.has_explicit_part();
}

numerics::ErrorEquations watched(const model::Equations& equations, const measure::ModelSetting& setting) {
    numerics::ErrorEquations result{.fields = {},
                                    .on_grid =
                                        [equations, degree = setting.grid.degree](const numerics::Grid& grid,
                                                                                  bool keeps_all, Threads& threads) {
                                            return equations.system(grid, threads, keeps_all ? 1 : degree);
                                        },
                                    .degree = setting.grid.degree,
                                    .noisy = equations.has_noise(),
                                    .shortest =
                                        shortest_of_patterns(equations, setting.grid.grid, setting.grid.degree)};
    int spin = 0;  // of the order: the first field that turns
    for (const measure::MeasuredField& field : setting.fields) {
        result.fields.push_back({field.first, field.spin == 0 ? 1 : 2, field.name});
        if (spin == 0) spin = field.spin;
        if (field.spin != 0 && field.spin == spin) result.turning.push_back(field.first);
    }
    return result;
}

/// The state shared by the functions of one simulation.
struct ModelWorld {
    io::Scene scene;
    model::Equations equations;
    measure::ModelSetting setting;
    numerics::WatchedStepper stepper;
    numerics::Transform transform;
    numerics::Spectra state;
    numerics::Fields fields;
    double time = 0.0;
    std::vector<double> fresh;       // saved by the stepper before any step
    std::vector<double> tails;       // of each component at the last check
    std::shared_ptr<StepBias> bias;  // nullptr: not measured

    ModelWorld(const io::Scene& the_scene, Threads& threads)
        : scene(the_scene),
          equations(io::model_of(scene.declared)),
          setting(measure::make_model_setting(equations, scene.grid, io::kept_degree(scene, equations),
                                              scene.time.max_error > 0.0)),
          stepper({.method = scene.time.stepper, .dt = scene.time.dt, .tolerance = scene.time.tolerance},
                  equations.system(scene.grid, threads, setting.grid.degree),
                  static_cast<std::uint64_t>(scene.run.seed), threads,
                  watches_error(scene, equations) ? std::optional(watched(equations, setting)) : std::nullopt),
          transform(scene.grid, system().degree, threads),
          state(start(threads)),
          fields(scene.grid, state.count()),
          fresh(stepper.save()),
          tails(static_cast<std::size_t>(state.count())) {
        if (why_no_step_bias(scene).empty() && equations.has_explicit_part())
            bias = std::make_shared<StepBias>(scene, biased(threads));
    }

    const numerics::System& system() const { return stepper.stepper().system(); }
    BiasedRun biased(Threads& threads) const;  // refers to this

    numerics::Spectra start(Threads& threads) const {
        if (scene.initial.kind != "file")
            return model::start_spectra(io::start_of(scene), equations, system(),
                                        static_cast<std::uint64_t>(scene.run.seed), threads);
        std::vector<FrameField> wanted;
        for (const model::StateComponent& one : setting.components) wanted.push_back({one.name, one.unit});
        numerics::Spectra spectra(scene.grid, static_cast<int>(wanted.size()));
        transform.forward(frame_of_file(scene, wanted, system().degree), spectra);
        model::remove_divergence(equations, scene.grid, spectra);
        return spectra;
    }
    const std::string& name(int component) const {
        return setting.components[static_cast<std::size_t>(component)].name;
    }
};

BiasedRun ModelWorld::biased(Threads& threads) const {
    struct Observer {
        measure::ModelSetting setting;
        numerics::Transform transform;
        numerics::Fields fields;
        measure::Observables<measure::ModelMoment> rows;

        Observer(const measure::ModelSetting& of_run, int count, Threads& threads)
            : setting(of_run),
              transform(of_run.grid.grid, of_run.grid.degree, threads),
              fields(of_run.grid.grid, count) {
            setting.grid.watches_error = false;
            rows = measure::model_observables(setting);
        }
    };
    const auto observer = std::make_shared<Observer>(setting, state.count(), threads);
    const auto make_twin = [this, &threads] {
        const auto twin =
            std::make_shared<numerics::WatchedStepper>(control_of_twin(scene.time),
                                                       equations.system(scene.grid, threads, setting.grid.degree),
                                                       static_cast<std::uint64_t>(scene.run.seed), threads,
                                                       std::nullopt);
        return twin_of(twin, [twin] { twin->begin_anew(); });
    };
    return {.values = count_values(observer->rows),
            .components = state.count(),
            .observe =
                [observer](double, const numerics::Spectra& at) {
                    observer->transform.backward(at, observer->fields);
                    return values_of(observer->rows, measure::ModelMoment{.setting = observer->setting,
                                                                          .spectra = at,
                                                                          .fields = observer->fields});
                },
            .known_error = [this] { return stepper.known_error(); },
            .make_twin = make_twin};
}

ScheduledRecording frames_of(const std::shared_ptr<ModelWorld>& world) {
    const auto observe = [world] {
        world->transform.backward(world->state, world->fields);
        std::vector<std::span<const double>> arrays;
        for (int c = 0; c < world->fields.count(); ++c) arrays.push_back(std::as_const(world->fields)[c]);
        return arrays;
    };
    return {model_frame_recording(world->scene, world->equations),
            io::whole_steps(world->scene, "output.frame_every", world->scene.output.frame_every), observe};
}

ScheduledRecording samples_of(const std::shared_ptr<ModelWorld>& world) {
    return sample_recording(world->scene, field_samples_group, measure::model_observables(world->setting), [world] {
        world->transform.backward(world->state, world->fields);
        return measure::ModelMoment{.setting = world->setting,
                                    .spectra = world->state,
                                    .fields = world->fields,
                                    .step_error = world->stepper.step_error().error};
    });
}

/// The part of the variance of a component that is in the shortest waves of the grid.
double tail_of(const ModelWorld& world, int component) {
    const numerics::Grid& grid = world.scene.grid;
    double tail = 0.0, all = 0.0;
    for (std::size_t row = 0, m = 0; row < static_cast<std::size_t>(grid.ny); ++row)
        for (std::size_t column = 0; column < numerics::columns(grid); ++column, ++m) {
            if (m == 0) continue;
            const double power = numerics::mode_weight(grid, column) * std::norm(world.state[component][m]);
            all += power;
            if (measure::is_in_tail(grid, world.setting.grid.degree, column, row)) tail += power;
        }
    return all > 0.0 ? tail / all : 0.0;
}

void check_finite(ModelWorld& world, std::int64_t step) {
    for (int c = 0; c < world.state.count(); ++c) {
        if (std::any_of(world.state[c].begin(), world.state[c].end(),
                        [&](Complex value) { return !is_finite(value, world.state.size); })) {
            const double dt = world.scene.time.dt, tail = world.tails[static_cast<std::size_t>(c)];
            fail_run(
                "the solution became NaN or infinite at or before step {} (t = {:.6g} s): {}, dt = {}, with {:.2g} of "
                "its variance in the shortest waves of the grid before; likely cause: the time step is too long for "
                "the products, {}no term of the equations limits its growth: choose time.dt = {}{}; the last "
                "checkpoint "
                "is good to restart from",
                step, static_cast<double>(step) * dt, world.name(c), dt, tail,
                tail > max_spectral_tail ? "the grid is too coarse, or " : "or ", 0.5 * dt,
                tail > max_spectral_tail ? text(", or {}", grid_keys(world.scene.grid, 2)) : "");
        }
    }
    for (int c = 0; c < world.state.count(); ++c) world.tails[static_cast<std::size_t>(c)] = tail_of(world, c);
}

/// Other fields start another run: without the history of the stepper.
void accept(ModelWorld& world) {
    std::vector<std::string> names;
    for (const model::StateComponent& one : world.setting.components) names.push_back(one.name);
    require_finite(world.fields, names, world.scene.grid);
    world.transform.forward(world.fields, world.state);
    model::remove_divergence(world.equations, world.scene.grid, world.state);
    world.stepper.restore(world.fresh);
}

std::vector<double> save(const ModelWorld& world) {
    return numbers_of_run(world.stepper.save(), world.time, world.state,
                          world.bias ? world.bias->save() : std::vector<double>{});
}

void restore(ModelWorld& world, std::span<const double> all) {
    const SavedRun saved = saved_run(all, 2 * world.state.values.size());
    world.stepper.restore(saved.stepper);
    world.time = saved.time;
    take_numbers(saved.state, world.state);
    if (world.bias) world.bias->restore(saved.bias);
}

}  // namespace

files::Recording model_frame_recording(const io::Scene& scene, const model::Equations& equations) {
    files::Recording recording = frames_on(scene.grid);
    for (const model::StateComponent& one : model::components_of_state(equations))
        recording.quantities.push_back({one.name, one.unit, one.meaning, {"y", "x"}});
    return recording;
}

numerics::Spectra initial_model_fields(const io::Scene& scene, Threads& threads) {
    return ModelWorld(start_alone(scene), threads).state;
}

Simulation make_model_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved) {
    const auto world = std::make_shared<ModelWorld>(scene, threads);
    Simulation simulation{.dt = scene.time.dt,
                          .steps = io::whole_steps(scene, "time.end", scene.time.end),
                          .recordings = {frames_of(world)},
                          .advance =
                              [world](std::int64_t step) {
                                  world->stepper.advance(step, world->state);
                                  world->stepper.watch(step, world->state);
                                  if (world->bias) world->bias->advance(step + 1, world->state);
                                  world->time = static_cast<double>(step + 1) * world->scene.time.dt;
                              },
                          .check_health =
                              [world](std::int64_t step) {
                                  check_chosen_step(world->scene.time, world->stepper.step_error(), step);
                                  check_finite(*world, step);
                              },
                          .save = [world] { return save(*world); },
                          .restore = [world](std::span<const double> values) { restore(*world, values); },
                          .accept = [world](std::int64_t) { accept(*world); },
                          .count = [world] { return world->stepper.stepper().count(); },
                          .step_error = [world] { return world->stepper.step_error().error; },
                          .describe = [world] { return steps_text(world->stepper.stepper(), world->scene); }};
    if (world->bias) simulation.recordings.push_back(StepBias::recording(world->bias, world->state));
    simulation.recordings.push_back(samples_of(world));
    simulation.threads = threads.count();
    blame_chosen_step(scene.time, simulation);
    if (!saved.empty()) simulation.restore(saved);
    return simulation;
}

double model_disk_bytes(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    const auto components = static_cast<double>(equations.state_components().size());
    const double frame = static_cast<double>(numerics::points(scene.grid)) * components;
    const double shells = 0.5 * (scene.grid.ny == 1 ? scene.grid.nx : std::min(scene.grid.nx, scene.grid.ny));
    return recorded_bytes(scene, frame, components * (8.0 + shells * (3.0 + 2.0 * measure::direction_sectors)) + 64.0);
}

double model_simulation_bytes(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    Threads one(1);
    const int degree = io::kept_degree(scene, equations);
    // Only sizes are read: the system of a small grid has the same layout.
    numerics::System system =
        equations.system({.nx = 4, .ny = scene.grid.ny == 1 ? 1 : 4, .lx = scene.grid.lx, .ly = scene.grid.ly}, one,
                         degree);
    system.grid = scene.grid;
    const double spectra = static_cast<double>(numerics::modes(scene.grid)) * sizeof(Complex);
    const double reals = static_cast<double>(numerics::points(scene.grid)) * sizeof(double);
    const int count = numerics::components(system.layout);
    const model::TransformCount transforms = equations.transforms();
    const double explicit_part = spectra * (2.0 * transforms.inverse + 2.0 * transforms.forward);
    constexpr int halvings = 1;  // of the steps that are repeated to measure their error
    const bool has_twin = why_no_step_bias(scene).empty() && equations.has_noise() && equations.has_explicit_part();
    double of_error = 0.0;
    if (watches_error(scene, equations)) {
        const double shortest = shortest_of_patterns(equations, scene.grid, system.degree);
        const numerics::Grid coarse =
            numerics::coarse_grid(scene.grid, equations.has_noise() ? 1 : system.degree, shortest);
        constexpr double states = 20.0;  // of the estimate and of the steps of the error
        of_error = static_cast<double>(numerics::points(coarse)) / static_cast<double>(numerics::points(scene.grid)) *
                   (explicit_part + states * count * spectra);
    }
    return numerics::noise_path_bytes(system, scene.time.dt, halvings) + steppers_bytes(system, scene.time, 2) +
           (has_twin ? 2.0 : 1.0) * explicit_part + (has_twin ? twin_stepper_bytes(system, scene.time) : 0.0) +
           of_error + 4.0 * count * spectra + 3.0 * count * reals;
}

}  // namespace drover::run
