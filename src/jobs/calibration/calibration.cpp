// jobs/calibration/calibration.cpp: the trials of a calibration as a campaign, and the table that comes of them.
#include "jobs/calibration/calibration.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>
#include <utility>

#include "base/duration.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"
#include "files/record_folder.hpp"
#include "io/calibration.hpp"
#include "jobs/calibration/target_plan.hpp"
#include "jobs/campaign/campaign.hpp"
#include "run/loop/provenance.hpp"
#include "run/loop/simulation.hpp"

namespace drover::jobs {

namespace {
namespace fs = std::filesystem;
constexpr const char* calibration_manifest = "calibrate.toml";
constexpr double grace_period = 5.0;  // for running trials after a signal [s]; the program then ends within 10 s
constexpr std::string_view before_number = "-trial-";

/// One trial: its unit in the layout, and its number.
struct TrialPlace {
    std::size_t unit = 0;
    std::uint64_t number = 0;
};

/// The trials of a calibration in its folder.
class StoredTrials {
public:
    StoredTrials(const io::Scene& scene, const CalibrationLayout& of, const fs::path& folder)
        : layout(of), max_failed_(scene.calibration.max_failed), folder_(folder) {
        for (std::size_t u = 0; u < layout.units.size(); ++u) units_[layout.units[u].name] = u;
    }

    const CalibrationLayout& layout;

    files::RecordIdentity identity() const { return files::identity_of("calibrate", layout.manifest); }
    std::string key_of(const TrialPlace& trial) const {
        return text("{}{}{}", layout.units[trial.unit].name, before_number, trial.number);
    }
    /// Nothing for a trial at another point.
    std::optional<TrialPlace> find(const std::string& key) const {
        const std::size_t at = key.rfind(before_number);
        const auto unit = units_.find(key.substr(0, at));
        if (at == std::string::npos || unit == units_.end()) return std::nullopt;
        TrialPlace place{.unit = unit->second};
        std::from_chars(key.data() + at + before_number.size(), key.data() + key.size(), place.number);
        return place;
    }

    /// With the plan of its assay, which the trials have in common.
    UnitResult encoded(const TrialPlace& trial, calibrate::Attempt attempt) const {
        attempt.number = trial.number;
        return {.content = io::attempt_bytes(attempt), .shared = plan_of(trial.unit)};
    }
    /// Throws an input Error for a trial of another plan.
    calibrate::Attempt decoded(const TrialPlace& trial, const UnitRecord& record) const {
        const std::string& plan = plan_of(trial.unit);
        require(record.result.shared == plan || files::are_same(record.result.shared, plan, layout.defaults),
                {.file = (folder_ / "records").string()},
                "the trials of {} have another plan: {}; choose another folder with --output",
                layout.units[trial.unit].name, files::difference(record.result.shared, plan));
        calibrate::Attempt attempt = io::attempt_of(record.result.content, record.key);
        if (record.state != UnitState::done) attempt.failure = record.reason;
        return attempt;
    }

    /// Of each unit, those of all processes.
    std::vector<calibrate::TrialSet> read() const {
        std::vector<calibrate::TrialSet> sets;
        for (const CalibrationUnit& unit : layout.units)
            sets.emplace_back(layout.assays[unit.assay], layout.goal, max_failed_);
        for (const UnitRecord& record : campaign_records(folder_, identity()))
            if (const auto trial = find(record.key); trial && record.state != UnitState::lost)
                sets[trial->unit].add(decoded(*trial, record));
        return sets;
    }

private:
    const std::string& plan_of(std::size_t unit) const { return layout.plans[layout.units[unit].assay]; }

