// run/pilot.cpp: the loop of a pilot, which writes no files.
#include "run/pilot.hpp"

#include <algorithm>

#include "base/log.hpp"
#include "drover/base/error.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/step_bias.hpp"
#include "run/loop/signals.hpp"
#include "run/simulation_type.hpp"

namespace drover::run {

namespace {
/// Appends a sample; returns its step_error.
double append_sample(const ScheduledRecording& samples, Pilot& pilot) {
    const std::vector<std::span<const double>> row = samples.observe();
    double error = 0.0;
    for (std::size_t q = 0, scalar = 0; q < row.size(); ++q) {
        const files::Quantity& quantity = samples.recording.quantities[q];
        if (!quantity.axes.empty()) continue;
        if (quantity.name == "step_error") error = row[q][0];
        else pilot.series[scalar++].push_back(row[q][0]);
    }
    return error;
}
}  // namespace

Pilot run_pilot(const io::Scene& scene, Threads& threads, double max_step_error) {
    io::Scene pilot_alone = scene;
    pilot_alone.accuracy.effort = effort_of_pilots;
    pilot_alone.accuracy.biases = false;
    const std::unique_ptr<Simulation> made = [&] {
        const LogPause quiet;  // the run itself says what its start has to say
        return simulation_type_of(pilot_alone).make(pilot_alone, threads, {});
    }();
    Simulation& simulation = *made;
    const auto samples = std::ranges::find_if(simulation.recordings, [](const auto& scheduled) {
        return scheduled.recording.group == field_samples_group;
    });
    Pilot pilot;
    for (const files::Quantity& quantity : samples->recording.quantities)
        if (quantity.axes.empty() && quantity.name != "step_error") pilot.names.push_back(quantity.name);
    pilot.series.resize(pilot.names.size());
    const auto stop = [&](std::int64_t step) { pilot.stopped = static_cast<double>(step) * simulation.dt; };
    constexpr double beginning = 1.0 / 32.0;  // of the run
    std::int64_t step = 0;
    try {
        while (step < simulation.steps && !(pilot.step_error > max_step_error)) {
            if (stop_signal() != 0)
                fail_environment("stopped by {} while time.dt was being chosen; no run was started",
                                 stop_reason(stop_signal()));
            simulation.advance(step++);
            const bool sampled = step % samples->every == 0;
            // A field that is 0 at the start has a large error for a while, which no step avoids.
            const bool counts = beginning * static_cast<double>(simulation.steps) <= static_cast<double>(step);
            if (is_checked(simulation, step)) simulation.check_health(step);
            if (!sampled) continue;
            const double error = append_sample(*samples, pilot);
            if (counts) pilot.step_error = std::max(pilot.step_error, error);
        }
    } catch (const Error& error) {
        if (error.fault() != Fault::run || stop_signal() != 0) throw;
        pilot.failure = error.what();
        stop(step);
    }
    if (pilot.step_error > max_step_error) stop(step);
    pilot.count = simulation.count();
    return pilot;
}

}  // namespace drover::run
