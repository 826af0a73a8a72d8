// jobs/trade_checks.cpp: convergence with the grid, and drift beyond the duration of the trials.
#include "jobs/trade_checks.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "jobs/trade_axes.hpp"
#include "jobs/trade_start.hpp"

namespace drover::jobs {

void require_relative(const Wish& wish, const Bias& mean) {
    if (!wish.is_relative) return;
    const SourceLocation where{.file = "--want " + wish.text};
    require(mean.value != 0.0, where,
            "the mean is 0, of which a per cent is nothing; expected an absolute error, such as {}=0.01", wish.text);
    constexpr double clear = 3.0;  // standard errors
    require(std::abs(mean.value) >= clear * mean.error, where,
            "the mean is {:.2g} +- {:.2g} in a trial, which may be 0, of which a per cent is nothing; expected an "
            "absolute error, such as {}={:.1g}, or a larger --budget",
            mean.value, mean.error, wish.text, mean.error);
}

bool converges(const TradeBench& bench, const std::vector<LevelFound>& grids) {
    const std::size_t n = grids.size();
    if (!bench.statistical || n < 2 || is_given(grids[n - 1].level) || !grids[n - 1].is_measured()) return true;
    for (std::size_t w = 0; w < bench.allowed.size(); ++w) {
        const Bias last = grids[n - 2].biases[w];
        const bool small = std::abs(last.value) < std::max(0.25 * bench.allowed[w], 4.0 * last.error);
        const bool shrinks = n > 2 && grids[n - 3].is_measured() &&
                             std::abs(last.value) < 2.0 / 3.0 * std::abs(grids[n - 3].biases[w].value - last.value);
        if (!small && !shrinks) return false;
    }
    return true;
}

double longer_duration(double trial, double affordable) {
    const double times = std::floor(affordable / trial);
    return times > 1.0 ? times * trial : 0.0;
}

LaterDrift later_drift(TradeBench& bench, const Candidate& best, const std::vector<Bias>& references) {
    constexpr double clear = 3.0;  // standard errors
    LaterDrift found;
    const double before = bench.duration, left = 0.5 * (bench.budget - bench.spent);
    const double duration = longer_duration(before, best.end * std::min(1.0, left / best.seconds));
    if (duration == 0.0) return found;
    std::vector<std::string> overrides = overrides_of(best);
    overrides.push_back(text("run.seed={}", bench.scene.run.seed + 4));  // after those of Study::reseeded
    bench.duration = duration;
    found.stopped = !bench.run({bench.trial_of(overrides)});
    const Measured run = bench.measured(overrides);
    bench.duration = before;
    if (found.stopped || !run.failure.empty()) return found;
    for (std::size_t w = 0; w < references.size(); ++w) {
        const Bias mean = bench.mean_of(run.numbers[w]), bias = best.parts[w].biases();
        const double moved = mean.value - references[w].value - bias.value,
                     error = std::hypot(mean.error, std::hypot(references[w].error, bias.error));
        if (std::abs(moved) <= std::max(clear * error, bench.allowed[w])) continue;
        found.notes.push_back(
            bench.drift_note(w, text("over {:.6g} s is {:.3g} +- {:.1g} {} than over the trials of {:.6g} s", run.end,
                                     std::abs(moved), error, moved > 0.0 ? "larger" : "smaller", before)));
    }
    if (!found.notes.empty() && (1.0 + run.end / before) * bench.spent <= bench.budget) found.affordable = run.end;
    return found;
}

}  // namespace drover::jobs
