// calibrate/trial_set.cpp: looks after whole rounds of attempts, in the order of their numbers.
#include "drover/calibrate/trial_set.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"

namespace drover::calibrate {

TrialSet::TrialSet(Assay assay, const Goal& goal, double max_failed)
    : assay_(std::move(assay)), goal_(goal), failed_most_(max_failed), look_(goal.round * goal.min_rounds) {
    judge(assay_, {}, goal_);  // refuses a goal that cannot be
    require(max_failed >= 0.0 && max_failed < 1.0, {}, "a part of {} of the trials may fail; expected 0 to below 1",
            max_failed);
}

void TrialSet::add(Attempt attempt) {
    const std::uint64_t number = attempt.number;
    attempts_.emplace(number, std::move(attempt));
    while (!ended() && attempts_.contains(taken_)) {
        const Attempt& next = attempts_.at(taken_++);
        if (next.failure.empty()) good_.push_back(next.numbers);
        else if (failed_++ == 0) failure_ = next.failure;
        if (taken_ == look_) look();
    }
}

std::optional<Measurement> TrialSet::so_far() const {
    Goal goal = goal_;
    const std::size_t rounds = good_.size() / goal.round;
    if (ended() || rounds < goal.min_rounds) return {};
    goal.min_rounds = rounds;
    goal.max_trials = rounds * goal.round;
    return judge(assay_, good_, goal).measurement;
}

void TrialSet::look() {
    const double tried = static_cast<double>(taken_), failed = static_cast<double>(failed_);
    const double allowed = failed_most_ * tried;
    const auto refuse = [&] {
        refusal_ = text("{}: {} of {} trials failed; expected at most {:.3g} %: {}", assay_.name, failed_, taken_,
                        100.0 * failed_most_, failure_);
    };
    // Twice the spread of their number beyond what is allowed: it will not become fewer.
    if (failed > allowed + 2.0 * std::sqrt(allowed)) return refuse();
    // A look that was in vain need not be taken again.
    Goal goal = goal_;
    goal.min_rounds = std::max(goal_.min_rounds, judged_ + 1);
    if (good_.size() >= goal.round * goal.min_rounds) {
        StoppingDecision judgement = judge(assay_, good_, goal);
        judged_ = good_.size() / goal.round;
        if (judgement.measurement && failed > allowed) return refuse();
        measurement_ = std::move(judgement.measurement);
        if (measurement_) return;
    }
    const std::size_t missing = goal_.round - good_.size() % goal_.round;
    look_ += missing;
}

}  // namespace drover::calibrate
