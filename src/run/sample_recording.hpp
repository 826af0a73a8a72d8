// run/sample_recording.hpp: observables of any kind of moment, into an archive and back.
#pragma once
#include <memory>
#include <utility>

#include "drover/measure/summary.hpp"
#include "drover/run/scene_support.hpp"
#include "drover/run/simulation.hpp"

namespace drover::run {

std::vector<files::Axis> file_axes(const std::vector<measure::Axis>& axes);

/// Records the observables in a group of the archive.  make_moment() returns the present moment of the run.
template <class Moment, class MakeMoment>
ScheduledRecording sample_recording(const io::Scene& scene, const char* group, measure::Observables<Moment> rows,
                                    MakeMoment make_moment) {
    files::Recording recording{.group = group,
                               .axes = file_axes(measure::axes_of(rows)),
                               .quantities = {},
                               .rows_per_chunk = samples_per_chunk(scene)};
    for (const auto& row : rows)
        recording.quantities.push_back({row.name, row.unit, row.formula, measure::names_of(row.axes)});
    const auto values = std::make_shared<std::vector<std::vector<double>>>();
    const auto observe = [rows = std::move(rows), make_moment = std::move(make_moment), values] {
        const Moment moment = make_moment();
        std::vector<std::vector<double>> measured;
        for (const auto& row : rows) measured.push_back(measure::measure_one(row, moment));
        return lend(*values, std::move(measured));
    };
    return {std::move(recording), io::whole_steps(scene, "output.sample_every", scene.output.sample_every), observe};
}

/// The first `samples` samples of the observables that such a recording holds.
template <class Moment>
std::vector<measure::RecordedSeries> read_series(const files::ArchiveReader& archive, const std::string& group,
                                                 const measure::Observables<Moment>& rows, std::size_t samples) {
    std::vector<measure::RecordedSeries> series;
    for (const auto& row : rows) {
        const std::string path = group + "/" + row.name;
        series.push_back(measure::recorded_series(row, archive.read(path).values));
        require(series.back().values.size() >= samples * measure::size_of(row.axes), {},
                "{} has {} numbers; expected at least {}, for {} samples: the archive is damaged", path,
                series.back().values.size(), samples * measure::size_of(row.axes), samples);
        series.back().values.resize(samples * measure::size_of(row.axes));
    }
    return series;
}

}  // namespace drover::run
