// run/simulation.cpp: schedules and sizes of recordings.
#include "run/simulation.hpp"

#include <algorithm>
#include <utility>

namespace drover::run {

std::vector<std::span<const double>> lend(std::vector<std::vector<double>>& arrays,
                                          std::vector<std::vector<double>> row) {
    if (arrays.empty()) arrays = std::move(row);
    else
        for (std::size_t i = 0; i < arrays.size(); ++i) std::copy(row[i].begin(), row[i].end(), arrays[i].begin());
    return {arrays.begin(), arrays.end()};
}

bool is_checked(const Simulation& simulation, std::int64_t step) {
    constexpr std::int64_t every = 8;
    return step % every == 0 || step == simulation.steps ||
           std::ranges::any_of(simulation.recordings,
                               [&](const ScheduledRecording& scheduled) { return is_due(scheduled, step); });
}

}  // namespace drover::run
