// app/explain_cost.cpp: memory, disk and wall time of a scene.
#include "explain_cost.hpp"

#include <cstdio>

#include "command.hpp"

namespace drover::app {

void print_cost(const io::Scene& scene, const run::Cost& cost, const char* smaller) {
    std::printf("memory %s (%s free), disk at most %s (%s free), %d thread%s\n",
                bytes_text(cost.needs.memory_bytes).c_str(), bytes_text(cost.needs.memory_free).c_str(),
                bytes_text(cost.needs.disk_bytes).c_str(), bytes_text(cost.needs.disk_free).c_str(), cost.threads,
                cost.threads == 1 ? "" : "s");
    if (cost.time) {
        const std::string timed = text("scaled from a few steps {}", smaller);
        std::printf("wall time about %s (estimate): %.3g ms per step, %s\n", duration_text(cost.time->total).c_str(),
                    1e3 * cost.time->step, cost.time->scaled ? timed.c_str() : "measured on a few steps");
    }
    print("archive " + run::archive_path(scene).string() + "\n");
}

}  // namespace drover::app
