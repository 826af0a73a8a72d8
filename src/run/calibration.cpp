// run/calibration.cpp: trials on workers, each stored when it ends; then the table.
#include "drover/run/calibration.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/clock.hpp"
#include "drover/base/log.hpp"
#include "drover/base/threads.hpp"
#include "drover/base/version.hpp"
#include "drover/files/new_file.hpp"
#include "drover/io/calibration.hpp"
#include "drover/io/trial_file.hpp"
#include "drover/run/loop.hpp"
#include "drover/run/provenance.hpp"
#include "drover/run/signals.hpp"
#include "drover/run/worker_pool.hpp"
#include "run/want_plan.hpp"

namespace drover::run {

namespace {
namespace fs = std::filesystem;
constexpr const char* calibration_manifest = "calibrate.toml";
constexpr double grace_period = 5.0;  // for running trials after a signal [s]; the program then ends within 10 s

fs::path trials_of(const fs::path& folder, const CalibrationUnit& unit) { return folder / (unit.name + ".trials"); }

calibrate::TrialSet trial_set_of(const CalibrationLayout& layout, const CalibrationUnit& unit, double max_failed) {
    return {layout.assays[unit.assay], layout.goal, max_failed};
}

std::string result_text(const calibrate::TrialSet& trial_set) {
    if (!trial_set.failure_reason().empty()) return "failed: " + trial_set.failure_reason();
    const calibrate::Measurement& found = *trial_set.measurement();
    const measure::Estimate& first = found.estimates.front();
    const calibrate::Quantity& quantity = trial_set.assay().quantities.front();
    const std::string failed = trial_set.failed() > 0 ? text(", {} failed", trial_set.failed()) : "";
    if (!first.error)
        return text("{}: no error estimate after {} trials{}: {}", quantity.name, found.trials, failed, first.refusal);
    return text("{} = {} {} from {} trials{}{}", quantity.name, measured_text_with_error(first.mean, *first.error),
                quantity.unit, found.trials, failed, found.reached ? "" : ", with a larger error than requested");
}

WantLimits limits_of(const io::Scene& scene, const CalibrationOptions& options, int workers) {
    return {.max_trials = static_cast<std::size_t>(scene.calibration.max_trials),
            .budget = options.budget,
            .workers = static_cast<std::size_t>(workers)};
}

/// The trials of one process: its locked trial files and the trials still needed.
class Work {
public:
    Work(const io::Scene& scene, const CalibrationLayout& layout, const CalibrationOptions& options, int workers)
        : layout_(layout), options_(options), factory_(calibrate::system_factory(scene.time.dt)) {
        if (!options.wishes.empty()) plan_.emplace(layout, options.wishes, limits_of(scene, options, workers));
        for (std::size_t u = 0; u < layout.units.size(); ++u) {
            none_.push_back(trial_set_of(layout, layout.units[u], scene.calibration.max_failed));
            const bool is_wanted = !plan_ || plan_->needs(u);
            if (is_wanted &&
                u % static_cast<std::size_t>(options.shares) == static_cast<std::size_t>(options.share - 1))
                open(u, scene.calibration.max_failed);
        }
    }

    std::size_t units() const { return units_.size(); }
    std::size_t already() const { return already_; }
    std::size_t ran() const { return ran_; }

    Jobs jobs() {
        return {.next = [this] { return next(); },
                .work = [this](std::size_t job, const Send& send) { return run(job, send); },
                .received = [this](std::size_t job, const std::string& message) { take(job, message); },
                .ended = [this](std::size_t job, int status) { end(job, status); }};
    }

private:
    struct Unit {
        std::size_t unit;
        io::TrialFile file;
        calibrate::TrialSet trial_set;
        std::uint64_t next = 0;     ///< trials below it are done or running
        std::uint64_t planned = 0;  ///< for wanted numbers: trials below it are to run
        bool crashed = false;       ///< a worker crashed in it
        bool warned = false;        ///< of a failed trial
    };
    struct Job {
        std::size_t unit;
        std::uint64_t trial;
    };

