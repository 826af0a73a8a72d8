// io/scene_text.hpp: scenes (input files) from their text and the files that it names: a model, a table of
// coefficients.
#pragma once
#include <filesystem>
#include <span>
#include <string>

#include "io/scene.hpp"

namespace drover::io {

/// Reads a scene file, applies "section.key=value" of each override, fills in the calibrated table and checks the
/// result. Throws an input Error with file:line:column and a suggested fix.
Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides = {});

/// The same from a text; messages call it `name`.  `functions`: those that its terms name.
Scene parse_scene(const std::string& toml, const std::string& name, std::span<const std::string> overrides = {},
                  const physics::TermFunctions& functions = {});

/// A scene with "section.key=value" of each change, checked as one that is read.
Scene changed(const Scene& scene, const std::vector<std::string>& overrides);

/// The scene in an archive, to read the archive: its terms may be functions that this program does not have.
Scene archived_scene(const std::string& toml, const std::string& name);

}  // namespace drover::io
