// measure/summary.hpp: time means of recorded observables, with errors, and the results derived from them.
#pragma once
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/measure/statistics.hpp"
#include "measure/observable.hpp"

namespace drover::measure {

/// One observable recorded at equal times.
struct RecordedSeries {
    std::string name, unit, formula;
    std::vector<Axis> axes;  ///< slowest first
    Averaging averaging = Averaging::mean;
    std::vector<double> values;  ///< [sample][size_of(axes)]
    Nature nature = Nature::number;
};

/// The values of the series of that name; empty when there is none.
std::vector<double> values_of(const std::vector<RecordedSeries>& series, const std::string& name);

template <class Moment>
RecordedSeries recorded_series(const Observable<Moment>& row, std::vector<double> values) {
    return {row.name, row.unit, row.formula, row.axes, row.averaging, std::move(values), row.nature};
}

/// A mean whose weight changes from sample to sample or may be zero (no pair in a bin, no bead near a rod): the time
/// mean of one observable divided by that of another with the same axes.
struct Quotient {
    std::string name, unit, formula;
    std::string sum, weight;  ///< names of the two observables
};

/// A product of two fields, which remembers as long as the squares of both, also where its own series does not show it.
struct Product {
    std::string name;
    std::array<std::string, 2> squares;
};

/// Boxes whose number variance was recorded as <what>_number_variance<ending>.
struct BoxSizes {
    std::string what;               ///< "rod"
    std::string ending;             ///< of the names of the rows
    std::string shape;              ///< for people: "square box"
    std::vector<double> total;      ///< number in the cell, of each sample; one number if it is always that
    std::vector<double> fractions;  ///< area of each box as a fraction of the cell, ascending
};

/// A recorded run of fields or of particles.
struct Recorded {
    std::vector<RecordedSeries> series;
    double area = 0.0;  ///< of the cell [mm2]
    std::vector<Quotient> quotients = {};
    std::vector<Product> products = {};
    std::vector<BoxSizes> boxes = {};
    std::vector<std::string> orders = {};              ///< the series of sizes of an order, which have a susceptibility
    std::vector<std::vector<double>> indicators = {};  ///< series whose longest warm-up is left out of all means
    double spacing = 1.0;                              ///< time between samples [s]
    std::string time_unit = "s";                       ///< what messages call it; "1": numbers without a unit
    std::optional<std::size_t> warm_up = {};  ///< samples left out at the start; nullopt: found from the indicators
};

struct Summary {
    std::size_t samples = 0;  ///< recorded, including the warm-up
    std::size_t warm_up = 0;  ///< samples left out at the start, the same for all rows
    std::string note;  ///< what the means may not be trusted in, such as a warm-up that may not have ended; else ""
    std::vector<SummaryRow> rows;
};

/// What the names of the results of a row end in, after its name.
inline constexpr std::array result_endings{
    "", "_error", "_step_bias", "_step_bias_error", "_autocorrelation_time", "_linear"};

/// The time mean of every observable under its name, of directions along their shortest turns, of those that accumulate
/// the mean rate as <name>_rate, of those that are a maximum the last value; then the quotients, and where
/// their observables were recorded:
///   polar_order_susceptibility [mm2], area (<P^2> - <P>^2);  polar_order_binder, 1 - <P^4>/(3 <P^2>^2),
///   of a model of one's own size_mean_F_susceptibility and size_mean_F_binder of each field F of spin >= 1;
///   rod_number, N of each box;  rod_number_deviation, DN = sqrt(<DN^2>);
///   rod_number_exponent, d ln DN/d ln N between each box and the next larger one (NaN for the largest);
/// and the same for beads and for each shape of box.
/// A value that is NaN in a sample has no mean; its estimate reports in how many samples.
/// Throws an input Error when a series does not consist of complete samples, or not of as many as the others.
Summary summarise(const Recorded& recorded);

/// Of a count: (a[i + 1] - a[i])/spacing, one value fewer than samples.
std::vector<double> rates(std::span<const double> accumulated, double spacing);

/// "mm4 s-2" of "mm s-1" twice and "mm2"; with brackets, "(1/mm^2)^2 mm2", where a unit is no such list of powers.
std::string unit_product(const std::vector<std::string>& units);

}  // namespace drover::measure
