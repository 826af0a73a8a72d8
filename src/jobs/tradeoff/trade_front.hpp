// jobs/tradeoff/trade_front.hpp: errors and costs of a scene's settings, measured one axis at a time, and what follows
// for all their combinations.
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
Findings find_tradeoff(const io::Scene& scene, const TradeoffOptions& options);

/// All combinations that follow, cheapest first for their error: none is both cheaper and better than another.
/// `only`: those of one model.
std::vector<Candidate> front_of(const Findings& found, const io::Scene& scene, const LevelFound* only = nullptr);

/// The changes of a candidate, without its end.
std::vector<std::string> overrides_of(const Candidate& candidate);

/// The scene of a candidate.
io::Scene scene_of(const io::Scene& scene, const Findings& found, const Candidate& candidate);

/// The cheapest that meets the targets within the budget; nullptr when there is none.
const Candidate* recommended(const std::vector<Candidate>& front, double budget);

}  // namespace drover::jobs
