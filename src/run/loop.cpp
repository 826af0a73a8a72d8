// run/loop.cpp: the main loop.
#include "drover/run/loop.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>

#include "drover/base/log.hpp"
#include "drover/files/checkpoint.hpp"
#include "drover/run/progress.hpp"
#include "drover/run/signals.hpp"

namespace drover::run {

namespace {
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

void append_row(const Simulation& simulation, std::size_t r, std::int64_t step, files::Archive& archive) {
    archive.append(r, static_cast<double>(step) * simulation.dt, simulation.recordings[r].observe(), step);
}

/// Appends the rows due at a step; true when one of them is a frame, which is committed at once so that at most one can
/// be lost.
bool append_due(const Simulation& simulation, std::int64_t step, files::Archive& archive) {
    bool frame = false;
    for (std::size_t r = 0; r < simulation.recordings.size(); ++r) {
        const ScheduledRecording& scheduled = simulation.recordings[r];
        if (!is_due(scheduled, step)) continue;
        append_row(simulation, r, step, archive);
        frame = frame || scheduled.recording.rows_per_chunk == 1;
    }
    return frame;
}

void save(const Simulation& simulation, std::int64_t step, files::Archive& archive, const LoopFiles& files) {
    archive.commit();  // first: a checkpoint never counts rows that the archive does not have
    files::Checkpoint checkpoint{.scene = files.scene,
                                 .step = step,
                                 .time = static_cast<double>(step) * simulation.dt,
                                 .rows = {},
                                 .state = simulation.save()};
    for (const std::size_t rows : archive.rows()) checkpoint.rows.push_back(rows);
    files::write_checkpoint(files.archive, checkpoint);
}

/// Every recording has a row of the last step.  It is written after the last checkpoint, which counts only scheduled
/// rows: a run that is extended later has the same rows as one of that length from the start.
void append_last(const Simulation& simulation, std::int64_t step, files::Archive& archive) {
    for (std::size_t r = 0; r < simulation.recordings.size(); ++r) {
        if (!is_due(simulation.recordings[r], step)) append_row(simulation, r, step, archive);
    }
    archive.commit();
}
}  // namespace

double core_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

LoopOutcome run_loop(Simulation& simulation, std::int64_t first, files::Archive& archive, const LoopFiles& files,
                     bool quiet) {
    const Clock::time_point start = Clock::now();
    const double core_start = core_seconds();
    Clock::time_point last_commit = start, last_checkpoint = start;
    constexpr double seconds_between_commits = 30.0;
    Progress progress(first, simulation.steps, simulation.dt, quiet);
    const std::vector<std::size_t> rows = archive.rows();
    if (std::all_of(rows.begin(), rows.end(), [](std::size_t count) { return count == 0; })) {
        simulation.check_health(0);
        append_due(simulation, 0, archive);
        save(simulation, 0, archive, files);
    }
    std::int64_t step = first;
    while (step < simulation.steps && stop_signal() == 0) {
        simulation.advance(step);
        ++step;
        const auto due_now = [&](const ScheduledRecording& scheduled) { return is_due(scheduled, step); };
        if (step % simulation.health_every == 0 || step == simulation.steps ||
            std::any_of(simulation.recordings.begin(), simulation.recordings.end(), due_now))
            simulation.check_health(step);  // never record a diverged state
        const bool frame = append_due(simulation, step, archive);
        if (frame || seconds_since(last_commit) > seconds_between_commits) {
            archive.commit();
            last_commit = Clock::now();
        }
        if (seconds_since(last_checkpoint) > 60.0 * files.checkpoint_minutes && step < simulation.steps) {
            simulation.check_health(step);
            save(simulation, step, archive, files);
            last_checkpoint = Clock::now();
        }
        progress.report(step, simulation.step_error);
    }
    if (step != first) simulation.check_health(step);
    save(simulation, step, archive, files);
    if (step == simulation.steps) append_last(simulation, step, archive);
    if (const std::string words = simulation.describe ? simulation.describe() : ""; !quiet && !words.empty())
        log_information("{}", words);
    return {.step = step,
            .signal = step < simulation.steps ? stop_signal() : 0,
            .wall_seconds = seconds_since(start),
            .core_seconds = core_seconds() - core_start};
}

}  // namespace drover::run
