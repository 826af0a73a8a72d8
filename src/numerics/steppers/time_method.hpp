// numerics/steppers/time_method.hpp: every method of time integration: those of drover and those of SUNDIALS.
#pragma once
#include <string>
#include <vector>

namespace drover::numerics {

struct TimeMethod {
    std::string name;
    int order = 1;  ///< without noise; the highest, where it varies
    std::string citation;
    bool is_exponential = false;   ///< linear terms are exact: a row of stepper_tables(), else a method of SUNDIALS
    bool allows_noise = false;     ///< exact, too
    bool estimates_error = false;  ///< a tolerance is allowed
    bool needs_tolerance = false;  ///< it has no steps of fixed length
    /// Right-hand sides per step of dt, or per part of dt with a tolerance; 0: they vary.
    int stages = 0, stages_with_tolerance = 0;
    std::string start = {};                                ///< of a multistep method: the method of its first steps
    std::string implicit_table = {}, explicit_table = {};  ///< of ARKODE, by SUNDIALS' names; "": CVODE
};

const std::vector<TimeMethod>& time_methods();

/// Right-hand sides per part of dt; 0: they vary.  halves: it is taken whole and in halves, see AdaptiveStepper.
inline int stages_per_part(const TimeMethod& method, bool has_tolerance, bool halves) {
    return halves ? 3 * method.stages : has_tolerance ? method.stages_with_tolerance : method.stages;
}

/// Throws an input Error that lists the names.
const TimeMethod& time_method(const std::string& name);

}  // namespace drover::numerics
