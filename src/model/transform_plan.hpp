// model/transform_plan.hpp: what is transformed to the grid, and the functions at its points.
#pragma once
#include "compiled.hpp"

namespace drover::model {

/// The arrays that are transformed to the grid, and the functions of them.
struct TransformPlan {
    std::vector<LinearForm> inputs;
    std::vector<Expression> values;  ///< of the outputs; slots: position, time, inputs
};
TransformPlan transform_plan(const CompiledEquations& equations);

/// Whether a form is one component of the fields.
bool is_plain(const LinearForm& form);

}  // namespace drover::model
