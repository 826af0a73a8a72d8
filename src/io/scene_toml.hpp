// io/scene_toml.hpp: TOML text as the tables of a scene, and settings of its keys.  Reads no file.
#pragma once
#include <span>
#include <string>

#include "io/scene.hpp"

namespace drover::io {

/// The tables of a scene or of a model; messages call the text `file`.  Throws an input Error at its place for a text
/// that is not TOML, or has what no scene has.
LocatedTables read_tables(const std::string& toml, const std::string& file);

/// Tables with "section.key=value" of each override as a scene, not yet filled from a calibrated table, nor checked.
/// Where an override changes what such a table has to give, the numbers that it gave before are left out.
Scene scene_of(LocatedTables tables, const std::string& name, std::span<const std::string> overrides);

}  // namespace drover::io
