// run/loop/scene_support.cpp: recordings of observables, sizes of recordings, and files named in a scene.
#include "run/loop/scene_support.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>

#include "base/log.hpp"
#include "files/archive_reader.hpp"
#include "files/system_calls.hpp"

namespace drover::run {

double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample) {
    const double frames = scene.output.frame_every == 0.0 ? 2.0 : 1.0 + scene.time.end / scene.output.frame_every;
    const double samples = scene.output.sample_every == 0.0 ? 2.0 : 1.0 + scene.time.end / scene.output.sample_every;
    // Not compressed: the index of the chunks, attributes, a summary.
    constexpr double per_file = 5e5, index_fraction = 0.1;
    return per_file +
           (1.0 + index_fraction) * sizeof(double) * (numbers_per_frame * frames + numbers_per_sample * samples);
}

namespace {
/// As many as there are between two frames, so that a chunk is full when a frame is committed and is written once, but
/// fewer where one sample of a quantity has many numbers, `largest`.
int samples_per_chunk(const io::Scene& scene, std::size_t largest) {
    constexpr double min = 8.0, max = 64.0, max_numbers = 1 << 20;  // of a chunk, which is held and written whole
    const bool is_free = scene.output.frame_every == 0.0 || scene.output.sample_every == 0.0;
    const double samples =
        is_free ? max : std::clamp(std::round(scene.output.frame_every / scene.output.sample_every), min, max);
    return static_cast<int>(std::clamp(std::floor(max_numbers / static_cast<double>(largest)), 2.0, samples));
}
}  // namespace

ScheduledRecording sample_recording(const io::Scene& scene, const char* group, const std::vector<measure::Axis>& axes,
                                    std::vector<files::Quantity> quantities,
                                    std::function<std::vector<std::vector<double>>()> measure) {
    const auto values = std::make_shared<std::vector<std::vector<double>>>();
    std::size_t largest = 1;
    for (const files::Quantity& quantity : quantities) {
        const std::vector<std::size_t> shape = files::shape_of(axes, quantity);
        largest = std::max(largest, std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>{}));
    }
    return {{.group = group,
             .axes = axes,
             .quantities = std::move(quantities),
             .rows_per_chunk = samples_per_chunk(scene, largest)},
            io::whole_steps(scene, "output.sample_every", scene.output.sample_every),
            [measure = std::move(measure), values] { return store_in_place(*values, measure()); }};
}

bool is_unfinished(const files::ArchiveReader& archive) {
    return files::text_in(archive.attributes(), "title").starts_with(text("drover {} of ", "run")) &&
           !archive.has("/summary/warm_up");
}

void warn_of_unfinished(const files::ArchiveReader& archive, const std::string& key, const std::string& file,
                        int frame) {
    if (frame < 0 && is_unfinished(archive))
        log_warning(
            "{} = \"{}\" is of a run that has not reached its end: its last frame is that of now, and another one when "
            "the run goes on; let it end, or name the frame",
            key, file);
}

files::ArchiveReader named_archive(const io::Scene& scene, const std::string& key, const std::string& file) try {
    return files::ArchiveReader(io::beside(scene.file, file));
} catch (const Error& error) {
    throw Error(error.fault(), io::locate(scene, key), text("{}: {}", key, error.what()));
}

std::vector<std::filesystem::path> inputs_of(const io::Scene& scene) {
    std::vector<std::filesystem::path> inputs{scene.file};
    for (const std::string& given : {scene.initial.file, scene.particles.packing.file, scene.calibrated.table})
        if (!given.empty()) inputs.push_back(io::beside(scene.file, given));
    return inputs;
}

void require_folder_of(const OutputFile& output) {
    const std::filesystem::path folder = files::folder_of(output.path);
    std::error_code problem;
    require(std::filesystem::is_directory(folder, problem), output.where,
            "{}: the folder \"{}\" does not exist; make it first", output.name, folder.string());
}

void check_output(const OutputFile& output, const std::vector<std::filesystem::path>& inputs) {
    require_folder_of(output);
    const std::filesystem::path& path = output.path;
    std::error_code problem;
    require(!std::filesystem::is_directory(path, problem), output.where, "{} is a folder; expected the name of a file",
            output.name);
    if (!std::filesystem::exists(path, problem)) return;
    for (const std::filesystem::path& input : inputs)
        require(!std::filesystem::equivalent(path, input, problem), output.where,
                "{} is an input of this command, which it does not replace; choose another name", output.name);
    require(!output.overwrite || files::is_hdf5(path), output.where,
            "{} exists and is not an HDF5 file, which --overwrite does not replace; choose another name", output.name);
    require(output.overwrite, output.where,
            "{} exists; choose another name, or give --overwrite; a run is resumed by drover restart", output.name);
}

}  // namespace drover::run
