// run/fields/field_simulation.cpp: a simulation of fields: state, stepper and recordings.
#include "run/fields/field_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "drover/numerics/transform.hpp"
#include "io/units.hpp"
#include "measure/fields.hpp"
#include "model/start.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "numerics/steppers/noise_path.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/fields/field_health.hpp"
#include "run/fields/field_problem.hpp"
#include "run/fields/step_bias.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

bool makes_step_error(const FieldProblem& problem) { return problem.integrated.equations.has_explicit_part(); }

numerics::StepWork work_of_run(const io::Scene& scene, const FieldProblem& problem) {
    numerics::StepWork work = model::step_work(problem.integrated, scene.grid);
    const double samples = scene.output.sample_every > 0.0 ? scene.time.dt / scene.output.sample_every : 0.0;
    work.observing = samples * numerics::work_of_observing(scene.grid, static_cast<int>(problem.components.size()));
    return work;
}

files::Recording frames_of(const FieldProblem& problem, const numerics::Grid& grid) {
    files::Recording recording{.group = "/",
                               .axes = {{"y", "mm", "position along y", cell_corners(grid.ny, grid.ly)},
                                        {"x", "mm", "position along x", cell_corners(grid.nx, grid.lx)}},
                               .quantities = problem.components,
                               .rows_per_chunk = 1};
    recording.quantities.insert(recording.quantities.end(), problem.balanced.begin(), problem.balanced.end());
    return recording;
}

/// Of the steppers of a method: so many, or of our own methods twice as many with a tolerance.
double steppers_bytes(const numerics::System& system, const io::TimeControl& time, int count) {
    if (const numerics::TimeMethod& method = numerics::time_method(time.stepper); !method.is_exponential)
        return count * numerics::sundials_stepper_bytes(system, method);
    return numerics::stepper_bytes(system, numerics::stepper_table(time.stepper),
                                   time.tolerance > 0.0 ? 2 * count : count);
}

/// Of the stepper of a twin with noise, and of its state.
double twin_stepper_bytes(const numerics::System& system, const io::TimeControl& time) {
    return numerics::noise_path_bytes(system, 0.5 * time.dt, 0) +
           numerics::stepper_bytes(system, numerics::stepper_table(time.stepper), 1) +
           static_cast<double>(numerics::modes(system.grid)) * numerics::components(system.layout) *
               sizeof(numerics::Complex);
}

double disk_bytes(const io::Scene& scene, const FieldProblem& problem) {
    const auto components = static_cast<double>(problem.components.size() + problem.balanced.size());
    const double frame = static_cast<double>(numerics::points(scene.grid)) * components;
    const double shells = 0.5 * (scene.grid.ny == 1 ? scene.grid.nx : std::min(scene.grid.nx, scene.grid.ny));
    return recorded_bytes(scene, frame, components * (8.0 + shells * (3.0 + 2.0 * measure::direction_sectors)) + 64.0);
}

RunBytes bytes_of(const io::Scene& scene, const FieldProblem& problem) {
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
    if (makes_step_error(problem) && what.equations.has_noise() && step_bias_state(scene) == StepBiasState::measured)
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
    const double memory = numerics::noise_path_bytes(system, scene.time.dt, halvings) +
                          steppers_bytes(system, scene.time, 2) + explicit_part + more +
                          (5.0 * count + count) * spectra + 3.0 * count * reals + 3.0 * reals;
    return {.memory = memory, .disk = disk_bytes(scene, problem)};
}

/// Throws StepTooLong where the step was chosen for the error of the fields, `error` after `step` steps.
void check_chosen_step(const io::Scene& scene, const numerics::StepError::Relative& error, std::int64_t step) {
    const io::TimeControl& time = scene.time;
    constexpr double any = 1.0;  // where the fields of two steps may part
    if (scene.found.step.by != io::ChosenBy::fields || time.max_error >= any) return;
    if (!(error.error > time.max_error)) return;  // also where it is not resolved
    // Errors grow at least in proportion to time, and fall less than the order tells: fields that are not smooth.
    const double t = static_cast<double>(step) * time.dt,
                 order = std::max(1.0, 0.5 * numerics::time_method(time.stepper).order);
    const double excess = error.error / (choice_margin * time.max_error) * time.end / t;
    const int halvings = std::clamp(static_cast<int>(std::ceil(std::log2(excess) / order)), 1, 4);
    throw StepTooLong(
        text("the chosen time.dt = {} makes an error of {:.2g} of the fluctuation of the {} by t = {}; expected "
             "at most time.max_error = {}: run the scene again from its start, with time.dt = {}",
             time.dt, error.error, error.field, io::in_unit("{:.6g}", t, "s", scene.units), time.max_error,
             std::ldexp(time.dt, -halvings)),
        halvings);
}

