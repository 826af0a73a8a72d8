// calibrate/assay.cpp: systems of the particle world; seeds of trials, errors over trials, and the stopping rule.
#include "drover/calibrate/assay.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/table.hpp"
#include "dem/packing/packing.hpp"
#include "drover/base/error.hpp"
#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "drover/dem/world.hpp"

namespace drover::calibrate {

namespace {
class WorldSystem : public ParticleSystem {
public:
    WorldSystem(const dem::Setup& setup, double dt, std::uint64_t seed)
        : world_(setup, dem::pack(setup, seed), dt, seed, threads_), bodies_(world_.bodies()) {}

    void impose(const dem::BodyForces& forces) override { world_.set_forces(forces); }

    void advance_to(double time) override {
        const double steps = std::round(time / world_.dt());
        require(steps >= static_cast<double>(step_) && steps < 0x1p53, {},
                "advance_to({}) at t = {} s; expected a finite time that is not earlier", time,
                static_cast<double>(step_) * world_.dt());
        const auto end = static_cast<std::int64_t>(steps);
        while (step_ < end) world_.advance(step_++);
        bodies_ = world_.bodies();
    }

    std::vector<RodPose> rods() const override {
        return mapped(bodies_.rods, [](const dem::Rod& rod) {
            return RodPose{rod.position.x, rod.position.y, std::atan2(rod.axis.y, rod.axis.x)};
        });
    }

    BeadMotion beads() const override {
        return {.x = mean([](const dem::Bead& bead) { return bead.position.x; }),
                .y = mean([](const dem::Bead& bead) { return bead.position.y; }),
                .vx = mean([](const dem::Bead& bead) { return bead.velocity.x; }),
                .vy = mean([](const dem::Bead& bead) { return bead.velocity.y; })};
    }

    std::vector<Position> bead_positions() const override {
        return mapped(bodies_.beads, [](const dem::Bead& bead) { return Position{bead.position.x, bead.position.y}; });
    }

    double shear_wave(int waves) const override {
        check_waves(waves);
        const double q = 2.0 * std::numbers::pi * waves / world_.setup().cell.ly;
        const auto wave = [q](const dem::Bead& bead) { return std::sin(q * bead.position.y); };
        // Least-squares fit to the velocities, as in the force that holds the wave.
        return mean([&](const dem::Bead& bead) { return bead.velocity.x * wave(bead); }) /
               mean([&](const dem::Bead& bead) { return wave(bead) * wave(bead); });
    }

    double density_wave(int waves) const override {
        check_waves(waves);
        const double q = 2.0 * std::numbers::pi * waves / world_.setup().cell.lx;
        return 2.0 * mean([q](const dem::Bead& bead) { return std::cos(q * bead.position.x); });
    }

private:
    void check_waves(int waves) const {
        require(waves >= 1 && !bodies_.beads.empty(), {}, "{} waves of {} beads; expected 1 or more of each", waves,
                bodies_.beads.size());
    }
    template <class Function>
    double mean(Function function) const {
        double total = 0.0;
        for (const dem::Bead& bead : bodies_.beads) total += function(bead);
        return bodies_.beads.empty() ? 0.0 : total / static_cast<double>(bodies_.beads.size());
    }

