// calibrate/trial_set.hpp: one assay at one point: which trials it still wants, and what comes of them when some fail.
#pragma once
#include <map>

#include "drover/calibrate/assay.hpp"

namespace drover::calibrate {

/// What became of one trial.
struct Attempt {
    std::uint64_t number = 0;  ///< from 0: the trial of run_trial()
    Trial numbers;             ///< empty when it failed
    std::string failure;       ///< the sentence that it threw; "" when it did not
};

/// Trials of an assay as they come in, in any order.  What is wanted, and what comes out, is a function of the trials alone: they are looked at in the
/// order of their numbers, after each whole round.  One that fails counts as failed, and the next takes its place.
class TrialSet {
public:
    /// max_failed: the part of the trials that may fail.  Throws an input Error for a goal that cannot be.
    TrialSet(Assay assay, const Goal& goal, double max_failed);

    /// Takes what became of a trial; the same number again changes nothing.  Looks at all that is there.
    void add(Attempt attempt);

    const Assay& assay() const { return assay_; }
    bool has(std::uint64_t number) const { return attempts_.contains(number); }
    std::size_t count() const { return attempts_.size(); }
    /// Trials below this number are wanted; once it has ended, no other than those that decided it.
    std::uint64_t wanted() const { return look_; }
    bool ended() const { return measurement_ || !refusal_.empty(); }
    /// How many of the trials that were looked at have failed, and the first sentence of one.
    std::size_t failed() const { return failed_; }
    const std::string& failure() const { return failure_; }
    /// Nothing while it has not ended, and when too many trials failed.
    const std::optional<Measurement>& measurement() const { return measurement_; }
    /// What whole rounds tell while it has not ended, if there are as many as a first look takes.
    std::optional<Measurement> so_far() const;
    /// Why there is none: "" unless too many trials failed.
    const std::string& refusal() const { return refusal_; }

private:
    void look();

    Assay assay_;
    Goal goal_;
    double failed_most_;
    std::map<std::uint64_t, Attempt> attempts_;
    std::vector<Trial> good_;  // of the attempts below taken_, in order
    std::uint64_t taken_ = 0, look_ = 0;
    std::size_t judged_ = 0, failed_ = 0;
    std::string failure_, refusal_;
    std::optional<Measurement> measurement_;
};

}  // namespace drover::calibrate