/// Where the step was chosen, and no tolerance divides it, a run Error of `work` becomes a StepTooLong: a pilot has
/// fewer points, or ends earlier.
template <class Work>
void blame_chosen_step(const io::Scene& scene, Work work) {
    const io::TimeControl& time = scene.time;
    const io::ChosenBy by = scene.found.step.by;
    if (time.tolerance > 0.0 || (by != io::ChosenBy::fields && by != io::ChosenBy::means)) return work();
    try {
        work();
    } catch (const StepTooLong&) {
        throw;
    } catch (const Error& error) {
        if (error.fault() != Fault::run) throw;
        throw StepTooLong(text("{}; the time.dt = {} was chosen: run the scene again from its start, with time.dt = {}",
                               error.message(), time.dt, 0.5 * time.dt),
                          1);
    }
}

/// Throws an input Error, for fields that were not taken as the state, at the first value that is not finite.
void require_finite(const numerics::Fields& fields, const std::vector<files::Quantity>& components,
                    const numerics::Grid& grid) {
    for (int c = 0; c < fields.count(); ++c) {
        const std::span<const double> values = fields[c];
        const auto found = std::ranges::find_if(values, [](double value) { return !std::isfinite(value); });
        require(found == values.end(), {},
                "{} is {} in cell ({}, {}); expected finite values: the fields were not changed",
                components[static_cast<std::size_t>(c)].name, found == values.end() ? 0.0 : *found,
                (found - values.begin()) % grid.nx, (found - values.begin()) / grid.nx);
    }
}

/// The parts of the numbers of a checkpoint: those of the stepper, the time, the state, the step bias and their number.
struct SavedRun {
    std::span<const double> stepper, state, bias;
    double time = 0.0;
};
/// state_numbers: those of the state.  Throws an input Error for fewer numbers than that needs.
SavedRun saved_run(std::span<const double> all, std::size_t state_numbers) {
    const double last = all.empty() ? 0.0 : all.back();
    require(last >= 0.0 && last < static_cast<double>(all.size()) && last == std::round(last), {},
            "the checkpoint holds {} numbers of the step bias; expected fewer than the {} of all; use the other "
            "checkpoint",
            last, all.size());
    const auto of_bias = static_cast<std::size_t>(last);
    const std::span<const double> values = all.first(all.empty() ? 0 : all.size() - 1 - of_bias);
    require(values.size() > state_numbers, {}, "the checkpoint holds {} numbers; this scene's state has more than {}",
            values.size(), state_numbers);
    const std::size_t before = values.size() - state_numbers;
    return {.stepper = values.first(before - 1),
            .state = values.last(state_numbers),
            .bias = all.subspan(values.size(), of_bias),
            .time = values[before - 1]};
}

class FieldSimulation final : public Simulation {
public:
    /// resumed: its state is that of a checkpoint, which restore() brings.
    FieldSimulation(const io::Scene& the_scene, Threads& threads, bool resumed)
        : Simulation(the_scene.time.dt, io::whole_steps(the_scene, "time.end", the_scene.time.end), threads.count()),
          scene_(the_scene),
          problem_(field_problem(scene_)),
          evolution_(problem_.integrated, scene_.grid,
                     {.method = scene_.time.stepper,
                      .dt = scene_.time.dt,
                      .tolerance = scene_.time.tolerance,
                      .watches_error = scene_.time.max_error > 0.0 && makes_step_error(problem_),
                      .effort = effort_of_step_error(scene_),
                      .work = work_of_run(scene_, problem_),
                      .steps = steps},
                     static_cast<std::uint64_t>(scene_.run.seed), threads),
          transform_(scene_.grid, evolution_.linear().degree, threads),
          observer_(field_observer(scene_, problem_.integrated, threads)),
          state_(first_state(threads, resumed)),
          fields_(scene_.grid, state_.count()),
          balanced_(scene_.grid, static_cast<int>(problem_.balanced.size())) {
        bytes = bytes_of(scene_, problem_);
        health_ = make_field_health(problem_, evolution_.linear(), state_);
        evolution_.start(state_);
        fresh_ = evolution_.save();
        if (step_bias_state(scene_) == StepBiasState::measured && makes_step_error(problem_))
            bias_.emplace(BiasedRun{.scene = scene_,
                                    .problem = problem_,
                                    .evolution = evolution_,
                                    .transform = transform_,
                                    .observer = observer_,
                                    .threads = threads});
        recordings.push_back(frames());
        if (bias_) recordings.push_back(bias_->recording(state_));
        recordings.push_back(samples());
    }

