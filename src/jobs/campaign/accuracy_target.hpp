// jobs/campaign/accuracy_target.hpp: a number that a user wants from a run, with the error allowed.
#pragma once
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "files/archive_reader.hpp"
#include "jobs/campaign/job_options.hpp"
#include "run/report/report.hpp"

namespace drover::jobs {

/// Part of an axis: min < axis < max.
struct AxisRange {
    std::string axis;
    double min = -INFINITY, max = INFINITY;
    bool holds(double value) const { return min < value && value < max; }
};

/// Of a run: the time mean of an observable; of an array, the mean of its components on part of its axis, within which
/// 95 % of the runs are.  Of a calibration: the onset or a coefficient, each on part of the table, to a standard error.
struct AccuracyTarget {
    std::string text;               ///< as given, without the error: "structure_factor_rods(q<1)"
    std::string observable;         ///< of the summary of a run, or of a calibration
    std::vector<AxisRange> ranges;  ///< each of another axis
    double error = 0.0;
    bool is_relative = true;  ///< the error is a fraction of the mean
    std::string unit = {};    ///< of an absolute error, where it was given
    double allowed(double value) const { return error * (is_relative ? std::abs(value) : 1.0); }
};

/// Reads "polar_order=1%", "polar_order=0.01" (an absolute error, also with its unit: "=0.01 mm-2") and
/// "structure_factor_rods(q<1)=3%"; (q>1), (0.5<q<1) and (q<1, w>2) too.  Throws an input Error for another text, and
/// for an error that is not positive.
AccuracyTarget parse_accuracy_target(const std::string& given);
std::vector<AccuracyTarget> parse_accuracy_targets(const std::vector<std::string>& given);

/// What a job is asked that is to find wanted numbers.
struct TargetOptions : JobOptions {
    std::vector<AccuracyTarget> targets = {};
    double budget = INFINITY;      ///< core seconds of all trials for them
    double run_budget = INFINITY;  ///< core seconds of a recommended run
};
/// From the texts of targets; with both budgets.
TargetOptions target_options(JobOptions job, const std::vector<std::string>& targets, double budget = INFINITY);

/// "polar_order=1" may mean 1 %: throws an input Error that asks for the unit where an absolute error without one is
/// half of the value or more, and where its unit is not that of the number.
void require_unit(const AccuracyTarget& target, const std::string& unit, double value);

/// Before any run: throws an input Error where an absolute error without a unit is half or more of what the number can
/// be at most (1 for an order or an area fraction), and where its unit is not `unit`.
void require_plausible(const AccuracyTarget& target, const std::string& unit, bool is_fraction = false);
/// The same for a number of runs with this summary.  Throws an input Error, with the names there are, when they have no
/// such observable, no such axis, or no component in the range.
void require_plausible(const AccuracyTarget& target, const measure::Summary& summary);

/// The wanted number of one run.
struct TargetNumber {
    double mean = 0.0;
    std::string unit;
    /// Its samples, those of the warm-up included; empty for a result that is no time mean, such as rod_speed.
    std::vector<double> series;
    double spacing = 0.0;         ///< of the samples [s]
    std::optional<double> error;  ///< of the mean, where there are no samples
    std::optional<double> linear_theory;
};

/// Throws an input Error for a number that the run does not have.
TargetNumber target_number(const AccuracyTarget& target, const run::Report& report,
                           const files::ArchiveReader& archive);

}  // namespace drover::jobs
