// run/loop/progress.cpp: progress lines with rate and time left.
#include "run/loop/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "base/log.hpp"

namespace drover::run {

namespace {
using namespace std::chrono_literals;
}

ProgressLine::ProgressLine(bool quiet) : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()) {
    next_ = start_ + (terminal_ ? 500ms : 20s);
}

ProgressLine::~ProgressLine() {
    if (shown_ && terminal_) std::fputs("\r\x1b[K", stderr);
}

void ProgressLine::show(const std::function<std::string(double elapsed)>& words) {
    const Clock::time_point now = Clock::now();
    if (quiet_ || now < next_) return;
    next_ = now + (terminal_ ? 250ms : 30s);
    const std::string line = words(std::chrono::duration<double>(now - start_).count());
    if (terminal_) std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
    else log_line(LogLevel::information, line);
    std::fflush(stderr);
    shown_ = true;
}

void Progress::report(std::int64_t step, const std::function<std::optional<double>()>& step_error) {
    line_.show([&](double elapsed) {
        const double rate = static_cast<double>(step - first_) / elapsed;
        const double left = rate > 0.0 ? static_cast<double>(last_ - step) / rate : 0.0;
        std::string line =
            text("t = {:.4g} of {:.4g} s ({:.0f} %), {:.3g} steps/s, {} left", static_cast<double>(step) * dt_,
                 static_cast<double>(last_) * dt_, 100.0 * static_cast<double>(step) / static_cast<double>(last_), rate,
                 duration_text(left));
        if (const std::optional<double> error = step_error(); error > 0.0)
            line += text(", estimated error of the steps {:.2g}", *error);
        return line;
    });
}

void PointProgress::add() {
    const std::int64_t count = ++count_;
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock.owns_lock()) return;
    line_.show([&](double elapsed) {
        return text("{} points of at least {}, {:.3g} points/s, {}", count, std::max(count, at_least_),
                    static_cast<double>(count) / elapsed, duration_text(elapsed));
    });
}

}  // namespace drover::run
