// tests/physics/initial_spectra.hpp: starts of rods and beads.
#pragma once
#include "model/start.hpp"
#include "physics/integrated.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics {

inline numerics::Spectra initial_spectra(const model::Start& start, const Model& model, const numerics::System& system,
                                         std::uint64_t seed, Threads& threads) {
    return model::start_spectra(start, Equations(model).solver(mean_densities(model)), system, seed, threads);
}

}  // namespace drover::physics
