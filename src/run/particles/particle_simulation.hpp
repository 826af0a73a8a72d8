// run/particles/particle_simulation.hpp: a scene of particles as a Simulation.
#pragma once
#include <memory>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "run/loop/scene_support.hpp"
#include "run/loop/simulation.hpp"
#include "run/report/report.hpp"

namespace drover::run {

// The functions of particles for run/simulation_type.hpp, which documents them.
int particle_threads(const io::Scene& scene);
RunBytes particle_bytes(const io::Scene& scene);
std::string particle_size(const io::Scene& scene);
void check_particle_start(const io::Scene& scene);
TimedScene timed_particles(const io::Scene& scene);
/// Warns when the time step of a scene is outside the range studied in tests/bench/particles.
std::vector<std::string> particle_warnings(const io::Scene& scene);
Report make_particle_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory);

/// Throws an input Error for a packing of other bodies, and a run Error where none was found.
std::unique_ptr<Simulation> make_particle_simulation(const io::Scene& scene, Threads& threads,
                                                     std::span<const double> saved);

}  // namespace drover::run