    void open(std::size_t u, double max_failed) {
        const CalibrationUnit& unit = layout_.units[u];
        const fs::path file = trials_of(options_.folder, unit);
        Unit one{.unit = u,
                 .file = io::TrialFile(file, identity_of(layout_, unit)),
                 .trial_set = trial_set_of(layout_, unit, max_failed)};
        if (one.file.cut() > 0)
            log_warning(
                "{}: the last {} bytes are an incomplete trial; they were removed, and the trial will be repeated",
                file.string(), one.file.cut());
        for (const calibrate::Attempt& attempt : one.file.attempts()) one.trial_set.add(attempt);
        already_ += one.trial_set.count();
        units_.push_back(std::move(one));
    }

    std::optional<std::size_t> next() {
        const std::optional<std::size_t> job = next_needed();
        if (job || !plan_ || planned_at_ == ended_) return job;
        planned_at_ = ended_;
        make_plan();
        return next_needed();
    }

    std::optional<std::size_t> next_needed() {
        for (std::size_t m = 0; m < units_.size(); ++m) {
            Unit& one = units_[m];
            if (one.crashed || one.trial_set.ended()) continue;
            const std::uint64_t needed = plan_ ? one.planned : one.trial_set.needed();
            while (one.next < needed && one.trial_set.has(one.next)) ++one.next;
            if (one.next >= needed) continue;
            jobs_.push_back({.unit = m, .trial = one.next++});
            return jobs_.size() - 1;
        }
        return std::nullopt;
    }

    void make_plan() {
        std::vector<UnitProgress> progress;
        for (const calibrate::TrialSet& none : none_) progress.push_back({.trials = &none});
        for (const Unit& one : units_)
            progress[one.unit] = {.trials = &one.trial_set,
                                  .given = std::max<std::uint64_t>(one.next, one.trial_set.count()),
                                  .has_crashed = one.crashed};
        const std::vector<std::uint64_t> needed = plan_->next(progress);
        for (Unit& one : units_) one.planned = needed[one.unit];
    }

    /// In the worker.
    int run(std::size_t job, const Send& send) const {
        const auto& [m, trial] = jobs_[job];
        const CalibrationUnit& unit = layout_.units[units_[m].unit];
        calibrate::Attempt attempt{.number = trial, .numbers = {}, .failure = {}};
        try {
            attempt.numbers = calibrate::run_trial(layout_.assays[unit.assay], factory_, unit.conditions, trial);
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
            attempt.failure = error.what();
        }
        if (plan_) attempt.core_seconds = core_seconds();
        send(io::attempt_bytes(attempt));
        return 0;
    }

    void end(std::size_t job, int status) {
        const auto& [m, trial] = jobs_[job];
        ++ended_;
        if (status == 0 || stop_signal() != 0) return;  // interrupted: runs again on resume
        log_warning("{}: the worker of trial {} ended with status {}; skipping this measurement",
                    layout_.units[units_[m].unit].name, trial, status);
        units_[m].crashed = true;
    }

    void take(std::size_t job, const std::string& message) {
        const auto& [m, trial] = jobs_[job];
        Unit& one = units_[m];
        const std::string& name = layout_.units[one.unit].name;
        calibrate::Attempt attempt = io::attempt_of(message);
        if (!attempt.failure.empty() && !std::exchange(one.warned, true))
            log_warning("{}: trial {} failed: {} (further failures are counted, not reported)", name, trial,
                        attempt.failure);
        one.file.append(attempt);
        one.trial_set.add(std::move(attempt));
        ++ran_;
        if (!options_.quiet) report(one, name);
    }

