// run/field_simulation.cpp: a simulation of fields: state, stepper and recordings.
#include "drover/run/field_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "drover/measure/fields.hpp"
#include "drover/numerics/time_method.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/energy.hpp"
#include "drover/physics/field_evolution.hpp"
#include "run/field_health.hpp"
#include "run/field_moment.hpp"
#include "run/grid_run.hpp"
#include "run/sample_recording.hpp"
#include "run/start_file.hpp"
#include "run/step_bias.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

/// The state shared by the functions of one simulation.
struct World {
    io::Scene scene;
    physics::Form form;
    physics::FieldEvolution evolution;
    numerics::Transform transform;
    numerics::Spectra state;
    FieldHealth health;
    FieldsOnGrid on_grid;
    std::optional<physics::EnergyMeter> energy;
    double time = 0.0;
    std::vector<double> fresh;  // saved by the evolution before any step
    measure::FieldSetting setting;
    std::shared_ptr<StepBias> bias;  // nullptr: not measured

    World(const io::Scene& the_scene, Threads& threads);
    BiasedRun biased(Threads& threads) const;  // refers to this
    void transform_to_grid() { to_grid(evolution, transform, time, state, on_grid); }
};

numerics::Spectra spectra_of_file(const io::Scene& scene, const World& world) {
    numerics::Spectra state(scene.grid, numerics::components(world.evolution.system().layout));
    std::vector<FrameField> fields;
    for (const physics::Component& one : physics::component_names(world.form)) fields.push_back({one.name, one.unit});
    world.transform.forward(frame_of_file(scene, fields, world.evolution.system().degree), state);
    return state;
}

World::World(const io::Scene& the_scene, Threads& threads)
    : scene(the_scene),
      form(physics::form(scene.model)),
      evolution(scene.model, scene.grid, scene.dealiasing,
                {.method = scene.time.stepper,
                 .dt = scene.time.dt,
                 .tolerance = scene.time.tolerance,
                 .watches_error = scene.time.max_error > 0.0},
                static_cast<std::uint64_t>(scene.run.seed), threads),
      transform(scene.grid, evolution.system().degree, threads) {
    on_grid.fields = numerics::Fields(scene.grid, numerics::components(evolution.system().layout));
    const numerics::System& system = evolution.system();
    if (scene.output.powers) energy.emplace(evolution.equations(), scene.grid, scene.dealiasing, threads);
    setting = measure::make_field_setting(scene.grid, form, system.degree);
    if (energy) setting.terms = energy->terms();
    setting.watches_error = scene.time.max_error > 0.0;
    state = scene.initial.kind == "file"
                ? spectra_of_file(scene, *this)
                : physics::initial_spectra(scene.initial, scene.model, system,
                                           static_cast<std::uint64_t>(scene.run.seed), threads);
    health = make_field_health(evolution, scene, state);
    evolution.start(state);
    fresh = evolution.save();
    if (why_no_step_bias(scene).empty() && physics::is_nonlinear(evolution.equations()))
        bias = std::make_shared<StepBias>(scene, biased(threads));
}

BiasedRun World::biased(Threads& threads) const {
    struct Observer {
        measure::FieldSetting setting;
        numerics::Transform transform;
        measure::Observables<measure::FieldMoment> rows;
        FieldsOnGrid on_grid = {};

        Observer(const measure::FieldSetting& of_run, const numerics::Grid& grid, Threads& threads)
            : setting(of_run), transform(grid, of_run.degree, threads) {
            setting.terms.reset();
            setting.watches_error = false;
            rows = measure::field_observables(setting);
        }
    };
    const auto observer = std::make_shared<Observer>(setting, scene.grid, threads);
    const auto make_twin = [this, &threads] {
        const auto twin =
            std::make_shared<physics::FieldEvolution>(scene.model, scene.grid, scene.dealiasing,
                                                      control_of_twin(scene.time),
                                                      static_cast<std::uint64_t>(scene.run.seed), threads);
        return twin_of(twin, [this, twin] { twin->follow(evolution); });
    };
    return {.values = count_values(observer->rows),
            .components = numerics::components(evolution.system().layout),
            .observe =
                [this, observer](double t, const numerics::Spectra& at) {
                    to_grid(evolution, observer->transform, t, at, observer->on_grid);
                    return values_of(observer->rows, moment_of(observer->setting, at, observer->on_grid));
                },
            .known_error = [this] { return evolution.known_error(); },
            .make_twin = make_twin};
}

}  // namespace

files::Recording frame_recording(const io::Scene& scene) {
    const physics::Form form = physics::form(scene.model);
    files::Recording recording = frames_on(scene.grid);
    for (const physics::Component& component : physics::component_names(form))
        recording.quantities.push_back({component.name, component.unit, component.meaning, {"y", "x"}});
    if (form.velocity == physics::Velocity::slaved)
        for (const char* axis : {"x", "y"})
            recording.quantities.push_back(
                {text("bead_velocity_{}", axis),
                 "mm s-1",
                 text("velocity of the beads along {}, in balance with the forces on them", axis),
                 {"y", "x"}});
    return recording;
}

