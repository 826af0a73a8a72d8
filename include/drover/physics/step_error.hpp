// physics/step_error.hpp: a running estimate of the error that the time step makes in the fields.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "drover/physics/linear_theory.hpp"

namespace drover::physics {

/// The distance of the computed fields from the exact solution of the discretised equations from the same start, with
/// noise on the same path.  Now and then the caller repeats a step in halves and adds the difference; in between, the
/// error evolves as a small perturbation of the fields does, d_t e = L e + N(a + e) - N(a), on fewer points: it grows
/// where they are unstable and decays where they relax.  Its part beyond those points is taken to grow as the rest, but
/// to persist no longer than a linear mode at their cut.  Under noise the direction of a free flock diffuses without
/// limit and changes no mean: errors of the direction of the mean order are left out.  It is good to a factor of about
/// 3 (tests/bench/step_error).
class StepError {
public:
    /// `divides`: a tolerance divides dt, so that waves may turn within it and be resolved all the same.
    StepError(const Equations& equations, const numerics::Grid& grid, const Dealiasing& dealiasing, double dt,
              bool divides = false);
    ~StepError();
    StepError(StepError&&) noexcept;

    /// The linear part about another reference.
    void set_reference(const Reference& about);

    /// Called with the fields before a step whose local error add_local() will add.
    void start_local(const numerics::Spectra& before);

    /// `local`: the error of the step that led to `state`, also that of each step up to the next call.
    void add_local(const numerics::Spectra& local, const numerics::Spectra& state);

    /// Called with the fields after each step; `step`: the number of steps so far.
    void advance(std::int64_t step, const numerics::Spectra& state);

    /// The error of a field, of all steps so far, relative to its fluctuation: the root mean square of its deviation
    /// from its mean over the cell and over time, or of that over the cell now if larger, and at least 1e-5 of the
    /// largest root mean square of the field.  Local: relative to the root mean square of the field, at least a
    /// thousandth of its largest.
    struct Relative {
        double error = 0.0;
        std::string field;  ///< "rod_density", "bead_velocity", ...
    };
    Relative largest() const;        ///< of any field, at most 1
    Relative largest_local() const;  ///< of the last local error alone

    /// The error on the grid of the fields; none where a part of it without known phases is larger, or where it is
    /// half of the fluctuation of a field, so that it has no definite effect.
    std::optional<numerics::Spectra> known() const;

    /// Its state, for checkpoints.
    std::vector<double> save() const;
    void restore(std::span<const double> values);
    std::size_t saved_numbers() const;

private:
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace drover::physics
