// model/transform_plan.hpp: what is transformed to the grid, and the functions at its points.
#pragma once
#include "model/compiled.hpp"

namespace drover::model {

/// The arrays that are transformed to the grid, and the functions of them.
struct TransformPlan {
    std::vector<LinearForm> inputs;
    /// A call whose results some function reads: of expressions, with results in the slots from `first`.
    struct Function {
        std::size_t call = 0;
        std::vector<Expression> arguments;
        std::vector<int> results;  ///< offsets from the first slot of the call: values and slopes that are read
        int first = 0;
    };
    std::vector<Function> functions;  ///< each after those that it reads
    std::vector<Expression> values;   ///< of the outputs; slots: position, time, inputs, results
    int slots = 0;
};
TransformPlan transform_plan(const CompiledEquations& equations);

/// Equations whose functions at points are the products in the balances of others.
std::shared_ptr<const CompiledEquations> with_forces_as_outputs(const CompiledEquations& equations);

/// Whether a form is one component of the fields.
bool is_plain(const LinearForm& form);

}  // namespace drover::model