    double max_failed_;
    const fs::path& folder_;
    std::map<std::string, std::size_t> units_;  ///< by name
};

std::string result_text(const calibrate::TrialSet& trial_set) {
    if (trial_set.failure_reason()) return "failed: " + *trial_set.failure_reason();
    const calibrate::Measurement& found = *trial_set.measurement();
    const measure::Estimate& first = found.estimates.front();
    const calibrate::Quantity& quantity = trial_set.assay().quantities.front();
    const std::string failed = trial_set.failed() > 0 ? text(", {} failed", trial_set.failed()) : "";
    if (!first.error)
        return text("{}: no error estimate after {} trials{}: {}", quantity.name, found.trials, failed,
                    first.why_no_error);
    return text("{} = {} {} from {} trials{}{}{}", quantity.name, measured_text_with_error(first.mean, *first.error),
                quantity.unit, found.trials, failed, found.reached ? "" : ", with a larger error than requested",
                found.diagnosis.empty() ? "" : "; " + found.diagnosis);
}

TargetLimits limits_of(const io::Scene& scene, const TargetOptions& options, int workers) {
    return {.max_trials = static_cast<std::size_t>(scene.calibration.max_trials),
            .budget = options.budget,
            .workers = static_cast<std::size_t>(workers)};
}

/// The plan of a campaign: which trials are still needed, from those that have ended anywhere.
class NeededTrials {
public:
    NeededTrials(const io::Scene& scene, const StoredTrials& stored, const TargetOptions& options, int workers)
        : stored_(stored), options_(options), factory_(calibrate::system_factory(scene.time.dt)) {
        if (!options.targets.empty())
            wanted_.emplace(stored.layout, options.targets, limits_of(scene, options, workers));
        for (calibrate::TrialSet& one : stored.read()) units_.push_back({.trials = std::move(one)});
        for (std::size_t u = 0; u < units_.size(); ++u)
            if (!wanted_ || wanted_->needs(u)) already_ += units_[u].trials.count();
        make_plan();
    }

    /// Trials that were present, of those that count.
    std::size_t already() const { return already_; }

    UnitPlan plan() {
        return {.wanted = [this](const Offer& offer) { want(offer); },
                .run = [this](const std::string& key) { return run(*stored_.find(key)); },
                .take = [this](const UnitRecord& record) { take(record); },
                .failed =
                    [this](const std::string& key, double seconds) {
                        return stored_.encoded(*stored_.find(key), {.core_seconds = seconds});
                    }};
    }

    /// Measurements that were given up here, as a worker died in a trial.
    std::size_t crashed() const {
        return static_cast<std::size_t>(std::ranges::count_if(units_, [](const Unit& one) { return one.has_crashed; }));
    }

    /// Those below which all trials of a unit are needed as far as is known.
    std::uint64_t needed(std::size_t unit) const {
        const Unit& one = units_[unit];
        if (wanted_) return one.planned;
        return one.trials.needed();
    }
    const calibrate::TrialSet& trials(std::size_t unit) const { return units_[unit].trials; }
    const std::vector<TargetProgress>* values() const { return wanted_ ? &wanted_->values() : nullptr; }

private:
    struct Unit {
        calibrate::TrialSet trials;
        std::uint64_t next = 0;     ///< trials below it have ended
        std::uint64_t planned = 0;  ///< for wanted numbers: trials below it are to run
        bool has_crashed = false;   ///< a worker of this process did, in a trial
        bool has_warned = false;    ///< of a failed trial
    };

    void want(const Offer& offer) {
        if (!offer_needed(offer) || !wanted_ || planned_at_ == ended_) return;
        make_plan();
        offer_needed(offer);
    }

    /// Whether more are welcome.
    bool offer_needed(const Offer& offer) {
        for (std::size_t i = 0; i < units_.size(); ++i) {
            const std::size_t u = options_.share.nth(i, units_.size());
            Unit& one = units_[u];
            if (one.has_crashed || one.trials.ended()) continue;
            while (one.trials.has(one.next)) ++one.next;
            for (std::uint64_t n = one.next; n < needed(u); ++n)
                if (!one.trials.has(n) && !offer(stored_.key_of({.unit = u, .number = n}))) return false;
        }
        return true;
    }

