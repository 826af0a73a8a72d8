// run/signals.hpp: a request to stop by SIGINT, SIGTERM or SIGUSR1.
#pragma once

namespace drover::run {

/// From now on these signals ask for a stop instead of ending the process.  A second SIGINT ends it at once.
void catch_stop_signals();

/// The signal that asked, 0 if none did.
int stop_signal();

}  // namespace drover::run
