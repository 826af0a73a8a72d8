// run/loop/simulation.cpp: schedules and rows of recordings.
#include "run/loop/simulation.hpp"

#include <algorithm>
#include <utility>

namespace drover::run {

std::vector<std::span<const double>> store_in_place(std::vector<std::vector<double>>& arrays,
                                                    std::vector<std::vector<double>> row) {
    if (arrays.empty()) arrays = std::move(row);
    else
        for (std::size_t i = 0; i < arrays.size(); ++i) std::ranges::copy(row[i], arrays[i].begin());
    return {arrays.begin(), arrays.end()};
}

namespace {
void append(const std::string& path, const std::vector<std::size_t>& shape, std::span<const double> values,
            Arrays& arrays) {
    files::Array& array = arrays[path];
    if (array.shape.empty()) {
        array.shape = {0};
        array.shape.insert(array.shape.end(), shape.begin(), shape.end());
    }
    ++array.shape[0];
    array.values.insert(array.values.end(), values.begin(), values.end());
}
}  // namespace

void append_row(const ScheduledRecording& scheduled, double time, Arrays& arrays) {
    const files::Recording& recording = scheduled.recording;
    const std::vector<std::span<const double>> row = scheduled.observe();
    if (!recording.trajectory) append(recording.group + "/time", {}, {&time, 1}, arrays);
    for (std::size_t q = 0; q < row.size(); ++q) {
        const files::Quantity& quantity = recording.quantities[q];
        const std::string path = recording.group + "/" + quantity.name;
        if (recording.trajectory) append(path + "/time", {}, {&time, 1}, arrays);
        append(recording.trajectory ? path + "/value" : path, files::shape_of(recording.axes, quantity), row[q],
               arrays);
    }
}

void remove_last_row(const ScheduledRecording& scheduled, Arrays& arrays) {
    for (auto& [path, array] : arrays) {
        if (!path.starts_with(scheduled.recording.group + "/")) continue;
        array.values.resize(array.values.size() / array.shape[0] * (array.shape[0] - 1));
        --array.shape[0];
    }
}

bool is_checked(const Simulation& simulation, std::int64_t step) {
    constexpr std::int64_t every = 8;
    return step % every == 0 || step == simulation.steps ||
           std::ranges::any_of(simulation.recordings,
                               [&](const ScheduledRecording& scheduled) { return is_due(scheduled, step); });
}

}  // namespace drover::run
