// run/loop/signals.cpp: the flag that the signal handler sets; exceptions to exit statuses.
#include "run/loop/signals.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <exception>
#include <new>

#include "base/duration.hpp"
#include "drover/base/error.hpp"

namespace drover::run {

namespace {
// A global: a signal handler has no other way to report.
volatile std::sig_atomic_t requested = 0;
Clock::time_point deadline = Clock::time_point::max();  // set before there are threads
double given_time = 0.0;                                // until then, from the start [s]
std::atomic<bool> host_handles_signals = false;         // a property of the process, as the handlers are

std::string& reason_of_alarm() {
    static std::string reason = "--max-time";
    return reason;
}

extern "C" void handle_signal(int signal) {
    if (requested != 0 && signal == SIGINT) {
        std::signal(SIGINT, SIG_DFL);
        std::raise(SIGINT);  // takes effect when this function returns
    }
    requested = signal;
}

/// Errors of other types as an Error.  Neither an Error nor a bad_alloc is converted: there may be no memory for it.
int in_errors(const std::function<int()>& work) {
    try {
        return work();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& exception) {
        throw error_of(exception);
    }
}
}  // namespace

StopSignals::StopSignals() : installed_(!host_handles_signals) {
    if (!installed_) return;
    for (std::size_t i = 0; i < handled.size(); ++i) {
        sigaction(handled[i], nullptr, &before_[i]);
        if (handled[i] == SIGHUP && before_[i].sa_handler == SIG_IGN) continue;
        struct sigaction action = {};
        action.sa_handler = handled[i] == SIGPIPE ? SIG_IGN : handle_signal;
        sigemptyset(&action.sa_mask);
        action.sa_flags = SA_RESTART;
        sigaction(handled[i], &action, nullptr);
    }
}

StopSignals::~StopSignals() {
    if (!installed_) return;
    for (std::size_t i = 0; i < handled.size(); ++i) sigaction(handled[i], &before_[i], nullptr);
}

int stop_signal() { return requested == 0 && Clock::now() >= deadline ? SIGALRM : requested; }

std::string stop_reason(int signal) {
    return signal == SIGALRM ? reason_of_alarm() : signal == 0 ? "a signal" : text("signal {}", signal);
}

double max_time() { return given_time; }

void stop_after(double seconds) {
    given_time = seconds;
    constexpr double longest = 1e9;  // 30 years, which the clock can hold
    deadline = Clock::now() +
               std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(seconds, longest)));
}

void check_stop_signal() {
    if (stop_signal() != 0) fail_environment("stopped by {} before the result was found", stop_reason(stop_signal()));
}

void leave_signals_to_host(bool leave) { host_handles_signals = leave; }

void request_stop(int signal, const std::string& reason) {
    reason_of_alarm() = reason;
    requested = signal;
}

void ignore_file_size_signal() { std::signal(SIGXFSZ, SIG_IGN); }

int status_of(const std::function<int()>& work) {
    try {
        return in_errors(work);
    } catch (const Error& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        const bool is_bad_input = error.fault() == Fault::input || error.fault() == Fault::unavailable;
        return is_bad_input ? exit_bad_input : exit_run_failed;
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "error: %s\n", no_memory_text);
        return exit_run_failed;
    }
}

}  // namespace drover::run
