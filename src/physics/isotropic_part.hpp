// physics/isotropic_part.hpp: the isotropic part of a term's linearisation, which the propagator takes.
#pragma once
#include "drover/physics/term.hpp"

namespace drover::physics {

/// Throws an input Error where a term declares an isotropic linear part that its linearisation does not have, or an
/// action that does not fit its linear part.
void check_linear_part(const CompiledModel& model, const Term& term);

/// Whether the linearisation of a term about a state at rest commutes with rotations and reflections: compared at two
/// angles and three |q|.
bool has_isotropic_linearisation(const CompiledModel& model, const Term& term);

/// The term's part in the propagator at q along x, about a reference.
void add_isotropic_part(const CompiledModel& model, const Term& term, const Reference& reference, double q, Symbol& m);

/// A symbol in axes turned by an angle of this cosine and sine: R m R^T.
Symbol rotated(const Symbol& m, double cosine, double sine);

}  // namespace drover::physics
