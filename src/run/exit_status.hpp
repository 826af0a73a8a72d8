// run/exit_status.hpp: the exit statuses of drover.
#pragma once
#include <functional>

namespace drover::run {

enum ExitStatus { exit_done = 0, exit_run_failed = 1, exit_bad_input = 2, exit_stopped = 3 };

/// The value of `work`.  An exception is reported on standard error, in one line, and gives 1 (a run failed) or 2 (bad
/// input).
int status_of(const std::function<int()>& work);

}  // namespace drover::run