    void advance(std::int64_t step) override {
        blame_chosen_step(scene_, [&] {
            try {
                evolution_.advance(step, state_);
                if (bias_) bias_->advance(step + 1, state_);
            } catch (const model::DomainFailure& error) {
                fail_step(diagnosed(), health_, step, error);
            }
        });
        time_ = static_cast<double>(step + 1) * dt;
    }

    void check_health(std::int64_t step) override {
        blame_chosen_step(scene_, [&] {
            check_step_error(step);
            check_field_health(diagnosed(), transform_, state_, step, health_);
        });
    }

    std::vector<double> save() const override {
        std::vector<double> all = evolution_.save();
        all.push_back(time_);
        const std::vector<double> bias = bias_ ? bias_->save() : std::vector<double>{};
        for (const std::span<const double> part : {numerics::parts_of(state_.values), std::span(bias)})
            all.insert(all.end(), part.begin(), part.end());
        all.push_back(static_cast<double>(bias.size()));
        return all;
    }

    void restore(std::span<const double> all) override {
        const SavedRun saved = saved_run(all, 2 * state_.values.size());
        evolution_.restore(saved.stepper);
        time_ = saved.time;
        std::ranges::copy(saved.state, numerics::parts_of(state_.values).begin());
        restore_field_health(evolution_.linear(), state_, std::llround(time_ / dt), health_);
        if (bias_) bias_->restore(saved.bias);
    }

    /// Other fields start another run: without the history of the stepper and the error so far.
    void accept(std::int64_t step) override {
        require_finite(fields_, problem_.components, scene_.grid);
        transform_.forward(fields_, state_);
        model::remove_divergence(problem_.integrated.equations, scene_.grid, state_);
        evolution_.restore(fresh_);
        evolution_.start(state_);
        health_ = make_field_health(problem_, evolution_.linear(), state_);
        restore_field_health(evolution_.linear(), state_, step, health_);
    }

    /// The choices of an adaptive stepper, and changes of the reference.
    std::string describe() const override {
        const numerics::StepCount steps_taken = count();
        const double last = evolution_.stepper().last_step();
        const std::string size = io::in_unit("{:.4g}", last, "s", scene_.units);
        std::string words;
        if (steps_taken.right_hand_sides > 0)
            words = text("{} steps taken, {} rejected, {} right-hand sides; the last step was {}", steps_taken.accepted,
                         steps_taken.rejected, steps_taken.right_hand_sides, size);
        else if (scene_.time.tolerance > 0.0)
            words = text("{} steps taken, {} rejected; the last were {} (time.dt/{})", steps_taken.accepted,
                         steps_taken.rejected, size, std::llround(scene_.time.dt / last));
        if (const auto changes = evolution_.reference_changes(); changes > 0)
            words += text("{}the reference of the linear part changed {} time{}", words.empty() ? "" : "; ", changes,
                          changes == 1 ? "" : "s");
        return words;
    }

    numerics::StepCount count() const override { return evolution_.stepper().count(); }
    std::optional<double> step_error() const override { return evolution_.step_error().error; }

    const numerics::Spectra& state() const { return state_; }

private:
    numerics::Spectra first_state(Threads& threads, bool resumed) const {
        if (scene_.initial.kind != model::StartKind::file)
            return model::start_spectra(scene_.initial, problem_.integrated.equations, evolution_.linear(),
                                        static_cast<std::uint64_t>(scene_.run.seed), threads);
        numerics::Spectra spectra(scene_.grid, static_cast<int>(problem_.components.size()));
        if (resumed) return spectra;  // the file of the start may be gone
        transform_.forward(frame_of_file(scene_, problem_.components, evolution_.linear().degree), spectra);
        model::remove_divergence(problem_.integrated.equations, scene_.grid, spectra);
        return spectra;
    }

    ScheduledRecording frames() {
        return {frames_of(problem_, scene_.grid),
                io::whole_steps(scene_, "output.frame_every", scene_.output.frame_every), [this] {
                    to_grid();
                    std::vector<std::span<const double>> arrays;
                    for (const numerics::Fields* fields : {&std::as_const(fields_), &std::as_const(balanced_)})
                        for (int c = 0; c < fields->count(); ++c) arrays.push_back((*fields)[c]);
                    return arrays;
                }};
    }

