// numerics/combination.hpp: how one stage of an exponential Runge-Kutta method is put together, with the fewest matrices.
#pragma once
#include <vector>

#include "drover/numerics/stepper_table.hpp"

namespace drover::numerics {

/// weight * input; inputs: 0 is the old state, j + 1 the rate of stage j.
struct WeightedInput {
    int input = 0;
    double weight = 1.0;
};

/// One matrix and what it acts on.
struct MatrixUse {
    std::vector<PhiTerm> terms;  ///< dt * sum of weight * phi_order(at dt L); empty: the propagator exp(c dt L)
    std::vector<WeightedInput> inputs;
};

/// A stage as a sum of matrices times sums of inputs, begun from zero or from the stage before.
struct StagePlan {
    bool from_previous = false;  ///< the stage before stands at the same time: only what differs is added to it
    std::vector<MatrixUse> uses;
};

/// Of every stage of a method; and of its estimate of the error, when it has one.
std::vector<StagePlan> stage_plans(const StepperTable& table);
StagePlan error_plan(const StepperTable& table);

}  // namespace drover::numerics
