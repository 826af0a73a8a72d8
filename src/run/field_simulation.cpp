// run/field_simulation.cpp: a simulation of fields: state, stepper and recordings.
#include "run/field_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "drover/measure/fields.hpp"
#include "drover/model/start.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/field_health.hpp"
#include "run/field_problem.hpp"
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
    FieldProblem problem;
    model::FieldEvolution evolution;
    numerics::Transform transform;
    FieldObserver observer;
    numerics::Spectra state;
    numerics::Fields fields, balanced;  // on the grid, in arrays that keep their places: they are lent out
    FieldHealth health;
    double time = 0.0;
    std::vector<double> fresh;       // saved by the evolution before any step
    std::shared_ptr<StepBias> bias;  // nullptr: not measured

    World(const io::Scene& the_scene, Threads& threads);
    BiasedRun biased(Threads& threads) const;  // refers to this
    numerics::Spectra first_state(Threads& threads) const;
    void to_grid();
    Diagnosed diagnosed() { return {.evolution = evolution, .problem = problem, .dt = scene.time.dt}; }
};

bool makes_step_error(const FieldProblem& problem) { return problem.integrated.equations.has_explicit_part(); }

numerics::StepWork work_of_run(const io::Scene& scene, const FieldProblem& problem) {
    numerics::StepWork work = model::step_work(problem.integrated, scene.grid);
    const double samples = scene.output.sample_every > 0.0 ? scene.time.dt / scene.output.sample_every : 0.0;
    work.observing = samples * numerics::work_of_observing(scene.grid, static_cast<int>(problem.components.size()));
    return work;
}

World::World(const io::Scene& the_scene, Threads& threads)
    : scene(the_scene),
      problem(field_problem(scene)),
      evolution(problem.integrated, scene.grid,
                {.method = scene.time.stepper,
                 .dt = scene.time.dt,
                 .tolerance = scene.time.tolerance,
                 .watches_error = scene.time.max_error > 0.0 && makes_step_error(problem),
                 .effort = effort_of_step_error(scene),
                 .work = work_of_run(scene, problem)},
                static_cast<std::uint64_t>(scene.run.seed), threads),
      transform(scene.grid, evolution.linear().degree, threads),
      observer(field_observer(scene, problem.integrated, threads)),
      state(first_state(threads)),
      fields(scene.grid, state.count()),
      balanced(scene.grid, static_cast<int>(problem.balanced.size())) {
    health = make_field_health(problem, evolution.linear(), state);
    evolution.start(state);
    fresh = evolution.save();
    if (why_no_step_bias(scene).empty() && makes_step_error(problem))
        bias = std::make_shared<StepBias>(scene, biased(threads));
}

numerics::Spectra World::first_state(Threads& threads) const {
    if (scene.initial.kind != "file")
        return model::start_spectra(scene.initial, problem.integrated.equations, evolution.linear(),
                                    static_cast<std::uint64_t>(scene.run.seed), threads);
    numerics::Spectra spectra(scene.grid, static_cast<int>(problem.components.size()));
    std::vector<FrameField> wanted;
    for (const files::Quantity& one : problem.components) wanted.push_back({one.name, one.unit});
    transform.forward(frame_of_file(scene, wanted, evolution.linear().degree), spectra);
    model::remove_divergence(problem.integrated.equations, scene.grid, spectra);
    return spectra;
}

void find_balanced(const model::FieldEvolution& evolution, double time, const numerics::Spectra& state,
                   numerics::Fields& to) {
    if (to.count() == 0) return;
    const numerics::Fields now = evolution.balanced(time, state);
    std::copy(now.values.begin(), now.values.end(), to.values.begin());
}

void World::to_grid() {
    transform.backward(state, fields);
    find_balanced(evolution, time, state, balanced);
}

