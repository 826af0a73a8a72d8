// run/scene_support.hpp: what the simulations of fields and of particles share: sizes of recordings, files, timing.
#pragma once
#include <filesystem>
#include <string>

#include "drover/io/scene.hpp"

namespace drover::run {

/// A smaller scene of the same kind for timing, and by how much a step of the full one is more work.
struct TimedScene {
    io::Scene scene;
    double larger = 1.0;
};

/// Bytes of the recordings of a run with so many values per frame and per sample, before compression.
double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample);

/// Samples of the observables per chunk: as many as there are between two frames, so that a chunk is full when a frame
/// is committed and is written once.
int samples_per_chunk(const io::Scene& scene);

/// A file named in a scene: in the folder of the scene if it exists there, else as given.
std::filesystem::path file_beside(const io::Scene& scene, const std::string& given);

}  // namespace drover::run
