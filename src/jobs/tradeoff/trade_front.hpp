// jobs/tradeoff/trade_front.hpp: errors and costs of a scene's settings, measured one axis at a time, and what follows
// for all their combinations; what the trials start from, and whether what they show holds on finer grids and longer.
#pragma once
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/constants.hpp"
#include "jobs/campaign/accuracy_target.hpp"
#include "jobs/tradeoff/trade_axes.hpp"
#include "jobs/tradeoff/trade_bench.hpp"

namespace drover::jobs {

/// What one level of an axis does.
struct LevelFound {
    AxisLevel level;
    LevelOutcome outcome;
    std::vector<Bias> biases;                        ///< by target
    double start_seconds = 0.0, step_seconds = 0.0;  ///< cost relative to that of the given level of its axis
    std::vector<Fluctuation> fluctuations = {};      ///< of a model, by target: another one fluctuates otherwise
    bool is_measured() const { return outcome.is_measured(); }
};

/// The parts of the error of one wanted number, each with its standard error, in its unit.
struct Parts {
    Bias step, grid, model;
    double statistics = 0.0;    ///< standard error of the mean over the duration
    std::optional<Bias> whole;  ///< of all three together, where a trial of the combination gave it
    Bias biases() const;        ///< the sum of all, or the whole
    /// Of the number: the sum of the biases and twice the standard error of everything.
    double bound() const;
};

/// One combination of levels.
struct Candidate {
    const LevelFound *step = nullptr, *grid = nullptr, *model = nullptr;  ///< step: none for linear theory
    double end = 0.0;                                                     ///< [s]
    double seconds = 0.0;                                                 ///< of a core, predicted
    std::vector<Parts> parts;
    double ratio = infinite;  ///< the largest error of a target over what it allows
};

/// A trial of a combination: its biases replace the sums of those of its levels, its fluctuations those of its model.
struct Checked {
    std::vector<std::string> overrides;
    LevelOutcome outcome;
    std::vector<Bias> biases;
    std::vector<Fluctuation> fluctuations;
};

/// Everything that was found.
struct Findings : BenchFacts {
    std::vector<AccuracyTarget> targets;
    std::vector<std::string> units;
    std::vector<Bias> references;      ///< the best value of each wanted number
    std::vector<Bias> rounding, cell;  ///< by target; empty where not measured
    /// Of each method; costs in core seconds: of the start, and per second of the scene.
    std::vector<std::vector<LevelFound>> ladders;
    std::vector<LevelFound> grids, models;       ///< the finest grid, and the full model, are the references
    std::size_t pilot_grid = 0;                  ///< of the step, model and rounding trials
    double pilot_start = 1.0, pilot_step = 1.0;  ///< its relative costs
    std::optional<std::vector<Bias>> linear_theory;
    double sample_every = 0.0;        ///< interval of samples that loses nothing of the means [s]; 0: as given
    double pairing = 1.0;             ///< variance of unpaired differences over that of paired ones
    double given_seconds = INFINITY;  ///< of a core, of the scene as given, predicted
    std::vector<Checked> checked;
    std::vector<std::string> notes;
    bool stopped = false;  ///< by a signal
};

/// Makes the trials of a study, axis by axis, within the budget.
Findings find_tradeoff(const io::Scene& scene, const TargetOptions& options);

/// All combinations that follow, cheapest first for their error: none is both cheaper and better than another.
/// `only`: those of one model.
std::vector<Candidate> front_of(const Findings& found, const io::Scene& scene, const LevelFound* only = nullptr);

/// The changes of a candidate, without its end.
std::vector<std::string> overrides_of(const Candidate& candidate);

/// The scene of a candidate.
io::Scene scene_of(const io::Scene& scene, const Findings& found, const Candidate& candidate);

/// The cheapest that meets the targets within the budget; nullptr when there is none.
const Candidate* recommended(const std::vector<Candidate>& front, double budget);

// ---- Trials

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

/// Throws an input Error for a target in per cent of a mean that is 0, or may be.
void require_relative(const AccuracyTarget& target, const std::string& unit, const Bias& mean);

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