    void make_plan() {
        planned_at_ = ended_;
        if (!wanted_) return;
        const std::vector<std::uint64_t> planned = wanted_->next(mapped(units_, [](const Unit& one) {
            return UnitProgress{.trials = &one.trials,
                                .given = std::max<std::uint64_t>(one.planned, one.trials.count()),
                                .has_crashed = one.has_crashed};
        }));
        for (std::size_t u = 0; u < units_.size(); ++u) units_[u].planned = wanted_->needs(u) ? planned[u] : 0;
    }

    /// In the worker.
    UnitResult run(const TrialPlace& trial) const {
        const CalibrationUnit& unit = stored_.layout.units[trial.unit];
        const double start = run::core_seconds();
        calibrate::Trial numbers =
            calibrate::run_trial(stored_.layout.assays[unit.assay], factory_, unit.conditions, trial.number);
        return stored_.encoded(trial, {.numbers = std::move(numbers), .core_seconds = run::core_seconds() - start});
    }

    void take(const UnitRecord& record) {
        const auto trial = stored_.find(record.key);
        if (!trial) return;
        Unit& one = units_[trial->unit];
        const std::string& name = stored_.layout.units[trial->unit].name;
        ++ended_;
        if (record.state == UnitState::lost) {
            if (!record.is_new) return;
            log_warning("{}: trial {}: {}; skipping this measurement", name, trial->number, record.reason);
            one.has_crashed = true;
            return;
        }
        calibrate::Attempt attempt = stored_.decoded(*trial, record);
        if (record.is_new && attempt.failure && !std::exchange(one.has_warned, true))
            log_warning("{}: trial {} failed: {} (further failures are counted, not reported)", name, trial->number,
                        *attempt.failure);
        const bool had_ended = one.trials.ended();
        one.trials.add(std::move(attempt));
        if (!record.is_new) return;
        ++ran_;
        if (!options_.quiet) report(one, name, had_ended);
    }

    void report(const Unit& one, const std::string& name, bool had_ended) {
        if (one.trials.ended() && !had_ended) log_information("{}: {}", name, result_text(one.trials));
        constexpr auto pause = std::chrono::seconds(30);
        const auto now = Clock::now();
        if (now - reported_ < pause) return;
        reported_ = now;
        const double seconds = std::chrono::duration<double>(now - start_).count();
        if (wanted_) {
            for (const TargetProgress& value : wanted_->values())
                if (std::isfinite(value.result.value) && value.result.error > 0.0)
                    log_information("{}: {}, wanted to {:.2g}", value.text,
                                    measured_text_with_error(value.result.value, value.cautious_error),
                                    value.result.allowed);
                else log_information("{}: not known yet", value.text);
            return log_information("{} trials in {}", ran_, duration_text(seconds));
        }
        const auto ended = std::ranges::count_if(units_, [](const Unit& m) { return m.trials.ended(); });
        log_information("{} of {} measurements done; {} trials in {}, one every {}; {}: {} of at least {} trials",
                        ended, units_.size(), ran_, duration_text(seconds),
                        duration_text(seconds / static_cast<double>(ran_)), name, one.trials.count(),
                        one.trials.needed());
    }

