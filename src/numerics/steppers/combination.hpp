// numerics/steppers/combination.hpp: one stage of an exponential method with the fewest matrices.
#pragma once
#include <vector>

#include "drover/numerics/stepper_table.hpp"

namespace drover::numerics {

/// weight * input; inputs: 0 is the old state, j + 1 the rate numbered j: see StepperTable.
struct WeightedInput {
    int input = 0;
    double weight = 1.0;
};

/// One matrix and its inputs.
struct MatrixUse {
    std::vector<PhiTerm> terms;  ///< dt * sum of weight * phi_order(at dt L); empty: the propagator exp(c dt L)
    std::vector<WeightedInput> inputs;
};

/// A stage as a sum of matrices times sums of inputs, starting from zero or from the previous stage.
struct StagePlan {
    bool from_previous = false;  ///< the previous stage is at the same time: only the difference is added
    std::vector<MatrixUse> uses;
};

/// For every stage of a method, and for its error estimate, where it has one.
std::vector<StagePlan> stage_plans(const StepperTable& table);
StagePlan error_plan(const StepperTable& table);

}  // namespace drover::numerics
