// run/simulation_type.hpp: the functions of each kind of scene: fields or particles.
#pragma once
#include <memory>
#include <span>
#include <string>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "run/loop/scene_support.hpp"
#include "run/loop/simulation.hpp"
#include "run/report/report.hpp"

namespace drover::run {

/// The functions of one kind.
struct SimulationType {
    /// The simulation of a scene, at its start, or in the state `saved` by save() when that is not empty.  `threads`
    /// must outlive it.
    std::unique_ptr<Simulation> (*make)(const io::Scene& scene, Threads& threads, std::span<const double> saved);
    /// The number of threads: as set, or the cores that the process may use, fewer for a small scene.
    int (*threads)(const io::Scene& scene);
    RunBytes (*bytes)(const io::Scene& scene);    ///< that a run needs; Simulation::bytes has the same
    std::string (*size)(const io::Scene& scene);  ///< "16 by 16 points"
    const char* body;                             ///< "a grid of": precedes size in messages
    const char* size_key;                         ///< the key of the scene that reduces its size
    const char* start;  ///< the section with kind, file and frame, from which a ramp of a sweep and another run start
    TimedScene (*timed)(const io::Scene& scene);
    /// Throws an input Error where the scene begins with a frame of a file that is not there or not of this scene.
    void (*check_start)(const io::Scene& scene);
    std::vector<std::string> (*warnings)(const io::Scene& scene);  ///< what is known before a run
    Report (*report)(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory);
};
const SimulationType& simulation_type_of(const io::Scene& scene);

/// The scene that an archive stores.
io::Scene archived_scene(const files::ArchiveReader& archive);

/// Whether an archive holds frames of particles alone, from which runs start.
bool is_start(const files::ArchiveReader& archive);

/// Reads the observables of an archive.  Throws an input Error if it is not an archive of a run.
Report make_report(const files::ArchiveReader& archive, Theory theory = Theory::included);
/// The same for the scene that wrote the archive, whose functions of Python the archive does not have.
Report make_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory);

}  // namespace drover::run
