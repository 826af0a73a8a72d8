// numerics/steppers/time_method.cpp: the rows of the stepper tables and of the methods of SUNDIALS, with what they can
// do.
#include "numerics/steppers/time_method.hpp"

#include <algorithm>

#include "drover/base/error.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "numerics/steppers/sundials_stepper.hpp"

namespace drover::numerics {

const std::vector<TimeMethod>& time_methods() {
    static const std::vector<TimeMethod> methods = [] {
        std::vector<TimeMethod> all;
        for (const StepperTable& table : stepper_tables()) {
            const auto stages = static_cast<int>(table.stages.size());
            all.push_back({.name = table.name,
                           .order = table.order,
                           .citation = table.citation,
                           .is_exponential = true,
                           .allows_noise = table.history == 0,
                           .estimates_error = table.history == 0 && !table.error.empty(),
                           .stages = stages,
                           .stages_with_tolerance = std::max(stages, static_cast<int>(table.error.size())),
                           .start = table.start});
        }
        for (const SundialsMethod& method : sundials_methods())
            all.push_back({.name = method.name,
                           .order = method.order,
                           .citation = method.citation,
                           .estimates_error = true,
                           .needs_tolerance = method.stages == 0,
                           .stages = method.stages});
        return all;
    }();
    return methods;
}

const TimeMethod& time_method(const std::string& name) {
    const std::vector<TimeMethod>& all = time_methods();
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const TimeMethod& method) { return method.name == name; });
    if (found != all.end()) return *found;
    std::vector<std::string> names;
    for (const TimeMethod& method : all) names.push_back(method.name);
    fail_input({}, "unknown stepper \"{}\"; expected one of {}", name, joined(names));
}

}  // namespace drover::numerics
