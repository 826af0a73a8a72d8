// physics/evaluation_cost.hpp: what one evaluation of the right-hand side costs, known before it is made.
#pragma once
#include "drover/physics/equations.hpp"

namespace drover::physics {

using model::TransformCount;

/// Transforms of one evaluation; none when every active term is linear.
TransformCount transform_count(const Equations& equations);

/// Whether N has any part at all.
bool is_nonlinear(const Equations& equations);

}  // namespace drover::physics
