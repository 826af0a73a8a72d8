// io/scene_declared.hpp: a declared model between TOML tables and a scene.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "io/declared_model.hpp"

namespace drover::io {

/// Tables of a declared model, besides its lists.
inline constexpr const char* declared_tables[] = {"model", "equations", "define", "coefficients"};
/// Lists of tables of a declared model: [[field]] number n is the table field[n].
inline constexpr const char* declared_lists[] = {"field", "white_noise", "tabulated"};
/// Whether a name is that of a table of such a list.
bool is_in_declared_list(const std::string& name);
bool is_declared_table(const std::string& name);

/// Fills the model of a scene and notes where each number is.
void read_declared(const LocatedTables& tables, DeclaredModel& model, std::map<std::string, SourceLocation>& places);

/// The names of all components, as [initial] and archives have them.
std::vector<std::string> component_names(const DeclaredModel& model);

/// The formulas of a table by key: texts or numbers.  Throws an input Error for another value.
std::map<std::string, model::Text> texts_of(const LocatedTable& table, const std::string& section);

/// The model, without the formulas of its start, as TOML.
std::string declared_text(const DeclaredModel& model);

/// The keys of [model].
std::vector<Description> model_rows();

}  // namespace drover::io
