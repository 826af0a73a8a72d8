// app/explain_cost.hpp: what a run of a scene takes, as explain tells it of every kind of scene.
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
    std::optional<run::ExpectedTime> time;  ///< nothing when the scene cannot be stepped
};

/// Measures it on the spot, where the memory is there.
Cost cost_of(const io::Scene& scene);

/// The keys of --json that it has.
nlohmann::json cost_json(const io::Scene& scene, const Cost& cost);

/// Memory, disk, threads, wall time and archive; `smaller`: where a scene too large to be timed was timed, "on a smaller grid".
void print_cost(const io::Scene& scene, const Cost& cost, const char* smaller);

}  // namespace drover::app
