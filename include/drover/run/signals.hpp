// run/signals.hpp: a request to stop by SIGINT, SIGTERM or SIGUSR1.
#pragma once

namespace drover::run {

/// These signals then request a stop instead of ending the process.  A second SIGINT ends it at once.
void catch_stop_signals();

/// The signal received, or 0.
int stop_signal();

}  // namespace drover::run
