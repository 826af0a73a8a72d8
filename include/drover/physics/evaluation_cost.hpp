// physics/evaluation_cost.hpp: whether a right-hand side needs any evaluation.
#pragma once
#include "drover/physics/equations.hpp"

namespace drover::physics {

/// Whether N has any part at all.
bool is_nonlinear(const Equations& equations);

}  // namespace drover::physics
