// run/loop/signals.hpp: a request to stop by a signal, or when the time is up; exit statuses.
#pragma once
#include <array>
#include <csignal>
#include <functional>
#include <string>

namespace drover::run {

enum ExitStatus { exit_done = 0, exit_run_failed = 1, exit_bad_input = 2, exit_stopped = 3 };

/// The value of `work`.  An exception is reported on standard error, in one line, and gives 1 (a run failed) or 2 (bad
/// input).
int status_of(const std::function<int()>& work);

/// While it lives, these signals request a stop instead of ending the process, except that a second SIGINT ends it at
/// once.  For work that polls stop_signal() and can be resumed; all other work is ended by the signals, as usual.  A
/// SIGHUP that is ignored (nohup) stays so.  By SIGUSR1 and SIGUSR2 schedulers announce the end of a job, and SIGXCPU
/// is that of a limit of the time of the processor.  SIGPIPE is ignored: a log that nobody reads any more does not end
/// a run.  Does nothing after leave_signals_to_host().
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    static constexpr std::array handled{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU, SIGPIPE};

private:
    bool installed_;
    std::array<struct sigaction, handled.size()> before_{};
};

/// The signal that requested a stop, or 0; SIGALRM when the time of stop_after() is up.
int stop_signal();

/// "signal 15", "--max-time" or what request_stop() gave; "a signal" for 0, that of another process.
std::string stop_reason(int signal);

/// From now on stop_signal() requests a stop after so many seconds, also in processes that are started by fork().
void stop_after(double seconds);
/// What stop_after() was given; 0: nothing.
double max_time();

/// For work without a result to keep: throws a run Error after a signal to stop.
void check_stop_signal();

/// For a library inside another program, such as Python, that handles signals itself: from now on StopSignals leaves
/// them alone, and the host calls request_stop().  `leave` = false: as in a program of our own.
void leave_signals_to_host(bool leave = true);

/// What a signal does while StopSignals lives.  0: the work has stopped, and other work may begin.  reason: what
/// stop_reason() says of SIGALRM from now on.
void request_stop(int signal, const std::string& reason = "--max-time");

/// From now on, a write beyond the file-size limit fails, as on a full disk, instead of ending the process.
void ignore_file_size_signal();

}  // namespace drover::run
