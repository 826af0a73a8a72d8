// io/scene_parts.hpp: the parts of a scene between TOML tables and values: its model, of a file or declared, its start;
// and a scene from its tables.
#pragma once
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drover/base/schema.hpp"
#include "io/declared_model.hpp"
#include "model/start.hpp"
#include "physics/model_values.hpp"

namespace drover::io {

struct Scene;
enum class SceneKind;

/// A table as a scene is written, with its keys in order: "grid", "terms[2]".
struct WrittenTable {
    std::string name;
    std::vector<std::pair<std::string, Value>> values;
};
using WrittenTables = std::vector<WrittenTable>;

// ---- A model file: sections by the registry of coefficients, terms as text

/// The table of the parameters of text terms.
inline constexpr const char* parameter_table = "terms";
/// What the table of a text term that has parameters has beside its own keys: a key without a place.
inline constexpr const char* parameter_names = "parameter_names";

/// Fills the model from the tables of a scene and notes where each key is.  `[[terms]]` number n is the table terms[n],
/// their parameters the table terms.
void read_model(const LocatedTables& tables, physics::ModelValues& model,
                std::map<std::string, SourceLocation>& locations);

/// The tables that belong to a model, whether or not a scene has them.
bool is_model_table(const std::string& name);

/// The model as tables.
WrittenTables written_model(const physics::ModelValues& model);

// ---- A declared model

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

/// The model, without the formulas of its start, as tables.
WrittenTables written_model(const DeclaredModel& model);

// ---- [initial] of scenes of fields: its keys, and the formulas of components

/// The rows of [initial].  The formulas of rods and beads are keys with a row each, those of a declared model are known
/// from the scene alone.
std::vector<Description> initial_rows(SceneKind kind);

/// The keys of [initial] with their values: those of the rows, and the formulas that a scene of a declared model gives.
std::vector<std::pair<std::string, Value>> initial_values(const model::Start& start, SceneKind kind);

/// Takes the formulas out of the table [initial] into the start of a scene, and notes where its keys are.  Throws an
/// input Error for a key that is neither a row nor a component.
void take_formulas(LocatedTable& table, Scene& scene);

/// Throws an input Error for a key of [initial] that a uniform start, the default, does not read.
void check_unread(const model::Start& start, SceneKind kind, const Locate& locate);

/// Throws an input Error for a stationary start without noise, with the keys of the noise of rods and beads.
void check_noise_of_start(const model::Start& start, const model::Equations& equations, const Locate& locate);

// ---- A scene from its tables

/// The tables of a scene or of a model in TOML; messages call the text `file`.  Throws an input Error at its place for
/// a text that is not TOML, or has what no scene has.
LocatedTables read_tables(const std::string& toml, const std::string& file);

/// Tables with "section.key=value" of each override as a scene, not yet filled from a calibrated table, nor checked.
/// Where an override changes what such a table has to give, the numbers that it gave before are left out.
Scene scene_of(LocatedTables tables, const std::string& name, std::span<const std::string> overrides);

}  // namespace drover::io
