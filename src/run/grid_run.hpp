// run/grid_run.hpp: what the simulations of fields on a grid share, whatever their equations.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "files/archive.hpp"
#include "io/scene.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"

namespace drover::run {

/// The recording of frames on a grid, without its quantities, each of which has the axes y and x.
files::Recording frames_on(const numerics::Grid& grid);

/// The scene with a step, whatever it is, and without estimates of errors: its fields at t = 0 are the same.
io::Scene start_alone(const io::Scene& scene);

/// Finite, and small enough that a sum over so many modes is finite too.  False for NaN.
bool is_finite(numerics::Complex value, std::size_t modes);

/// Throws an input Error, for fields that were not taken as the state, at the first value that is not finite.
void require_finite(const numerics::Fields& fields, const std::vector<std::string>& names, const numerics::Grid& grid);

/// The coefficients of a state as numbers of a checkpoint: two for each mode; and back, for as many numbers.
void append_numbers(const numerics::Spectra& state, std::vector<double>& to);
void take_numbers(std::span<const double> numbers, numerics::Spectra& state);

/// The parts of the numbers of a checkpoint: those of the stepper, the time, the state, the step bias and their number.
struct SavedRun {
    std::span<const double> stepper, state, bias;
    double time = 0.0;
};
std::vector<double> numbers_of_run(std::vector<double> stepper, double time, const numerics::Spectra& state,
                                   const std::vector<double>& bias);
/// state_numbers: those of the state.  Throws an input Error for fewer numbers than that needs.
SavedRun saved_run(std::span<const double> all, std::size_t state_numbers);

/// The choices of an adaptive stepper, for people; "" where its steps are fixed.
std::string steps_text(const numerics::AdaptiveStepper& stepper, const io::Scene& scene);

/// Memory of the steppers of a method: so many, or of our own methods twice as many with a tolerance [bytes].
double steppers_bytes(const numerics::System& system, const io::TimeControl& time, int count);

/// Memory of the stepper of a twin with noise, and of its state [bytes].
double twin_stepper_bytes(const numerics::System& system, const io::TimeControl& time);

}  // namespace drover::run
