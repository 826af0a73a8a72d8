// measure/particle_summary.cpp: time means, rates and quotients of the observables of particles.
#include "drover/measure/particle_summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/base/error.hpp"

namespace drover::measure {

namespace {
RecordedSeries series_of(const ParticleRecorded& recorded, std::size_t observable) {
    const ParticleObservable& row = recorded.observables[observable];
    std::vector<std::string> axes;
    for (const ParticleAxis axis : row.axes) axes.push_back(axis_of(axis, recorded.setting).name);
    return {row.name, row.unit, row.formula, axes, size_of(row, recorded.setting), recorded.series[observable]};
}

std::optional<std::size_t> find_observable(const ParticleRecorded& recorded, const std::string& name) {
    for (std::size_t i = 0; i < recorded.observables.size(); ++i)
        if (recorded.observables[i].name == name) return i;
    return std::nullopt;
}

/// The samples recorded.  Throws unless all series agree.
std::size_t checked_samples(const ParticleRecorded& recorded) {
    require(recorded.series.size() == recorded.observables.size(), {},
            "{} recorded series for {} observables; expected one each", recorded.series.size(),
            recorded.observables.size());
    std::optional<std::size_t> samples;
    for (std::size_t i = 0; i < recorded.series.size(); ++i) {
        const std::size_t size = size_of(recorded.observables[i], recorded.setting), found = recorded.series[i].size();
        if (size == 0) continue;
        if (!samples) samples = found / size;
        require(found == *samples * size, {}, "{}: {} numbers recorded; expected {} samples of {} numbers each",
                recorded.observables[i].name, found, *samples, size);
    }
    return samples.value_or(0);
}

std::size_t automatic_warm_up(const ParticleRecorded& recorded) {
    std::size_t longest = 0;
    for (const char* name : {"polar_order", "energy_kinetic"})
        if (const auto i = find_observable(recorded, name))
            longest = std::max(longest, warm_up_length(recorded.series[*i]));
    return longest;
}

/// The mean rate of what accumulates.
SummaryRow rate_row(const ParticleRecorded& recorded, std::size_t observable, std::size_t skip) {
    RecordedSeries series = series_of(recorded, observable);
    const std::vector<double> changes = rates(series.values, recorded.spacing);
    series.values = changes;
    series.name += "_rate";
    series.unit = series.unit == "1" ? "s-1" : series.unit + " s-1";
    SummaryRow row = mean_row(series, recorded.spacing, std::min(skip, changes.size()));
    row.formula = "mean rate: " + series.formula;
    return row;
}

SummaryRow quotient_row(const ParticleRecorded& recorded, const ParticleQuotient& quotient, std::size_t sum,
                        std::size_t weight, std::size_t skip) {
    const RecordedSeries above = series_of(recorded, sum), below = series_of(recorded, weight);
    const Samples sums = split(above, recorded.spacing, skip), weights = split(below, recorded.spacing, skip);
    SummaryRow row{quotient.name, quotient.unit, quotient.formula, above.axes, {}};
    for (std::size_t k = 0; k < above.size; ++k) {
        const std::vector<double>& weighing = weights.series[k];
        const auto used = weighing.begin() + static_cast<std::ptrdiff_t>(std::min(skip, weighing.size()));
        if (std::all_of(used, weighing.end(), [](double value) { return value == 0.0; })) {
            row.estimates.push_back({.mean = std::numeric_limits<double>::quiet_NaN(),
                                     .refusal = "its weight, " + quotient.weight + ", is zero in every sample"});
            continue;
        }
        const Samples both{.series = {sums.series[k], weighing}, .spacing = recorded.spacing, .skip = skip};
        row.estimates.push_back(estimate_function(both, [](auto means) { return means[0] / means[1]; }));
    }
    return row;
}
}  // namespace

Summary summarise(const ParticleRecorded& recorded) {
    Summary summary{.samples = checked_samples(recorded), .warm_up = 0, .note = "", .rows = {}};
    const std::size_t automatic = recorded.warm_up ? 0 : automatic_warm_up(recorded);
    const std::size_t skip = summary.warm_up = std::min(recorded.warm_up.value_or(automatic), summary.samples);
    summary.note = warm_up_note(automatic, summary.samples);
    for (std::size_t i = 0; i < recorded.observables.size(); ++i)
        summary.rows.push_back(recorded.observables[i].accumulates
                                   ? rate_row(recorded, i, skip)
                                   : mean_row(series_of(recorded, i), recorded.spacing, skip));
    for (const ParticleQuotient& quotient : particle_quotients(recorded.setting)) {
        const auto sum = find_observable(recorded, quotient.sum), weight = find_observable(recorded, quotient.weight);
        if (sum && weight) summary.rows.push_back(quotient_row(recorded, quotient, *sum, *weight, skip));
    }
    if (const auto order = find_observable(recorded, "polar_order"))
        add_order_rows(series_of(recorded, *order), dem::area(recorded.setting.cell), recorded.spacing, skip,
                       summary.rows);
    for (const auto& [what, total] : {std::pair{"rod", recorded.setting.rods}, {"bead", recorded.setting.beads}})
        if (const auto variance = find_observable(recorded, text("{}_number_variance", what)))
            add_box_rows({series_of(recorded, *variance), what, "", "square", static_cast<double>(total),
                          recorded.setting.part},
                         recorded.spacing, skip, summary.rows);
    return summary;
}

}  // namespace drover::measure
