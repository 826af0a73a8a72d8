// physics/model_file.cpp: rows of a model file.
#include "physics/model_file.hpp"

#include <algorithm>

#include "drover/base/error.hpp"

namespace drover::physics {

const CoefficientRow& coefficient_row(const std::string& key, const ModelFile& file) {
    const auto found = std::ranges::find(file.coefficients, key, &CoefficientRow::key);
    require(found != file.coefficients.end(), {}, "unknown coefficient {}; expected one of the model file", key);
    return *found;
}

std::vector<const FieldRow*> densities(const ModelFile& file) {
    std::vector<const FieldRow*> found;
    for (const FieldRow& field : file.fields)
        if (!field.reference.empty()) found.push_back(&field);
    return found;
}

const CoefficientRow* with_conventions(const ModelFile& file) {
    for (const CoefficientRow& row : file.coefficients)
        if (!row.factor_key.empty()) return &row;
    return nullptr;
}

double factor_of(const CoefficientRow& row, const std::string& word) {
    for (const auto& [known, factor] : row.factors)
        if (known == word) return factor;
    fail_input({}, "{} = \"{}\"; expected one of those of the model file", row.factor_key, word);
}

}  // namespace drover::physics
