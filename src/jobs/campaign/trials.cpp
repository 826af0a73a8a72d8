// jobs/campaign/trials.cpp: trials as a campaign, and their records.
#include "jobs/campaign/trials.hpp"

#include <algorithm>

#include "base/log.hpp"
#include "drover/base/error.hpp"
#include "files/archive_reader.hpp"
#include "files/bytes.hpp"
#include "files/checkpoint.hpp"
#include "run/loop/provenance.hpp"

namespace drover::jobs {

namespace {
namespace fs = std::filesystem;
constexpr const char* agreed_prefix = "agreed-";

/// Whether a unit is numbers to agree on, not a trial.
bool is_agreement(const std::string& key) { return key.starts_with(agreed_prefix); }

/// What a worker tells of a trial.
struct Ran {
    std::string name;
    TrialResult result;
    std::string old_failure = {};  ///< of a record of an earlier version, in which a failed trial was done
    bool is_of_machine = false;    ///< that one: the machine was too small
};

/// The members in their order, for a ByteWriter and a ByteReader.
template <class Order, class Of>
void members(Order& order, Of& ran) {
    auto& result = ran.result;
    order(ran.name, result.end, result.start_seconds, result.step_seconds, result.timed, result.host, result.run_id,
          ran.old_failure, ran.is_of_machine);
}

std::string bytes_of(const Ran& ran) {
    files::ByteWriter to;
    members(to, ran);
    return files::text_of(to.bytes);
}

Ran ran_of(const UnitRecord& record) {
    files::ByteReader reader{std::as_bytes(std::span(record.result.content))};
    Ran ran;
    members(reader, ran);
    require(reader.has_ended(), {record.key}, "is not a trial; expected a record of this version of drover");
    if (record.state != UnitState::done) ran.result.failure = record.reason;
    else if (!ran.old_failure.empty()) ran.result.failure = ran.old_failure;
    return ran;
}

/// Nothing when a signal came.
std::optional<TrialResult> run_trial(const TrialRun& trial) {
    TrialResult result{.end = trial.scene.time.end};
    const auto is_longer = [&](const fs::path& path) {  // another process has continued it beyond the end of this trial
        if (!files::has_checkpoint(path)) return false;
        const files::Checkpoint checkpoint = files::read_newest_checkpoint(path);
        if (checkpoint.time < result.end * (1.0 - 1e-9)) return false;
        result.end = checkpoint.time;
        result.run_id = checkpoint.run_id;
        return true;
    };
    const auto [end, outcome] = run_or_resume(trial.scene, trial.rounds_up, is_longer);
    if (end == RunEnd::stopped) return std::nullopt;
    if (end == RunEnd::found) return result;
    const auto steps = static_cast<double>(std::max<std::int64_t>(outcome.loop.step, 1));
    result.run_id = files::run_id_of(files::ArchiveReader(outcome.archive));
    result.step_seconds = outcome.loop.core_seconds;
    result.timed = result.end * (1.0 - static_cast<double>(outcome.loop.first) / steps);
    return result;
}

/// Runs that differ in their end alone are one trial.
std::string name_of(const TrialRun& trial) {
    io::Scene scene = trial.scene;
    scene.time.end = 0.0;
    scene.run.threads = 1;
    scene.output.file.clear();
    return text("trial-{:016x}{}", files::fingerprint(io::resolved_text(scene)), trial.rounds_up ? "-up" : "");
}

std::string key_of(const TrialRun& trial) { return text("{}-{:.17g}", name_of(trial), trial.scene.time.end); }

files::RecordIdentity trials_identity(const std::string& scene) { return files::identity_of("trials", scene); }

}  // namespace

Trials::Trials(const std::string& scene, const JobOptions& options)
    : options_(with_workers(options)),
      campaign_(plan(), {.job = options_, .identity = trials_identity(scene), .shares_wait = true, .max_group = 1}) {}

UnitPlan Trials::plan() {
    return {.wanted =
                [this](const Offer& offer) {
                    for (const Wanted& one : wanted_) {
                        const bool is_done = one.compute ? agreed_.contains(one.key) : find(one.trial) != nullptr;
                        if (!is_done && !offer(one.key)) return;
                    }
                },
            .run = [this](const std::string& key) { return run_one(wanted(key)); },
            .take = [this](const UnitRecord& record) { take(record); },
            .holds = [](const UnitRecord& record) { return is_agreement(record.key) || !ran_of(record).is_of_machine; },
            .failed = [this](const std::string& key, double seconds) { return failed(wanted(key), seconds); },
            .claim = [this](const std::string& key) { return wanted(key).name; }};
}

const Trials::Wanted& Trials::wanted(const std::string& key) const {
    return *std::ranges::find_if(wanted_, [&](const Wanted& one) { return one.key == key; });
}

/// In a worker.
std::optional<UnitResult> Trials::run_one(const Wanted& one) const {
    if (one.compute) {
        files::ByteWriter to;
        to(one.compute());
        return UnitResult{.content = files::text_of(to.bytes)};
    }
    const double start = run::core_seconds();
    try {
        std::optional<TrialResult> result = run_trial(one.trial);
        if (!result) return std::nullopt;
        result->host = files::host_name();
        result->start_seconds = run::core_seconds() - start - result->step_seconds;
        return UnitResult{.content = bytes_of({.name = one.name, .result = std::move(*result)})};
    } catch (const run::MixedFiles&) {
        throw;  // no failure of the trial
    } catch (const Error& error) {
        if (files::is_being_written(one.trial.scene.output.file))
            fail_environment("{}; run the command again", std::string(error.what()));
        throw;
    }
}

UnitResult Trials::failed(const Wanted& one, double seconds) {
    if (one.compute) return {};
    const double end = one.trial.scene.time.end;
    return {.content = bytes_of({one.name, {.end = end, .start_seconds = seconds, .host = files::host_name()}})};
}

void Trials::take(const UnitRecord& record) {
    if (taken_.contains(record.key)) return;
    const bool is_lost = record.state == UnitState::lost && !record.is_new;  // another machine may be large enough
    if (is_lost || (record.state != UnitState::done && record.result.content.empty()))
        lost_.insert_or_assign(record.key, record);
    else keep(record);
}

void Trials::keep(const UnitRecord& record) {
    lost_.erase(record.key);
    taken_.insert(record.key);
    if (is_agreement(record.key)) {
        files::ByteReader reader{std::as_bytes(std::span(record.result.content))};
        reader(agreed_[record.key]);
        return;
    }
    const Ran ran = ran_of(record);
    TrialResult& result = (ran.result.failure ? failed_ : results_)[ran.name];
    // The longest that ended, and the shortest that failed.
    const bool is_better =
        result.archive.empty() || (ran.result.failure ? ran.result.end < result.end : ran.result.end >= result.end);
    result.archive = options_.folder / (ran.name + ".h5");
    // One that is continued starts more than once.
    result.start_seconds = std::max(result.start_seconds, ran.result.start_seconds);
    result.step_seconds += ran.result.step_seconds;
    result.timed += ran.result.timed;
    if (!is_better) return;
    result.end = ran.result.end;
    result.host = ran.result.host;
    result.program = record.program;
    result.run_id = ran.result.run_id;
    result.failure = ran.result.failure;
}

const TrialResult* Trials::find(const TrialRun& trial) const {
    const std::string name = name_of(trial);
    const double end = trial.scene.time.end * (1.0 - 1e-9);
    if (const auto found = results_.find(name); found != results_.end() && found->second.end >= end)
        return &found->second;
    const auto failed = failed_.find(name);
    return failed != failed_.end() && trial.scene.time.end >= failed->second.end * (1.0 - 1e-9) ? &failed->second
                                                                                                : nullptr;
}

void Trials::require_archive(const TrialRun& trial, const TrialResult& result) const {
    run::require_archive_of(trial.scene, result.archive, run::End::any);
    const std::string found = files::run_id_of(files::ArchiveReader(result.archive));
    require(found == result.run_id, {.file = result.archive.string()},
            "the archive is of another run of this trial: run_id = {} there, {} in {}; expected the one that was "
            "written here: put it back, or choose another folder with --output",
            found.empty() ? "none" : found, result.run_id, (options_.folder / "records").string());
}

bool Trials::run(const std::vector<TrialRun>& trials) {
    if (options_.collect) return true;
    wanted_.clear();
    for (const TrialRun& trial : trials) {
        Wanted wanted{.key = key_of(trial), .name = name_of(trial), .trial = trial};
        const bool is_twice = std::ranges::any_of(wanted_, [&](const Wanted& one) { return one.name == wanted.name; });
        if (is_twice || find(trial) != nullptr) continue;
        const fs::path archive = options_.folder / (wanted.name + ".h5");
        wanted.trial.scene.output.file = archive.string();
        wanted.trial.scene.run.threads = 1;
        if (fs::exists(archive)) {
            const auto shorter = results_.find(wanted.name);
            if (shorter != results_.end()) require_archive(wanted.trial, shorter->second);
            else run::require_archive_of(wanted.trial.scene, archive, run::End::any);
        }
        wanted_.push_back(std::move(wanted));
    }
    return run_wanted();
}

bool Trials::run_wanted() {
    if (!options_.quiet && !wanted_.empty() && !wanted_.front().compute)
        log_information("{} trials, {} at a time, in {}", wanted_.size(), options_.workers, options_.folder.string());
    if (campaign_.run().stopped) return false;
    for (const Wanted& one : wanted_) {
        const auto found = lost_.find(one.key);
        if (found == lost_.end()) continue;
        const UnitRecord record = found->second;
        if (record.result.content.empty())
            fail_environment("{}: {}; run the command again to repeat it", one.key, record.reason);
        keep(record);  // several machines were too small
    }
    return true;
}

std::optional<std::vector<double>> Trials::agreed(const std::string& name,
                                                  const std::function<std::vector<double>()>& compute) {
    const std::string key = agreed_prefix + name;
    if (options_.collect && !agreed_.contains(key)) return compute();
    wanted_.assign(1, {.key = key, .name = key, .compute = compute});
    if (!run_wanted()) return std::nullopt;
    return agreed_.at(key);
}

std::string trials_status(const fs::path& folder, const std::string& scene) {
    std::size_t ended = 0, failed = 0;
    double seconds = 0.0;
    for (const UnitRecord& record : campaign_records(folder, trials_identity(scene))) {
        if (record.result.content.empty() || is_agreement(record.key)) continue;
        const Ran ran = ran_of(record);
        ++(ran.result.failure ? failed : ended);
        seconds += ran.result.seconds();
    }
    const Working working = working_in(folder);
    return text("{} trials done, {} failed, in {} of core time; {} running in {} processes", ended, failed,
                duration_text(seconds), working.units, working.processes);
}

}  // namespace drover::jobs