    Threads threads_{1};
    dem::World world_;
    dem::Bodies bodies_;
    std::int64_t step_ = 0;
};

constexpr double max_failing =
    0.02;  // fraction of resamples; they lie in the tails, so the error without them is too small

/// Mean of each number over the selected trials.
std::vector<double> means_of(std::span<const Trial> trials, std::span<const std::size_t> chosen) {
    std::vector<double> means(trials.front().size(), 0.0);
    for (const std::size_t t : chosen)
        for (std::size_t i = 0; i < means.size(); ++i) means[i] += trials[t][i];
    for (double& mean : means) mean /= static_cast<double>(chosen.size());
    return means;
}

/// Sets the error to the spread over resamples, and subtracts the bias: resamples deviate from the estimate on average
/// as the estimate deviates from the true value.
void set_error_and_bias(measure::Estimate& estimate, const std::vector<std::vector<double>>& values,
                        std::size_t quantity) {
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (const std::vector<double>& value : values)
        if (std::isfinite(value[quantity])) {
            const double apart = value[quantity] - estimate.mean;
            sum += apart, squares += apart * apart, count += 1.0;
        }
    if (!std::isfinite(estimate.mean) || count < (1.0 - max_failing) * static_cast<double>(values.size())) {
        estimate.why_no_error = text(
            "no error estimate: {} of {} resamples of the {} trials give no value, where {:g} % may: take more trials, "
            "or longer ones",
            static_cast<double>(values.size()) - count, values.size(), estimate.samples, 100.0 * max_failing);
        return;
    }
    const double trials = static_cast<double>(estimate.samples);
    estimate.error = std::sqrt(std::max(squares - sum * sum / count, 0.0) / (count - 1.0) * trials / (trials - 1.0));
    estimate.mean -= sum / count;
}

void check(const Goal& goal) {
    require(goal.relative_error > 0.0 && std::isfinite(goal.relative_error), {},
            "the requested relative error is {}; expected a number > 0", goal.relative_error);
    require(goal.round >= 1 && goal.round * goal.min_rounds >= measure::min_blocks, {},
            "{} rounds of {} trials before the first evaluation; expected at least {} trials for a meaningful error",
            goal.min_rounds, goal.round, measure::min_blocks);
    require(goal.max_trials >= goal.round * goal.min_rounds, {},
            "max_trials = {} with {} rounds of {} before the first evaluation; expected at least as many",
            goal.max_trials, goal.min_rounds, goal.round);
}

/// Error divided by the target: at most 1 if the target is met.
double excess(const measure::Estimate& estimate, const Goal& goal) {
    if (!estimate.error || !std::isfinite(estimate.mean)) return infinite;
    if (*estimate.error == 0.0) return 0.0;
    return *estimate.error / (goal.relative_error * std::abs(estimate.mean));
}

/// largest: its error divided by the target.
std::string unmet_target_of(const Assay& assay, const Measurement& measurement, const Goal& goal, double largest) {
    const Quantity& quantity = assay.quantities[measurement.unmet];
    const std::string& name = quantity.name;
    const measure::Estimate& estimate = measurement.estimates[measurement.unmet];
    if (!estimate.error)
        return text("{}: {} has no error estimate after {} trials: {}", assay.name, name, measurement.trials,
                    estimate.why_no_error);
    const double trials = std::ceil(static_cast<double>(measurement.trials) * largest * largest);
    if (std::abs(estimate.mean) < 2.0 * *estimate.error)
        return text(
            "{}: {} = {:.3g} +- {:.2g} {} after {} trials is not significantly different from 0; the target error is "
            "{:.3g} %",
            assay.name, name, estimate.mean, *estimate.error, quantity.unit, measurement.trials,
            100.0 * goal.relative_error);
    return text(
        "{}: {} has an error of {:.3g} % after {} trials; the target is {:.3g} %: about {:.0f} trials are needed",
        assay.name, name, 100.0 * *estimate.error / std::abs(estimate.mean), measurement.trials,
        100.0 * goal.relative_error, trials);
}

/// Finds the wanted quantity that misses its target by most.
void compare_with_goal(const Assay& assay, const Goal& goal, Measurement& measurement) {
    double largest = 1.0;
    measurement.reached = true;
    for (std::size_t q = 0; q < assay.quantities.size(); ++q)
        if (const double found = excess(measurement.estimates[q], goal); assay.quantities[q].wanted && found > largest)
            measurement.reached = false, measurement.unmet = q, largest = found;
    if (!measurement.reached) measurement.unmet_target = unmet_target_of(assay, measurement, goal, largest);
}
}  // namespace

SystemFactory system_factory(double dt) {
    return [dt](const dem::Setup& setup, std::uint64_t seed) { return std::make_unique<WorldSystem>(setup, dt, seed); };
}

std::uint64_t trial_seed(std::uint64_t seed, const std::string& assay, std::uint64_t trial) {
    double drawn = 0.0;
    fill_uniform({.seed = seed, .stream = Stream::trial, .step = number_of_name(assay)}, trial, 1, {&drawn, 1});
    return static_cast<std::uint64_t>(std::ldexp(drawn, 52));  // 52 bits: exact as a double, which a checkpoint may use
}

Trial run_trial(const Assay& assay, const SystemFactory& make, const Conditions& conditions, std::uint64_t trial) {
    require(static_cast<bool>(assay.trial), {}, "{}: no function of a trial; expected an assay with one", assay.name);
    require(dem::is_periodic(conditions.setup.cell), {}, "{}: the cell shape is \"{}\"; expected \"periodic\"",
            assay.name, conditions.setup.cell.shape);
    const bool of_beads = assay.population == Population::beads;
    const char* const bodies = of_beads ? "beads" : "rods";
    require(of_beads ? conditions.setup.beads.any() : conditions.setup.rods.any(), {},
            "{}: the setup has no {}; expected {}.area_fraction or {}.count > 0", assay.name, bodies, bodies, bodies);
    if (assay.check) assay.check(conditions.setup, no_location);
    return assay.trial(make, conditions.setup, trial_seed(conditions.seed, assay.name, trial));
}

Measurement measurement_of(const Assay& assay, std::span<const Trial> trials) {
    require(trials.size() >= 2, {}, "{}: {} trials; expected at least two", assay.name, trials.size());
    for (const Trial& trial : trials)
        require(trial.size() == trials.front().size(), {},
                "{}: trials with {} and with {} numbers; expected equal lengths", assay.name, trials.front().size(),
                trial.size());
    require(!trials.front().empty(), {}, "{}: trials of no numbers; expected one or more", assay.name);
    require(static_cast<bool>(assay.estimator), {}, "{}: no estimator; expected an assay with one", assay.name);
    const Estimator estimator = assay.estimator(trials);
    require(static_cast<bool>(estimator), {}, "{}: its estimator gives no function; expected one of the means",
            assay.name);
    const auto values_of = [&](const std::vector<double>& means) {
        std::vector<double> values = estimator(means);
        require(values.size() == assay.quantities.size(), {}, "{}: {} estimates of {} quantities; expected one of each",
                assay.name, values.size(), assay.quantities.size());
        return values;
    };
    std::vector<std::size_t> chosen(trials.size());
    for (std::size_t t = 0; t < chosen.size(); ++t) chosen[t] = t;
    Measurement found{.trials = trials.size()};
    for (const double value : values_of(means_of(trials, chosen)))
        found.estimates.push_back({.mean = value, .samples = trials.size(), .blocks = trials.size()});
    std::vector<double> drawn(trials.size());
    for (std::size_t r = 0; r < resample_count; ++r) {
        fill_uniform({.stream = Stream::bootstrap, .step = r}, 0, 1, drawn);
        for (std::size_t t = 0; t < chosen.size(); ++t)
            chosen[t] = static_cast<std::size_t>(drawn[t] * static_cast<double>(trials.size()));
        found.resamples.push_back(values_of(means_of(trials, chosen)));
    }
    for (std::size_t q = 0; q < found.estimates.size(); ++q) set_error_and_bias(found.estimates[q], found.resamples, q);
    if (assay.conclude) found.diagnosis = assay.conclude(found.estimates);
    return found;
}

StoppingDecision judge(const Assay& assay, std::span<const Trial> trials, const Goal& goal) {
    check(goal);
    for (std::size_t count = goal.round * goal.min_rounds;; count += goal.round) {
        if (count > trials.size()) return {.begin = trials.size(), .end = count};
        Measurement found = measurement_of(assay, trials.first(count));
        compare_with_goal(assay, goal, found);
        if (found.reached || count + goal.round > goal.max_trials)
            return {.begin = count, .end = count, .measurement = std::move(found)};
    }
}

Measurement carry_out(const Assay& assay, const SystemFactory& make, const Conditions& conditions, const Goal& goal) {
    std::vector<Trial> trials;
    Goal next = goal;
    for (;;) {
        StoppingDecision decision = judge(assay, trials, next);
        if (decision.measurement) return std::move(*decision.measurement);
        next.min_rounds = decision.end / goal.round;  // evaluations that asked for more trials are not repeated
        for (std::size_t t = decision.begin; t < decision.end; ++t)
            trials.push_back(run_trial(assay, make, conditions, t));
    }
}

}  // namespace drover::calibrate
