// run/memory_run.cpp: the rows that a loop would append to an archive, in memory.
#include "run/memory_run.hpp"

#include "run/run_scene.hpp"
#include "run/signals.hpp"
#include "run/simulation_type.hpp"
#include "run/step_choice.hpp"

namespace drover::run {

namespace {
/// Frames of fields, of which reports use none.
bool is_unused(const files::Recording& recording) { return recording.group == "/" && !recording.trajectory; }

void append_used(const Simulation& simulation, const ScheduledRecording& scheduled, std::int64_t step, Arrays& arrays) {
    if (!is_unused(scheduled.recording)) append_row(scheduled, static_cast<double>(step) * simulation.dt, arrays);
}

/// As run_loop().  False when a signal stopped it.
bool run_to_end(Simulation& simulation, Arrays& arrays) {
    const auto append_due = [&](std::int64_t step) {
        for (const ScheduledRecording& scheduled : simulation.recordings)
            if (is_due(scheduled, step)) append_used(simulation, scheduled, step, arrays);
    };
    simulation.check_health(0);
    append_due(0);
    for (std::int64_t step = 0; step < simulation.steps;) {
        if (stop_signal() != 0) return false;
        simulation.advance(step++);
        if (is_checked(simulation, step)) simulation.check_health(step);
        append_due(step);
    }
    for (const ScheduledRecording& scheduled : simulation.recordings)
        if (!is_due(scheduled, simulation.steps)) append_used(simulation, scheduled, simulation.steps, arrays);
    return true;
}
}  // namespace

std::optional<Report> run_in_memory(const io::Scene& given) {
    check_memory(given);
    return with_halved_steps(with_chosen_step(given, true), true, [](const io::Scene& scene) -> std::optional<Report> {
        Threads threads(simulation_type_of(scene).threads(scene));
        const std::unique_ptr<Simulation> simulation = simulation_type_of(scene).make(scene, threads, {});
        Arrays arrays;
        if (!run_to_end(*simulation, arrays)) return std::nullopt;
        return simulation_type_of(scene).report(files::ArchiveReader(std::move(arrays)), scene, Theory::omitted);
    });
}

}  // namespace drover::run
