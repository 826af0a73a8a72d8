// numerics/steppers/time_method.cpp: the rows of the stepper tables and of the methods of SUNDIALS, with what they can
// do.
#include "numerics/steppers/time_method.hpp"

#include <algorithm>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/numerics/stepper_table.hpp"

namespace drover::numerics {

namespace {
constexpr const char* cvode_citation = "Hindmarsh et al., ACM Trans. Math. Softw. 31, 363 (2005); SUNDIALS CVODE";
constexpr const char* ark2003 = "Kennedy & Carpenter, Appl. Numer. Math. 44, 139 (2003); SUNDIALS ARKODE";
constexpr const char* ark2019 = "Kennedy & Carpenter, Appl. Numer. Math. 136, 183 (2019); SUNDIALS ARKODE";

/// Without steps of fixed length.
TimeMethod cvode(const std::string& name, int highest_order) {
    return {.name = name,
            .order = highest_order,
            .citation = cvode_citation,
            .estimates_error = true,
            .needs_tolerance = true};
}

/// table: as in "ARKODE_ARK324L2SA_DIRK_4_2_3".
TimeMethod arkode(const std::string& name, int order, int stages, const char* citation, const std::string& table,
                  const std::string& orders) {
    return {.name = name,
            .order = order,
            .citation = citation,
            .estimates_error = true,
            .stages = stages,
            .implicit_table = "ARKODE_" + table + "_DIRK_" + orders,
            .explicit_table = "ARKODE_" + table + "_ERK_" + orders};
}
}  // namespace

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
        for (const TimeMethod& method : {cvode("cvode-bdf", 5), cvode("cvode-adams", 12),
                                         arkode("arkode-ark324l2sa", 3, 4, ark2003, "ARK324L2SA", "4_2_3"),
                                         arkode("arkode-ark436l2sa", 4, 6, ark2003, "ARK436L2SA", "6_3_4"),
                                         arkode("arkode-ark437l2sa", 4, 7, ark2019, "ARK437L2SA", "7_3_4"),
                                         arkode("arkode-ark548l2sa", 5, 8, ark2003, "ARK548L2SA", "8_4_5"),
                                         arkode("arkode-ark548l2sab", 5, 8, ark2019, "ARK548L2SAb", "8_4_5")})
            all.push_back(method);
        return all;
    }();
    return methods;
}

const TimeMethod& time_method(const std::string& name) {
    const std::vector<TimeMethod>& all = time_methods();
    const auto found = std::ranges::find(all, name, &TimeMethod::name);
    if (found != all.end()) return *found;
    fail_input({}, "unknown stepper \"{}\"; expected one of {}", name, joined(mapped(all, &TimeMethod::name)));
}

}  // namespace drover::numerics
