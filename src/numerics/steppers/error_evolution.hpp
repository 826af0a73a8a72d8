// numerics/steppers/error_evolution.hpp: the error of the fields, which evolves by the tangent equations of a run.
#pragma once
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <vector>

#include "drover/numerics/stepper.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "numerics/steppers/error_equations.hpp"
#include "numerics/steppers/local_errors.hpp"

namespace drover::numerics {

struct ErrorEvolution {
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
    std::optional<Stepper> turn;                 // the linear part alone, over a part of a step
    Spectra error, shifted, rate;
    // At the ends of a step of the error and, if it is taken in parts, at a time between them.  Fields held at one of
    // the ends would change the growth of errors: those of the phase of an oscillation would decay.
    Reference from, to, between;
    double error_step = 0.0;
    LocalErrors local;
    Spectra drive, driven;  // the local error, without noise per time, and its sum over the steps since the last
    decltype(System::nonlinear) remainder;  // N
    System system;
    std::map<double, Stepper> steppers;  // by their steps over dt: a stride, or one over a number of parts
    bool noisy;
    Effort effort, checks;          // of all, and of local errors alone
    bool is_lost = false;           // it would have cost more than it may
    bool is_waiting = false;        // for a local error, for longer than it should
    double work_of_run_step = 0.0;  // the last
    double work_of_local;           // beside the steps that it takes

    ErrorEvolution(const ErrorEquations& the_equations, const Grid& grid, const StepControl& control);
    void set_equations();
    Reference& reference_at(double t);
    void perturbation_rate(double t, const Spectra& perturbation, Spectra& out);
    double size_of(const Spectra& spectra, const FieldSize& field) const { return field.size_of(spectra, coarse); }
    void measure_fluctuations(const Spectra& fine_fields, double weight) {
        for (FieldSize& field : fields) field.add_moment(fine_fields, fine, noisy, weight);
    }
    double wave_size(const FieldSize& field) const;
    double relative_size(const Spectra& spectra) const;
    double local_size() const;
    Spectra error_now() const;
    /// Whether it is more than what so many first steps make of 0, of which a part is wrong whatever their length.
    bool has_size(const FieldSize& field, std::int64_t first) const { return steps > first || field.start > 0.0; }
    double growth() const;
    double size_without_phase(const FieldSize& field) const;
    void sample(const Spectra& fine_fields, Reference& into);
    Stepper& stepper(double steps);
    void evolve(std::int64_t step);
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
};

}  // namespace drover::numerics
