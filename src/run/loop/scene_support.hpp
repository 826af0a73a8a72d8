// run/loop/scene_support.hpp: what the simulations of fields and of particles share: recordings of observables and
// their sizes, files, timing.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/mapped.hpp"
#include "io/scene.hpp"
#include "measure/summary.hpp"
#include "run/loop/simulation.hpp"

namespace drover::run {

/// A smaller scene of the same kind for timing, and by how much a step of the full one is more work.
struct TimedScene {
    io::Scene scene;
    double larger = 1.0;
};

/// Bytes of the recordings of a run with so many values per frame and per sample, before compression.
double recorded_bytes(const io::Scene& scene, double numbers_per_frame, double numbers_per_sample);

template <class Moment>
std::vector<files::Quantity> quantities_of(const measure::Observables<Moment>& rows) {
    return mapped(rows, [](const auto& row) {
        return files::Quantity{row.name, row.unit, row.formula, measure::names_of(row.axes)};
    });
}
template <class Moment>
std::vector<std::vector<double>> measure_all(const measure::Observables<Moment>& rows, const Moment& moment) {
    return mapped(rows, [&](const auto& row) { return measure::measure_one(row, moment); });
}

/// Records observables in a group of the archive, at output.sample_every.  measure() returns their present values.
ScheduledRecording sample_recording(const io::Scene& scene, const char* group, const std::vector<measure::Axis>& axes,
                                    std::vector<files::Quantity> quantities,
                                    std::function<std::vector<std::vector<double>>()> measure);

/// The first `samples` samples of the observables that such a recording holds: those of earlier versions have fewer.
template <class Moment>
std::vector<measure::RecordedSeries> read_series(const files::ArchiveReader& archive, const std::string& group,
                                                 const measure::Observables<Moment>& rows, std::size_t samples) {
    std::vector<measure::RecordedSeries> series;
    for (const auto& row : rows) {
        const std::string path = group + "/" + row.name;
        if (!archive.has(path)) continue;
        series.push_back(measure::recorded_series(row, archive.read(path).values));
        require(series.back().values.size() >= samples * measure::size_of(row.axes), {},
                "{} has {} numbers; expected at least {}, for {} samples: the archive is damaged", path,
                series.back().values.size(), samples * measure::size_of(row.axes), samples);
        series.back().values.resize(samples * measure::size_of(row.axes));
    }
    return series;
}

/// Whether an archive is that of a run which has not reached its end: it has no summary.
bool is_unfinished(const files::ArchiveReader& archive);

/// Warns where a scene starts from the last frame of such an archive.
void warn_of_unfinished(const files::ArchiveReader& archive, const std::string& key, const std::string& file,
                        int frame);

/// The archive that a key of a scene names.  Throws an Error at its place.
files::ArchiveReader named_archive(const io::Scene& scene, const std::string& key, const std::string& file);

/// The files that a scene is read from: itself, a start, a table of coefficients.
std::vector<std::filesystem::path> inputs_of(const io::Scene& scene);

/// An archive that is to be written.
struct OutputFile {
    std::filesystem::path path;
    SourceLocation where;  ///< of its name, for errors
    std::string name;      ///< "--output x.h5"
    bool overwrite = false;
};

/// Throws an input Error unless the folder of the file exists.
void require_folder_of(const OutputFile& output);

/// Throws an input Error unless the file can be written there: in a folder that exists, over none of these inputs, and,
/// where a file exists, with `overwrite` over an HDF5 file.
void check_output(const OutputFile& output, const std::vector<std::filesystem::path>& inputs);

}  // namespace drover::run