    const StoredTrials& stored_;
    const TargetOptions& options_;
    calibrate::SystemFactory factory_;
    std::vector<Unit> units_;           // as in the layout
    std::optional<TargetPlan> wanted_;  // for wanted numbers
    std::size_t planned_at_ = 0;        // trials that had ended at the last plan
    std::size_t already_ = 0, ran_ = 0, ended_ = 0;
    Clock::time_point start_ = Clock::now(), reported_ = start_;
};

void write_table(io::Scene scene, const fs::path& folder, CalibrationOutcome& outcome) {
    scene.calibration.workers = 0;
    std::vector<files::Attribute> attributes = run::shared_provenance(scene, "calibrate");
    attributes.emplace_back("scene_hash", text("{:016x}", files::fingerprint(io::resolved_text(scene))));
    outcome.file = folder / "table.h5";
    io::write_calibration(outcome.file, *outcome.table, attributes);
    std::string heading;
    for (const auto& [name, value] : attributes)
        if (name != "scene")
            heading += name + " = " + std::visit([](const auto& held) { return toml_text(Value(held)); }, value) + "\n";
    files::replace_file(folder / "table.toml", calibration_toml(*outcome.table, heading));
}

void warn_of_idle_keys(const io::Scene& scene) {
    const auto is_idle = [](const std::string& key) { return key.starts_with("forces") || key.starts_with("packing"); };
    io::Scene alone = scene;
    alone.particles.forces = {};
    alone.particles.packing = {};
    if (io::chosen_text(scene, is_idle) != io::chosen_text(alone, is_idle))
        log_warning(
            "[forces] and [packing] have no effect on drover calibrate: its assays place the bodies and act on them "
            "themselves");
}

/// The plan in a folder.  Trials there that a version of drover with other keys began keep their manifest.
CalibrationLayout plan_in(const fs::path& folder, const io::Scene& scene) {
    CalibrationLayout layout = plan_calibration(scene);
    const fs::path file = folder / calibration_manifest;
    if (!fs::exists(file)) return layout;
    for (const fs::directory_entry& one : fs::directory_iterator(folder))
        require(fs::exists(folder / "records") || one.path().extension() != ".trials", {},
                "{} holds trials of an earlier version of drover, such as {}, which this version does not read; use "
                "the version that wrote them, or another folder with --output",
                folder.string(), one.path().filename().string());
    std::string there = files::read_text(file, "the scene of a calibration");
    there.erase(0, files::first_line(there).size() + 1);  // the version
    if (files::are_same(there, layout.manifest, layout.defaults)) layout.manifest = there;
    return layout;
}

void join(const io::Scene& scene, const TargetOptions& options) {
    const CalibrationLayout layout = plan_in(options.folder, scene);
    warn_of_idle_keys(scene);
    needed_assays(layout, options.targets);  // targets that it cannot answer are rejected before there is a folder
    const std::string factory = "# made by drover " + run::this_program();
    const std::string first = files::join_folder(options.folder, calibration_manifest, factory, layout.manifest);
    if (first != factory)
        log_warning("{}",
                    other_program_text(text("{}: its first trials were {}", options.folder.string(), first.substr(2)),
                                       "the calibration"));
}

void run_trials(const io::Scene& scene, const StoredTrials& stored, const TargetOptions& options,
                CalibrationOutcome& outcome) {
    const JobOptions job = with_workers(options, scene.calibration.workers);
    NeededTrials needed(scene, stored, options, job.workers);
    outcome.already = needed.already();
    if (!options.quiet)
        log_information("{} measurements ({} trials already done), {} trials at a time, in {}", outcome.units,
                        outcome.already, job.workers, options.folder.string());
    const CampaignOutcome ran =
        Campaign(needed.plan(),
                 {.job = job, .identity = stored.identity(), .grace_period = grace_period, .shares_wait = true})
            .run();
    outcome.trials = ran.ran;
    outcome.stopped = ran.stopped;
    outcome.crashed = needed.crashed();
}

/// For wanted numbers: the layout of the assays that they need and of those that have trials in the folder, without a
/// goal for each.
CalibrationLayout layout_for(const io::Scene& scene, const TargetOptions& options) {
    CalibrationLayout layout = plan_in(options.folder, scene);
    if (options.targets.empty()) return layout;
    io::Scene part = scene;
    part.calibration.assays = needed_assays(layout, options.targets);
    const std::vector<calibrate::TrialSet> present = StoredTrials(scene, layout, options.folder).read();
    for (std::size_t u = 0; u < layout.units.size(); ++u)
        if (present[u].count() > 0) part.calibration.assays.push_back(layout.assays[layout.units[u].assay].name);
    layout = plan_in(options.folder, part);
    layout.goal = calibrate::TrialSet::no_goal();
    return layout;
}

/// Takes all trials, and says what they give for the wanted numbers.
void conclude_want(const io::Scene& scene, const CalibrationLayout& layout, const TargetOptions& options,
                   std::vector<calibrate::TrialSet>& trial_sets, CalibrationOutcome& outcome) {
    TargetPlan plan(layout, options.targets, limits_of(scene, options, 1));
    std::vector<UnitProgress> progress;
    for (const calibrate::TrialSet& one : trial_sets) progress.push_back({.trials = &one, .given = one.count()});
    plan.next(progress);
    outcome.want = target_result(layout, plan, progress);
    for (const TargetProgress& value : plan.values())
        if (!value.reached) ++outcome.unmet_wants;
    for (calibrate::TrialSet& one : trial_sets) one.take_all();
}
}  // namespace

CalibrationOutcome run_calibration(const io::Scene& scene, const TargetOptions& options) {
    if (options.collect) require_folder(options.folder, "calibrate");
    join(scene, options);
    const CalibrationLayout layout = layout_for(scene, options);
    const StoredTrials stored(scene, layout, options.folder);
    CalibrationOutcome outcome{.units = layout.units.size()};
    if (!options.collect) run_trials(scene, stored, options, outcome);
    std::vector<calibrate::TrialSet> trial_sets;
    const auto read = [&] {
        trial_sets = stored.read();
        if (options.collect)
            outcome.already = std::transform_reduce(trial_sets.begin(), trial_sets.end(), std::size_t{0}, std::plus<>(),
                                                    [](const calibrate::TrialSet& one) { return one.count(); });
        outcome.unfinished = outcome.failed = outcome.unmet_targets = 0;
        for (const calibrate::TrialSet& one : trial_sets) {
            if (!options.targets.empty()) break;
            if (!one.ended()) ++outcome.unfinished;
            else if (!one.has_result()) ++outcome.failed;
            else if (!one.measurement()->reached) ++outcome.unmet_targets;
        }
        return outcome.unfinished == 0 && !outcome.stopped;
    };
    conclude(options, read, [&](bool) {
        if (!options.targets.empty()) conclude_want(scene, layout, options, trial_sets, outcome);
        outcome.table = table_of(layout, trial_sets);
        write_table(scene, options.folder, outcome);
    });
    return outcome;
}

std::string calibration_status(const io::Scene& scene, const TargetOptions& options) {
    require_folder(options.folder, "calibrate");
    const CalibrationLayout layout = layout_for(scene, options);
    const StoredTrials stored(scene, layout, options.folder);
    const NeededTrials needed(scene, stored, options, with_workers(options, scene.calibration.workers).workers);
    const std::vector<UnitRecord> records = campaign_records(options.folder, stored.identity());
    std::vector<std::string> keys;
    for (const UnitRecord& record : records)
        if (record.state != UnitState::lost && stored.find(record.key)) keys.push_back(record.key);
    std::size_t ended = 0;
    for (std::size_t u = 0; u < layout.units.size(); ++u) {
        if (needed.trials(u).ended()) ++ended;
        else
            for (std::uint64_t n = 0; n < needed.needed(u); ++n)
                if (!needed.trials(u).has(n)) keys.push_back(stored.key_of({.unit = u, .number = n}));
    }
    std::string done = text("{} of {} measurements done", ended, layout.units.size());
    if (const std::vector<TargetProgress>* values = needed.values())
        done =
            text("{} of {} wanted numbers reached",
                 std::ranges::count_if(*values, [](const TargetProgress& one) { return one.reached; }), values->size());
    return done + "; of the trials that are known to be needed: " + campaign_status(options.folder, records, keys);
}

}  // namespace drover::jobs