BiasedRun World::biased(Threads& threads) const {
    struct Observed {
        numerics::Fields fields, balanced;
    };
    const FieldObserver part = observer_of_state(observer, threads);
    const auto observed = std::make_shared<std::optional<Observed>>();  // made when it is needed
    const auto make_twin = [this, &threads] {
        const auto twin =
            std::make_shared<model::FieldEvolution>(problem.integrated, scene.grid, control_of_twin(scene.time),
                                                    static_cast<std::uint64_t>(scene.run.seed), threads);
        return Twin{.follow = [this, twin] { twin->follow(evolution); },
                    .advance = [twin](std::int64_t step, numerics::Spectra& at) { twin->advance(step, at); },
                    .save = [twin] { return twin->save(); },
                    .restore = [twin](std::span<const double> values) { twin->restore(values); }};
    };
    return {.values = part.values,
            .components = state.count(),
            .work_done = [this] { return evolution.work_done(); },
            .observe =
                [this, observed, part](double t, const numerics::Spectra& at) {
                    if (!*observed)
                        observed->emplace(numerics::Fields(scene.grid, fields.count()),
                                          numerics::Fields(scene.grid, balanced.count()));
                    Observed& now = **observed;
                    transform.backward(at, now.fields);
                    find_balanced(evolution, t, at, now.balanced);
                    std::vector<double> values;
                    for (const std::vector<double>& row :
                         part.measure({.time = t, .spectra = at, .fields = now.fields, .balanced = now.balanced}))
                        values.insert(values.end(), row.begin(), row.end());
                    return values;
                },
            .known_error = [this] { return evolution.known_error(); },
            .make_twin = make_twin};
}

files::Recording frames_of(const FieldProblem& problem, const numerics::Grid& grid) {
    files::Recording recording = frames_on(grid);
    recording.quantities = problem.components;
    recording.quantities.insert(recording.quantities.end(), problem.balanced.begin(), problem.balanced.end());
    return recording;
}
}  // namespace

files::Recording frame_recording(const io::Scene& scene) { return frames_of(field_problem(scene), scene.grid); }

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
    const FieldProblem problem = field_problem(scene);
    const auto components = static_cast<double>(problem.components.size() + problem.balanced.size());
    const double frame = static_cast<double>(numerics::points(scene.grid)) * components;
    const double shells = 0.5 * (scene.grid.ny == 1 ? scene.grid.nx : std::min(scene.grid.nx, scene.grid.ny));
    return recorded_bytes(scene, frame, components * (8.0 + shells * (3.0 + 2.0 * measure::direction_sectors)) + 64.0);
}

TimedScene timed_fields(const io::Scene& scene) {
    constexpr double max_points = 256.0 * 256.0;
    const auto work = [](const numerics::Grid& grid) {
        const auto points = static_cast<double>(numerics::points(grid));
        return points * std::log2(points);
    };
    io::Scene timed = scene;
    if (timed.initial.kind != "formula") timed.initial = io::default_start(timed.kind);
    while (static_cast<double>(numerics::points(timed.grid)) > max_points && timed.grid.nx % 4 == 0 &&
           timed.grid.ny % 4 == 0 && std::min(timed.grid.nx, timed.grid.ny) > 8) {
        timed.grid.nx /= 2;
        timed.grid.ny /= 2;
    }
    return {timed, work(scene.grid) / work(timed.grid)};
}

double field_simulation_bytes(const io::Scene& scene) {
    const FieldProblem problem = field_problem(scene);
    const model::Integrated& what = problem.integrated;
    numerics::System system = what.equations.linear_system(scene.grid, what.kept_degree);
    const bool evaluates = what.equations.has_nonlinear_part();
    if (evaluates) system.nonlinear = [](double, const auto&, auto&) {};
    const double spectra = static_cast<double>(numerics::modes(scene.grid)) * sizeof(Complex);
    const double reals = static_cast<double>(numerics::points(scene.grid)) * sizeof(double);
    const int count = numerics::components(system.layout);
    const double explicit_part = evaluates ? model::explicit_bytes(what, scene.grid, system.degree) : 0.0;
    constexpr int halvings = 1;  // of the steps that are repeated to measure their error
    const auto balanced = static_cast<double>(problem.balanced.size());
    double more = balanced == 0.0 ? 0.0 : explicit_part + 2.0 * balanced * (reals + spectra);
    if (makes_step_error(problem) && what.equations.has_noise() && why_no_step_bias(scene).empty())
        more += twin_stepper_bytes(system, scene.time) + explicit_part;
    if (makes_step_error(problem) && scene.time.max_error > 0.0) {
        const numerics::Grid coarse =
            numerics::coarse_grid(scene.grid, system.degree, what.equations.has_noise(), what.shortest).grid;
        constexpr double states = 20.0;  // of the estimate and of the steps of the error
        more += static_cast<double>(numerics::points(coarse)) / static_cast<double>(numerics::points(scene.grid)) *
                (explicit_part + states * count * spectra);
    }
    // The state, the last two healthy ones, a copy for the checkpoint and its file; fields, and a frame of them with
    // its compressed bytes; scratch; shells, sectors and powers.
    return numerics::noise_path_bytes(system, scene.time.dt, halvings) + steppers_bytes(system, scene.time, 2) +
           explicit_part + more + (5.0 * count + count) * spectra + 3.0 * count * reals + 3.0 * reals;
}

