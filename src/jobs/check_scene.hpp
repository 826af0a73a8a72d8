// jobs/check_scene.hpp: whether a scene can be run.
#pragma once
#include <string>
#include <vector>

#include "io/scene.hpp"

namespace drover::jobs {

/// Warnings that are known before a run.  Throws an input Error where a run, sweep, calibration or boundary of the
/// scene would: a file of its start that is not there, memory or disk that are not free.
std::vector<std::string> check_scene(const io::Scene& scene);

}  // namespace drover::jobs
