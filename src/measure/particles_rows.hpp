// measure/particles_rows.hpp: rows of the list of observables of particles.
#pragma once
#include <string>
#include <utility>

#include "drover/measure/particles.hpp"

namespace drover::measure {

using ParticleRows = std::vector<ParticleObservable>;
using ParticleNumber = std::function<double(const ParticleMoment&)>;

/// An observable that is one number.
inline void add_number(ParticleRows& rows, std::string name, std::string unit, std::string formula,
                       ParticleNumber function, bool accumulates = false) {
    rows.push_back({.name = std::move(name),
                    .unit = std::move(unit),
                    .axes = {},
                    .formula = std::move(formula),
                    .measure = [function = std::move(function)](const ParticleMoment& moment,
                                                                std::span<double> out) { out[0] = function(moment); },
                    .accumulates = accumulates});
}

}  // namespace drover::measure
