// calibrate/trial_set.hpp: the trials of one assay at one point: which are still needed, and their result.
#pragma once
#include <map>

#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// Outcome of one trial.
struct Attempt {
    std::uint64_t number = 0;                 ///< from 0: the trial of run_trial()
    Trial numbers;                            ///< empty if it failed
    std::optional<std::string> failure = {};  ///< the error message, if it failed
    double core_seconds = 0.0;                ///< that it took; 0: not recorded
};

/// Trials of an assay, added in any order.  The trials that are needed, and the result, depend on the trials alone:
/// they are evaluated in order of their numbers, after each whole round.  A failed trial is counted and replaced by the
/// next one.
class TrialSet {
public:
    /// max_failed: largest allowed fraction of failed trials.  Throws an input Error for an invalid goal.
    TrialSet(Assay assay, const Goal& goal, double max_failed);

    /// Adds the outcome of a trial and evaluates whole rounds.  A number that is already present has no effect.
    void add(Attempt attempt);

    const Assay& assay() const { return assay_; }
    bool has(std::uint64_t number) const { return attempts_.contains(number); }
    std::size_t count() const { return attempts_.size(); }
    /// Of those trials whose time was recorded: their number, and the sum.
    std::size_t timed() const { return timed_; }
    double core_seconds() const { return core_seconds_; }
    /// Trials below this number are needed; after the end, only those that decided it.
    std::uint64_t needed() const { return next_evaluation_; }
    bool ended() const { return measurement_ || failure_reason_; }
    /// Number of failed trials among those evaluated, and the first error message, if any failed.
    std::size_t failed() const { return failed_; }
    const std::optional<std::string>& first_failure() const { return first_failure_; }
    /// Empty before the end, and if too many trials failed.
    const std::optional<Measurement>& measurement() const { return measurement_; }
    /// Whether there is a measurement in which all wanted quantities have a value and an error.
    bool has_result() const;
    /// Result of the whole rounds present before the end, if there are enough for a first evaluation.
    std::optional<Measurement> so_far() const;
    /// Why the measurement failed, where too many trials did.
    const std::optional<std::string>& failure_reason() const { return failure_reason_; }

    /// A goal that no number of trials meets: the set collects them, and take_all() gives its result.
    static Goal no_goal();
    /// The trials that did not fail, in order, up to the first missing one.
    const std::vector<Trial>& successful() const { return successful_; }
    /// Ends a set that has at least two successful trials with the result of all of them.
    void take_all();

private:
    void evaluate();
    void fail();

    Assay assay_;
    Goal goal_;
    double max_failed_;
    std::map<std::uint64_t, Attempt> attempts_;
    std::vector<Trial> successful_;  // of the attempts below taken_, in order
    std::uint64_t taken_ = 0, next_evaluation_ = 0;
    std::size_t judged_rounds_ = 0, failed_ = 0, timed_ = 0;
    double core_seconds_ = 0.0;
    std::optional<std::string> first_failure_, failure_reason_;
    std::optional<Measurement> measurement_;
};

}  // namespace drover::calibrate
