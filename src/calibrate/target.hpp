// calibrate/target.hpp: numbers that a calibration has to reach to an error, and which measurements make their errors.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/table.hpp"

namespace drover::calibrate {

/// The onset at an area fraction of rods of the table, or an entry of one of its rows.
struct TableTarget {
    std::string row;                            ///< "": the onset, Convention::mean
    std::size_t varied = 0, bead = 0, rod = 0;  ///< indices into the axes; `bead` is not used for the onset
    double error = 0.0;                         ///< standard error to reach
    bool is_relative = true;                    ///< `error` is a fraction of the median
};

/// One result of a measurement: where it is in the table.
struct EntryPlace {
    std::string row;
    std::size_t entry = 0;
    bool operator==(const EntryPlace&) const = default;
};
/// The results of one assay at one point.
using Source = std::vector<EntryPlace>;

/// A target in a table of measurements.
struct TargetResult {
    double value = 0.0;  ///< of the table; of an onset beyond the table minus or plus infinity
    /// 16, 50 and 84 % of redrawn_tables().
    std::array<double, 3> quantiles{};
    double error = 0.0;    ///< half of the distance from 16 to 84 %; infinite if one of them is beyond the table
    double allowed = 0.0;  ///< error to reach, in the unit of the value
    /// Of an onset: relative standard error of the slope of the excess there, to which `error` is inversely
    /// proportional; 0 for a coefficient.
    double slope_error = 0.0;
    /// Part of each source in the variance, from slopes; with `disagreement` their sum is 1.  Of an onset beyond the
    /// table: in the variance of the excess that decides whether there is one.
    std::vector<double> parts;
    double disagreement = 0.0;                ///< part of what the measurements of c differ by, which no trials reduce
    bool is_beyond = false;                   ///< an onset that 97.5 % of these tables have beyond the same end
    std::optional<std::string> missing = {};  ///< the entry of the table that is missing, if there is no value
};

/// `measured`: the rows of assays and of the setup.  What follows from them is derived anew for every redrawn table, so
/// that errors which two inputs of the target share cancel or add as they should.  Sources are independent.
std::vector<TargetResult> evaluate(const std::vector<TableTarget>& targets, const Table& measured,
                                   const std::vector<Source>& sources);

/// Names of the rows of assays from which the target follows.  Throws an input Error for an unknown row, and if the
/// assays measure not all that it needs.
std::vector<std::string> inputs_of(const TableTarget& target, const std::vector<std::string>& measured_rows);

/// What limits and drives the choice of the next trials of one source.
struct TrialCosts {
    std::size_t trials = 0;      ///< those that have run or are running, at least one
    std::size_t max_trials = 0;  ///< not to be exceeded
    double seconds = 0.0;        ///< of a core, for one trial
    /// Its part in the variance of each target at this number of trials, divided by the variance allowed.
    std::vector<double> variances;
    double caution = 1.0;  ///< by which its variance may be larger than estimated
};

/// Numbers of trials to add to each source: one after the other where the variances fall most for a core second,
/// until all targets are predicted to be reached, or `seconds` are spent.  The cheapest way to an error has numbers of
/// trials that go as (standard deviation over trials)/sqrt(seconds), times the slope of the target (Neyman 1934).
std::vector<std::size_t> allocate(std::vector<TrialCosts> sources, double seconds);

}  // namespace drover::calibrate
