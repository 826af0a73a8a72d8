// run/write_result.hpp: a result as an archive.
#pragma once
#include <filesystem>
#include <string>

#include "drover/io/scene.hpp"
#include "drover/run/result.hpp"

namespace drover::run {

/// Writes the archive of a result with its provenance; `what`: "stability", "boundary".  Throws as
/// files::Archive::create.
void write_result(const Result& result, const std::filesystem::path& file, const std::string& what,
                  const io::Scene& scene, int threads, bool overwrite);

}  // namespace drover::run
