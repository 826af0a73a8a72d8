// run/kind.cpp: the two kinds of scenes.
#include "drover/run/kind.hpp"

#include <algorithm>
#include <cmath>

#include "drover/run/field_simulation.hpp"
#include "drover/run/particle_simulation.hpp"

namespace drover::run {

const Kind& kind_of(const io::Scene& scene) {
    static const Kind fields{.make = make_field_simulation,
                             .threads = choose_threads,
                             .memory_bytes = field_simulation_bytes,
                             .disk_bytes = field_disk_bytes,
                             .size = field_size,
                             .body = "a grid of",
                             .size_key = "grid.nx",
                             .start = "initial",
                             .timed = timed_fields,
                             .advice = [](const io::Scene&) { return std::string(); },
                             .report = make_field_report};
    static const Kind particles{.make = make_particle_simulation,
                                .threads = particle_threads,
                                .memory_bytes = particle_simulation_bytes,
                                .disk_bytes = particle_disk_bytes,
                                .size = particle_size,
                                .body = "a world of",
                                .size_key = "beads.area_fraction",
                                .start = "packing",
                                .timed = timed_particles,
                                .advice = particle_advice,
                                .report = make_particle_report};
    return scene.kind == io::SceneKind::fields ? fields : particles;
}

double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample) {
    const double frames = scene.output.frame_every == 0.0 ? 2.0 : 1.0 + scene.time.end / scene.output.frame_every;
    const double samples = scene.output.sample_every == 0.0 ? 2.0 : 1.0 + scene.time.end / scene.output.sample_every;
    // Not compressed: the index of the chunks, attributes, a summary.
    constexpr double per_file = 5e5, index_fraction = 0.1;
    return per_file +
           (1.0 + index_fraction) * sizeof(double) * (numbers_per_frame * frames + numbers_per_sample * samples);
}

int samples_per_chunk(const io::Scene& scene) {
    constexpr double min = 8.0, max = 64.0;
    if (scene.output.frame_every == 0.0 || scene.output.sample_every == 0.0) return static_cast<int>(max);
    return static_cast<int>(std::clamp(std::round(scene.output.frame_every / scene.output.sample_every), min, max));
}

std::filesystem::path file_beside(const io::Scene& scene, const std::string& given) {
    const std::filesystem::path path = given, in_folder = std::filesystem::path(scene.file).parent_path() / path;
    return path.is_relative() && std::filesystem::exists(in_folder) ? in_folder : path;
}

}  // namespace drover::run
