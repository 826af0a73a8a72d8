// jobs/tradeoff/trade_front.cpp: errors and costs of all combinations of levels; those that no other beats.
#include "jobs/tradeoff/trade_front.hpp"

#include <algorithm>

#include "io/scene.hpp"

namespace drover::jobs {

namespace {
Bias sum(const Bias& a, const Bias& b) { return {std::abs(a.value) + std::abs(b.value), std::hypot(a.error, b.error)}; }

/// The trial of a combination; nullptr: none.
const Checked* check_of(const Findings& found, const Candidate& one) {
    const std::vector<std::string> overrides = overrides_of(one);
    const auto checked =
        std::ranges::find_if(found.checked, [&](const Checked& run) { return run.overrides == overrides; });
    return checked == found.checked.end() ? nullptr : &*checked;
}

/// The fluctuations of the wanted numbers in a run of a combination.
const std::vector<Fluctuation>& fluctuations_of(const Candidate& one, const Checked* check) {
    return check == nullptr ? one.model->fluctuations : check->fluctuations;
}

/// The autocorrelation time of a wanted number over that of the trials, if samples are as rare as a level needs; of an
/// exponential correlation, else an upper bound.
double rarity(const Findings& found, const Fluctuation& fluctuation, const LevelFound& step) {
    if (step.level.sample_every <= found.sample_every) return 1.0;
    const double half = 0.5 * step.level.sample_every, tau = fluctuation.time;
    return std::max(1.0, half / std::tanh(half / tau) / tau);
}

/// The variance of a mean times its duration [s], from a trial.
double variance_time(const Findings& found, const Fluctuation& fluctuation, const LevelFound& step) {
    return rarity(found, fluctuation, step) * std::pow(fluctuation.error, 2) * (found.duration - found.warm_up);
}

/// The cost of a run with these levels: costs of grid and model multiply, since each was compared on one of the others.
double seconds_of(const Findings& found, const Candidate& one) {
    const double grid_start = one.grid->start_seconds / std::max(found.pilot_start, 1e-9),
                 grid_step = one.grid->step_seconds / std::max(found.pilot_step, 1e-9);
    return one.step->start_seconds * grid_start * one.model->start_seconds +
           one.step->step_seconds * grid_step * one.model->step_seconds * one.end;
}

/// False for a combination whose trial failed.
bool weigh(const Findings& found, Candidate& one, double end) {
    one.end = end;
    const Checked* check = check_of(found, one);
    if (check != nullptr && !check->outcome.is_measured()) return false;
    const std::vector<Fluctuation>& fluctuations = fluctuations_of(one, check);
    one.ratio = 0.0;
    for (std::size_t w = 0; w < found.targets.size(); ++w) {
        one.parts.push_back({one.step->biases[w], one.grid->biases[w], one.model->biases[w], 0.0, std::nullopt});
        if (found.statistical)  // from the error over the duration of the trials
            one.parts.back().statistics =
                std::sqrt(variance_time(found, fluctuations[w], *one.step) / std::max(one.end - found.warm_up, 1e-9));
        if (check != nullptr) one.parts.back().whole = check->biases[w];
        const double ratio = one.parts.back().bound() / found.allowed[w];
        if (!std::isfinite(ratio)) return false;
        one.ratio = std::max(one.ratio, ratio);
    }
    one.seconds = seconds_of(found, one);
    return true;
}

/// Whole units of time.
double rounded_up(const Findings& found, const io::Scene& scene, const LevelFound& step, double duration) {
    const double unit = std::max({unit_of_time(scene), found.sample_every, step.level.sample_every});
    return unit * std::ceil(duration / unit - 1e-9);
}

/// Durations of runs: that of the scene; with statistical errors the shortest that tells its own error, and powers of
/// two times that of the trials.
std::vector<double> durations(const Findings& found, const io::Scene& scene, const Candidate& one) {
    if (!found.statistical) return {scene.time.end};
    const LevelFound& step = *one.step;
    double shortest = found.warm_up;
    for (const Fluctuation& number : fluctuations_of(one, check_of(found, one)))
        shortest =
            std::max(shortest, rarity(found, number, step) * number.margin * number.time *
                                   measure::autocorrelation_times_per_block * static_cast<double>(measure::min_blocks));
    std::vector<double> result{rounded_up(found, scene, step, found.warm_up + shortest)};
    constexpr int shorter = 4, longer = 24;
    for (int k = -shorter; k <= longer; ++k)
        if (const double duration = rounded_up(found, scene, step, found.duration * std::exp2(0.5 * k));
            duration > result.back())
            result.push_back(duration);
    return result;
}

/// The duration for which a combination just meets the targets; nothing where its biases do not.
std::optional<double> sufficient_duration(const Findings& found, const Candidate& one) {
    if (!found.statistical) return std::nullopt;
    const std::vector<Fluctuation>& fluctuations = fluctuations_of(one, check_of(found, one));
    double longest = 0.0;
    for (std::size_t w = 0; w < found.targets.size(); ++w) {
        const Bias all = one.parts[w].biases();
        const double margin = 0.5 * (found.allowed[w] - std::abs(all.value));
        if (margin <= all.error) return std::nullopt;
        longest = std::max(longest, variance_time(found, fluctuations[w], *one.step) /
                                        (margin * margin - all.error * all.error));
    }
    constexpr double margin = 1.02;  // rounding of the duration
    return found.warm_up + margin * longest;
}

/// A simpler model is worth its bias only if it saves time.
bool is_cheaper(const LevelFound& model) {
    constexpr double saving = 0.1;
    return model.is_measured() && (is_given(model.level) || model.step_seconds < 1.0 - saving);
}

Candidate linear_theory(const Findings& found) {
    Candidate one;
    one.ratio = 0.0;
    for (std::size_t w = 0; w < found.targets.size(); ++w) {
        one.parts.push_back({{}, {}, (*found.linear_theory)[w], 0.0, std::nullopt});
        one.ratio = std::max(one.ratio, one.parts.back().bound() / found.allowed[w]);
    }
    return one;
}
}  // namespace

Bias Parts::biases() const { return whole ? *whole : sum(sum(step, grid), model); }

double Parts::bound() const {
    const Bias all = biases();
    return std::abs(all.value) + 2.0 * std::hypot(all.error, statistics);
}

std::vector<Candidate> front_of(const Findings& found, const io::Scene& scene, const LevelFound* only) {
    std::vector<Candidate> all;
    if (found.linear_theory && only == nullptr) all.push_back(linear_theory(found));
    for (const std::vector<LevelFound>& ladder : found.ladders)
        for (const LevelFound& step : ladder)
            for (const LevelFound& grid : found.grids)
                for (const LevelFound& model : found.models) {
                    if (!step.is_measured() || !grid.is_measured() || !is_cheaper(model)) continue;
                    if (only != nullptr && only != &model) continue;
                    const Candidate levels{.step = &step, .grid = &grid, .model = &model, .parts = {}};
                    const std::vector<double> ends = durations(found, scene, levels);
                    std::optional<double> sufficient;
                    for (const double end : ends)
                        if (Candidate one = levels; weigh(found, one, end)) {
                            if (!sufficient) sufficient = sufficient_duration(found, one);
                            all.push_back(std::move(one));
                        }
                    if (Candidate one = levels; sufficient && *sufficient > ends.front() &&
                                                weigh(found, one, rounded_up(found, scene, step, *sufficient)))
                        all.push_back(std::move(one));
                }
    std::ranges::stable_sort(all, [](const Candidate& a, const Candidate& b) {
        return a.seconds != b.seconds ? a.seconds < b.seconds : a.ratio < b.ratio;
    });
    std::vector<Candidate> front;
    for (Candidate& one : all)
        if (front.empty() || one.ratio < 0.95 * front.back().ratio ||
            (one.ratio <= 1.0 && front.back().ratio > 1.0))  // the cheapest that is good enough, by however little
            front.push_back(std::move(one));
    return front;
}

std::vector<std::string> overrides_of(const Candidate& candidate) {
    std::vector<std::string> overrides;
    for (const LevelFound* one : {candidate.grid, candidate.model, candidate.step})  // the row of a model, on any grid
        overrides.insert(overrides.end(), one->level.overrides.begin(), one->level.overrides.end());
    return overrides;
}

io::Scene scene_of(const io::Scene& scene, const Findings& found, const Candidate& candidate) {
    std::vector<std::string> overrides;
    if (found.sample_every > 0.0) overrides.push_back(set("output.sample_every", found.sample_every));
    std::ranges::move(overrides_of(candidate), std::back_inserter(overrides));
    overrides.push_back(set("time.end", candidate.end));
    if (found.warm_up > 0.0) overrides.push_back(set("analysis.warm_up", found.warm_up));
    // The errors of what is wanted are measured: the run need not warn of those of its fields.
    if (scene.time.max_error > 0.0 && io::has_grid(scene.kind)) overrides.push_back("time.max_error=1.0");
    // No more frames than were asked for, at whole steps.
    double frames = scene.output.frame_every;
    if (frames > 0.0 && io::has_grid(scene.kind)) {
        overrides.push_back("output.frame_every=0.0");
        const io::Scene chosen = io::changed(scene, overrides);
        frames *= std::max(1.0, std::ceil(candidate.end / scene.time.end - 1e-9));
        const double steps = frames / chosen.time.dt;
        if (std::abs(steps - std::round(steps)) > 1e-9 * steps)
            frames = chosen.output.sample_every * std::ceil(frames / chosen.output.sample_every);
        overrides.push_back(set("output.frame_every", std::min(frames, candidate.end)));
    }
    return io::changed(scene, overrides);
}

const Candidate* recommended(const std::vector<Candidate>& front, double budget) {
    constexpr double little = 1.1;  // times the cost, for the most accurate
    const Candidate *cheapest = nullptr, *best = nullptr;
    for (const Candidate& one : front) {
        if (one.step == nullptr || one.ratio > 1.0) continue;
        if (cheapest == nullptr) cheapest = &one;
        if (one.seconds <= little * cheapest->seconds) best = &one;
    }
    return best != nullptr && best->seconds <= budget ? best : nullptr;
}

}  // namespace drover::jobs
