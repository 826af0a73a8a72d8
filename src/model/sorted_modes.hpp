// model/sorted_modes.hpp: the eigenvalues and eigenvectors of one matrix, sorted by growth.
#pragma once
#include "drover/model/theory.hpp"

namespace drover::model {

/// As model::modes.
Modes sorted_modes(const Symbol& m);

}  // namespace drover::model
