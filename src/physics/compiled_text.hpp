// physics/compiled_text.hpp: the terms that a scene writes as text, differentiated and compiled for the grid.
#pragma once
#include <vector>

#include "drover/physics/term.hpp"

namespace drover::physics {

/// The text terms of a model.  Each is split into its linear isotropic part, a term of its own that the propagator
/// takes exactly, and the rest, which is evaluated at points; its linearisation is symbolic, so exact.
/// `pointwise_velocity`: what reads a slaved velocity is then evaluated at points.
/// Throws an input Error at the column of a text that cannot be read, or of a term that the form does not admit.
std::vector<Term> compiled_text_terms(const CompiledModel& model, bool pointwise_velocity);

}  // namespace drover::physics
