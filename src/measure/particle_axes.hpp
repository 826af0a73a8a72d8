// measure/particle_axes.hpp: the axes of the observables of particles.
#pragma once
#include "measure/particles.hpp"

namespace drover::measure {

Axis bead_separation_axis(const ParticleSetting& setting);
Axis rod_separation_axis(const ParticleSetting& setting);
Axis box_axis(const ParticleSetting& setting);
Axis along_axis(const ParticleSetting& setting);
Axis across_axis(const ParticleSetting& setting);

}  // namespace drover::measure
