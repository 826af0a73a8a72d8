// run/kind.hpp: what a run needs to know of the kind of a scene, fields or particles, in one place.
#pragma once
#include <span>
#include <string>

#include "drover/base/threads.hpp"
#include "drover/io/scene.hpp"
#include "drover/run/report.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

/// A smaller scene of the same kind that costs less to time, and how many times more work a step of the true one is.
struct TimedScene {
    io::Scene scene;
    double larger = 1.0;
};

/// The functions of one kind.
struct Kind {
    /// The scene's world, at its start, or in a state that its save() gave when `saved` is not empty.  `threads` must outlive it.
    Simulation (*make)(const io::Scene& scene, Threads& threads, std::span<const double> saved);
    /// Threads: as asked, or the cores that the process may use, fewer where the scene cannot feed them.
    int (*threads)(const io::Scene& scene);
    double (*memory_bytes)(const io::Scene& scene);  ///< that the simulation will hold
    double (*disk_bytes)(
        const io::Scene& scene);  ///< of its archive, before compression, counted without making its world
    std::string (*size)(const io::Scene& scene);  ///< "16 by 16 points"
    const char* body;                             ///< "a grid of": goes before size
    const char* size_key;                         ///< of the scene: where to make it smaller
    const char* start;  ///< the section with kind, file and frame: what a ramp of a sweep and another run start from
    TimedScene (*timed)(const io::Scene& scene);
    std::string (*advice)(const io::Scene& scene);  ///< what the user should know before the run starts; "": nothing
    Report (*report)(const files::ArchiveReader& archive, const io::Scene& scene);
};
const Kind& kind_of(const io::Scene& scene);

/// Bytes that recordings with so many numbers a frame and a sample take in the whole run of a scene, before compression.
double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample);

/// Samples of the observables in a chunk: as many as fall between two frames, for a chunk that is filled when a frame is committed is
/// written once, not again and again.
int samples_per_chunk(const io::Scene& scene);

/// A file that a scene names: as given, or beside the scene where it is there.
std::filesystem::path file_beside(const io::Scene& scene, const std::string& given);

}  // namespace drover::run
