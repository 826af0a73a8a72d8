// run/declared_stability.cpp: the uniform states of a declared model.
#include <algorithm>
#include <cmath>

#include "run/stability_problem.hpp"

namespace drover::run {

namespace {
AnalysedState analysed(const model::Equations& equations, const model::StationaryState& state, std::size_t number_of) {
    const model::Model& model = equations.model();
    std::string group = "/" + state.name;
    std::replace_if(
        group.begin() + 1, group.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    AnalysedState result{.name = state.name,
                         .group = text("{}_{}", group, number_of),
                         .heading = "state: " + state_words(model, state),
                         .entries = {},
                         .linear = model::LinearisedAt(equations, state.values),
                         .has_free_direction = state.has_free_direction};
    std::size_t component = 0;
    for (const model::Field& field : model.fields)
        for (const std::string& name : model::dataset_names(field))
            result.entries.push_back(number(name, field.unit, name + " of the state", state.values[component++]));
    result.is_mapped_along_x = result.linear.is_isotropic();
    Eigen::Index place = 0;
    for (const std::string& name : model::part_names(equations)) {
        result.parts.push_back(
            {name, "1", [at = result.linear, place](const model::Symbol& s, const numerics::Wavevector& q) {
                 return at.along_and_across(s, q)(place, place).real();
             }});
        ++place;
    }
    result.slow_modes = [at = result.linear](double angle) { return model::slow_modes(at, angle); };
    return result;
}
}  // namespace

std::string state_text(const model::Model& model, const model::UniformState& values) {
    std::string result;
    std::size_t at = 0;
    for (const model::Field& field : model.fields) {
        const auto count = static_cast<std::size_t>(model::components(field));
        const double value = count == 1 ? values[at] : std::hypot(values[at], values[at + 1]);
        if (value != 0.0)
            result += text("{}{} = {:.6g}", result.empty() ? "" : ", ",
                           count == 1 ? field.symbol : "|" + field.symbol + "|", value);
        at += count;
    }
    return result.empty() ? "all fields 0" : result;
}

std::string state_words(const model::Model& model, const model::StationaryState& state) {
    return text("{}, {}", state.is_isotropic ? "isotropic" : "ordered", state_text(model, state.values));
}

StabilityProblem declared_stability(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    const model::StationaryStates found = model::stationary_states(equations);
    const auto only_data = [](const char* name, const std::string& why) {
        return Entry{.name = name, .unit = "", .meaning = "", .value = why, .shown = {.text = false}};
    };
    StabilityProblem problem{.direction = "the order",
                             .entries = {words("model", "its name", scene.declared.name),
                                         only_data("no_state", found.why_none),
                                         only_data("no_order", found.why_no_order)}};
    for (const model::StationaryState& state : found.states)
        problem.states.push_back(analysed(equations, state, problem.states.size() + 1));
    if (!found.why_none.empty()) problem.footer.push_back("\nno uniform stationary state: " + found.why_none);
    if (!found.why_no_order.empty()) problem.footer.push_back("\nno ordered state: " + found.why_no_order);
    return problem;
}

}  // namespace drover::run
