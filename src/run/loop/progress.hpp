// run/loop/progress.hpp: progress on standard error: one live line on a terminal, a line every 30 s elsewhere.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

namespace drover::run {

/// A line that is shown now and then, and removed from a terminal in the end.  Quiet: shows nothing.
class ProgressLine {
public:
    explicit ProgressLine(bool quiet);
    ~ProgressLine();
    ProgressLine(const ProgressLine&) = delete;
    ProgressLine& operator=(const ProgressLine&) = delete;

    /// `words`, called only for a line that is shown, gets the time since the beginning [s].
    void show(const std::function<std::string(double elapsed)>& words);

private:
    using Clock = std::chrono::steady_clock;
    bool quiet_, terminal_, shown_ = false;
    Clock::time_point start_, next_;
};

/// Of a run.
class Progress {
public:
    /// From step `first` to step `last`; `dt` [s] gives the time shown.
    Progress(std::int64_t first, std::int64_t last, double dt, bool quiet)
        : first_(first), last_(last), dt_(dt), line_(quiet) {}

    /// `step_error` is called for a line that is shown.
    void report(std::int64_t step, const std::function<std::optional<double>()>& step_error);

private:
    std::int64_t first_, last_;
    double dt_;
    ProgressLine line_;
};

/// Of points that several threads compute, whose number is known from below.
class PointProgress {
public:
    PointProgress(std::int64_t at_least, bool quiet) : at_least_(at_least), line_(quiet) {}

    /// A point begins.
    void add();

private:
    std::int64_t at_least_;
    std::atomic<std::int64_t> count_ = 0;
    std::mutex mutex_;  // of the line
    ProgressLine line_;
};

}  // namespace drover::run
