// run/particle_simulation.hpp: a scene of particles as a Simulation.
#pragma once
#include "drover/measure/particles.hpp"
#include "drover/run/kind.hpp"

namespace drover::run {

// A scene of particles, for run/kind.hpp: what each is stands there.
int particle_threads(const io::Scene& scene);
double particle_simulation_bytes(const io::Scene& scene);
double particle_disk_bytes(const io::Scene& scene);
std::string particle_size(const io::Scene& scene);
TimedScene timed_particles(const io::Scene& scene);
/// Says so when the steps of a scene lie outside what tests/bench/particles measured.
std::string particle_advice(const io::Scene& scene);
Report make_particle_report(const files::ArchiveReader& archive, const io::Scene& scene);

/// Throws an input Error for a packing that is not of these bodies, and a run Error where none was found.
Simulation make_particle_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved = {});

/// The observables that have numbers in a setting, and the axes of them all, as files have them.
std::vector<measure::ParticleObservable> recorded_observables(const measure::ParticleSetting& setting);
std::vector<files::Axis> series_axes(const measure::ParticleSetting& setting,
                                     std::span<const measure::ParticleObservable> observables);

}  // namespace drover::run
