// run/trials.cpp: trials on workers and their records.
#include "run/trials.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>

#include "drover/base/error.hpp"
#include "drover/files/run_id.hpp"
#include "drover/io/scene_text.hpp"
#include "drover/run/exit_status.hpp"
#include "drover/run/run_scene.hpp"
#include "drover/run/signals.hpp"
#include "drover/run/worker_pool.hpp"
#include "run/same_run.hpp"

namespace drover::run {

namespace {
namespace fs = std::filesystem;

constexpr const char* records_name = "trials.records";
RunOutcome run_or_continue(const Trial& trial) {
    const fs::path path = archive_path(trial.scene);
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

constexpr std::string_view id_sign = "run_id=";

std::string one_line(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return text;
}

/// Kinds of failures with which a study continues, without the trial.  Only those of the scene are recorded.
constexpr std::array kinds_of_failure{Fault::input, Fault::run, Fault::unavailable};

std::string prefix_of(Fault fault) { return fault_name(fault) + ": "; }

/// The kind of "run: the fields diverged".  Records of older versions hold no kind, so that a failure may be that of a
/// full disk.
std::optional<Fault> kind_of_failure(const std::string& failure) {
    for (const Fault fault : kinds_of_failure)
        if (failure.starts_with(prefix_of(fault))) return fault;
    return std::nullopt;
}

/// In a child process: runs a trial and makes its record.  Of a run that a signal stopped the record says how far it
/// came.  Throws what is neither a property of the scene nor of the machine.
int run_trial(const Trial& trial, const std::string& name, std::string& record) {
    double steps = 0.0, end = trial.scene.time.end;
    int status = exit_done;
    std::string failure, run_id;
    try {
        const RunOutcome outcome = run_or_continue(trial);
        run_id = files::run_id_of(files::ArchiveReader(outcome.archive));
        steps = outcome.loop.core_seconds;
        if (outcome.loop.signal != 0) {
            status = exit_stopped;
            end = outcome.checkpoint_time;
        }
    } catch (const Error& error) {
        if (std::find(kinds_of_failure.begin(), kinds_of_failure.end(), error.fault()) == kinds_of_failure.end()) throw;
        failure = prefix_of(error.fault()) + one_line(error.what());
    }
    record =
        text("{} {:.17g} {:.6g} {:.6g} {}{} {}", name, end, core_seconds() - steps, steps, id_sign, run_id, failure);
    return status;
}
}  // namespace

Trials::Trials(const fs::path& folder, const std::string& scene, int workers)
    : folder_(folder), workers_(workers), records_(folder / records_name, {files::fingerprint("trials"), scene}) {
    for (const std::string& record : records_.records()) take(record);
}

/// Runs that differ in their end alone are one trial.
std::string Trials::name_of(const Trial& trial) const {
    io::Scene scene = trial.scene;
    scene.time.end = 0.0;
    scene.output.file.clear();
    return text("trial-{:016x}{}", files::fingerprint(io::resolved_text(scene)), trial.rounds_up ? "-up" : "");
}

/// A record: name, end, core seconds of start and of steps, run id, failure with its kind.  One that failed for an
/// unknown reason is passed over: the trial is repeated.
void Trials::take(const std::string& record) {
    std::istringstream words(record);
    std::string name, failure;
    double end = 0.0, start = 0.0, steps = 0.0;
    words >> name >> end >> start >> steps;
    std::getline(words >> std::ws, failure);
    std::string run_id;
    if (failure.starts_with(id_sign)) {
        const std::size_t space = failure.find(' ');
        run_id = failure.substr(id_sign.size(), space - id_sign.size());
        failure.erase(0, space == std::string::npos ? space : space + 1);
    }
    const std::optional<Fault> kind = kind_of_failure(failure);
    if (!failure.empty() && !kind) return;
    TrialResult& result = results_[name];
    result.archive = folder_ / (name + ".h5");
    result.end = end;
    result.start_seconds = std::max(result.start_seconds, start);  // one that is continued starts more than once
    result.step_seconds += steps;
    result.run_id = run_id;
    result.failure = kind ? failure.substr(prefix_of(*kind).size()) : "";
    result.is_recorded = !kind || is_of_scene(*kind);
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
    require(result.run_id.empty() || found == result.run_id, {.file = result.archive.string()},
            "the archive is of another run of this trial: run_id = {} there, {} in {}; expected the one that was "
            "written here: put it back, or choose another folder with --output",
            found.empty() ? "none" : found, result.run_id, (folder_ / records_name).string());
}

bool Trials::run(const std::vector<Trial>& trials) {
    std::vector<Trial> missing;
    std::vector<std::string> names;
    for (const Trial& trial : trials) {
        const std::string name = name_of(trial);
        if (find(trial) != nullptr || std::find(names.begin(), names.end(), name) != names.end()) continue;
        missing.push_back(trial);
        missing.back().scene.output.file = (folder_ / (name + ".h5")).string();
        missing.back().scene.run.threads = 1;
        const fs::path& archive = missing.back().scene.output.file;
        if (fs::exists(archive)) {
            const auto shorter = results_.find(name);
            if (shorter != results_.end() && shorter->second.failure.empty())
                require_archive(missing.back(), shorter->second);
            else require_archive_of(missing.back().scene, archive);
        }
        names.push_back(name);
    }
    std::size_t next = 0;
    std::vector<bool> has_record(missing.size(), false);
    const Jobs jobs{.next = [&]() -> std::optional<std::size_t> {
                        if (next == missing.size()) return std::nullopt;
                        return next++;
                    },
                    .work =
                        [&](std::size_t job, const Send& send) {
                            std::string record;
                            const int status = run_trial(missing[job], names[job], record);
                            send(record);
                            return status;
                        },
                    .received =
                        [&](std::size_t job, const std::string& record) {
                            has_record[job] = true;
                            take(record);
                            if (results_[names[job]].is_recorded) records_.append(record);
                        },
                    .ended =
                        [&](std::size_t job, int status) {
                            if (has_record[job] || stop_signal() != 0) return;
                            fail_environment("the trial {} ended with status {}; run the command again to repeat it",
                                             names[job], status);
                        }};
    return !run_jobs(jobs, {.workers = workers_}).stopped;
}

}  // namespace drover::run
