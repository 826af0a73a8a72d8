// run/loop/simulation.cpp: schedules and rows of recordings; the main loop.
#include "run/loop/simulation.hpp"

#include <algorithm>
#include <ctime>
#include <utility>

#include "base/duration.hpp"
#include "base/log.hpp"
#include "drover/measure/statistics.hpp"
#include "files/checkpoint.hpp"
#include "run/loop/progress.hpp"
#include "run/loop/signals.hpp"

namespace drover::run {

namespace {
void append(const std::string& path, const std::vector<std::size_t>& shape, std::span<const double> values,
            Arrays& arrays) {
    files::Array& array = arrays[path];
    if (array.shape.empty()) {
        array.shape = {0};
        array.shape.insert(array.shape.end(), shape.begin(), shape.end());
    }
    ++array.shape[0];
    array.values.insert(array.values.end(), values.begin(), values.end());
}

void append_row(const Simulation& simulation, std::size_t r, std::int64_t step, files::Archive& archive) {
    archive.append(r, static_cast<double>(step) * simulation.dt, simulation.recordings[r].observe(), step);
}

/// Commits rows by time: after a kill, the frames of at most the last second are lost, or of the last step where that
/// is longer, and the samples of at most half a minute.
class Commits {
public:
    explicit Commits(files::Archive& archive) : archive_(archive) {}

