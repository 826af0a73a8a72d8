// run/cost.hpp: the wall time of a scene, estimated from a few steps.
#pragma once
#include <optional>

#include "io/scene.hpp"

namespace drover::run {

/// Expected wall time of a scene on this machine [s].
struct ExpectedTime {
    double step = 0.0;    ///< of one step
    double total = 0.0;   ///< of all steps, samples and frames
    bool scaled = false;  ///< measured on a smaller grid or cell, and scaled by the work per step
};

/// Times a few steps, a sample and a frame for at most half a second; from a uniform state where the initial state is
/// costly.  Empty when the scene cannot be stepped.
std::optional<ExpectedTime> expected_time(const io::Scene& scene);

}  // namespace drover::run