numerics::Spectra initial_fields(const io::Scene& scene, Threads& threads) {
    return World(start_alone(scene), threads).state;
}

int choose_threads(const io::Scene& scene) {
    if (scene.run.threads > 0) return scene.run.threads;
    // With less work per thread, waking a thread costs more than it saves.
    constexpr std::size_t points_per_thread = 16384;
    const auto useful = static_cast<int>(std::min<std::size_t>(numerics::points(scene.grid) / points_per_thread, 64));
    return std::clamp(useful, 1, usable_cores());
}

std::string field_size(const io::Scene& scene) { return text("{} by {} points", scene.grid.nx, scene.grid.ny); }

double field_disk_bytes(const io::Scene& scene) {
    const double frame = static_cast<double>(numerics::points(scene.grid)) *
                         numerics::components(physics::layout(physics::form(scene.model)));
    const double shells = 0.5 * (scene.grid.ny == 1 ? scene.grid.nx : std::min(scene.grid.nx, scene.grid.ny));
    return recorded_bytes(scene, frame, 16.0 + shells * (4.0 + 2.0 * measure::direction_sectors) + 32.0);
}

TimedScene timed_fields(const io::Scene& scene) {
    constexpr double max_points = 256.0 * 256.0;
    const auto work = [](const numerics::Grid& grid) {
        const auto points = static_cast<double>(numerics::points(grid));
        return points * std::log2(points);
    };
    io::Scene timed = scene;
    if (timed.initial.kind != "formula") timed.initial = {};
    while (static_cast<double>(numerics::points(timed.grid)) > max_points && timed.grid.nx % 4 == 0 &&
           timed.grid.ny % 4 == 0 && std::min(timed.grid.nx, timed.grid.ny) > 8) {
        timed.grid.nx /= 2;
        timed.grid.ny /= 2;
    }
    return {timed, work(scene.grid) / work(timed.grid)};
}

namespace {
double twin_bytes(const io::Scene& scene, const physics::Equations& equations) {
    if (!why_no_step_bias(scene).empty() || !io::has_noise(scene) || !physics::is_nonlinear(equations)) return 0.0;
    numerics::System system =
        physics::linear_system(equations, scene.grid, physics::reference(scene.model.uniform), scene.dealiasing);
    system.nonlinear = [](double, const auto&, auto&) {};
    return twin_stepper_bytes(system, scene.time) +
           physics::right_hand_side_bytes(equations, scene.grid, system.degree);
}
}  // namespace

double field_simulation_bytes(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    numerics::System system =
        physics::linear_system(equations, scene.grid, physics::reference(scene.model.uniform), scene.dealiasing);
    if (physics::is_nonlinear(equations)) system.nonlinear = [](double, const auto&, auto&) {};
    const double spectra = static_cast<double>(numerics::modes(scene.grid)) * sizeof(Complex);
    const double reals = static_cast<double>(numerics::points(scene.grid)) * sizeof(double);
    const int count = numerics::components(system.layout);
    // The state, the last two healthy ones, a copy for the checkpoint and its file; fields, and a frame of them with
    // its compressed bytes; scratch; shells, sectors and powers.
    constexpr int halvings = 1;  // of the steps that are repeated to measure their error
    return numerics::noise_path_bytes(system, scene.time.dt, halvings) + steppers_bytes(system, scene.time, 2) +
           2.0 * physics::right_hand_side_bytes(equations, scene.grid, system.degree) + twin_bytes(scene, equations) +
           (5.0 * count + count) * spectra + 3.0 * count * reals + 3.0 * reals;
}

namespace {
ScheduledRecording frames_of(const std::shared_ptr<World>& world) {
    const io::Scene& scene = world->scene;
    const auto observe = [world] {
        world->transform_to_grid();
        std::vector<std::span<const double>> arrays;
        for (const numerics::Fields* fields :
             {&std::as_const(world->on_grid.fields), &std::as_const(world->on_grid.slaved)})
            for (int c = 0; c < fields->count(); ++c) arrays.push_back((*fields)[c]);
        return arrays;
    };
    return {frame_recording(world->scene), io::whole_steps(scene, "output.frame_every", scene.output.frame_every),
            observe};
}

ScheduledRecording samples_of(const std::shared_ptr<World>& world) {
    return sample_recording(world->scene, field_samples_group, measure::field_observables(world->setting), [world] {
        world->transform_to_grid();
        std::optional<physics::EnergyBudget> energy;
        if (world->energy) energy = world->energy->measure(world->time, world->state);
        measure::FieldMoment moment = moment_of(world->setting, world->state, world->on_grid);
        moment.energy = std::move(energy);
        moment.step_error = world->evolution.step_error().error;
        return moment;
    });
}
}  // namespace

