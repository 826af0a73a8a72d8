// physics/evaluation_cost.hpp: what one evaluation of the right-hand side costs, known before it is made.
#pragma once
#include "drover/physics/equations.hpp"

namespace drover::physics {

/// What one evaluation costs.
struct TransformCount {
    int inverse = 0, forward = 0;  ///< of real fields: to the grid, and from it
};

/// Transforms of one evaluation; none when every active term is linear.
TransformCount transform_count(const Equations& equations);

/// Whether N has any part at all.
bool is_nonlinear(const Equations& equations);

/// Memory that a RightHandSide holds [bytes], without the fields.
double right_hand_side_bytes(const Equations& equations, const numerics::Grid& grid, int degree);

}  // namespace drover::physics
