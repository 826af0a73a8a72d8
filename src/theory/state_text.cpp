// theory/state_text.cpp: uniform states in words.
#include "theory/state_text.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/text.hpp"

namespace drover::theory {

bool is_given(const model::Field& field) { return field.spin == 0 && !field.observed.counted.empty(); }

std::vector<std::size_t> drawn_fields(const model::Model& model) {
    std::vector<std::size_t> fields(model.fields.size());
    for (std::size_t n = 0; n < fields.size(); ++n) fields[n] = n;
    std::ranges::stable_sort(fields, {}, [&](std::size_t n) { return model.fields[n].observed.drawn; });
    return fields;
}

std::string values_text(const model::Model& model, const model::UniformState& values) {
    const std::vector<int> firsts = model::first_components(model);
    std::string result;
    for (const std::size_t n : drawn_fields(model)) {
        const model::Field& field = model.fields[n];
        const auto at = static_cast<std::size_t>(firsts[n]);
        const double value = field.spin == 0 ? values[at] : std::hypot(values[at], values[at + 1]);
        if (value != 0.0 && !is_given(field))
            result += text("{}{} = {:.6g}", result.empty() ? "" : ", ",
                           field.spin == 0 ? field.symbol : "|" + field.symbol + "|", value);
    }
    return result;
}

std::string state_text(const model::Model& model, const model::UniformState& values) {
    const std::string result = values_text(model, values);
    return result.empty() ? "all fields 0" : result;
}

std::string state_words(const model::Model& model, const StationaryState& state) {
    return text("{}, {}", state.is_isotropic ? "isotropic" : "ordered", state_text(model, state.values));
}

}  // namespace drover::theory
