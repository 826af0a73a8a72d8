// jobs/calibration/target_plan.hpp: the trials of a calibration that bring wanted numbers to their errors at the least
// cost.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "calibrate/target.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "jobs/campaign/accuracy_target.hpp"
#include "run/result.hpp"

namespace drover::jobs {

struct TargetLimits {
    std::size_t max_trials = 512;  ///< of one assay at one point
    double budget = INFINITY;      ///< core seconds of all trials
    std::size_t workers = 1;       ///< trials that run at a time
};

/// The trials of one unit of the layout.
struct UnitProgress {
    const calibrate::TrialSet* trials = nullptr;  ///< with TrialSet::no_goal()
    std::uint64_t given = 0;                      ///< trials below it have ended or are running
    bool has_crashed = false;                     ///< no more trials can run
};

/// One wanted number.
struct TargetProgress {
    calibrate::TableTarget in_table;
    std::string text;  ///< "onset at rod area fraction 0.08"
    calibrate::TargetResult result;
    double variance_error = 0.0;  ///< relative standard error of its variance, which few trials leave
    /// The error, enlarged by what is uncertain in it: by the relative standard error of the variance, and by a slope
    /// of the excess that may be smaller than it seems.  This is what has to reach the wanted error.
    double cautious_error = 0.0;
    bool reached = false;
    std::string note;  ///< why it was not reached, or cannot be; else ""
    /// The variance that no number of trials reduces, as a part of that allowed; 0 where the error is not known.
    double fixed_variance() const {
        const double whole = std::pow(result.error / result.allowed, 2);
        return std::isfinite(whole) ? result.disagreement * whole : 0.0;
    }
};

/// Decides which trials run next.  Every unit that a wanted number needs has a few trials first.  Then, again and
/// again: errors and slopes of the wanted numbers from redrawn tables, and some trials more where their variances
/// fall most for a core second.  A number is reached when its error, enlarged by what the finite numbers of trials
/// leave uncertain in it, is the wanted one: else the first error that is too small by chance would end the
/// calibration.
class TargetPlan {
public:
    /// Throws an input Error for a target that the layout cannot answer.
    TargetPlan(const CalibrationLayout& layout, const std::vector<AccuracyTarget>& targets, const TargetLimits& limits);

    /// Whether a wanted number depends on this unit of the layout.
    bool needs(std::size_t unit) const { return !sources_[unit].empty(); }
    /// By unit of the layout: trials below this number are to run.
    std::vector<std::uint64_t> next(const std::vector<UnitProgress>& units);
    /// The wanted numbers with the trials of the last call of next().
    const std::vector<TargetProgress>& values() const { return values_; }

private:
    void add_targets(const AccuracyTarget& target, const calibrate::Table& whole);
    void find_needed(const calibrate::TableTarget& in_table, const calibrate::Table& whole);
    bool lacks_trials(std::size_t unit, const UnitProgress& progress) const;
    void evaluate_targets(const std::vector<UnitProgress>& units);
    bool is_spent(const std::vector<UnitProgress>& units) const;
    std::string note_on(const TargetProgress& value, const std::vector<UnitProgress>& units) const;
    std::vector<double> seconds_each(const std::vector<UnitProgress>& units) const;
    bool add_for_relevant(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const;
    void add_for_missing(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const;
    void add_for_errors(const std::vector<UnitProgress>& units, std::vector<std::uint64_t>& needed) const;

    const CalibrationLayout& layout_;
    TargetLimits limits_;
    calibrate::Table setup_;                  ///< the rows of setups
    std::vector<calibrate::TrialSet> ended_;  ///< by unit: the trials that have been taken, ended
    std::vector<calibrate::Source> sources_;  ///< by unit: the results from which the wanted numbers follow
    std::vector<TargetProgress> values_;
};

/// Wanted numbers, which measurements make their errors, and core seconds by assay.
run::Result target_result(const CalibrationLayout& layout, const TargetPlan& plan,
                          const std::vector<UnitProgress>& units);

}  // namespace drover::jobs
