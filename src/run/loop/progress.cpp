// run/loop/progress.cpp: when progress is shown, and where.
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
