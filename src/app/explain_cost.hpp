// app/explain_cost.hpp: memory, disk and wall time of a scene, for drover explain.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>

#include "drover/run/cost.hpp"
#include "drover/run/run_scene.hpp"

namespace drover::app {

struct Cost {
    std::int64_t steps = 0;
    int threads = 1;
    run::Needs needs;
    std::optional<run::ExpectedTime> time;  ///< empty when the scene cannot be stepped
};

/// Times a few steps, where there is enough memory.
Cost cost_of(const io::Scene& scene);

/// Its keys of --json.
nlohmann::json cost_json(const io::Scene& scene, const Cost& cost);

/// Memory, disk, threads, wall time and archive; `smaller`: the substitute on which a large scene is timed, "on a
/// smaller grid".
void print_cost(const io::Scene& scene, const Cost& cost, const char* smaller);

}  // namespace drover::app
