// app/explain_cost.hpp: the last lines of drover explain.
#pragma once
#include "drover/run/explain.hpp"

namespace drover::app {

/// Memory, disk, threads, wall time and archive; `smaller`: the substitute on which a large scene is timed, "on a
/// smaller grid".
void print_cost(const io::Scene& scene, const run::Cost& cost, const char* smaller);

}  // namespace drover::app
