// run/model_coefficients.cpp: names and values of coefficients.
#include "run/model_coefficients.hpp"

namespace drover::run {

std::string coefficient_of(const io::Scene& scene, const std::string& list, const std::string& key,
                           const SourceLocation& where) {
    const std::string section = "coefficients.", name = key.starts_with(section) ? key.substr(section.size()) : key;
    std::vector<std::string> names;
    for (const auto& [known, value] : scene.declared.coefficients) names.push_back(section + known);
    require(scene.declared.coefficients.contains(name), where, "{} names {}; expected {}", list, key,
            names.empty() ? "a coefficient of the model, which has none" : "one of " + joined(names));
    return name;
}

model::Equations equations_with(const io::DeclaredModel& declared,
                                const std::vector<std::pair<std::string, double>>& changes) {
    io::DeclaredModel changed = declared;
    for (const auto& [name, value] : changes) changed.coefficients[name] = value;
    try {
        return model::Equations(io::model_of(changed));
    } catch (const Error& error) {
        std::string at;
        for (const auto& [name, value] : changes) at += text("{}{} = {}", at.empty() ? "" : ", ", name, value);
        throw Error(error.fault(), {}, text("at {}: {}", at, error.what()));
    }
}

}  // namespace drover::run
