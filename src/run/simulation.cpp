// run/simulation.cpp: schedules and sizes of recordings.
#include "drover/run/simulation.hpp"

#include <algorithm>

namespace drover::run {

std::size_t scheduled_rows(const ScheduledRecording& recording, std::int64_t step) {
    return 1 + (recording.every == 0 ? 0 : static_cast<std::size_t>(step / recording.every));
}

double archive_bytes(const Simulation& simulation) {
    double bytes = 0.0;
    for (const ScheduledRecording& scheduled : simulation.recordings) {
        double row = sizeof(double);
        for (const io::Quantity& quantity : scheduled.recording.quantities) {
            double size = sizeof(double);
            for (const std::string& name : quantity.axes)
                for (const io::Axis& axis : scheduled.recording.axes)
                    if (axis.name == name) size *= static_cast<double>(axis.values.size());
            row += size;
        }
        bytes +=
            row * static_cast<double>(scheduled_rows(scheduled, simulation.steps) + (scheduled.every == 0 ? 1 : 0));
    }
    return bytes;
}

}  // namespace drover::run
