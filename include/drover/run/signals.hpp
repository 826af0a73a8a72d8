// run/signals.hpp: a request to stop by SIGINT, SIGTERM, SIGHUP or SIGUSR1.
#pragma once
#include <array>
#include <csignal>

namespace drover::run {

/// While it lives, these signals request a stop instead of ending the process, except that a second SIGINT ends it at
/// once.  For work that polls stop_signal() and can be resumed; all other work is ended by the signals, as usual.  A
/// SIGHUP that is ignored (nohup) stays so.  SIGPIPE is ignored: a log that nobody reads any more does not end a run.
class StopSignals {
public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    static constexpr std::array handled{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};

private:
    std::array<struct sigaction, handled.size()> before_{};
};

/// The signal that requested a stop, or 0.
int stop_signal();

/// From now on, a write beyond the file-size limit fails, as on a full disk, instead of ending the process.
void ignore_file_size_signal();

}  // namespace drover::run
