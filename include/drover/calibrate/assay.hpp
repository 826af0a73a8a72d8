// calibrate/assay.hpp: what an assay is, and how many trials of it are enough.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/calibrate/particle_system.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::calibrate {

/// What one trial found: numbers whose means over trials are all that an estimate needs.  Their count is fixed by the assay; this is what a
/// manifest stores.
using Trial = std::vector<double>;

/// One result of an assay.
struct Quantity {
    std::string name, unit, formula;
    bool wanted = true;  ///< its error decides when there are enough trials; else it is told beside
};

/// Quantities of an assay from the means of the numbers of its trials.
using Estimator = std::function<std::vector<double>(std::span<const double> means)>;

/// The bodies in the cell of an assay, and so the area fractions that its results depend on.
enum class Population {
    beads,        ///< beads alone: results depend on the area fraction of beads
    single_rods,  ///< one rod, or a few far apart, among beads: the same
    all           ///< rods and beads: results depend on both area fractions
};

/// A coefficient measured on particles.  Made by the functions of the assays' own headers, from their plans.
struct Assay {
    std::string name;
    Population population = Population::all;
    std::vector<Quantity> quantities;
    /// A pure function: the same numbers for the same factory, setup and seed.
    std::function<Trial(const SystemFactory& make, const dem::Setup& setup, std::uint64_t seed)> trial;
    /// Chooses what is read off the means (where a regime begins and ends) from all trials together, once.
    std::function<Estimator(std::span<const Trial> trials)> estimator;
    /// What the estimates say in words: linear or not, resolved or not.  May refuse an estimate: set its refusal, and drop its error.
    std::function<std::string(std::vector<measure::Estimate>& estimates)> conclude;
};

/// The state of matter and its seed.  `setup` gives shapes, area fractions, plates, contacts and the periodic cell; an assay takes bodies away or
/// aligns them, and sets the forces.
struct Conditions {
    dem::Setup setup;
    std::uint64_t seed = 0;
};

/// When there are enough trials.  They are counted in rounds and looked at after whole rounds alone, in their order.
struct Goal {
    double relative_error = 0.05;  ///< of every wanted quantity, > 0
    std::size_t round = 16;        ///< trials of a round, >= 1
    /// Rounds before the first look, together 8 trials or more.  An error from n trials is itself known to 1/sqrt(2n); a rule that stops when it is small enough picks
    /// those that came out small, and the interval covers less than it says: from 32 trials on, 1 or 2 % less.
    std::size_t min_rounds = 2;
    std::size_t max_trials = 512;  ///< rounded down to whole rounds
};

struct Measurement {
    /// Of each quantity, with the standard error over trials: `samples` and `blocks` are the trials.
    std::vector<measure::Estimate> estimates;
    std::size_t trials = 0;
    bool reached = false;      ///< whether every wanted quantity is known as well as was asked
    std::string unmet_target;  ///< a sentence: what was not reached, and how many trials would do; "" otherwise
    std::string diagnosis;     ///< a sentence on linearity, regimes or resolution
};

/// Trials [begin, end) are wanted next, or the measurement is done.
struct StoppingDecision {
    std::size_t begin = 0, end = 0;
    std::optional<Measurement> measurement;
};

/// Seed of one trial: a pure function of its arguments, as good as independent from trial to trial and assay to assay.
std::uint64_t trial_seed(std::uint64_t seed, const std::string& assay, std::uint64_t trial);

/// Trial number `trial`.  Throws what the factory and its specimens throw, and an input Error for a setup without a periodic cell, or without the
/// bodies that the assay is about.
Trial run_trial(const Assay& assay, const SystemFactory& make, const Conditions& conditions, std::uint64_t trial);

/// Estimates from these trials, each with its standard error by the bootstrap over trials: resamples of whole trials (blocks within which everything
/// may be correlated), drawn by counter, so the same trials give the same error.  The spread of resamples is multiplied by sqrt(n/(n - 1)), which
/// makes it right for a mean.  Their mean beside the estimate is the bias of the estimator to first order in 1/n (a quotient of noisy means has one) and is taken
/// off.  No error, and a refusal, where more than one resample in 50 gives no finite value.
/// Source: Efron & Tibshirani, An introduction to the bootstrap (1993), ch. 6 and 10.
std::vector<measure::Estimate> estimate(const Assay& assay, std::span<const Trial> trials);

/// Looks at the first whole rounds of these trials, in order, until they are enough; what comes after them changes nothing.  So trials may be run in
/// any order and in any number at a time.  Throws an input Error for a goal that cannot be, or trials of other lengths than each other.
StoppingDecision judge(const Assay& assay, std::span<const Trial> trials, const Goal& goal);

/// All of it, one trial after the other.
Measurement carry_out(const Assay& assay, const SystemFactory& make, const Conditions& conditions, const Goal& goal);

}  // namespace drover::calibrate
