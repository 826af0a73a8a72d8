// numerics/steppers/step_error.hpp: a running estimate of the error that the time step makes in the fields.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/stepper.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "numerics/steppers/linear_operator.hpp"

namespace drover::numerics {

/// The distance of the computed fields from the exact solution of the discretised equations from the same start, with
/// noise on the same path.  Now and then the caller repeats a step in halves and adds the difference; in between, the
/// error evolves as a small perturbation of the fields does, d_t e = L e + N(a + e) - N(a), on fewer points: it grows
/// where they are unstable and decays where they relax.  Its part beyond those points is taken to grow as the rest, but
/// to persist no longer than a linear mode at their cut, and to be twice as large as these waves at most.  It is good
/// to a factor of about 3 (tests/bench/step_error).
class StepError {
public:
    StepError(const ErrorEquations& equations, const Grid& grid, const StepControl& control);
    StepError(const StepError&) = delete;
    StepError& operator=(const StepError&) = delete;

    /// The same equations with another linear part.
    void set_equations(const ErrorEquations::OnGrid& on_grid);

    /// Called first after each step: the work of all steps so far and of this one.  No checkpoint has it.
    void count_work(double done, double of_step);

    /// Steps until the next local error, which takes so much work, may be measured; from 1 to `max_steps`.
    std::int64_t steps_to_afford(double work, std::int64_t max_steps) const;
    /// The next local error comes so late that the error is not known before it.
    void wait();

    /// Called with the fields before a step whose local error add_local() will add.
    void start_local(const Spectra& before);

    /// `of_step`: the error of the step that led to `state`, which took so much work; `waited`: steps since the last.
    void add_local(const Spectra& of_step, const Spectra& state, double work, std::int64_t waited);
    /// Called after it: that of each step up to the next call, which comes after `intervals` times as many steps as
    /// this one did after the last.
    void continue_local(double intervals);

    /// The angle between the last local error and what it was taken for [radians]: 0 where it has only another size;
    /// those of waves, moving bands and oscillations turn.
    double turn() const;
    /// Whether the phases of so many `more` local errors as large as the last matter: not where they add less than a
    /// tenth of the error so far, where the fields have parted, or with noise.
    bool follows_phases(std::int64_t more) const;

    /// Called with the fields after each step; `step`: the number of steps so far.
    void advance(std::int64_t step, const Spectra& state);

    /// The error of a field, of all steps so far, relative to its fluctuation: the root mean square of its deviation
    /// from its mean over the cell and over time, or of that over the cell now if larger, and at least 1e-5 of the
    /// largest root mean square of the field.  In the first four steps of a longer run a field that began at 0 does not
    /// count: its size is that of these steps (local: 16 steps).  Local: relative to the root mean square of the field,
    /// at least its fluctuation and a thousandth of its largest.
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
    std::size_t saved_numbers() const { return save().size(); }

private:
    static constexpr std::int64_t first_steps = 4;

    ErrorEquations equations;
    KeptGrid fine, coarse;
    double dt;
    bool divides;  // waves may turn within dt and be resolved all the same
    double own_change;
    std::int64_t stride = 1, since = 0;    // steps of the run in one of the error, and since its last
    std::int64_t last_moment = 0;          // step
    std::int64_t steps = 0;                // so far
    double unforeseen = 0.0;               // angle between the last local error and what it was taken for [radians]
    bool follows = false;                  // whether it is known from the motion of the fields
    double turn_rate = 0.0;                // of the fields' motion, in a step of the run [radians]
    double work_of_step;                   // of the error
    std::int64_t taken = 0, leap = 0;      // steps of the error since its last leap; length of the present one, or 0
    Spectra earlier, change;               // the error before its last step, and its change a step of the run
    Spectra start, motion, motion_before;  // fields before a step that is checked; their change a step of the run
    double perturbation_growth = 0.0;      // |N(a + e) - N(a)|/|e|
    double alignment = 0.0;                // of that rate with the error: the cosine of the angle between them
    Threads one{1};
    std::vector<ModePair> shared, sampled;
    std::vector<FieldSize> fields;
    std::vector<FastWave> waves;                 // without noise
    std::vector<double> wave_local, wave_error;  // as error.values: the last local error, and the sum of all so far
    Spectra rate_before;                         // the explicit terms at the start of a step that is repeated in halves
    std::optional<Stepper> linear_step;          // the linear part alone, over a part of a step
    Spectra error, shifted, rate;
    // At the ends of a step of the error and, if it is taken in parts, at a time between them.  Fields held at one of
    // the ends would change the growth of errors: those of the phase of an oscillation would decay, and grow along the
    // chord.
    Reference from, to, between;
    std::optional<LinearOperator> linear;
    double error_step = 0.0;
    LocalErrors local;
    Spectra drive, driven;  // the local error, without noise per time, and its sum over the steps since the last
    decltype(System::nonlinear) remainder;  // N
    System system;
    std::map<double, Stepper> steppers;  // by their steps over dt: a stride, or one over a number of parts
    bool noisy;
    bool is_short;                  // the run, of which then all steps count
    Effort effort, checks;          // of all, and of local errors alone
    bool is_lost = false;           // it would have cost more than it may
    bool is_waiting = false;        // for a local error, for longer than it should
    double work_of_run_step = 0.0;  // the last
    double work_of_local;           // beside the steps that it takes

    Reference& reference_at(double t);
    void perturbation_rate(double t, const Spectra& perturbation, Spectra& out);
    double size_of(const Spectra& spectra, const FieldSize& field) const { return field.size_of(spectra, coarse); }
    void measure_fluctuations(const Spectra& fine_fields, double weight);
    double wave_size(const FieldSize& field) const;
    double relative_size(const Spectra& spectra) const;
    double relative_size(double FieldSize::*of_field) const;
    Spectra error_now() const;
    /// Whether it is more than what so many first steps make of 0, of which a part is wrong whatever their length.
    bool has_size(const FieldSize& field, std::int64_t first) const { return steps > first || field.start > 0.0; }
    double growth(double FieldSize::*local) const;
    double size_without_phase(const FieldSize& field) const;
    void sample(const Spectra& fine_fields, Reference& into);
    Stepper& stepper(double steps);
    double longest_change() const;
    void evolve(std::int64_t step);
    void find_motion();
    void add_unresolved_waves(const Spectra& after);
    void add_random_errors(std::int64_t step, std::uint64_t number);
    void leave_out_direction();
    void bound();
    void choose_stride(std::int64_t step);
    void choose_leap(std::int64_t step);
    double stretch() const;
    void end_leap(const Spectra& fine_fields);
    void follow_motion();
    double angle_to_drive() const;
    void set_equations();
    template <class Self, class Visit>
    static void for_saved(Self& self, Visit visit);
};

}  // namespace drover::numerics
