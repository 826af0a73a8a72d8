// run/step_choice.cpp: pilots, runs of fields in memory, with ever shorter steps.
#include "run/step_choice.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/constants.hpp"
#include "drover/base/error.hpp"
#include "drover/measure/statistics.hpp"
#include "io/units.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/signals.hpp"
#include "run/simulation_type.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
constexpr double default_max_error = 0.01;  // of a figure
constexpr double largest_tolerance = 0.1;   // of the schema: the pilot records errors and hardly ever divides

double max_error_of(const io::Scene& scene) {
    return scene.time.max_error > 0.0 ? scene.time.max_error : default_max_error;
}

/// Points along an axis of a pilot, at least 32 where the run has them.
int pilot_points(int points, int coarser) {
    for (; coarser > 1 && points % 2 == 0 && points >= 64; coarser /= 2) points /= 2;
    return points;
}

/// The scene of the pilots, with the longest step of the run: the interval of the outputs, or a sixteenth of the run.
io::Scene pilot_scene(const io::Scene& scene, int coarser) {
    io::Scene pilot = scene;
    pilot.time.dt = io::longest_step(scene);
    while (scene.time.end / pilot.time.dt < 16.0) pilot.time.dt *= 0.5;
    pilot.time.max_error = max_error_of(scene);
    if (scene.initial.kind != model::StartKind::file) {
        pilot.grid.nx = pilot_points(scene.grid.nx, coarser);
        pilot.grid.ny = pilot_points(scene.grid.ny, coarser);
    }
    // A pilot costs less than the run: it has fewer points, or ends earlier.  The means of a noisy run are known from a
    // part of it.
    const bool is_coarse = numerics::points(pilot.grid) < numerics::points(scene.grid);
    const double share = io::has_noise(scene) ? 0.25 : is_coarse ? 1.0 : 0.1, min_time = 64.0 * pilot.time.dt;
    const auto down_to_steps = [&](double duration) { return pilot.time.dt * std::floor(duration / pilot.time.dt); };
    pilot.time.end = std::min(scene.time.end, down_to_steps(std::max(min_time, share * scene.time.end)));
    constexpr double samples = 256.0;
    pilot.output.sample_every = std::max(pilot.time.dt, down_to_steps(pilot.time.end / samples));
    pilot.output.frame_every = 0.0;
    pilot.output.powers = false;
    pilot.analysis.warm_up = -1.0;
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    const bool records_errors = method.estimates_error && method.stages_with_tolerance > 0;  // of the parts of a step
    if (!io::has_noise(scene) && scene.time.tolerance == 0.0 && records_errors)
        pilot.time.tolerance = largest_tolerance;
    return pilot;
}

/// Whether a pilot has fewer points than the run, and these hold its start as well.
bool represents(const io::Scene& pilot, const io::Scene& scene) {
    if (numerics::points(pilot.grid) == numerics::points(scene.grid)) return false;
    try {
        io::check(pilot);
    } catch (const Error&) {  // the grid cuts the start
        return false;
    }
    return simulation_type_of(pilot).warnings(pilot).size() <= simulation_type_of(scene).warnings(scene).size();
}

/// What a run in memory shows, to its end or to where it stops.
struct Pilot {
    std::vector<std::pair<std::string, std::vector<double>>> series;  ///< of the scalar observables
    double step_error = 0.0;                                          ///< the largest so far
    double stopped = INFINITY;           ///< time at which the error exceeded the limit, or the run failed [s]
    std::optional<std::string> failure;  ///< why the run failed, if it did
    numerics::StepCount count;
};

/// The series of an observable of a pilot; nullptr: it has none.
const std::vector<double>* pilot_series(const Pilot& run, const std::string& name) {
    const auto found = std::ranges::find_if(run.series, [&](const auto& one) { return one.first == name; });
    return found == run.series.end() ? nullptr : &found->second;
}