namespace {
/// The choices of the adaptive stepper.
std::string describe(const physics::FieldEvolution& evolution, const io::Scene& scene) {
    std::string words = steps_text(evolution.stepper(), scene);
    if (const auto changes = evolution.reference_changes(); changes > 0)
        words += text("{}the reference density changed {} time{}", words.empty() ? "" : "; ", changes,
                      changes == 1 ? "" : "s");
    return words;
}
}  // namespace

void check_chosen_step(const io::TimeControl& time, const numerics::StepError::Relative& error, std::int64_t step) {
    constexpr double any = 1.0;  // where the fields of two steps may part
    if (time.chosen != "fields" || time.max_error >= any || error.error <= choice_margin * time.max_error) return;
    // Errors grow at least in proportion to time: more than half of the step where much of the run is to come.
    const double t = static_cast<double>(step) * time.dt, order = numerics::time_method(time.stepper).order;
    const int halvings = std::clamp(static_cast<int>(std::ceil(std::log2(2.0 * time.end / t) / order)), 1, 4);
    throw StepTooLong(
        text("the chosen time.dt = {} makes an error of {:.2g} of the fluctuation of the {} by t = {:.6g} s; expected "
             "at most half of time.max_error = {}: run the scene again from its start, with time.dt = {}",
             time.dt, error.error, error.field, t, time.max_error, std::ldexp(time.dt, -halvings)),
        halvings);
}

void blame_chosen_step(const io::TimeControl& time, Simulation& simulation) {
    if (time.tolerance > 0.0 || (time.chosen != "fields" && time.chosen != "means")) return;
    for (std::function<void(std::int64_t)>* part : {&simulation.advance, &simulation.check_health})
        *part = [whole = *part, dt = time.dt](std::int64_t step) {
            try {
                whole(step);
            } catch (const StepTooLong&) {
                throw;
            } catch (const Error& error) {
                if (error.fault() != Fault::run) throw;
                throw StepTooLong(text("{}; the time.dt = {} was chosen: run the scene again from its start, with "
                                       "time.dt = {}",
                                       error.message(), dt, 0.5 * dt),
                                  1);
            }
        };
}

namespace {
/// Other fields start another run: without the history of the stepper and the error so far.
void accept(World& world, std::int64_t step) {
    std::vector<std::string> names;
    for (const physics::Component& one : physics::component_names(world.form)) names.push_back(one.name);
    require_finite(world.on_grid.fields, names, world.scene.grid);
    world.transform.forward(world.on_grid.fields, world.state);
    world.evolution.restore(world.fresh);
    world.evolution.start(world.state);
    world.health = make_field_health(world.evolution, world.scene, world.state);
    restore_field_health(world.evolution.system(), world.state, step, world.health);
}
}  // namespace

namespace {
std::vector<double> save(const World& world) {
    return numbers_of_run(world.evolution.save(), world.time, world.state,
                          world.bias ? world.bias->save() : std::vector<double>{});
}

void restore(World& world, std::span<const double> all) {
    const SavedRun saved = saved_run(all, 2 * world.state.values.size());
    world.evolution.restore(saved.stepper);
    world.time = saved.time;
    take_numbers(saved.state, world.state);
    restore_field_health(world.evolution.system(), world.state, std::llround(world.time / world.scene.time.dt),
                         world.health);
    if (world.bias) world.bias->restore(saved.bias);
}
}  // namespace

Simulation make_field_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved) {
    const auto world = std::make_shared<World>(scene, threads);
    Simulation simulation{.dt = scene.time.dt,
                          .steps = io::whole_steps(scene, "time.end", scene.time.end),
                          .recordings = {},
                          .advance = {},
                          .check_health = {},
                          .save = {},
                          .restore = {},
                          .accept = {},
                          .count = [world] { return world->evolution.stepper().count(); },
                          .step_error = [world] { return world->evolution.step_error().error; },
                          .describe = {}};
    simulation.threads = threads.count();
    simulation.recordings = {frames_of(world)};
    if (world->bias) simulation.recordings.push_back(StepBias::recording(world->bias, world->state));
    simulation.recordings.push_back(samples_of(world));
    simulation.advance = [world](std::int64_t step) {
        try {
            world->evolution.advance(step, world->state);
            if (world->bias) world->bias->advance(step + 1, world->state);
        } catch (const physics::DensityFailure& error) {
            fail_step(world->evolution, world->health, step, world->scene.time.dt, error);
        }
        world->time = static_cast<double>(step + 1) * world->scene.time.dt;
    };
    simulation.check_health = [world](std::int64_t step) {
        check_chosen_step(world->scene.time, world->evolution.step_error(), step);
        check_field_health(world->evolution, world->scene, world->transform, world->state, step, world->health);
    };
    simulation.accept = [world](std::int64_t step) { accept(*world, step); };
    simulation.describe = [world] { return describe(world->evolution, world->scene); };
    simulation.save = [world] { return save(*world); };
    simulation.restore = [world](std::span<const double> values) { restore(*world, values); };
    blame_chosen_step(scene.time, simulation);
    if (!saved.empty()) simulation.restore(saved);
    return simulation;
}

}  // namespace drover::run
