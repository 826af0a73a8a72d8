// physics/term_inputs.hpp: what the terms of a user may read, and the equations that they add to.
#pragma once
#include <array>

#include "drover/base/expression.hpp"
#include "drover/physics/term.hpp"

namespace drover::physics {

/// Slots of a text, or of the arguments of a function: the inputs at points, then the parameters of the model.
inline constexpr int derivatives_begin = Input::d_x, position_begin = Input::x, parameters_begin = Input::count;

bool has_field(const Form& form, int field);

/// The names that a term may use in this form.
Vocabulary vocabulary_of(const CompiledModel& model);

/// Values of the inputs in a uniform state: derivatives and places are 0.
std::array<double, Input::count> slots_at(const UniformPoint& about);

/// Adds to a symbol what a component contributes by its slope in a slot.  first_row: of the equation; the components of
/// a flux share it.
void add_derivative(int first_row, bool is_flux, std::size_t component, double slope, int slot,
                    const numerics::Wavevector& q, Symbol& m);

/// An equation that a term can be of.
struct Target {
    const char* of;
    const char* equation;
    Equation which;
    int row, rate, flux;  ///< flux: -1 of a vector
};
/// Throws an input Error if the model does not have it.
const Target& target_of(const CompiledModel& model, const TextTerm& written);

struct WrittenTraits {
    std::string name;
    Equation of = Equation::polar_order;
    bool conserves = false;  ///< leaves the mean density of a uniform state as it is
    bool reads_velocity = false, derives_velocity = false;
    bool is_linear = false;  ///< and isotropic
};
/// Throws an input Error for a term that this form cannot have.
void check_admissible(const CompiledModel& model, const SourceLocation& where, const WrittenTraits& term,
                      bool pointwise_velocity);

}  // namespace drover::physics