/// Runs a scene to its end, or to where its step_error exceeds max_step_error.  Throws a run Error on a stop signal.
Pilot run_pilot(io::Scene scene, Threads& threads, double max_step_error) {
    scene.accuracy.effort = infinite;
    scene.accuracy.biases = false;
    const std::unique_ptr<Simulation> simulation = [&] {
        const LogPause quiet;  // the run itself says what its start has to say
        return simulation_type_of(scene).make(scene, threads, {});
    }();
    const ScheduledRecording& samples = simulation->recordings.back();
    const std::vector<files::Quantity>& quantities = samples.recording.quantities;
    Pilot pilot;
    for (const files::Quantity& quantity : quantities)
        if (quantity.axes.empty()) pilot.series.push_back({quantity.name, {}});
    constexpr double beginning = 1.0 / 32.0;  // of the run
    std::int64_t step = 0;
    try {
        while (step < simulation->steps && !(pilot.step_error > max_step_error)) {
            if (stop_signal() != 0)
                fail_environment("stopped by {} while time.dt was being chosen; no run was started",
                                 stop_reason(stop_signal()));
            simulation->advance(step++);
            if (is_checked(*simulation, step)) simulation->check_health(step);
            if (step % samples.every != 0) continue;
            const std::vector<std::span<const double>> row = samples.observe();
            for (std::size_t q = 0, scalar = 0; q < row.size(); ++q)
                if (quantities[q].axes.empty()) pilot.series[scalar++].second.push_back(row[q][0]);
            // A field that is 0 at the start has a large error for a while, which no step avoids.
            const bool counts = beginning * static_cast<double>(simulation->steps) <= static_cast<double>(step);
            if (const std::vector<double>* errors = pilot_series(pilot, "step_error"); counts && errors != nullptr)
                pilot.step_error = std::max(pilot.step_error, errors->back());
        }
    } catch (const Error& error) {
        if (error.fault() != Fault::run || stop_signal() != 0) throw;
        pilot.failure = error.what();
    }
    if (pilot.failure || pilot.step_error > max_step_error) pilot.stopped = static_cast<double>(step) * simulation->dt;
    pilot.count = simulation->count();
    return pilot;
}

std::string tail_name(const model::Field& field) { return "spectral_tail_" + field.name; }

/// Whether the grid of the pilot resolves its fields, once those of the start have evolved.
bool is_resolved(const Pilot& run, const model::Model& model) {
    for (const model::Field& field : model.fields) {
        const std::vector<double>*tails = pilot_series(run, tail_name(field)),
              *variances = pilot_series(run, "variance_" + field.name);
        if (tails == nullptr || tails->empty()) continue;
        const double largest = *std::ranges::max_element(*variances);
        for (std::size_t i = tails->size() / 4; i < tails->size(); ++i)
            if ((*tails)[i] > max_spectral_tail &&
                (*tails)[i] * (*variances)[i] > max_spectral_tail * max_spectral_tail * largest)
                return false;
    }
    return true;
}

/// The field with the largest part of its variance in the shortest waves at the end of a pilot, and that part.
std::pair<std::string, double> roughest_field(const Pilot& run, const model::Model& model) {
    std::pair<std::string, double> worst;
    for (const model::Field& field : model.fields)
        if (const std::vector<double>* tails = pilot_series(run, tail_name(field));
            tails != nullptr && !tails->empty() && tails->back() > worst.second)
            worst = {field.name, tails->back()};
    return worst;
}

/// The bias of a mean, relative to the mean or, where larger, to the spread of the observable.
struct RelativeBias {
    std::string name;
    double relative = 0.0, error = 0.0;
    double bound() const { return std::abs(relative) + error; }
};

/// Whether the mean of an observable is compared: not those of components, since the direction of a flock wanders.
bool is_compared(const std::string& name, const model::Model& model) {
    bool is_component = false, is_scalar = false, is_left_out = name == "step_error";
    for (const model::Field& field : model.fields) {
        is_scalar = is_scalar || (field.spin == 0 && name.ends_with("_" + field.name));
        is_left_out = is_left_out || name == tail_name(field);
        for (const std::string& part : model::dataset_names(field))
            is_component |= field.spin > 0 && name.ends_with(part.substr(field.name.size()));
    }
    return !is_left_out && (is_scalar || !is_component);
}

/// Below which the mean of an observable is rounding; 0: not known.
double rounding_of(const std::string& name, const Pilot& run, const model::Model& model) {
    for (const model::Field& field : model.fields) {
        const bool is_mean = name == "mean_" + field.name || name == "size_mean_" + field.name;
        if (const auto* variances = pilot_series(run, "variance_" + field.name); is_mean && variances != nullptr)
            return 1e-10 * std::sqrt(*std::ranges::max_element(*variances));
    }
    return 0.0;
}

/// The largest over the observables, of the run with the longer step, which is `of_difference` times what half of it
/// changes.
RelativeBias largest_bias(const Pilot& longer, const Pilot& shorter, const model::Model& model, double of_difference) {
    RelativeBias largest;
    for (std::size_t k = 0; k < shorter.series.size(); ++k) {
        const std::vector<double>& a = longer.series[k].second;
        const auto& [name, b] = shorter.series[k];
        if (!is_compared(name, model) || a.size() != b.size() || b.size() < 8) continue;
        const std::size_t skip = b.size() / 4;
        double mean = 0.0, square = 0.0;
        for (std::size_t i = skip; i < b.size(); ++i) {
            mean += b[i];
            square += b[i] * b[i];
        }
        const auto count = static_cast<double>(b.size() - skip);
        mean /= count;
        const double spread = std::sqrt(std::max(0.0, square / count - mean * mean));
        const double scale = std::max(std::abs(mean), spread);
        if (scale <= rounding_of(name, shorter, model)) continue;
        const measure::RoughMean difference = measure::paired_difference(a, b, skip);
        const RelativeBias bias{name, of_difference * difference.value / scale, difference.error / scale};
        if (!(bias.bound() <= largest.bound())) largest = bias;
    }
    return largest;
}

