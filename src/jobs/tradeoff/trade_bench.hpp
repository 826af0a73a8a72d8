// jobs/tradeoff/trade_bench.hpp: trials of changes of one scene within a budget, their costs, and differences of wanted
// numbers.
#pragma once
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "drover/measure/statistics.hpp"
#include "jobs/campaign/trials.hpp"

namespace drover::jobs {

/// A bias of one wanted number and its standard error, in the unit of the number.
using Bias = measure::RoughMean;

/// Whether a trial or a level of an axis has numbers, or why not.
enum class LevelState {
    measured,
    alone,           ///< measured, but with no other level to compare it with: its bias is taken as 0
    failed,          ///< its run
    wrong_steps,     ///< the error of its steps is too large
    lacks_number,    ///< a wanted one
    impossible,      ///< the scene does not allow it
    not_affordable,  ///< it was not run
    not_ended,       ///< it was not run before the trials were collected
    grid_of_model    ///< the given grid is part of the model
};

struct LevelOutcome {
    LevelState state = LevelState::measured;
    std::string detail = {};  ///< the message of a failure, the error of the steps, or the number that it lacks
    bool is_measured() const { return state == LevelState::measured || state == LevelState::alone; }
    bool was_run() const { return state != LevelState::not_affordable && state != LevelState::not_ended; }
};

/// For people; "" for a level that is measured.
std::string text_of(const LevelOutcome& outcome);

/// A trial and its wanted numbers.
struct TrialMeasurement {
    LevelOutcome outcome;
    double start_seconds = 0.0, step_seconds = 0.0;  ///< of a core; step: per second of the scene
    double end = 0.0;                                ///< of the trial, which may be a longer one of before [s]
    double step_error = 0.0;                         ///< the largest; 0: not estimated
    std::vector<TargetNumber> numbers;
    bool is_measured() const { return outcome.is_measured(); }
};

/// Of the samples of a wanted number in a trial.
struct Fluctuation {
    double error = 0.0;   ///< standard error of the mean over the duration of the trial, in the unit of the number
    double time = 0.0;    ///< integrated autocorrelation time [s]
    double margin = 1.0;  ///< times it: an upper bound
};

/// Points of a grid; of particles the area of the cell.
double size_of(const io::Scene& scene);
/// Durations of a scene are whole numbers of this [s].
double unit_of_time(const io::Scene& scene);

/// Steps that are wrong by half a field may stop a run on another path of the noise: such runs count as failed.  Where
/// the error of all runs is as large, the fields are chaotic: it says nothing of the step.
void reject_wrong_steps(std::vector<std::vector<TrialMeasurement>>& runs);

/// a - b, of independent numbers.
Bias less(const Bias& a, const Bias& b);

/// What all trials have in common, and how far they have come.
struct BenchFacts {
    io::Units unit_names;
    double duration = 0.0, warm_up = 0.0;  ///< of the trials; left out of all means [s]
    bool statistical = false;              ///< means have statistical errors: the duration is free
    std::vector<double> allowed;           ///< error of each wanted number, in its unit
    double spent = 0.0;                    ///< core seconds of the trials so far
    bool is_short = false;                 ///< some trials were not made, for want of budget
    std::set<std::string> hosts;           ///< on which trials ran
    std::set<std::string> programs;        ///< versions of drover that ran them
};

std::string time_text(const BenchFacts& facts, double time);

class TradeBench : public BenchFacts {
public:
    /// `of`: the resolved text of the scene whose trials the folder holds.
    TradeBench(const io::Scene& scene, const std::string& of, const TargetOptions& options);

    Trials trials;
    io::Scene scene;             ///< that the trials change
    double budget = 0.0;         ///< core seconds
    bool is_collecting = false;  ///< no trials are made

    TrialRun trial_of(const std::vector<std::string>& overrides, bool rounds_up = false) const;

    /// Runs the trials that the budget allows, the cheapest first.  False when a signal came.
    bool run(std::vector<TrialRun> wanted);

    /// Costs of later trials follow from this one: steps times points.
    void set_rate(const TrialMeasurement& base);

    /// Whether a trial of the scene as given has so few correlation times that it finds them too short, and errors that
    /// are too small, and the budget allows trials of twice the duration.
    bool may_be_longer(const TrialMeasurement& base) const;

    /// Of a trial that was run.  Throws an input Error when the scene itself has no such number.
    TrialMeasurement measured(const std::vector<std::string>& overrides, bool rounds_up = false);

    /// Mean of a wanted number; its error is 0 where the run is a definite one.
    Bias mean_of(const TargetNumber& number) const;

    /// Of each wanted number.
    std::vector<Fluctuation> fluctuations(const TrialMeasurement& run) const;

    /// Of each wanted number whose halves disagree by more than is allowed: the means of a run that has not settled are
    /// not those of a longer one.  None where the duration is that of the run.
    std::vector<std::string> drift_notes(const TrialMeasurement& run) const;

    /// That the mean of a wanted number is another one than that of the trials.
    std::string drift_note(std::size_t target, const std::string& what) const;

    /// The same changes with other seeds; none where nothing is statistical.
    std::vector<std::vector<std::string>> reseeded(const std::vector<std::string>& overrides) const;

    /// Where those scatter by more than their errors allow, a wanted number fluctuates more slowly than a trial shows:
    /// from here on its statistical error is at least that of the scatter.  Returns what is to be said of it.
    std::vector<std::string> widen(const std::vector<std::string>& overrides);

    /// An interval between samples from which the means of a run are as exact as from those that it has: half of the
    /// shortest autocorrelation time, but a multiple of the scene's, with 64 samples of the trial [s].
    double sparse_sampling(const TrialMeasurement& base) const;

    /// a - b.  Runs of fields share their noise; those of particles share nothing.
    Bias difference(const TargetNumber& a, const TargetNumber& b) const;
    std::vector<Bias> differences(const TrialMeasurement& a, const TrialMeasurement& b) const;

    /// The largest ratio of biases to what is allowed.
    double ratio(const std::vector<Bias>& biases) const;

    /// Whether biases are small, or too uncertain for a shorter step to tell.  part: of what is allowed.
    bool is_resolved(const std::vector<Bias>& biases, double part) const;

    /// Whether two runs without noise have become independent, although both fluctuate.
    bool are_independent(const TrialMeasurement& a, const TrialMeasurement& b) const;

private:
    double expected_seconds(const TrialRun& trial) const;
    double step_seconds_of(const TrialRun& trial, const TrialResult& result);
    std::size_t skip(const TargetNumber& number) const;  ///< samples of the warm-up

    std::vector<AccuracyTarget> targets_;
    double rate_ = 0.0;
    std::vector<double> min_error_;  ///< statistical, of the mean of each wanted number over a trial, see widen()
    std::map<std::pair<std::string, double>, TrialMeasurement> measured_;
    std::map<std::string, double> counted_;
};

}  // namespace drover::jobs
