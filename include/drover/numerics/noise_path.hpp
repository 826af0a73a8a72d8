// numerics/noise_path.hpp: the noise of a system as one function of time, shared by its steppers.
#pragma once
#include <cstdint>
#include <memory>

#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// Increments of noise over intervals of time; the same however time is divided into steps.
class NoisePath;

/// For steps of dt and of its halves; nullptr without noise.
std::shared_ptr<NoisePath> make_noise_path(const System& system, double dt, std::uint64_t seed, Threads& threads);

/// Memory of a noise path for steps of dt that are halved up to `halvings` times [bytes].
double noise_path_bytes(const System& system, double dt, int halvings);

}  // namespace drover::numerics