/// One scene, ever shorter steps.
class Ladder {
public:
    Ladder(const io::Scene& scene, const io::Scene& pilot, const model::Equations& equations)
        : given_(scene),
          model_(equations.model()),
          target_(choice_margin * max_error_of(scene)),
          pilot_(pilot),
          bias_of_difference_(equations.has_product_noise() ? 2.0 : 4.0 / 3.0),
          foreseen_(std::exp2(numerics::time_method(scene.time.stepper).order - 1)),
          is_noisy_(io::has_noise(scene)),
          is_coarse_(numerics::points(pilot_.grid) < numerics::points(scene.grid)),
          threads_(choose_threads(pilot_)) {}

    /// The scene with dt, a tolerance, and how they were found; none: see failure().
    std::optional<io::Scene> choose() {
        if (!is_noisy_)
            if (auto chosen = by_fields(); chosen || !is_chaotic()) return chosen;
        return by_means();
    }

    /// Of the shortest step tried.
    std::string failure() const {
        const auto& [field, tail] = roughest_;
        std::string words =
            text("at the shortest step tried, {}, {}", io::in_unit("{:.3g}", shortest_, "s", given_.units), failure_);
        if (tail > max_spectral_tail)
            words += text("; {:.2g} of the variance of {} is in the shortest waves of the grid: choose {}{}", tail,
                          field, grid_keys(pilot_.grid, 2), is_noisy_ ? ", unless the noise explains this" : "");
        return words;
    }

private:
    bool within_reach() const {
        constexpr double max_steps = 1e6, max_work = 5e8;  // points times steps: a minute or two
        const double steps = pilot_.time.end / pilot_.time.dt;
        return steps < max_steps && steps * static_cast<double>(numerics::points(pilot_.grid)) < max_work;
    }

    Pilot next_run(double max_step_error) {
        Pilot run = run_pilot(pilot_, threads_, max_step_error);
        ++runs_;
        shortest_ = pilot_.time.dt;
        // A run that diverges without a tolerance tells so itself.
        roughest_ = !run.failure || pilot_.time.tolerance > 0.0 ? roughest_field(run, model_) : decltype(roughest_)();
        return run;
    }

    std::optional<io::Scene> by_fields() {
        for (int unresolved = 0; within_reach(); pilot_.time.dt *= 0.5) {
            const Pilot run = next_run(foreseen_ * target_);
            const bool reached_end = std::isinf(run.stopped);
            if (run.failure) failure_ = *run.failure;
            else
                failure_ = text("its error is {:.2g} of a field at t = {}", run.step_error,
                                io::in_unit("{:.4g}", run.stopped, "s", given_.units));
            // From a field that is 0 at the start, the first parts are wrong by as much as they make.
            const auto few = static_cast<std::int64_t>(pilot_.time.end / pilot_.time.dt / 32.0);
            // A step that is too long leaves short waves too, hence two steps.
            unresolved = is_coarse_ && !run.failure && !is_resolved(run, model_) ? unresolved + 1 : 0;
            if (unresolved == 2) break;
            if (reached_end && unresolved == 0 &&
                (run.count.rejected <= few || pilot_.time.tolerance < largest_tolerance)) {
                if (run.step_error <= target_)
                    return chosen(io::ChosenBy::fields, text("step_error {:.2g}", run.step_error),
                                  run.count.largest_error);
                const double of_longer = pilot_.time.dt;
                pilot_.time.dt *= 0.5;
                return chosen(io::ChosenBy::fields,
                              text("step_error {:.2g} with dt = {}", run.step_error,
                                   io::in_unit("{:.4g}", of_longer, "s", given_.units)),
                              run.count.largest_error / foreseen_);
            }
            stopped_.push_back(run.stopped);
            if (is_chaotic()) break;
        }
        return std::nullopt;
    }

    /// The error of a chaotic run grows as an exponential: each half of the step puts off its limit by the same time.
    bool is_chaotic() const {
        constexpr std::size_t needed = 6;
        if (stopped_.size() < needed) return false;
        for (std::size_t k = stopped_.size() - needed + 2; k < stopped_.size(); ++k) {
            const double before = stopped_[k - 1] - stopped_[k - 2], now = stopped_[k] - stopped_[k - 1];
            if (!(before > 0.0 && now > 0.0 && now < 1.5 * before)) return false;
        }
        return true;
    }

