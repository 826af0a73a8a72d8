// app/explain_cost.cpp: memory, disk and wall time of a scene.
#include "explain_cost.hpp"

#include <cstdio>

#include "drover/run/kind.hpp"

namespace drover::app {

Cost cost_of(const io::Scene& scene) {
    const run::Needs needs = run::needs_of(scene);
    return {.steps = io::whole_steps(scene, "time.end", scene.time.end),
            .threads = run::kind_of(scene).threads(scene),
            .needs = needs,
            .time = needs.memory_bytes < needs.memory_free ? run::expected_time(scene) : std::nullopt};
}

nlohmann::json cost_json(const io::Scene& scene, const Cost& cost) {
    const auto seconds = [&](double run::ExpectedTime::*part) {
        return cost.time ? nlohmann::json(*cost.time.*part) : nlohmann::json();
    };
    return {{"steps", cost.steps},
            {"threads", cost.threads},
            {"seconds_per_step_estimate", seconds(&run::ExpectedTime::step)},
            {"seconds_estimate", seconds(&run::ExpectedTime::total)},
            {"memory_bytes", cost.needs.memory_bytes},
            {"disk_bytes", cost.needs.disk_bytes},
            {"archive", run::archive_path(scene).string()}};
}

void print_cost(const io::Scene& scene, const Cost& cost, const char* smaller) {
    std::printf("memory %s (%s free), disk at most %s (%s free), %d thread%s\n",
                bytes_text(cost.needs.memory_bytes).c_str(), bytes_text(cost.needs.memory_free).c_str(),
                bytes_text(cost.needs.disk_bytes).c_str(), bytes_text(cost.needs.disk_free).c_str(), cost.threads,
                cost.threads == 1 ? "" : "s");
    if (cost.time) {
        const std::string timed = text("scaled from a few steps {}", smaller);
        std::printf("wall time about %s (estimate): %.3g ms per step, %s\n", duration_text(cost.time->total).c_str(),
                    1e3 * cost.time->step, cost.time->scaled ? timed.c_str() : "measured on a few steps");
    }
    std::printf("archive %s\n", run::archive_path(scene).c_str());
}

}  // namespace drover::app
