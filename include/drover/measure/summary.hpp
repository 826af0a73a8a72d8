// measure/summary.hpp: what a recorded run says: each observable averaged over time with its error, and what follows.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/measure/observables.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// All that was recorded of a run at equal times.
struct Recorded {
    const Setting& setting;
    std::span<const Observable> observables;
    std::span<const std::vector<double>> series;  ///< of each observable: [sample][size_of(observable, setting)]
    double spacing = 1.0;                         ///< time between samples [s]
    std::optional<std::size_t> warm_up = {};      ///< samples left out at the start; nullopt: found from the series
    double rods = 0.0;                            ///< mean number of rods in the cell, N of the boxes
    double beads = 0.0;                           ///< the same of beads
};

/// One result: a single number, or an array over the axes.
struct SummaryRow {
    std::string name;
    std::string unit;  ///< UDUNITS text
    std::string formula;
    std::vector<std::string> axes;    ///< names, slowest first; none: a single number
    std::vector<Estimate> estimates;  ///< the product of its axes
};

struct Summary {
    std::size_t samples = 0;  ///< recorded, with the warm-up
    std::size_t warm_up = 0;  ///< of these left out, one number for all rows
    std::string note;         ///< a sentence when the warm-up may not have ended, else ""
    std::vector<SummaryRow> rows;
};

/// The time means of all observables, under their names, and, where the observables they need are there:
///   polar_order_susceptibility [mm2], area (<P^2> - <P>^2);  polar_order_binder, 1 - <P^4>/(3 <P^2>^2);
///   rod_number, N of each box;  rod_number_deviation, DN = sqrt(<DN^2>);
///   rod_number_exponent, d ln DN/d ln N between each box and the next larger one (of the largest box: not-a-number).
/// An automatic warm-up is the largest warm_up_length of the polar order and of the total powers of rods, of beads and of order.
/// Throws an input Error when a series does not hold whole samples, or not as many as the others.
Summary summarise(const Recorded& recorded);

/// One observable of any kind of world as it was recorded at equal times.
struct RecordedSeries {
    std::string name, unit, formula;
    std::vector<std::string> axes;   ///< names, slowest first
    std::size_t size = 1;            ///< numbers of one sample: the product of its axes
    std::span<const double> values;  ///< [sample][size]
};

/// Each of the numbers of an observable as a series of its own.
Samples split(const RecordedSeries& recorded, double spacing, std::size_t skip);

/// Its time means.
SummaryRow mean_row(const RecordedSeries& recorded, double spacing, std::size_t skip);

/// polar_order_susceptibility and polar_order_binder, from the series of the polar order, in a cell of an area [mm2].
void add_order_rows(const RecordedSeries& order, double area, double spacing, std::size_t skip,
                    std::vector<SummaryRow>& rows);

/// Number fluctuations in boxes of one shape, from the series of their variances: number, number_deviation and number_exponent.
struct BoxSeries {
    RecordedSeries variance;
    std::string what;           ///< "rod"
    std::string ending;         ///< of the names of the rows
    std::string shape;          ///< for people: "square"
    double total = 0.0;         ///< in the cell
    std::vector<double> parts;  ///< share of each box of the area of the cell, ascending
};
void add_box_rows(const BoxSeries& boxes, double spacing, std::size_t skip, std::vector<SummaryRow>& rows);

/// A sentence when an automatic warm-up of so many of the samples may not have ended, else "".
std::string warm_up_note(std::size_t automatic, std::size_t samples);

/// The row of that name; nullptr when there is none.
const SummaryRow* find_row(const Summary& summary, const std::string& name);

}  // namespace drover::measure