    std::optional<io::Scene> by_means() {
        pilot_.time.tolerance = given_.time.tolerance;
        if (!stopped_.empty()) pilot_.time.dt *= std::exp2(static_cast<double>(stopped_.size()) - 1.0);
        std::optional<Pilot> longer;
        for (; within_reach(); pilot_.time.dt *= 0.5) {
            Pilot run = next_run(INFINITY);
            if (run.failure) {
                failure_ = *run.failure;
                longer.reset();
                continue;
            }
            if (longer) {
                const RelativeBias bias = largest_bias(*longer, run, model_, bias_of_difference_);
                failure_ = text("its bias of {} is {:.2g} +- {:.2g}", bias.name, bias.relative, bias.error);
                if (bias.bound() <= target_) {
                    pilot_.time.dt *= 2.0;
                    return chosen(io::ChosenBy::means,
                                  text("bias of {}, the largest of the means, {:.2g} +- {:.2g}", bias.name,
                                       bias.relative, bias.error),
                                  0.0);
                }
            }
            longer = std::move(run);
        }
        return std::nullopt;
    }

    io::Scene chosen(io::ChosenBy by, const std::string& error, double largest_part_error) const {
        io::Scene scene = given_;
        scene.time.dt = pilot_.time.dt;
        if (given_.time.tolerance == 0.0) scene.time.tolerance = std::min(target_, 2.0 * largest_part_error);
        scene.found.step = {.by = by,
                            .pilot = text("{} in {} pilot run{} of {} by {} points to t = {}", error, runs_,
                                          runs_ == 1 ? "" : "s", pilot_.grid.nx, pilot_.grid.ny,
                                          io::in_unit("{:.4g}", pilot_.time.end, "s", given_.units))};
        return scene;
    }

    io::Scene given_;
    const model::Model& model_;
    double target_;
    io::Scene pilot_;
    // Of means: half of the step makes a quarter of it; half with noise that multiplies fields, of first weak order.
    double bias_of_difference_;
    double foreseen_;  // half of the step makes the error of fields at least so many times smaller
    bool is_noisy_, is_coarse_;
    Threads threads_;
    int runs_ = 0;
    std::vector<double> stopped_;  // by step, of by_fields()
    double shortest_ = 0.0;
    std::pair<std::string, double> roughest_;
    std::string failure_;
};

/// A pilot may end before a pulse in time, or step over it.
void shorten_to_times(io::Scene& scene, const model::Model& model) {
    constexpr double max_steps = 1e7;
    const double chosen = scene.time.dt;
    while (!resolves_time(scene, model) && scene.time.end / scene.time.dt < max_steps) scene.time.dt *= 0.5;
    if (scene.time.dt < chosen)
        scene.found.step.pilot +=
            text("; shortened from {} to resolve the terms of t", io::in_unit("{:.4g}", chosen, "s", scene.units));
}
}  // namespace

io::Scene with_chosen_step(const io::Scene& scene, bool quiet) {
    if (scene.time.dt > 0.0) return scene;
    io::Scene result = scene;
    // The cheapest for its error in most comparisons (tests/bench), with noise and without.
    if (!scene.places.contains("time.stepper")) result.time.stepper = "etdrk4-krogstad";
    const model::Equations equations = equations_of(scene);
    if (!equations.has_explicit_part()) {
        result.time.dt = io::longest_step(scene);
        result.found.step.by = io::ChosenBy::linear;
        return result;
    }
    if (scene.time.tolerance > 0.0 && numerics::time_method(scene.time.stepper).stages_with_tolerance == 0) {
        result.time.dt = io::longest_step(scene);  // the steps follow the tolerance
        return result;
    }
    if (!quiet)
        log_information("time.dt is left out: choosing it by pilot runs for an error of {}", max_error_of(scene));
    std::string failure;
    for (const int coarser : {4, 2, 1}) {
        const io::Scene pilot = pilot_scene(result, coarser);
        if (coarser > 1 && !represents(pilot, result)) continue;
        Ladder ladder(result, pilot, equations);
        if (auto chosen = ladder.choose()) {
            shorten_to_times(*chosen, equations.model());
            return *chosen;
        }
        failure = ladder.failure();
    }
    fail_run(
        "no time step was found that keeps the error below {} of time.max_error = {}: {}; expected a time.dt in the "
        "scene, or a larger time.max_error",
        choice_margin, max_error_of(scene), failure);
}

}  // namespace drover::run
