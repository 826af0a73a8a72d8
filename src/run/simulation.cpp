// run/simulation.cpp: schedules and sizes of recordings.
#include "drover/run/simulation.hpp"

namespace drover::run {

std::size_t scheduled_rows(const ScheduledRecording& recording, std::int64_t step) {
    return 1 + (recording.every == 0 ? 0 : static_cast<std::size_t>(step / recording.every));
}

}  // namespace drover::run
