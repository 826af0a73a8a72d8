// measure/summary.cpp: time means of all observables of a run, and what follows from them.
#include "drover/measure/summary.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/base/error.hpp"

namespace drover::measure {

namespace {

std::optional<std::size_t> find_observable(const Recorded& recorded, const std::string& name) {
    for (std::size_t i = 0; i < recorded.observables.size(); ++i)
        if (recorded.observables[i].name == name) return i;
    return std::nullopt;
}

std::size_t size_at(const Recorded& recorded, std::size_t observable) {
    return size_of(recorded.observables[observable], recorded.setting);
}

/// The samples recorded.  Throws unless all series agree.
std::size_t checked_samples(const Recorded& recorded) {
    require(recorded.series.size() == recorded.observables.size(), {},
            "{} recorded series for {} observables; expected one each", recorded.series.size(),
            recorded.observables.size());
    std::optional<std::size_t> samples;
    for (std::size_t i = 0; i < recorded.series.size(); ++i) {
        const std::size_t size = size_at(recorded, i), found = recorded.series[i].size();
        if (size == 0) continue;  // a grid too small for any shell
        if (!samples) samples = found / size;
        require(found == *samples * size, {}, "{}: {} numbers recorded; expected {} samples of {} numbers each",
                recorded.observables[i].name, found, *samples, size);
    }
    return samples.value_or(0);
}

RecordedSeries series_of(const Recorded& recorded, std::size_t observable) {
    const Observable& row = recorded.observables[observable];
    return {row.name,
            row.unit,
            row.formula,
            names_of(row.axes),
            size_at(recorded, observable),
            recorded.series[observable]};
}

/// Sum over all modes in shells, at each sample, of the observables named: the total power.
std::vector<double> total_power(const Recorded& recorded, const std::vector<std::string>& names, std::size_t samples) {
    const std::vector<double>& weight = recorded.setting.shells.weight;
    std::vector<double> total(samples);
    for (const std::string& name : names)
        if (const auto i = find_observable(recorded, name))
            for (std::size_t sample = 0; sample < samples; ++sample)
                for (std::size_t n = 0; n < weight.size(); ++n)
                    total[sample] += weight[n] * recorded.series[*i][sample * weight.size() + n];
    return total;
}

std::size_t automatic_warm_up(const Recorded& recorded, std::size_t samples) {
    std::size_t longest = 0;
    for (const std::vector<std::string>& names : {std::vector<std::string>{"structure_factor_rods"},
                                                  {"structure_factor_beads"},
                                                  {"structure_factor_order_along", "structure_factor_order_across"}})
        longest = std::max(longest, warm_up_length(total_power(recorded, names, samples)));
    if (const auto order = find_observable(recorded, "polar_order"))
        longest = std::max(longest, warm_up_length(recorded.series[*order]));
    return longest;
}

/// Sectors of small shells that hold no mode are told so, not blamed on the run.
void name_empty_sectors(const Recorded& recorded, SummaryRow& row) {
    if (row.axes != std::vector{name_of(ObservableAxis::sector), name_of(ObservableAxis::shell)}) return;
    const std::vector<double> ones(numerics::modes(recorded.setting.grid), 1.0);
    const std::vector<double> present =
        numerics::sector_means(recorded.setting.grid, recorded.setting.shells, recorded.setting.sectors, ones);
    for (std::size_t k = 0; k < present.size(); ++k)
        if (std::isnan(present[k])) row.estimates[k].refusal = "no mode lies in this sector of this shell";
}

/// Number fluctuations of rods or of beads, `total` of them in the cell, in boxes of one shape.
void add_boxes(const Recorded& recorded, const std::string& what, double total, const BoxFamily& family,
               std::size_t skip, std::vector<SummaryRow>& rows) {
    const auto variance = find_observable(recorded, what + "_number_variance" + family.ending);
    if (!variance) return;
    BoxSeries boxes{series_of(recorded, *variance), what, family.ending, family.shape, total, {}};
    for (const int side : recorded.setting.*family.sides)
        boxes.parts.push_back(static_cast<double>(family.along_x * side) * (family.along_y * side) /
                              static_cast<double>(numerics::points(recorded.setting.grid)));
    add_box_rows(boxes, recorded.spacing, skip, rows);
}

}  // namespace

Samples split(const RecordedSeries& recorded, double spacing, std::size_t skip) {
    const std::size_t size = recorded.size;
    Samples result{.series = std::vector<std::vector<double>>(size), .spacing = spacing, .skip = skip};
    for (std::size_t k = 0; k < size; ++k)
        for (std::size_t i = k; i < recorded.values.size(); i += size) result.series[k].push_back(recorded.values[i]);
    return result;
}

SummaryRow mean_row(const RecordedSeries& recorded, double spacing, std::size_t skip) {
    SummaryRow row{recorded.name, recorded.unit, "time mean: " + recorded.formula, recorded.axes, {}};
    const Samples samples = split(recorded, spacing, skip);
    for (std::size_t k = 0; k < samples.series.size(); ++k) row.estimates.push_back(estimate_mean(samples, k));
    return row;
}

void add_order_rows(const RecordedSeries& order, double area, double spacing, std::size_t skip,
                    std::vector<SummaryRow>& rows) {
    const Samples samples = split(order, spacing, skip);
    rows.push_back({"polar_order_susceptibility",
                    "mm2",
                    "area (<P^2> - <P>^2), P the polar order of one time",
                    {},
                    {estimate_susceptibility(samples, 0, area)}});
    rows.push_back({"polar_order_binder",
                    "1",
                    "Binder cumulant 1 - <P^4>/(3 <P^2>^2) of the polar order P",
                    {},
                    {estimate_binder_cumulant(samples, 0)}});
}

void add_box_rows(const BoxSeries& boxes, double spacing, std::size_t skip, std::vector<SummaryRow>& rows) {
    const Samples samples = split(boxes.variance, spacing, skip);
    const std::string start = boxes.what + "_number", &ending = boxes.ending, &what = boxes.what;
    const std::vector<std::string>& axes = boxes.variance.axes;
    SummaryRow number{start + ending, "1", "mean number of " + what + "s in a " + boxes.shape + ", N", axes, {}};
    SummaryRow deviation{start + "_deviation" + ending,
                         "1",
                         "DN, root of the time mean of the variance of the number of " + what + "s in a " + boxes.shape,
                         axes,
                         {}};
    SummaryRow exponent{
        start + "_exponent" + ending,
        "1",
        "d ln DN/d ln N between a box and the next larger one; compare with linear theory of the same boxes: "
        "the finite cell alone makes it fall",
        axes,
        {}};
    for (std::size_t b = 0; b < boxes.parts.size(); ++b) {
        number.estimates.push_back({.mean = boxes.total * boxes.parts[b], .error = 0.0});
        deviation.estimates.push_back(estimate_deviation(samples, b));
        if (b + 1 < boxes.parts.size())
            exponent.estimates.push_back(
                estimate_local_exponent(samples, b, b + 1, boxes.parts[b + 1] / boxes.parts[b]));
        else
            exponent.estimates.push_back(
                {.mean = std::numeric_limits<double>::quiet_NaN(), .refusal = "there is no larger box"});
    }
    rows.insert(rows.end(), {number, deviation, exponent});
}

std::string warm_up_note(std::size_t automatic, std::size_t samples) {
    if (automatic == 0 || 2 * automatic + 10 <= samples) return "";  // the last cut tried, up to the length of a batch
    return text(
        "the warm-up may not have ended: the best cut found is the last one tried, half of {} samples; run "
        "longer or set the warm-up",
        samples);
}

Summary summarise(const Recorded& recorded) {
    Summary summary{.samples = checked_samples(recorded), .warm_up = 0, .note = "", .rows = {}};
    const std::size_t automatic = recorded.warm_up ? 0 : automatic_warm_up(recorded, summary.samples);
    summary.warm_up = std::min(recorded.warm_up.value_or(automatic), summary.samples);
    summary.note = warm_up_note(automatic, summary.samples);
    for (std::size_t i = 0; i < recorded.observables.size(); ++i) {
        summary.rows.push_back(mean_row(series_of(recorded, i), recorded.spacing, summary.warm_up));
        name_empty_sectors(recorded, summary.rows.back());
    }
    if (const auto order = find_observable(recorded, "polar_order"))
        add_order_rows(series_of(recorded, *order), numerics::area(recorded.setting.grid), recorded.spacing,
                       summary.warm_up, summary.rows);
    for (const BoxFamily& family : box_families()) {
        add_boxes(recorded, "rod", recorded.rods, family, summary.warm_up, summary.rows);
        add_boxes(recorded, "bead", recorded.beads, family, summary.warm_up, summary.rows);
    }
    return summary;
}

const SummaryRow* find_row(const Summary& summary, const std::string& name) {
    for (const SummaryRow& row : summary.rows)
        if (row.name == name) return &row;
    return nullptr;
}

}  // namespace drover::measure
