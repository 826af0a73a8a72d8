// theory/sorted_modes.hpp: the eigenvalues and eigenvectors of one matrix, sorted by growth.
#pragma once
#include "drover/theory/theory.hpp"

namespace drover::theory {

/// As model::modes.
Modes sorted_modes(const model::Symbol& m);

}  // namespace drover::theory
