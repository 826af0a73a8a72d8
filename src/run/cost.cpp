// run/cost.cpp: timing a few steps of a scene.
#include "run/cost.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/clock.hpp"
#include "run/simulation_type.hpp"

namespace drover::run {

namespace {
constexpr double seconds_of_steps = 0.2;
constexpr int max_steps = 50;

double seconds_of(const std::function<void()>& action) {
    const auto start = Clock::now();
    action();
    return seconds_since(start);
}

/// Rows of a recording in the whole run.
double rows(const ScheduledRecording& recording, std::int64_t steps) {
    return recording.every == 0 ? 2.0
                                : 1.0 + std::floor(static_cast<double>(steps) / static_cast<double>(recording.every));
}
}  // namespace

std::optional<ExpectedTime> expected_time(const io::Scene& scene) {
    const SimulationType& kind = simulation_type_of(scene);
    const auto [timed, larger] = kind.timed(scene);
    try {
        Threads threads(kind.threads(scene));
        const std::unique_ptr<Simulation> made = kind.make(timed, threads, {});
        Simulation& simulation = *made;
        std::int64_t step = 0;
        const auto advance = [&] { simulation.advance(step++); };
        const auto last = std::min<std::int64_t>(simulation.steps, max_steps);
        if (last > 1) advance();  // the first step touches all memory
        std::vector<double> times;
        double spent = 0.0;
        while (times.empty() || (step < last && spent < seconds_of_steps)) {
            times.push_back(seconds_of(advance));
            spent += times.back();
        }
        std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
        ExpectedTime result{.step = larger * times[times.size() / 2], .scaled = larger > 1.0};
        result.total = result.step * static_cast<double>(simulation.steps);
        for (const ScheduledRecording& recording : simulation.recordings)
            result.total += larger * rows(recording, simulation.steps) * seconds_of([&] { recording.observe(); });
        return result;
    } catch (const Error&) {
        return std::nullopt;  // the run itself reports the error
    }
}

}  // namespace drover::run
