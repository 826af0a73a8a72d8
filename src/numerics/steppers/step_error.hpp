// numerics/steppers/step_error.hpp: a running estimate of the error that the time step makes in the fields.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "numerics/steppers/adaptive_stepper.hpp"
#include "numerics/steppers/error_equations.hpp"

namespace drover::numerics {

struct ErrorEvolution;

/// The distance of the computed fields from the exact solution of the discretised equations from the same start, with
/// noise on the same path.  Now and then the caller repeats a step in halves and adds the difference; in between, the
/// error evolves as a small perturbation of the fields does, d_t e = L e + N(a + e) - N(a), on fewer points: it grows
/// where they are unstable and decays where they relax.  Its part beyond those points is taken to grow as the rest, but
/// to persist no longer than a linear mode at their cut.  It is good to a factor of about 3 (tests/bench/step_error).
class StepError {
public:
    StepError(const ErrorEquations& equations, const Grid& grid, const StepControl& control);
    ~StepError();
    StepError(StepError&&) noexcept;

    /// The same equations with another linear part.
    void set_equations(const ErrorEquations::OnGrid& on_grid);

    /// Called first after each step: the work of all steps so far and of this one.  No checkpoint has it.
    void count_work(double done, double of_step);

    /// Steps until the next local error, which takes so much work, may be measured; from 1 to `most`.
    std::int64_t steps_to_afford(double work, std::int64_t most) const;
    /// The next local error comes so late that the error is not known before it.
    void wait();

    /// Called with the fields before a step whose local error add_local() will add.
    void start_local(const Spectra& before);

    /// `local`: the error of the step that led to `state`, which took so much work; `waited`: steps since the last.
    void add_local(const Spectra& local, const Spectra& state, double work, std::int64_t waited);
    /// Called after it: that of each step up to the next call, which comes after `intervals` times as many steps as
    /// this one did after the last.
    void continue_local(double intervals);

    /// The angle between the last local error and what it was taken for [radians]: 0 where it has only another size;
    /// those of waves, moving bands and oscillations turn.
    double turn() const;
    /// Whether the phases of `steps` more local errors as large as the last matter: not where they add less than a
    /// tenth of the error so far, where the fields have parted, or with noise.
    bool follows_phases(std::int64_t steps) const;

    /// Called with the fields after each step; `step`: the number of steps so far.
    void advance(std::int64_t step, const Spectra& state);

    /// The error of a field, of all steps so far, relative to its fluctuation: the root mean square of its deviation
    /// from its mean over the cell and over time, or of that over the cell now if larger, and at least 1e-5 of the
    /// largest root mean square of the field.  In the first four steps a field that began at 0 does not count: its
    /// size is that of these steps (local: 16 steps).  Local: relative to the root mean square of the field, at least
    /// its fluctuation and a thousandth of its largest.
    struct Relative {
        double error = 0.0;
        std::string field;  ///< "rod_density", "bead_velocity", ...
    };
    Relative largest() const;        ///< of any field, at most 1; NaN where it is not known
    Relative largest_local() const;  ///< of the last local error alone

    /// The error on the grid of the fields; none where a part of it without known phases is larger, or where it is
    /// half of the fluctuation of a field, so that it has no definite effect.
    std::optional<Spectra> known() const;

    /// Its state, for checkpoints.
    std::vector<double> save() const;
    void restore(std::span<const double> values);
    std::size_t saved_numbers() const;

private:
    std::unique_ptr<ErrorEvolution> work_;
};

}  // namespace drover::numerics
