// run/cost.hpp: what a run of a scene will take, measured on the spot.
#pragma once
#include <optional>

#include "drover/io/scene.hpp"

namespace drover::run {

/// Wall time that a scene is expected to take on this machine [s].
struct ExpectedTime {
    double step = 0.0;    ///< one of time.dt
    double whole = 0.0;   ///< all steps, samples and frames
    bool scaled = false;  ///< measured on a smaller grid or cell, and scaled as the work of a step
};

/// Times a few steps, a sample and a frame, from a uniform state where the start is costly: half a second, and less on small grids.
/// Nothing when the scene cannot be stepped.
std::optional<ExpectedTime> expected_time(const io::Scene& scene);

}  // namespace drover::run