    void append_due(const Simulation& simulation, std::int64_t step) {
        for (std::size_t r = 0; r < simulation.recordings.size(); ++r) {
            const ScheduledRecording& scheduled = simulation.recordings[r];
            if (!is_due(scheduled, step)) continue;
            append_row(simulation, r, step, archive_);
            if (scheduled.recording.rows_per_chunk == 1) {
                ++frames_;
                last_frame_ = Clock::now();
            }
        }
    }
    void commit_if_due() {
        constexpr double seconds_between_frames = 1.0, seconds_between_samples = 30.0;
        constexpr int max_frames = 64;  // in memory
        const bool overdue = seconds_since(last_) > (frames_ > 0 ? seconds_between_frames : seconds_between_samples);
        // A frame is compressed during the next steps, for which a commit would wait.
        const bool would_wait = archive_.is_compressing() && seconds_since(last_frame_) < seconds_between_frames;
        if (frames_ >= max_frames || (overdue && !would_wait)) commit();
    }
    void commit() {
        archive_.commit();
        frames_ = 0;
        last_ = Clock::now();
    }

private:
    files::Archive& archive_;
    int frames_ = 0;  // since the last commit
    Clock::time_point last_ = Clock::now(), last_frame_ = last_;
};

void save(const Simulation& simulation, std::int64_t step, files::Archive& archive, Commits& commits,
          const LoopFiles& files) {
    commits.commit();  // first: a checkpoint never counts rows that the archive does not have
    files::Checkpoint checkpoint{.scene = files.scene,
                                 .step = step,
                                 .time = static_cast<double>(step) * simulation.dt,
                                 .state = simulation.save(),
                                 .run_id = files.run_id,
                                 .program = files.program,
                                 .row_checksums = archive.row_checksums()};
    for (const std::size_t rows : archive.rows()) checkpoint.rows.push_back(rows);
    files::write_checkpoint(files.archive, checkpoint);
}

/// Calls a function of the simulation; if it fails, the frames before it are committed.
template <class Work>
void keeping_frames(Commits& commits, Work work) {
    try {
        work();
    } catch (...) {  // also what a function of the caller throws
        commits.commit();
        throw;
    }
}

/// For people, `seconds` after step `first`.
std::string progress_text(const Simulation& simulation, std::int64_t first, std::int64_t step, double seconds) {
    const auto done = static_cast<double>(step), all = static_cast<double>(simulation.steps);
    const double rate = static_cast<double>(step - first) / seconds;
    std::string line = text("t = {:.4g} of {} ({:.0f} %), {:.3g} steps/s, {} left", done * simulation.dt,
                            measure::time_text(all * simulation.dt, simulation.recordings.back().recording.time_unit),
                            100.0 * done / all, rate, duration_text(rate > 0.0 ? (all - done) / rate : 0.0));
    if (const std::optional<double> error = simulation.step_error(); error > 0.0)
        line += text(", estimated error of the steps {:.2g}", *error);
    return line;
}
}  // namespace

std::vector<std::span<const double>> store_in_place(std::vector<std::vector<double>>& arrays,
                                                    std::vector<std::vector<double>> row) {
    if (arrays.empty()) arrays = std::move(row);
    else
        for (std::size_t i = 0; i < arrays.size(); ++i) std::ranges::copy(row[i], arrays[i].begin());
    return {arrays.begin(), arrays.end()};
}

void append_row(const ScheduledRecording& scheduled, double time, Arrays& arrays) {
    const files::Recording& recording = scheduled.recording;
    const std::vector<std::span<const double>> row = scheduled.observe();
    if (!recording.trajectory) append(recording.group + "/time", {}, {&time, 1}, arrays);
    for (std::size_t q = 0; q < row.size(); ++q) {
        const files::Quantity& quantity = recording.quantities[q];
        const std::string path = recording.group + "/" + quantity.name;
        if (recording.trajectory) append(path + "/time", {}, {&time, 1}, arrays);
        append(recording.trajectory ? path + "/value" : path, files::shape_of(recording.axes, quantity), row[q],
               arrays);
    }
}

void remove_last_row(const ScheduledRecording& scheduled, Arrays& arrays) {
    for (auto& [path, array] : arrays) {
        if (!path.starts_with(scheduled.recording.group + "/")) continue;
        array.values.resize(array.values.size() / array.shape[0] * (array.shape[0] - 1));
        --array.shape[0];
    }
}

bool is_checked(const Simulation& simulation, std::int64_t step) {
    constexpr std::int64_t every = 8;
    return step % every == 0 || step == simulation.steps ||
           std::ranges::any_of(simulation.recordings,
                               [&](const ScheduledRecording& scheduled) { return is_due(scheduled, step); });
}

double core_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

LoopOutcome run_loop(Simulation& simulation, std::int64_t first, files::Archive& archive, const LoopFiles& files,
                     bool quiet) {
    const Clock::time_point start = Clock::now();
    const double core_start = core_seconds();
    Commits commits(archive);
    const std::vector<std::size_t> rows = archive.rows();
    if (std::ranges::all_of(rows, [](std::size_t count) { return count == 0; })) {
        simulation.check_health(0);
        commits.append_due(simulation, 0);
        save(simulation, 0, archive, commits, files);
    }
    std::int64_t step = first;
    Clock::time_point last_checkpoint = Clock::now();
    for (ProgressLine progress(quiet); step < simulation.steps && stop_signal() == 0;) {
        keeping_frames(commits, [&] { simulation.advance(step); });
        ++step;
        if (is_checked(simulation, step)) keeping_frames(commits, [&] { simulation.check_health(step); });
        commits.append_due(simulation, step);
        commits.commit_if_due();
        if (seconds_since(last_checkpoint) > 60.0 * files.checkpoint_minutes && step < simulation.steps) {
            keeping_frames(commits, [&] { simulation.check_health(step); });
            save(simulation, step, archive, commits, files);
            last_checkpoint = Clock::now();
        }
        progress.show([&](double elapsed) { return progress_text(simulation, first, step, elapsed); });
    }
    if (step != first) keeping_frames(commits, [&] { simulation.check_health(step); });
    save(simulation, step, archive, commits, files);
    // Every recording has a row of the last step.  It is written after the last checkpoint, which counts only scheduled
    // rows: a run that is extended later has the same rows as one of that length from the start.
    if (step == simulation.steps) {
        for (std::size_t r = 0; r < simulation.recordings.size(); ++r)
            if (!is_due(simulation.recordings[r], step)) append_row(simulation, r, step, archive);
        archive.commit();
    }
    if (const std::string words = simulation.describe(); !quiet && !words.empty()) log_information("{}", words);
    return {.first = first,
            .step = step,
            .signal = step < simulation.steps ? stop_signal() : 0,
            .wall_seconds = seconds_since(start),
            .core_seconds = core_seconds() - core_start};
}

}  // namespace drover::run
