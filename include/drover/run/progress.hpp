// run/progress.hpp: progress on standard error: one live line on a terminal, a line every 30 s elsewhere.
#pragma once
#include <chrono>
#include <cstdint>
#include <functional>

namespace drover::run {

class Progress {
public:
    /// From step `first` to step `last`; `dt` [s] gives the time shown.  Quiet: prints nothing.
    Progress(std::int64_t first, std::int64_t last, double dt, bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// `step_error`, where it is not empty, is called for a line that is shown.
    void report(std::int64_t step, const std::function<double()>& step_error);

private:
    using Clock = std::chrono::steady_clock;
    std::int64_t first_, last_;
    double dt_;
    bool quiet_, terminal_, shown_ = false;
    Clock::time_point start_, next_;
};

}  // namespace drover::run
