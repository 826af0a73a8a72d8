// run/kind.hpp: the functions of each kind of scene: fields or particles.
#pragma once
#include <span>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/run/report.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

/// A smaller scene of the same kind for timing, and by how much a step of the full one is more work.
struct TimedScene {
    io::Scene scene;
    double larger = 1.0;
};

/// The functions of one kind.
struct Kind {
    /// The simulation of a scene, at its start, or in the state `saved` by save() when that is not empty.  `threads`
    /// must outlive it.
    Simulation (*make)(const io::Scene& scene, Threads& threads, std::span<const double> saved);
    /// The number of threads: as set, or the cores that the process may use, fewer for a small scene.
    int (*threads)(const io::Scene& scene);
    double (*memory_bytes)(const io::Scene& scene);  ///< of memory that the simulation needs
    double (*disk_bytes)(const io::Scene& scene);    ///< of its archive, before compression
    std::string (*size)(const io::Scene& scene);     ///< "16 by 16 points"
    const char* body;                                ///< "a grid of": precedes size in messages
    const char* size_key;                            ///< the key of the scene that reduces its size
    const char* start;  ///< the section with kind, file and frame, from which a ramp of a sweep and another run start
    TimedScene (*timed)(const io::Scene& scene);
    std::string (*advice)(const io::Scene& scene);  ///< a warning before the run starts; else ""
    Report (*report)(const files::ArchiveReader& archive, const io::Scene& scene);
};
const Kind& kind_of(const io::Scene& scene);

/// Bytes of the recordings of a run with so many values per frame and per sample, before compression.
double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample);

/// Samples of the observables per chunk: as many as there are between two frames, so that a chunk is full when a frame
/// is committed and is written once.
int samples_per_chunk(const io::Scene& scene);

/// A file named in a scene: in the folder of the scene if it exists there, else as given.
std::filesystem::path file_beside(const io::Scene& scene, const std::string& given);

}  // namespace drover::run
