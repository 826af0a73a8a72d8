// run/sample_recording.hpp: observables of any kind of moment, into an archive and back.
#pragma once
#include <functional>
#include <utility>

#include "measure/summary.hpp"
#include "run/scene_support.hpp"
#include "run/simulation.hpp"

namespace drover::run {

template <class Moment>
std::vector<files::Quantity> quantities_of(const measure::Observables<Moment>& rows) {
    std::vector<files::Quantity> quantities;
    for (const auto& row : rows) quantities.push_back({row.name, row.unit, row.formula, measure::names_of(row.axes)});
    return quantities;
}
template <class Moment>
std::vector<std::vector<double>> measure_all(const measure::Observables<Moment>& rows, const Moment& moment) {
    std::vector<std::vector<double>> measured;
    for (const auto& row : rows) measured.push_back(measure::measure_one(row, moment));
    return measured;
}

/// Records observables in a group of the archive, at output.sample_every.  measure() returns their present values.
ScheduledRecording sample_recording(const io::Scene& scene, const char* group, const std::vector<measure::Axis>& axes,
                                    std::vector<files::Quantity> quantities,
                                    std::function<std::vector<std::vector<double>>()> measure);

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