namespace {
ScheduledRecording frames_of(const std::shared_ptr<World>& world) {
    const io::Scene& scene = world->scene;
    const auto observe = [world] {
        world->to_grid();
        std::vector<std::span<const double>> arrays;
        for (const numerics::Fields* fields : {&std::as_const(world->fields), &std::as_const(world->balanced)})
            for (int c = 0; c < fields->count(); ++c) arrays.push_back((*fields)[c]);
        return arrays;
    };
    return {frames_of(world->problem, scene.grid),
            io::whole_steps(scene, "output.frame_every", scene.output.frame_every), observe};
}

ScheduledRecording samples_of(const std::shared_ptr<World>& world) {
    return sample_recording(world->scene, field_samples_group, world->observer.axes, world->observer.quantities,
                            [world] {
                                world->to_grid();
                                return world->observer.measure({.time = world->time,
                                                                .spectra = world->state,
                                                                .fields = world->fields,
                                                                .balanced = world->balanced,
                                                                .step_error = world->evolution.step_error().error});
                            });
}

/// The choices of the adaptive stepper.
std::string describe(const model::FieldEvolution& evolution, const io::Scene& scene) {
    std::string words = steps_text(evolution.stepper(), scene);
    if (const auto changes = evolution.reference_changes(); changes > 0)
        words += text("{}the reference of the linear part changed {} time{}", words.empty() ? "" : "; ", changes,
                      changes == 1 ? "" : "s");
    return words;
}
}  // namespace

void check_chosen_step(const io::TimeControl& time, const numerics::StepError::Relative& error, std::int64_t step) {
    constexpr double any = 1.0;  // where the fields of two steps may part
    if (time.chosen != "fields" || time.max_error >= any) return;
    if (!(error.error > time.max_error)) return;  // also where it is not resolved
    // Errors grow at least in proportion to time, and fall less than the order tells: fields that are not smooth.
    const double t = static_cast<double>(step) * time.dt,
                 order = std::max(1.0, 0.5 * numerics::time_method(time.stepper).order);
    const double excess = error.error / (choice_margin * time.max_error) * time.end / t;
    const int halvings = std::clamp(static_cast<int>(std::ceil(std::log2(excess) / order)), 1, 4);
    throw StepTooLong(
        text("the chosen time.dt = {} makes an error of {:.2g} of the fluctuation of the {} by t = {:.6g} s; expected "
             "at most time.max_error = {}: run the scene again from its start, with time.dt = {}",
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
    for (const files::Quantity& one : world.problem.components) names.push_back(one.name);
    require_finite(world.fields, names, world.scene.grid);
    world.transform.forward(world.fields, world.state);
    model::remove_divergence(world.problem.integrated.equations, world.scene.grid, world.state);
    world.evolution.restore(world.fresh);
    world.evolution.start(world.state);
    world.health = make_field_health(world.problem, world.evolution.linear(), world.state);
    restore_field_health(world.evolution.linear(), world.state, step, world.health);
}

std::vector<double> save(const World& world) {
    return numbers_of_run(world.evolution.save(), world.time, world.state,
                          world.bias ? world.bias->save() : std::vector<double>{});
}

void restore(World& world, std::span<const double> all) {
    const SavedRun saved = saved_run(all, 2 * world.state.values.size());
    world.evolution.restore(saved.stepper);
    world.time = saved.time;
    take_numbers(saved.state, world.state);
    restore_field_health(world.evolution.linear(), world.state, std::llround(world.time / world.scene.time.dt),
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
        } catch (const model::DomainFailure& error) {
            fail_step(world->diagnosed(), world->health, step, error);
        }
        world->time = static_cast<double>(step + 1) * world->scene.time.dt;
    };
    simulation.check_health = [world](std::int64_t step) {
        check_chosen_step(world->scene.time, world->evolution.step_error(), step);
        check_field_health(world->diagnosed(), world->transform, world->state, step, world->health);
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
