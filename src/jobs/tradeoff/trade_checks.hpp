// jobs/tradeoff/trade_checks.hpp: what the trials of a study start from, and whether what they show holds on finer
// grids, and for longer than they last.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "jobs/tradeoff/trade_bench.hpp"
#include "jobs/tradeoff/trade_front.hpp"

namespace drover::jobs {

/// The scene with a step, few frames, and no limit on the estimate of its error.  Throws an input Error for a scene
/// without samples.
io::Scene trial_scene(const io::Scene& scene);

/// What the trials of a study have in common.
struct TrialStart {
    io::Scene scene;        ///< without noise on the finest grid on which a trial takes at most a fifth of the budget
    double duration = 0.0;  ///< of a noisy scene as its budget allows; else that of the run [s]
};
/// Both follow from timings, so all processes in the folder take what the first has found.  Nothing when a signal came.
/// Throws a run Error where no grid is coarse enough.
std::optional<TrialStart> trial_start(TradeBench& bench);

/// Those of cell_levels(), but none where a target is of a range of waves: the waves of a larger cell are others, and
/// their mean is another number.
std::vector<AxisLevel> compared_cells(const io::Scene& scene, const std::vector<AccuracyTarget>& targets);

/// Throws an input Error for a target in per cent of a mean that is 0, or may be.
void require_relative(const AccuracyTarget& target, const Bias& mean);

/// What is to be said where trials are made on a coarser grid than the given one.
std::vector<std::string> coarser_notes(const io::Scene& scene, const std::string& given, const std::string& tried);

/// Differences of the wanted numbers between grids, each of twice the points of the one before: between the two finest,
/// and those before; 0 +- 0 where there are none.
struct GridSteps {
    std::vector<Bias> longer, last;
};

/// The bias of the finest grid, from the last difference and the one before it.  Smooth fields converge faster than any
/// power: a third of the last difference is on the safe side.  With white noise differences shrink by the same ratio
/// again and again: that which is seen, where it is clear, at most 2/3; else 1/2, that of waves on a line, whose
/// variance is the sum of 1/q^2.
Bias bias_of_finest(const Bias& longer, const Bias& last, bool is_noisy);

/// Whether the last difference between noisy grids is small, or at most two thirds of the one before.
bool converges(const GridSteps& steps, const std::vector<double>& allowed);

/// What a trial that is longer than the others shows of them.
struct LaterDrift {
    std::vector<std::string> notes;  ///< of each wanted number whose mean is another one
    double affordable = 0.0;         ///< its duration, where all trials may last as long [s]
    bool stopped = false;            ///< by a signal
};

/// The longest whole multiple of the duration of the trials, which the steps of all of them fit, that is affordable; 0:
/// less than twice it [s].
double longer_duration(double trial, double affordable);

/// Runs the recommended setting with other noise for as long as it is recommended, if half of what is left of the
/// budget allows that, and compares its means.
LaterDrift later_drift(TradeBench& bench, const Candidate& best, const std::vector<Bias>& references);

}  // namespace drover::jobs
