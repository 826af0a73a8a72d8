// calibrate/assay.hpp: the definition of an assay, and the rule that decides when it has enough trials.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/dem/setup.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::calibrate {

/// Position of a body in the plane, not wrapped [mm].
struct Position {
    double x = 0.0, y = 0.0;
};

/// A rod in the plane.
struct RodPose {
    double x = 0.0, y = 0.0;  ///< centre of mass, not wrapped [mm]
    double angle = 0.0;       ///< from the x axis to n, modulo 2 pi [rad]
};

/// Means over all beads, in the plane.
struct BeadMotion {
    double x = 0.0, y = 0.0;    ///< mean position, not wrapped: its change is the integral of the mean velocity [mm]
    double vx = 0.0, vy = 0.0;  ///< mean velocity [mm/s]
};

/// Rods and beads in a periodic cell, with imposed forces and a few measured quantities.  The virtual functions allow
/// the particle world and synthetic systems with known coefficients to be exchanged at run time.
class ParticleSystem {
public:
    virtual ~ParticleSystem() = default;
    /// Replaces the forces on the bodies from now on.
    virtual void impose(const dem::BodyForces& forces) = 0;
    /// Advances to a time since the start [s].  Throws an input Error for one that is earlier than now or not finite.
    virtual void advance_to(double time) = 0;

    virtual std::vector<RodPose> rods() const = 0;
    virtual BeadMotion beads() const = 0;
    /// Position of each bead.
    virtual std::vector<Position> bead_positions() const = 0;
    /// Amplitude A of v_x = A sin(2 pi waves y/ly) of the beads [mm/s].  Throws an input Error without beads or waves.
    virtual double shear_wave(int waves) const = 0;
    /// Amplitude d of the bead density rho (1 + d cos(2 pi waves x/lx)).  Throws as shear_wave().
    virtual double density_wave(int waves) const = 0;
};

/// Creates a system at t = 0: the bodies of the setup, its packing and its forces; the seed fixes all random choices.
using SystemFactory = std::function<std::unique_ptr<ParticleSystem>(const dem::Setup& setup, std::uint64_t seed)>;

/// Creates systems of the particle world, single-threaded, with time step dt [s].
/// A system throws what dem::World and the packing throw.
SystemFactory system_factory(double dt);

/// The result of one trial: numbers whose means over trials suffice for an estimate.  The assay fixes their count.
/// Trial files store these numbers.
using Trial = std::vector<double>;

/// One result of an assay.
struct Quantity {
    std::string name, unit, formula;
    bool wanted = true;  ///< whether its error decides how many trials are run; other quantities are by-products
};

/// Computes the quantities of an assay from the means of the numbers of its trials.
using Estimator = std::function<std::vector<double>(std::span<const double> means)>;

/// The bodies in the cell of an assay, which decide the area fractions that its results depend on.
enum class Population {
    beads,        ///< beads without rods: results depend on the area fraction of beads
    single_rods,  ///< one rod, or a few far apart, among beads: results depend on the area fraction of beads
    all           ///< rods and beads: results depend on both area fractions
};

/// A measurement of coefficients on particles.  A function of each creates it from its plan.
struct Assay {
    std::string name;
    Population population = Population::all;
    std::vector<Quantity> quantities;
    /// A pure function: the same factory, setup and seed give the same numbers.
    std::function<Trial(const SystemFactory& make, const dem::Setup& setup, std::uint64_t seed)> trial;
    /// Called once with all trials, to choose what is fixed for all resamples, such as the range of a fit.
    std::function<Estimator(std::span<const Trial> trials)> estimator;
    /// Describes the estimates: linear or not, resolved or not.  May reject an estimate: sets its `why_no_error` and
    /// removes its error.
    std::function<std::string(std::vector<measure::Estimate>& estimates)> conclude;
    /// Throws an input Error, at the location of a key of the plan, for a setup that the plan does not suit.  Empty: it
    /// suits all.
    std::function<void(const dem::Setup& setup, const Locate& locate)> check = {};
};

/// State of matter and seed.  `setup` gives shapes, area fractions, plates, contacts and the periodic cell; an assay
/// removes or aligns bodies and sets the forces.
struct Conditions {
    dem::Setup setup;
    std::uint64_t seed = 0;
};

/// When an assay has enough trials.  Trials are counted in rounds and evaluated after whole rounds, in order.
struct Goal {
    double relative_error = 0.05;  ///< target of every wanted quantity, > 0
    std::size_t round = 16;        ///< trials of a round, >= 1
    /// Rounds before the first evaluation, together at least 8 trials.  An error estimated from n trials is itself
    /// known to 1/sqrt(2n); stopping when it is small enough favours errors that came out small, so intervals cover
    /// less than they claim: from 32 trials on, 1 to 2 % less.
    std::size_t min_rounds = 2;
    std::size_t max_trials = 512;  ///< rounded down to whole rounds
};

struct Measurement {
    /// One for each quantity, with the standard error over trials; `samples` and `blocks` are the number of trials.
    std::vector<measure::Estimate> estimates;
    /// The values that the errors come from, [resample][quantity]; NaN where a resample gives none.
    std::vector<std::vector<double>> resamples;
    std::size_t trials = 0;
    bool reached = false;      ///< whether every wanted quantity meets the goal
    std::size_t unmet = 0;     ///< the quantity that misses the goal by most, if not reached
    std::string unmet_target;  ///< of it, and how many trials would meet the goal; "" if reached
    std::string diagnosis;     ///< remark on linearity, regimes or resolution
};

/// Either trials [begin, end) are needed next, or the measurement is complete.
struct StoppingDecision {
    std::size_t begin = 0, end = 0;
    std::optional<Measurement> measurement;
};

/// Seed of one trial: a pure function of its arguments, independent between trials and assays for all purposes.
std::uint64_t trial_seed(std::uint64_t seed, const std::string& assay, std::uint64_t trial);

/// Runs trial number `trial`.  Throws what the factory and its systems throw, and an input Error for an assay without
/// a trial, and for a setup without a periodic cell or without the bodies that the assay needs.
Trial run_trial(const Assay& assay, const SystemFactory& make, const Conditions& conditions, std::uint64_t trial);

/// The result of all these trials, compared with no goal.  Standard errors by the bootstrap over trials: whole trials
/// are resampled, since everything within a trial may be correlated.  Resamples are drawn by counter, so the same
/// trials give the same errors. The spread of the resamples is multiplied by sqrt(n/(n - 1)), which makes it exact for
/// a mean.  The difference between their mean and the estimate is the first-order bias in 1/n (a quotient of noisy
/// means is biased) and is subtracted.  If more than one resample in 50 gives no finite value, there is no error, and
/// `why_no_error` gives the reason.
/// Throws an input Error for fewer than two trials, trials without numbers or of different lengths, an assay without an
/// estimator, and another number of estimates than of quantities.
/// Source: Efron & Tibshirani, An introduction to the bootstrap (1993), ch. 6 and 10.
Measurement measurement_of(const Assay& assay, std::span<const Trial> trials);

/// Evaluates the first whole rounds of these trials, in order, until they suffice; later trials have no effect, so
/// trials may run in any order and number at a time.  Throws an input Error for an invalid goal, or for trials of
/// different lengths.
StoppingDecision judge(const Assay& assay, std::span<const Trial> trials, const Goal& goal);

/// Runs trials one after the other until judge() is satisfied.
Measurement carry_out(const Assay& assay, const SystemFactory& make, const Conditions& conditions, const Goal& goal);

}  // namespace drover::calibrate