    void report(const Unit& one, const std::string& name) {
        if (one.trial_set.ended()) log_information("{}: {}", name, result_text(one.trial_set));
        constexpr auto pause = std::chrono::seconds(30);
        const auto now = Clock::now();
        if (now - reported_ < pause) return;
        reported_ = now;
        const double seconds = std::chrono::duration<double>(now - start_).count();
        if (plan_) {
            for (const WantedValue& value : plan_->values())
                log_information("{}: {}, wanted to {:.2g}", value.text,
                                measured_text_with_error(value.result.value, value.cautious_error),
                                value.result.allowed);
            return log_information("{} trials in {}", ran_, duration_text(seconds));
        }
        const auto ended =
            std::count_if(units_.begin(), units_.end(), [](const Unit& m) { return m.trial_set.ended(); });
        log_information("{} of {} measurements done; {} trials in {}, one every {}; {}: {} of at least {} trials",
                        ended, units_.size(), ran_, duration_text(seconds),
                        duration_text(seconds / static_cast<double>(ran_)), name, one.trial_set.count(),
                        one.trial_set.needed());
    }

    const CalibrationLayout& layout_;
    const CalibrationOptions& options_;
    calibrate::SystemFactory factory_;
    std::vector<Unit> units_;
    std::vector<Job> jobs_;
    std::optional<WantPlan> plan_;           // for wanted numbers
    std::vector<calibrate::TrialSet> none_;  // by unit of the layout: no trials
    std::optional<std::size_t> planned_at_;  // trials that had ended at the last plan
    std::size_t already_ = 0, ran_ = 0, ended_ = 0;
    Clock::time_point start_ = Clock::now(), reported_ = start_;
};

/// The stored trials of all units, including those of other shares.
std::vector<calibrate::TrialSet> stored_trial_sets(const io::Scene& scene, const CalibrationLayout& layout,
                                                   const fs::path& folder) {
    std::vector<calibrate::TrialSet> trial_sets;
    for (const CalibrationUnit& unit : layout.units) {
        trial_sets.push_back(trial_set_of(layout, unit, scene.calibration.max_failed));
        for (calibrate::Attempt& attempt : io::read_trials(trials_of(folder, unit), identity_of(layout, unit)))
            trial_sets.back().add(std::move(attempt));
    }
    return trial_sets;
}

std::string hash_text(const std::string& words) { return text("{:016x}", files::fingerprint(words)); }

/// Provenance of the table, without what depends on time or machine: trials may come from several.
std::vector<files::Attribute> attributes_of(io::Scene scene) {
    scene.calibration.workers = 0;
    std::vector<files::Attribute> attributes = provenance(scene, 1, "calibrate");
    std::erase_if(attributes, [](const files::Attribute& one) {
        return one.first == "host" || one.first == "start_time" || one.first == "threads";
    });
    attributes.emplace_back("scene_hash", hash_text(io::resolved_text(scene)));
    return attributes;
}

void write_table(const io::Scene& scene, const fs::path& folder, CalibrationOutcome& outcome) {
    const std::vector<files::Attribute> attributes = attributes_of(scene);
    outcome.file = folder / "table.h5";
    io::write_calibration(outcome.file, *outcome.table, attributes);
    std::string heading;
    for (const auto& [name, value] : attributes)
        if (name != "scene")
            heading += name + " = " + std::visit([](const auto& held) { return toml_text(Value(held)); }, value) + "\n";
    files::replace_file(folder / "table.toml", calibration_toml(*outcome.table, heading));
}

void claim(const CalibrationLayout& layout, const CalibrationOptions& options) {
    const Version built = version();
    const std::string factory =
        text("# made by drover {} ({}{})", built.version, built.git_hash, built.dirty ? ", changed" : "");
    const std::string first =
        files::claim_folder(options.folder, calibration_manifest, factory, layout.manifest).first_line;
    if (first != factory)
        log_warning(
            "{}: its first trials were {}; this is drover {} ({}): if a change between them affects trials, "
            "start again in another folder",
            options.folder.string(), first.substr(2), built.version, built.git_hash);
}

void run_share(const io::Scene& scene, const CalibrationLayout& layout, const CalibrationOptions& options,
               CalibrationOutcome& outcome) {
    claim(layout, options);
    const int workers = scene.calibration.workers > 0 ? scene.calibration.workers : usable_cores();
    Work work(scene, layout, options, workers);
    outcome.units = work.units();
    outcome.already = work.already();
    if (!options.quiet)
        log_information("{} measurements{} ({} trials already done), {} trials at a time, in {}", work.units(),
                        options.shares > 1 ? text(", share {} of {}", options.share, options.shares) : "",
                        work.already(), workers, options.folder.string());
    const PoolOutcome pool = run_jobs(work.jobs(), {.workers = workers, .grace_period = grace_period});
    outcome.trials = work.ran();
    outcome.stopped = pool.stopped;
}
/// Whether all wanted quantities have a value and an error.
bool has_result(const calibrate::TrialSet& trial_set) {
    if (!trial_set.measurement()) return false;
    const std::vector<calibrate::Quantity>& quantities = trial_set.assay().quantities;
    for (std::size_t q = 0; q < quantities.size(); ++q)
        if (const measure::Estimate& found = trial_set.measurement()->estimates[q];
            quantities[q].wanted && (!found.error || !std::isfinite(found.mean)))
            return false;
    return true;
}

/// The layout of the assays that the wanted numbers need and of those that have trials in the folder, without a goal
/// for each.
CalibrationLayout wanted_layout(const io::Scene& scene, const CalibrationOptions& options) {
    CalibrationLayout layout = plan_calibration(scene);
    io::Scene part = scene;
    part.calibration.assays = needed_assays(layout, options.wishes);
    for (const CalibrationUnit& unit : layout.units)
        if (fs::exists(trials_of(options.folder, unit)))
            part.calibration.assays.push_back(layout.assays[unit.assay].name);
    layout = plan_calibration(part);
    layout.goal = calibrate::TrialSet::no_goal();
    return layout;
}

/// Takes all trials, and says what they give for the wanted numbers.
void conclude_want(const io::Scene& scene, const CalibrationLayout& layout, const CalibrationOptions& options,
                   std::vector<calibrate::TrialSet>& trial_sets, CalibrationOutcome& outcome) {
    WantPlan plan(layout, options.wishes, limits_of(scene, options, 1));
    std::vector<UnitProgress> progress;
    for (const calibrate::TrialSet& one : trial_sets) progress.push_back({.trials = &one, .given = one.count()});
    plan.next(progress);
    outcome.want = want_result(layout, plan, progress);
    for (const WantedValue& value : plan.values())
        if (!value.reached) ++outcome.unmet_wants;
    for (calibrate::TrialSet& one : trial_sets) one.take_all();
}
}  // namespace

CalibrationOutcome run_calibration(const io::Scene& scene, const CalibrationOptions& options) {
    const bool has_wishes = !options.wishes.empty();
    require(!has_wishes || options.shares == 1, {}, "wanted numbers with shares; expected all trials in one call");
    const CalibrationLayout layout = has_wishes ? wanted_layout(scene, options) : plan_calibration(scene);
    CalibrationOutcome outcome{.units = layout.units.size()};
    require(!options.collect || fs::is_directory(options.folder), {.file = options.folder.string()},
            "no such folder; expected the output folder of drover calibrate: set it with --output");
    if (options.collect) claim(layout, options);
    else run_share(scene, layout, options, outcome);
    std::vector<calibrate::TrialSet> trial_sets = stored_trial_sets(scene, layout, options.folder);
    if (has_wishes) conclude_want(scene, layout, options, trial_sets, outcome);
    for (std::size_t u = 0; !has_wishes && u < trial_sets.size(); ++u) {
        if (u % static_cast<std::size_t>(options.shares) != static_cast<std::size_t>(options.share - 1)) continue;
        const calibrate::TrialSet& one = trial_sets[u];
        if (!one.ended()) ++outcome.unfinished;
        else if (!has_result(one)) ++outcome.failed;
        else if (!one.measurement()->reached) ++outcome.unmet_targets;
    }
    if (options.shares > 1) return outcome;
    outcome.table = table_of(layout, trial_sets);
    write_table(scene, options.folder, outcome);
    return outcome;
}

}  // namespace drover::run
