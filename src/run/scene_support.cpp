// run/scene_support.cpp: sizes of recordings, and files named in a scene.
#include "drover/run/scene_support.hpp"

#include <algorithm>
#include <cmath>

namespace drover::run {

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
