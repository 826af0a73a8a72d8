// io/names_used.cpp: a search through the formulas of a model.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "base/mapped.hpp"
#include "io/declared_model.hpp"

namespace drover::io {

namespace {
/// What a scene declares for its equations.
struct DeclaredName {
    std::string place;                  ///< for people
    std::vector<std::string> names;     ///< in formulas
    std::vector<std::string> formulas;  ///< of what it is
};

std::vector<DeclaredName> declared_names(const DeclaredModel& model) {
    std::vector<DeclaredName> all;
    for (const auto& [name, value] : model.coefficients) all.push_back({"coefficients." + name, {name}, {}});
    for (const auto& [name, value] : model.definitions) all.push_back({"define." + name, {name}, {value.text}});
    for (const DeclaredTable& table : model.tables)
        all.push_back({"[[tabulated]] " + table.symbol, {table.symbol}, table.of});
    for (const DeclaredNoise& noise : model.noises) {
        all.push_back({"[[white_noise]] " + noise.symbol, {noise.symbol}, {}});
        for (const int spin : {1, 2, 3})
            for (std::string& name : component_names(model::Field{.symbol = noise.symbol, .spin = spin}))
                all.back().names.push_back(std::move(name));
    }
    return all;
}

}  // namespace

bool mentions(const std::string& formula, const std::vector<std::string>& names) {
    const auto in_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    const char *at = formula.data(), *const last = at + formula.size();
    while (at < last) {
        if (std::isdigit(static_cast<unsigned char>(*at)) != 0 || *at == '.') {  // "2k" is 2 times k
            double number = 0.0;
            at = std::max(at + 1, std::from_chars(at, last, number).ptr);
            continue;
        }
        const char* const end = std::find_if_not(at, last, in_name);
        if (std::ranges::find(names, std::string(at, end)) != names.end()) return true;
        at = std::max(at + 1, end);
    }
    return false;
}

std::vector<std::string> without_effect(const DeclaredModel& model) {
    std::vector<DeclaredName> idle = declared_names(model);
    std::vector<std::string> formulas;
    for (const auto& [symbol, equation] : model.equations) formulas.push_back(equation.text);
    for (const DeclaredField& field : model.fields)
        formulas.insert(formulas.end(), {field.reference, field.noise, field.mass});
    while (!formulas.empty()) {
        const std::string formula = std::move(formulas.back());
        formulas.pop_back();
        std::erase_if(idle, [&](const DeclaredName& one) {
            const bool is_there = mentions(formula, one.names);
            if (is_there) formulas.insert(formulas.end(), one.formulas.begin(), one.formulas.end());
            return is_there;
        });
    }
    return mapped(idle, &DeclaredName::place);
}

}  // namespace drover::io
