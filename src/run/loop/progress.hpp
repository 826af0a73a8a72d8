// run/loop/progress.hpp: progress on standard error: one live line on a terminal, a line every 30 s elsewhere.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
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
