// run/memory_run.hpp: a run of a scene from its start that writes no file, and its report.
#pragma once
#include <optional>

#include "io/scene.hpp"
#include "run/report.hpp"

namespace drover::run {

/// The report, without linear theory, that the archive of this run would give, to the last bit.  Nothing when a signal
/// stopped it.  Throws as run_scene.
std::optional<Report> run_in_memory(const io::Scene& scene);

}  // namespace drover::run
