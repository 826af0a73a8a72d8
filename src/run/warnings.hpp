// run/warnings.hpp: what a run cannot be trusted in, from its scene and what its archive has recorded.
#pragma once
#include <string>
#include <vector>

#include "files/archive_reader.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// A field is resolved while modes beyond two thirds of the cut hold less than this fraction of its variance.  Without
/// noise the relative error of the longest waves is then below 1 %: it was 3 to 5 times the tail for steepening waves
/// on 32 to 128 points.
inline constexpr double max_spectral_tail = 1e-3;
/// With noise the tail is physical where the noise is white: it must exceed the linear prediction by this factor as
/// well.  Nonlinear terms change the spectrum of a resolved flock by less.
inline constexpr double max_tail_over_linear = 3.0;

/// Each warning names the key of the scene and a value that would do.

/// What is known before a run.
std::vector<std::string> field_scene_warnings(const io::Scene& scene);

/// Those, and what its archive shows.  Every reader of an archive gets the same: a run,
/// a restart, drover info.
std::vector<std::string> field_warnings(const files::ArchiveReader& archive, const io::Scene& scene);

}  // namespace drover::run
