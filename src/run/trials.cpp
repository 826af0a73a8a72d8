// run/trials.cpp: trials as a campaign, and their records.
#include "run/trials.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "drover/base/error.hpp"
#include "drover/files/bytes.hpp"
#include "drover/files/run_id.hpp"
#include "drover/io/scene_text.hpp"
#include "drover/run/run_scene.hpp"
#include "drover/run/signals.hpp"
#include "run/same_run.hpp"

namespace drover::run {

namespace {
namespace fs = std::filesystem;

/// What a worker tells of a trial.
struct Ran {
    std::string name;
    TrialResult result;
    bool is_of_machine = false;  ///< a failure of a machine that is too small: the next command tries again
};

std::string bytes_of(const Ran& ran) {
    std::vector<std::byte> bytes;
    files::put_text(bytes, ran.name);
    for (const double number : {ran.result.end, ran.result.start_seconds, ran.result.step_seconds, ran.result.timed})
        files::put(bytes, number);
    files::put_text(bytes, ran.result.host);
    files::put_text(bytes, ran.result.run_id);
    files::put_text(bytes, ran.result.failure);
    files::put(bytes, static_cast<std::uint8_t>(ran.is_of_machine));
    return files::text_of(bytes);
}

Ran ran_of(const UnitRecord& record) {
    files::ByteReader reader{std::as_bytes(std::span(record.result.content))};
    Ran ran{.name = reader.take_list<std::string>(), .result = {}};
    for (double* number : {&ran.result.end, &ran.result.start_seconds, &ran.result.step_seconds, &ran.result.timed})
        *number = reader.take<double>();
    ran.result.host = reader.take_list<std::string>();
    ran.result.run_id = reader.take_list<std::string>();
    ran.result.failure = reader.take_list<std::string>();
    ran.is_of_machine = reader.take<std::uint8_t>() != 0;
    require(reader.is_complete && reader.rest.empty(), {record.key},
            "is not a trial; expected a record of this version of drover");
    return ran;
}

/// Where another process is at a shorter run of the same trial, this one continues it.
void wait_for_other(const fs::path& archive) {
    while (stop_signal() == 0 && files::is_being_written(archive))
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

RunOutcome run_or_continue(const Trial& trial) {
    const fs::path path = archive_path(trial.scene);
    wait_for_other(path);
    const RunOptions options{.overwrite = true, .quiet = true, .rounds_up = trial.rounds_up};
    if (fs::exists(path) && has_checkpoint(path)) {
        try {
            const std::vector<std::string> end{text("time.end={:.17g}", trial.scene.time.end)};
            return restart_run(path, end, options);
        } catch (const Error& error) {
            if (error.fault() != Fault::input) throw;  // else its files are damaged: from the start
        }
    }
    return run_scene(trial.scene, options);
}

/// Runs that differ in their end alone are one trial.
std::string name_of(const Trial& trial) {
    io::Scene scene = trial.scene;
    scene.time.end = 0.0;
    scene.output.file.clear();
    return text("trial-{:016x}{}", files::fingerprint(io::resolved_text(scene)), trial.rounds_up ? "-up" : "");
}

std::string key_of(const Trial& trial) { return text("{}-{:.17g}", name_of(trial), trial.scene.time.end); }

files::RecordIdentity identity_of(const std::string& scene) {
    return {.hash = files::fingerprint("trials\n" + scene), .content = scene};
}

CampaignOptions campaign_options(const fs::path& folder, const std::string& scene, const TrialOptions& options) {
    return {.folder = folder,
            .identity = identity_of(scene),
            .share = options.share,
            .workers = options.workers,
            .quiet = options.quiet,
            .shares_wait = true};
}
}  // namespace

Trials::Trials(const fs::path& folder, const std::string& scene, const TrialOptions& options)
    : folder_(folder), options_(options), campaign_(plan(), campaign_options(folder, scene, options)) {}

UnitPlan Trials::plan() {
    return {.wanted =
                [this](const Offer& offer) {
                    for (const auto& [key, wanted] : wanted_)
                        if (find(wanted.trial) == nullptr && !offer(key)) return;
                },
            .run = [this](const std::string& key) { return run_one(key); },
            .take = [this](const UnitRecord& record) { take(record); },
            .holds = [](const UnitRecord& record) { return !ran_of(record).is_of_machine; }};
}

/// In a worker.
std::optional<UnitResult> Trials::run_one(const std::string& key) const {
    const auto& [trial, name] = wanted_.at(key);
    Ran ran{.name = name, .result = {.end = trial.scene.time.end, .host = files::this_process(1, 1, 1).host}};
    const double start = core_seconds();
    try {
        const RunOutcome outcome = run_or_continue(trial);
        if (outcome.loop.signal != 0) return std::nullopt;
        const auto steps = static_cast<double>(std::max<std::int64_t>(outcome.loop.step, 1));
        ran.result.run_id = files::run_id_of(files::ArchiveReader(outcome.archive));
        ran.result.step_seconds = outcome.loop.core_seconds;
        ran.result.timed = ran.result.end * (1.0 - static_cast<double>(outcome.loop.first) / steps);
    } catch (const Error& error) {
        if (!is_of_scene(error.fault()) && error.fault() != Fault::unavailable) throw;
        ran.result.failure = error.what();
        ran.is_of_machine = !is_of_scene(error.fault());
    }
    ran.result.start_seconds = core_seconds() - start - ran.result.step_seconds;
    return UnitResult{.content = bytes_of(ran)};
}

void Trials::take(const UnitRecord& record) {
    if (record.state != UnitState::done) {
        if (record.is_new) crash_ = text("{}: {}", record.key, record.reason);
        return;
    }
    if (!taken_.insert(record.key).second) return;
    const Ran ran = ran_of(record);
    TrialResult& result = results_[ran.name];
    const bool is_longer = ran.result.end >= result.end;
    result.archive = folder_ / (ran.name + ".h5");
    result.end = std::max(result.end, ran.result.end);
    // One that is continued starts more than once.
    result.start_seconds = std::max(result.start_seconds, ran.result.start_seconds);
    result.step_seconds += ran.result.step_seconds;
    result.timed += ran.result.timed;
    if (!is_longer) return;
    result.host = ran.result.host;
    result.run_id = ran.result.run_id;
    result.failure = ran.result.failure;
}

const TrialResult* Trials::find(const Trial& trial) const {
    const auto found = results_.find(name_of(trial));
    if (found == results_.end()) return nullptr;
    const TrialResult& result = found->second;
    return !result.failure.empty() || result.end >= trial.scene.time.end * (1.0 - 1e-9) ? &result : nullptr;
}

void Trials::require_archive(const Trial& trial, const TrialResult& result) const {
    require_archive_of(trial.scene, result.archive);
    const std::string found = files::run_id_of(files::ArchiveReader(result.archive));
    require(found == result.run_id, {.file = result.archive.string()},
            "the archive is of another run of this trial: run_id = {} there, {} in {}; expected the one that was "
            "written here: put it back, or choose another folder with --output",
            found.empty() ? "none" : found, result.run_id, (folder_ / "records").string());
}

bool Trials::run(const std::vector<Trial>& trials) {
    if (options_.collect) return true;
    wanted_.clear();
    for (const Trial& trial : trials) {
        if (find(trial) != nullptr) continue;
        Wanted wanted{.trial = trial, .name = name_of(trial)};
        const fs::path archive = folder_ / (wanted.name + ".h5");
        wanted.trial.scene.output.file = archive.string();
        wanted.trial.scene.run.threads = 1;
        const auto shorter = results_.find(wanted.name);
        if (fs::exists(archive)) {
            if (shorter != results_.end()) require_archive(wanted.trial, shorter->second);
            else require_archive_of(wanted.trial.scene, archive);
        }
        wanted_.emplace(key_of(trial), std::move(wanted));
    }
    crash_.clear();
    const bool stopped = campaign_.run().stopped;
    if (!crash_.empty() && !stopped) fail_environment("{}; run the command again to repeat it", crash_);
    return !stopped;
}

std::string trials_status(const fs::path& folder, const std::string& scene) {
    std::size_t ended = 0, failed = 0;
    double seconds = 0.0;
    for (const UnitRecord& record : campaign_records(folder, identity_of(scene))) {
        if (record.state != UnitState::done) continue;
        const Ran ran = ran_of(record);
        ++(ran.result.failure.empty() ? ended : failed);
        seconds += ran.result.seconds();
    }
    const Working working = working_in(folder);
    return text("{} trials done, {} failed, in {} of core time; {} running in {} processes", ended, failed,
                duration_text(seconds), working.units, working.processes);
}

}  // namespace drover::run
