// numerics/stepper_table.hpp: exponential Runge-Kutta and multistep methods as tables of coefficients.
#pragma once
#include <span>
#include <string>
#include <vector>

namespace drover::numerics {

/// weight * phi_order(at * dt * L).
struct PhiTerm {
    double weight = 0.0;
    int order = 1;    ///< 1 to max_phi
    double at = 1.0;  ///< fraction of the step
};

/// One stage: a_i = exp(c dt L) a + dt sum_j (sum of terms[j]) N(t + c_j dt, a_j), j < i.
struct StepperStage {
    double c = 0.0;                           ///< fraction of the step, 0 to 1
    std::vector<std::vector<PhiTerm>> terms;  ///< one list for each earlier stage
};

/// One method.  The last stage is the new state: its c is 1.  With noise, a stage at c includes the noise from t to
/// t + c dt, exact for the linear system; the rate at c = 0 includes none.
///
/// A multistep method uses rates of earlier steps too.  The lists of its stages and of its error are those of the
/// rates of the stages, then that of the rate at the new state, then those of the rates at t - dt, t - 2 dt, ...
struct StepperTable {
    std::string name;
    int order = 1;  ///< of the error without noise
    std::string citation;
    std::vector<StepperStage> stages;  ///< stages[0]: the second; the first is the old state itself
    /// The embedded estimate of the local error, dt sum_j (sum of error[j]) N_j: one list for each stage, and one more
    /// where the rate at the new state is needed.  Empty: no estimate.  Of a multistep method: the new state less a
    /// more accurate one.
    std::vector<std::vector<PhiTerm>> error = {};
    std::string error_citation = {};
    int history = 0;         ///< rates of earlier steps that a step needs; 0: a Runge-Kutta method
    std::string start = {};  ///< the Runge-Kutta method of the first steps of a multistep method
    int start_parts = 1;     ///< equal parts of a step at the start
};

/// Throws an input Error for a table that no stepper can use: without stages, with a last c other than 1, lists of
/// another number than of rates, or phi functions beyond 1 to max_phi.
void check(const StepperTable& table);

/// All methods.
std::span<const StepperTable> stepper_tables();

/// The method of that name; throws an input Error that lists the names.
const StepperTable& stepper_table(const std::string& name);

}  // namespace drover::numerics
