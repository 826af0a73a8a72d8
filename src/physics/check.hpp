// physics/check.hpp: whether a scene's values make a model.
#pragma once
#include "physics/compiled_model.hpp"

namespace drover::physics {

/// Throws an input Error, with its location, for invalid numbers or terms: also for a balance without drag, for
/// products beside derivatives of its field in one, and for texts of a scene that a balance cannot have.
void check(const ModelValues& model, const LocationOf& location_of = no_location);

}  // namespace drover::physics
