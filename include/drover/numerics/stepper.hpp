// numerics/stepper.hpp: steps of a System: linear part and noise exact, the rest by an exponential Runge-Kutta table.
#pragma once
#include <cstdint>
#include <memory>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// A method applied to one system with one step.  The blocks of each |q| are computed at construction.
class Stepper {
public:
    /// Throws a run Error if a linear mode grows beyond the range of numbers in one step.
    Stepper(const System& system, const StepperTable& table, double dt, std::uint64_t seed, Threads& threads);
    ~Stepper();
    Stepper(Stepper&&) noexcept;

    /// From a(t) to a(t + dt) in place.  Modes that are not kept must be zero.  The noise is a function of (seed, step
    /// number, mode) alone.
    void step(double t, std::uint64_t step_number, Spectra& state);

    /// Whether the method has an embedded error estimate.
    bool estimates_error() const;

    /// A step of a system without noise that may still be rejected: next = a(t + dt), error = an estimate of its local
    /// error. Throws an input Error for a method without an estimate.
    void attempt(double t, const Spectra& state, Spectra& next, Spectra& error);

    double dt() const;
    double bytes() const;  ///< memory, stages included

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

/// Memory of a Stepper [bytes], without constructing it.
double stepper_bytes(const System& system, const StepperTable& table);

/// A sample of the stationary distribution of the linear system; modes at q = 0 that do not decay are zero.
/// Throws a run Error where a mode with q != 0 grows or does not decay.
void draw_stationary(const System& system, const RandomKey& key, Spectra& state);

}  // namespace drover::numerics
