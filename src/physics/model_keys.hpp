// physics/model_keys.hpp: the keys of a scene that its model file has, and what they are in a model.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "physics/model_values.hpp"

namespace drover::physics {

/// One scene key of a model.
struct ModelKey {
    Description description;
    std::function<Value(const ModelValues&)> get;
    std::function<void(ModelValues&, const Value&)> set;
    bool is_number = false;  ///< of the equations: a coefficient or a mean density
};

struct ModelSection {
    std::string name, doc;
    std::vector<ModelKey> keys;
};

/// All sections of a model with their keys, in the order in which a scene is written.
std::vector<ModelSection> model_sections(const ModelFile& file);
/// Those of the shipped model.
const std::vector<ModelSection>& model_sections();
/// nullptr if they do not have it.
const ModelKey* find_key(const std::string& key);

/// What a symbol in the equations of a model stands for.
struct CoefficientValue {
    std::string key, symbol;
    Variant<double, std::string> value;
    std::string unit, doc;
};
/// Those that are not 0.
std::vector<CoefficientValue> coefficient_values(const ModelValues& model);

/// The coefficients as a Markdown table, for the manual.
std::string coefficient_documentation(const ModelFile& file = shipped_model());

}  // namespace drover::physics
