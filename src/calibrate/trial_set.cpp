// calibrate/trial_set.cpp: evaluation of trials after whole rounds, in order of their numbers.
#include "calibrate/trial_set.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"

namespace drover::calibrate {

TrialSet::TrialSet(Assay assay, const Goal& goal, double max_failed)
    : assay_(std::move(assay)), goal_(goal), max_failed_(max_failed), next_evaluation_(goal.round * goal.min_rounds) {
    judge(assay_, {}, goal_);  // throws for an invalid goal
    require(max_failed >= 0.0 && max_failed < 1.0, {}, "max_failed = {}; expected a fraction from 0 to below 1",
            max_failed);
}

void TrialSet::add(Attempt attempt) {
    const std::uint64_t number = attempt.number;
    const double seconds = attempt.core_seconds;
    if (attempts_.emplace(number, std::move(attempt)).second && seconds > 0.0) ++timed_, core_seconds_ += seconds;
    while (!ended() && attempts_.contains(taken_)) {
        const Attempt& next = attempts_.at(taken_++);
        if (!next.failure) successful_.push_back(next.numbers);
        else if (failed_++ == 0) first_failure_ = next.failure;
        if (taken_ == next_evaluation_) evaluate();
    }
}

std::optional<Measurement> TrialSet::so_far() const {
    Goal goal = goal_;
    const std::size_t rounds = successful_.size() / goal.round;
    if (ended() || rounds < goal.min_rounds) return {};
    goal.min_rounds = rounds;
    goal.max_trials = rounds * goal.round;
    return judge(assay_, successful_, goal).measurement;
}

void TrialSet::fail() {
    failure_reason_ = text("{}: {} of {} trials failed; expected at most {:.3g} %: {}", assay_.name, failed_, taken_,
                           100.0 * max_failed_, first_failure_.value_or(""));
}

Goal TrialSet::no_goal() {
    constexpr std::size_t never = 1000000;
    return {.relative_error = 1e300, .round = never, .min_rounds = 1, .max_trials = never};
}

void TrialSet::take_all() {
    if (ended() || taken_ == 0) return;
    if (static_cast<double>(failed_) > max_failed_ * static_cast<double>(taken_)) fail();
    if (ended() || successful_.size() < 2) return;
    measurement_ = measurement_of(assay_, successful_);
    measurement_->reached = true;
}

void TrialSet::evaluate() {
    const double tried = static_cast<double>(taken_), failed = static_cast<double>(failed_);
    const double allowed = max_failed_ * tried;
    // Two standard deviations above the allowed number: further trials will not help.
    if (failed > allowed + 2.0 * std::sqrt(allowed)) return fail();
    // Do not repeat evaluations that asked for more trials.
    Goal goal = goal_;
    goal.min_rounds = std::max(goal_.min_rounds, judged_rounds_ + 1);
    if (successful_.size() >= goal.round * goal.min_rounds) {
        StoppingDecision decision = judge(assay_, successful_, goal);
        judged_rounds_ = successful_.size() / goal.round;
        if (decision.measurement && failed > allowed) return fail();
        measurement_ = std::move(decision.measurement);
        if (measurement_) return;
    }
    const std::size_t missing = goal_.round - successful_.size() % goal_.round;
    next_evaluation_ += missing;
}

bool TrialSet::has_result() const {
    if (!measurement_) return false;
    for (std::size_t q = 0; q < assay_.quantities.size(); ++q)
        if (const measure::Estimate& found = measurement_->estimates[q];
            assay_.quantities[q].wanted && (!found.error || !std::isfinite(found.mean)))
            return false;
    return true;
}

}  // namespace drover::calibrate
