// measure/replicates.hpp: the mean of one observable over independent runs, with the error that their scatter shows.
#pragma once
#include <optional>
#include <span>

#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// Runs of one scene that differ in their seeds.
struct Replicates {
    /// Of two runs or more the error is half of the interval that covers the true mean in 68.3 % of all cases: the
    /// standard error of their scatter times the quantile of Student's t with so many degrees of freedom less one.  It
    /// counts what the own errors of the runs do not see, such as a change slower than a run.  Fewer than eight runs
    /// may agree by chance: their error is at least own_error.  `blocks` is the number of runs.  Of a single run it is
    /// that run's own.
    Estimate mean;
    /// Of a single run, from their scatter: NaN for fewer than two.
    double deviation = 0.0;
    /// Of the mean, from the own errors of the runs: sqrt(sum e^2)/n.  Nothing where one of them has none.
    std::optional<double> own_error;
    std::size_t without_error = 0;  ///< runs that are too short for an own error
    /// Variance of the scatter over the mean square of the own errors: chi squared per degree of freedom.  And the
    /// chance that it is further from one on its side, if the own errors are right, each known from `blocks` blocks: an
    /// F distribution, exactly so where the true errors of all runs are equal.  NaN without own errors above zero.
    double chi_squared = 0.0, chance = 0.0;
};

/// Throws an input Error for no run.
Replicates combine(std::span<const Estimate> runs);

/// Whether scatter and own errors contradict each other: a chance below one in two thousand.
bool contradicts(const Replicates& replicates);

}  // namespace drover::measure
