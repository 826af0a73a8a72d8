// measure/particle_summary.hpp: what a recorded run of particles says: each observable averaged over time with its error, and what follows.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "drover/measure/particles.hpp"
#include "drover/measure/summary.hpp"

namespace drover::measure {

/// All that was recorded of a run at equal times.
struct ParticleRecorded {
    const ParticleSetting& setting;
    std::span<const ParticleObservable> observables;
    std::span<const std::vector<double>> series;  ///< of each observable: [sample][size_of(observable, setting)]
    double spacing = 1.0;                         ///< time between samples [s]
    std::optional<std::size_t> warm_up = {};      ///< samples left out at the start; nullopt: found from the series
};

/// The time means of all observables, under their names; of those that accumulate the mean rate, as <name>_rate; the quotients; and
/// susceptibility and Binder cumulant of the polar order, and the number fluctuations of boxes, where there are any.
/// An automatic warm-up is the largest warm_up_length of the polar order and of the kinetic energy.
/// Throws an input Error when a series does not hold whole samples, or not as many as the others.
Summary summarise(const ParticleRecorded& recorded);

}  // namespace drover::measure
