// io/scene_model.hpp: the model of a scene: its sections by the registry of coefficients, its terms as text.
#pragma once
#include <map>
#include <string>

#include "drover/base/schema.hpp"
#include "physics/model_values.hpp"

namespace drover::io {

/// The table of the parameters of text terms.
inline constexpr const char* parameter_table = "terms";

/// Fills the model from the tables of a scene and notes where each key is.  `[[terms]]` number n is the table terms[n],
/// their parameters the table terms.
void read_model(const LocatedTables& tables, physics::ModelValues& model,
                std::map<std::string, SourceLocation>& locations);

/// The tables that belong to a model, whether or not a scene has them.
bool is_model_table(const std::string& name);

/// The model as TOML.
std::string model_text(const physics::ModelValues& model);

}  // namespace drover::io
