// run/model_simulation.cpp: the fields of a declared model: state, stepper and recordings.
#include "drover/run/model_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "drover/measure/model_fields.hpp"
#include "drover/numerics/adaptive_stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/run/field_simulation.hpp"
#include "run/grid_run.hpp"
#include "run/sample_recording.hpp"
#include "run/start_file.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

/// The state shared by the functions of one simulation.
struct ModelWorld {
    io::Scene scene;
    model::Equations equations;
    measure::ModelSetting setting;
    numerics::AdaptiveStepper stepper;
    numerics::Transform transform;
    numerics::Spectra state;
    numerics::Fields fields;
    double time = 0.0;

    ModelWorld(const io::Scene& the_scene, Threads& threads)
        : scene(the_scene),
          equations(io::model_of(scene.declared)),
          setting(measure::make_model_setting(equations, scene.grid, io::kept_degree(scene, equations))),
          stepper({.method = scene.time.stepper,
                   .dt = scene.time.dt,
                   .tolerance = scene.time.tolerance,
                   .watches_error = false},
                  equations.system(scene.grid, threads, io::kept_degree(scene, equations)),
                  static_cast<std::uint64_t>(scene.run.seed), threads),
          transform(scene.grid, stepper.system().degree, threads),
          state(start(threads)),
          fields(scene.grid, state.count()) {}

    numerics::Spectra start(Threads& threads) const {
        if (scene.initial.kind != "file")
            return model::start_spectra(io::start_of(scene), equations, stepper.system(),
                                        static_cast<std::uint64_t>(scene.run.seed), threads);
        std::vector<FrameField> wanted;
        for (const model::StateComponent& one : setting.components) wanted.push_back({one.name, one.unit});
        numerics::Spectra spectra(scene.grid, static_cast<int>(wanted.size()));
        transform.forward(frame_of_file(scene, wanted), spectra);
        return spectra;
    }
    const std::string& name(int component) const {
        return setting.components[static_cast<std::size_t>(component)].name;
    }
};

files::Recording frames_of_model(const io::Scene& scene, const std::vector<model::StateComponent>& components) {
    files::Recording recording = frames_on(scene.grid);
    for (const model::StateComponent& one : components)
        recording.quantities.push_back({one.name, one.unit, one.meaning, {"y", "x"}});
    return recording;
}

ScheduledRecording frames_of(const std::shared_ptr<ModelWorld>& world) {
    const auto observe = [world] {
        world->transform.backward(world->state, world->fields);
        std::vector<std::span<const double>> arrays;
        for (int c = 0; c < world->fields.count(); ++c) arrays.push_back(std::as_const(world->fields)[c]);
        return arrays;
    };
    return {frames_of_model(world->scene, world->setting.components),
            io::whole_steps(world->scene, "output.frame_every", world->scene.output.frame_every), observe};
}

ScheduledRecording samples_of(const std::shared_ptr<ModelWorld>& world) {
    return sample_recording(world->scene, field_samples_group, measure::model_observables(world->setting), [world] {
        world->transform.backward(world->state, world->fields);
        return measure::ModelMoment{.setting = world->setting, .spectra = world->state, .fields = world->fields};
    });
}

void check_finite(const ModelWorld& world, std::int64_t step) {
    for (int c = 0; c < world.state.count(); ++c)
        for (const Complex value : world.state[c])
            if (!is_finite(value, world.state.size))
                fail_run(
                    "the solution became NaN or infinite at or before step {} (t = {:.6g} s): {}, dt = {}; likely "
                    "cause: the time step is too large for the products, or no term of the equations limits its "
                    "growth; the last checkpoint is good to restart from",
                    step, static_cast<double>(step) * world.scene.time.dt, world.name(c), world.scene.time.dt);
}

/// Other fields start another run: without the history of the stepper.
void accept(ModelWorld& world) {
    std::vector<std::string> names;
    for (const model::StateComponent& one : world.setting.components) names.push_back(one.name);
    require_finite(world.fields, names, world.scene.grid);
    world.transform.forward(world.fields, world.state);
    world.stepper.restore_history({});
}

std::vector<double> save(const ModelWorld& world) {
    std::vector<double> values{static_cast<double>(world.stepper.division()), world.time};
    const std::vector<double> history = world.stepper.save_history();
    values.insert(values.end(), history.begin(), history.end());
    append_numbers(world.state, values);
    return values;
}

void restore(ModelWorld& world, std::span<const double> values) {
    const std::size_t numbers = 2 * world.state.values.size();
    require(values.size() >= numbers + 2, {}, "the checkpoint holds {} numbers; this scene's state has {} or more",
            values.size(), numbers + 2);
    const double division = values[0];
    require(division >= 1.0 && division <= numerics::AdaptiveStepper::max_division && division == std::round(division),
            {},
            "the checkpoint contains {} parts of a step; expected an integer from 1 to {}; use the other checkpoint",
            division, numerics::AdaptiveStepper::max_division);
    world.stepper.set_division(static_cast<int>(division));
    world.time = values[1];
    const std::span<const double> rest = values.subspan(2);
    world.stepper.restore_history(rest.first(rest.size() - numbers));
    take_numbers(rest.last(numbers), world.state);
}

}  // namespace

Simulation make_model_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved) {
    const auto world = std::make_shared<ModelWorld>(scene, threads);
    Simulation simulation{.dt = scene.time.dt,
                          .steps = io::whole_steps(scene, "time.end", scene.time.end),
                          .recordings = {frames_of(world), samples_of(world)},
                          .advance =
                              [world](std::int64_t step) {
                                  world->stepper.advance(step, world->state);
                                  world->time = static_cast<double>(step + 1) * world->scene.time.dt;
                              },
                          .check_health = [world](std::int64_t step) { check_finite(*world, step); },
                          .save = [world] { return save(*world); },
                          .restore = [world](std::span<const double> values) { restore(*world, values); },
                          .accept = [world](std::int64_t) { accept(*world); },
                          .count = [world] { return world->stepper.count(); },
                          .step_error = {},
                          .describe =
                              [world] {
                                  const numerics::AdaptiveStepper& stepper = world->stepper;
                                  return steps_text(stepper.count(), stepper.division(), stepper.last_step(),
                                                    world->scene);
                              }};
    simulation.threads = threads.count();
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
    constexpr int halvings = 1;
    return numerics::noise_path_bytes(system, scene.time.dt, halvings) + steppers_bytes(system, scene.time, 1) +
           explicit_part + 4.0 * count * spectra + 3.0 * count * reals;
}

}  // namespace drover::run
