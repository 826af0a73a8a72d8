// io/scene_initial.hpp: [initial] of scenes of fields: its keys, and the formulas of components.
#pragma once
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drover/base/schema.hpp"
#include "model/start.hpp"

namespace drover::io {

/// Whose components have formulas: those of rods and beads are keys with a row each, those of a declared model are
/// known from the scene alone.
enum class FormulasOf { rod_bead, declared };

/// The initial state where a scene has no [initial].
model::Start start_without_keys(FormulasOf of);

/// The rows of [initial].
std::vector<Description> initial_rows(FormulasOf of);

/// The keys of [initial] with their values: those of the rows, and the formulas that a scene of a declared model gives.
std::vector<std::pair<std::string, Value>> initial_values(const model::Start& start, FormulasOf of);

/// Takes the formulas out of the table [initial], and notes where its keys are.  declared: the components of a declared
/// model; nullptr: rods and beads.  Throws an input Error for a key that is neither a row nor a component.
LocatedTable take_formulas(LocatedTable& table, const std::vector<std::string>* declared,
                           std::map<std::string, SourceLocation>& places);

/// Throws an input Error for a key of [initial] that a uniform start, the default, does not read.
void check_unread(const model::Start& start, FormulasOf of, const Locate& locate);

/// Throws an input Error for a stationary start without noise, with the keys of the noise of rods and beads.
void check_noise_of_start(const model::Start& start, const model::Equations& equations, const Locate& locate);

}  // namespace drover::io
