// analysis/stability.hpp: the stability analysis of a scene: uniform states, coefficients, modes, instabilities,
// fluctuations.
#pragma once
#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::analysis {

/// Coefficients and states; in an archive each state is a group named after it ("along_the_field").  With `threads`
/// also the maps that archives hold: branches over angle and wavenumber (growth_rate, frequency, shapes), slow modes by
/// angle, structure factors (NaN where a mode grows) and dynamic structure factors at stability.sound.  Throws an input
/// Error for an empty range of wavenumbers.
run::Result make_stability(const io::Scene& scene, Threads* threads = nullptr);

}  // namespace drover::analysis
