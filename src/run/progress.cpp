// run/progress.cpp: progress lines with rate and time left.
#include "drover/run/progress.hpp"

#include <unistd.h>

#include <cstdio>
#include <string>

#include "drover/base/log.hpp"

namespace drover::run {

namespace {
using namespace std::chrono_literals;
}

Progress::Progress(std::int64_t first, std::int64_t last, double dt, bool quiet)
    : first_(first), last_(last), dt_(dt), quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1), start_(Clock::now()) {
    next_ = start_ + (terminal_ ? 500ms : 20s);
}

Progress::~Progress() {
    if (shown_ && terminal_) std::fputs("\r\x1b[K", stderr);
}

void Progress::report(std::int64_t step, const std::function<double()>& step_error) {
    const Clock::time_point now = Clock::now();
    if (quiet_ || now < next_) return;
    next_ = now + (terminal_ ? 250ms : 30s);
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double rate = static_cast<double>(step - first_) / elapsed;
    const double left = rate > 0.0 ? static_cast<double>(last_ - step) / rate : 0.0;
    std::string line = text("t = {:.4g} of {:.4g} s ({:.0f} %), {:.3g} steps/s, {} left",
                            static_cast<double>(step) * dt_, static_cast<double>(last_) * dt_,
                            100.0 * static_cast<double>(step) / static_cast<double>(last_), rate, duration_text(left));
    if (const double error = step_error ? step_error() : 0.0; error > 0.0)
        line += text(", estimated error of the steps {:.2g}", error);
    if (terminal_) std::fprintf(stderr, "\r%s\x1b[K", line.c_str());
    else log_line(LogLevel::information, line);
    std::fflush(stderr);
    shown_ = true;
}

}  // namespace drover::run