    ScheduledRecording samples() {
        return sample_recording(scene_, field_samples_group, observer_->axes(), observer_->quantities(), [this] {
            to_grid();
            return observer_->measure({.time = time_,
                                       .spectra = state_,
                                       .fields = fields_,
                                       .balanced = balanced_,
                                       .step_error = evolution_.step_error().error});
        });
    }

    void to_grid() {
        transform_.backward(state_, fields_);
        find_balanced(evolution_, time_, state_, balanced_);
    }

    /// A field that grows from nothing by large factors a step has a large error for a while: it is that of a small
    /// part of what it will be.
    void check_step_error(std::int64_t step) {
        const numerics::StepError::Relative error = evolution_.step_error();
        if (!(error.error > scene_.time.max_error)) too_large_since_.reset();
        else if (!too_large_since_) too_large_since_ = step;
        const std::int64_t a_while = steps / 64;
        if (too_large_since_ && (step == steps || step >= *too_large_since_ + a_while))
            check_chosen_step(scene_, error, step);
    }

    Diagnosed diagnosed() { return {.scene = scene_, .problem = problem_, .evolution = evolution_}; }

    io::Scene scene_;
    FieldProblem problem_;
    model::FieldEvolution evolution_;
    numerics::Transform transform_;
    SharedObserver observer_;
    numerics::Spectra state_;
    numerics::Fields fields_, balanced_;  // on the grid, in arrays that keep their places: they are lent out
    FieldHealth health_;
    double time_ = 0.0;
    std::optional<std::int64_t> too_large_since_;  // step from which on the error is larger than that of a chosen step
    std::vector<double> fresh_;                    // saved by the evolution before any step
    std::optional<StepBias> bias_;                 // none: not measured
};
}  // namespace

files::Recording frame_recording(const io::Scene& scene) { return frames_of(field_problem(scene), scene.grid); }

io::Scene start_alone(const io::Scene& scene) {
    io::Scene start = io::with_step(scene);
    start.time.stepper = io::TimeControl{}.stepper;
    start.time.tolerance = start.time.max_error = 0.0;
    start.output.powers = false;
    start.accuracy.effort = 0.0;
    return start;
}

numerics::Spectra initial_fields(const io::Scene& scene, Threads& threads) {
    return FieldSimulation(start_alone(scene), threads, false).state();
}

void check_field_start(const io::Scene& scene) {
    if (scene.initial.kind != model::StartKind::file) return;
    const FieldProblem problem = field_problem(scene);
    const model::Integrated& what = problem.integrated;
    frame_of_file(scene, problem.components, what.equations.linear_system(scene.grid, what.kept_degree).degree);
}

int choose_threads(const io::Scene& scene) {
    if (scene.run.threads > 0) return scene.run.threads;
    // With less work per thread, waking a thread costs more than it saves.
    constexpr std::size_t points_per_thread = 16384;
    const auto useful = static_cast<int>(std::min<std::size_t>(numerics::points(scene.grid) / points_per_thread, 64));
    return std::clamp(useful, 1, usable_cores());
}

std::string field_size(const io::Scene& scene) { return text("{} by {} points", scene.grid.nx, scene.grid.ny); }

TimedScene timed_fields(const io::Scene& scene) {
    constexpr double max_points = 256.0 * 256.0;
    const auto work = [](const numerics::Grid& grid) {
        const auto points = static_cast<double>(numerics::points(grid));
        return points * std::log2(points);
    };
    io::Scene timed = scene;
    if (timed.initial.kind != model::StartKind::formula) timed.initial = io::default_start(timed.kind);
    while (static_cast<double>(numerics::points(timed.grid)) > max_points && timed.grid.nx % 4 == 0 &&
           timed.grid.ny % 4 == 0 && std::min(timed.grid.nx, timed.grid.ny) > 8) {
        timed.grid.nx /= 2;
        timed.grid.ny /= 2;
    }
    return {timed, work(scene.grid) / work(timed.grid)};
}

RunBytes field_bytes(const io::Scene& scene) { return bytes_of(scene, field_problem(scene)); }

std::unique_ptr<Simulation> make_field_simulation(const io::Scene& scene, Threads& threads,
                                                  std::span<const double> saved) {
    auto simulation = std::make_unique<FieldSimulation>(scene, threads, !saved.empty());
    for (ScheduledRecording& scheduled : simulation->recordings) {
        io::rename_units(scheduled.recording.axes, scene.units);
        io::rename_units(scheduled.recording.quantities, scene.units);
        scheduled.recording.time_unit = io::renamed("s", scene.units);
    }
    if (!saved.empty()) simulation->restore(saved);
    return simulation;
}

}  // namespace drover::run
