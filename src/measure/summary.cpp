// measure/summary.cpp: time means of all observables of a run, and the results derived from them; units of products,
// whose exponents add up.
#include "measure/summary.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "base/constants.hpp"
#include "drover/base/error.hpp"

namespace drover::measure {

namespace {
/// The samples recorded.  Throws unless all series agree.
std::size_t checked_samples(const Recorded& recorded) {
    std::optional<std::size_t> samples;
    for (const RecordedSeries& series : recorded.series) {
        const std::size_t size = size_of(series.axes), found = series.values.size();
        if (size == 0) continue;
        if (!samples) samples = found / size;
        require(found == *samples * size, {}, "{}: {} values recorded; expected {} samples of {} values each",
                series.name, found, *samples, size);
    }
    return samples.value_or(0);
}

/// Samples at the times of `timing`, which has no series.
Samples with_series(Samples timing, std::vector<std::vector<double>> series) {
    timing.series = std::move(series);
    return timing;
}

/// Each value of an observable as a series of its own.
Samples split(const RecordedSeries& recorded, const Samples& timing) {
    const std::size_t size = size_of(recorded.axes);
    Samples result = with_series(timing, std::vector<std::vector<double>>(size));
    for (std::size_t k = 0; k < size; ++k)
        for (std::size_t i = k; i < recorded.values.size(); i += size) result.series[k].push_back(recorded.values[i]);
    return result;
}

SummaryRow mean_row(const RecordedSeries& recorded, const Samples& timing) {
    SummaryRow row{recorded.name, recorded.unit, "time mean: " + recorded.formula, recorded.axes, {}, recorded.nature};
    Samples samples = split(recorded, timing);
    for (std::size_t k = 0; k < samples.series.size(); ++k) {
        const bool is_direction = recorded.averaging == Averaging::direction;
        std::vector<double>& values = samples.series[k];
        for (std::size_t i = 1; is_direction && i < values.size(); ++i)  // by the shortest turn from the one before
            values[i] = values[i - 1] + std::remainder(values[i] - values[i - 1], 2.0 * std::numbers::pi);
        Estimate& estimate = row.estimates.emplace_back(estimate_mean(samples, k));
        if (is_direction) estimate.mean = std::remainder(estimate.mean, 2.0 * std::numbers::pi);
        estimate.averaging = recorded.averaging;
    }
    return row;
}

/// The last value of a running maximum.
SummaryRow maximum_row(const RecordedSeries& recorded, const Samples& timing) {
    SummaryRow row{recorded.name, recorded.unit, recorded.formula, recorded.axes, {}, recorded.nature};
    for (const std::vector<double>& values : split(recorded, timing).series)
        row.estimates.push_back({.mean = values.empty() ? nan : values.back(),
                                 .samples = values.size(),
                                 .why_no_error = "no error estimate: it is the largest value of the run",
                                 .averaging = Averaging::maximum});
    return row;
}

/// Gives the means of a product the errors of blocks that are long enough for its squares.
void take_memory(const RecordedSeries& product, const std::array<const RecordedSeries*, 2>& squares,
                 const Samples& timing, SummaryRow& row) {
    const Samples own = split(product, timing), first = split(*squares[0], timing), second = split(*squares[1], timing);
    for (std::size_t k = 0; k < row.estimates.size(); ++k) {
        Estimate& one = row.estimates[k];
        if (!one.error || *one.error == 0.0) continue;
        const Samples all = with_series(timing, {own.series[k], first.series[k], second.series[k]});
        const Estimate long_blocks = estimate_function(all, [](auto means) { return means[0]; });
        one.why_no_error = long_blocks.why_no_error;
        one.autocorrelation_time = std::max(one.autocorrelation_time, long_blocks.autocorrelation_time);
        if (long_blocks.error) {
            one.error = std::max(*one.error, *long_blocks.error);
            one.blocks = long_blocks.blocks;
        } else {
            one.error.reset();
        }
    }
}

SummaryRow rate_row(RecordedSeries series, const Samples& timing) {
    series.values = rates(series.values, timing.spacing);
    series.name += "_rate";
    const bool counts = series.unit == "1";
    series.unit = counts ? "s-1" : series.unit + " s-1";
    SummaryRow row = mean_row(series, timing);
    row.formula = "mean rate: " + series.formula;
    if (Estimate& rate = row.estimates.front(); counts && rate.mean == 0.0 && rate.error) {
        rate.error.reset();
        rate.why_no_error = text("no error estimate: no event in {}, so the rate is below about one in that time",
                                 time_text(static_cast<double>(rate.samples) * timing.spacing, timing.time_unit));
    }
    return row;
}

SummaryRow row_of(const RecordedSeries& recorded, const Samples& timing) {
    switch (recorded.averaging) {
        case Averaging::maximum: return maximum_row(recorded, timing);
        case Averaging::rate: return rate_row(recorded, timing);
        default: return mean_row(recorded, timing);
    }
}

SummaryRow quotient_row(const Quotient& quotient, const RecordedSeries& sum, const RecordedSeries& weight,
                        const Samples& timing) {
    const Samples sums = split(sum, timing), weights = split(weight, timing);
    SummaryRow row{quotient.name, quotient.unit, quotient.formula, sum.axes, {}};
    for (std::size_t k = 0; k < sums.series.size(); ++k) {
        const std::vector<double>& weighing = weights.series[k];
        const auto used = weighing.begin() + static_cast<std::ptrdiff_t>(std::min(timing.skip, weighing.size()));
        if (std::all_of(used, weighing.end(), [](double value) { return value == 0.0; })) {
            row.estimates.push_back(
                {.mean = nan, .why_no_error = "its weight, " + quotient.weight + ", is zero in every sample"});
            continue;
        }
        row.estimates.push_back(estimate_function(with_series(timing, {sums.series[k], weighing}),
                                                  [](auto means) { return means[0] / means[1]; }));
    }
    return row;
}

/// Susceptibility and Binder cumulant of the size of an order, in a cell of this area [mm2].
void add_order_rows(const RecordedSeries& order, double area, const Samples& timing, std::vector<SummaryRow>& rows) {
    const Samples samples = split(order, timing);
    rows.push_back({order.name + "_susceptibility",
                    unit_product({"mm2", order.unit, order.unit}),
                    text("area (<P^2> - <P>^2), P = {} at one time", order.name),
                    {},
                    {estimate_susceptibility(samples, 0, area)},
                    Nature::square_area});
    rows.push_back({order.name + "_binder",
                    "1",
                    text("Binder cumulant 1 - <P^4>/(3 <P^2>^2), P = {} at one time", order.name),
                    {},
                    {estimate_binder_cumulant(samples, 0)},
                    Nature::ratio});
}

/// Number fluctuations in boxes of one shape.
void add_box_rows(const BoxSizes& boxes, const RecordedSeries& variance, const Samples& timing,
                  std::vector<SummaryRow>& rows) {
    const Samples samples = split(variance, timing);
    const std::string start = boxes.what + "_number", &ending = boxes.ending;
    const std::vector<Axis>& axes = variance.axes;
    SummaryRow number{start + ending, "1", text("mean of {} in a {}, N", start, boxes.shape), axes, {}};
    SummaryRow deviation{start + "_deviation" + ending,
                         "1",
                         text("DN, square root of the time mean of the variance of {} in a {}", start, boxes.shape),
                         axes,
                         {}};
    SummaryRow exponent{
        start + "_exponent" + ending,
        "1",
        "d ln DN/d ln N between a box and the next larger one; compare with linear theory of the same boxes, since "
        "the finite cell alone reduces it",
        axes,
        {}};
    const Estimate total = boxes.total.size() == 1 ? Estimate{.mean = boxes.total.front(), .error = 0.0}
                                                   : estimate_mean(with_series(timing, {boxes.total}), 0);
    for (std::size_t b = 0; b < boxes.fractions.size(); ++b) {
        number.estimates.push_back(total);
        number.estimates.back().mean *= boxes.fractions[b];
        if (total.error) number.estimates.back().error = *total.error * boxes.fractions[b];
        deviation.estimates.push_back(estimate_deviation(samples, b));
        if (b + 1 < boxes.fractions.size())
            exponent.estimates.push_back(
                estimate_local_exponent(samples, b, b + 1, boxes.fractions[b + 1] / boxes.fractions[b]));
        else exponent.estimates.push_back({.mean = nan, .why_no_error = "there is no larger box"});
    }
    rows.insert(rows.end(), {number, deviation, exponent});
}

/// Samples until the start is forgotten: at the cut of warm_up_length what is left of it may be as large as the
/// fluctuations of one run, which in the mean of many runs is no longer small.  Ten autocorrelation times later it is
/// not, even where it decays several times more slowly than these.
std::size_t forgotten_after(std::span<const double> indicator, std::size_t cut) {
    if (indicator.size() <= cut) return cut;  // of a field without modes
    const double times = 10.0 * autocorrelation_time(indicator.subspan(cut));
    if (!(times > 5.0)) return cut;  // not correlated, or not finite
    return std::min(cut + static_cast<std::size_t>(std::ceil(times)), std::max(cut, indicator.size() / 2));
}

/// Non-empty when an automatic warm-up may not have ended: the best cut of so many of the samples is the last one
/// tried, up to the length of a batch, or more than half would have to be left out.
std::string warm_up_note(std::size_t cut, std::size_t automatic, std::size_t samples) {
    if ((cut == 0 || 2 * cut + 10 <= samples) && (automatic <= cut || automatic < samples / 2)) return "";
    return text(
        "the warm-up may not have ended: {} of {} samples are left out (at most half of them can be); run longer or "
        "set the warm-up",
        automatic, samples);
}

using Powers = std::vector<std::pair<std::string, int>>;

/// Adds those of "mm2 s-1"; returns whether the unit is a list of names and integer exponents.
bool add_powers(const std::string& unit, Powers& powers) {
    std::istringstream words(unit);
    for (std::string word; words >> word;) {
        if (word == "1") continue;
        const auto letters = static_cast<std::size_t>(
            std::ranges::find_if(word, [](unsigned char c) { return std::isalpha(c) == 0; }) - word.begin());
        const std::string name = word.substr(0, letters), exponent = word.substr(letters);
        const std::string digits = exponent.starts_with('-') ? exponent.substr(1) : exponent;
        constexpr std::size_t max_digits = 4;  // digits
        if (name.empty() || digits.size() > max_digits || (!exponent.empty() && digits.empty()) ||
            !std::ranges::all_of(digits, [](unsigned char c) { return std::isdigit(c) != 0; }))
            return false;
        auto found = std::ranges::find_if(powers, [&](const auto& one) { return one.first == name; });
        if (found == powers.end()) found = powers.insert(found, {name, 0});
        found->second += exponent.empty() ? 1 : std::stoi(exponent);
    }
    return true;
}

std::string in_brackets(const std::vector<std::string>& units) {
    std::string product;
    for (std::size_t n = 0; n < units.size(); ++n) {
        if (units[n] == "1") continue;
        const bool is_square = n + 1 < units.size() && units[n + 1] == units[n], is_last = n + 1 == units.size();
        if (!product.empty()) product += ' ';
        product += is_last && n > 1 ? units[n] : "(" + units[n] + ")" + (is_square ? "^2" : "");
        if (is_square) ++n;
    }
    return product;
}
}  // namespace

std::vector<double> values_of(const std::vector<RecordedSeries>& series, const std::string& name) {
    const RecordedSeries* row = find_row(series, name);
    return row == nullptr ? std::vector<double>() : row->values;
}

Summary summarise(const Recorded& recorded) {
    Summary summary{.samples = checked_samples(recorded)};
    std::size_t cut = 0, automatic = 0;
    if (!recorded.warm_up)
        for (const std::vector<double>& indicator : recorded.indicators) cut = std::max(cut, warm_up_length(indicator));
    if (!recorded.warm_up)
        for (const std::vector<double>& indicator : recorded.indicators)
            automatic = std::max(automatic, forgotten_after(indicator, cut));
    summary.warm_up = std::min(recorded.warm_up.value_or(automatic), summary.samples);
    const Samples timing{.spacing = recorded.spacing, .skip = summary.warm_up, .time_unit = recorded.time_unit};
    summary.note = warm_up_note(cut, automatic, summary.samples);
    for (const RecordedSeries& series : recorded.series) summary.rows.push_back(row_of(series, timing));
    for (const Product& product : recorded.products) {
        const std::array squares{find_row(recorded.series, product.squares[0]),
                                 find_row(recorded.series, product.squares[1])};
        const RecordedSeries* const series = find_row(recorded.series, product.name);
        if (series == nullptr || squares[0] == nullptr || squares[1] == nullptr) continue;
        const auto row = std::ranges::find(summary.rows, product.name, &SummaryRow::name);
        take_memory(*series, squares, timing, *row);
    }
    for (const Quotient& quotient : recorded.quotients) {
        const RecordedSeries *sum = find_row(recorded.series, quotient.sum),
                             *weight = find_row(recorded.series, quotient.weight);
        if (sum && weight) summary.rows.push_back(quotient_row(quotient, *sum, *weight, timing));
    }
    for (const std::string& name : recorded.orders)
        if (const RecordedSeries* order = find_row(recorded.series, name))
            add_order_rows(*order, recorded.area, timing, summary.rows);
    for (const BoxSizes& boxes : recorded.boxes)
        if (const auto* variance = find_row(recorded.series, boxes.what + "_number_variance" + boxes.ending))
            add_box_rows(boxes, *variance, timing, summary.rows);
    return summary;
}

std::vector<double> rates(std::span<const double> accumulated, double spacing) {
    std::vector<double> result;
    for (std::size_t i = 0; i + 1 < accumulated.size(); ++i)
        result.push_back((accumulated[i + 1] - accumulated[i]) / spacing);
    return result;
}

std::string unit_product(const std::vector<std::string>& units) {
    Powers powers;
    if (!std::ranges::all_of(units, [&](const std::string& unit) { return add_powers(unit, powers); }))
        return in_brackets(units);
    std::string product;
    for (const auto& [name, power] : powers)
        if (power != 0) product += (product.empty() ? "" : " ") + name + (power == 1 ? "" : std::to_string(power));
    return product.empty() ? "1" : product;
}

}  // namespace drover::measure
