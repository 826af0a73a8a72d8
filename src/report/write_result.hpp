// report/write_result.hpp: a result as an archive.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::report {

/// Throws as check_output: for the start of a command, before it computes the result.  `inputs`: beside those of the
/// scene.
void check_result_file(const std::filesystem::path& file, std::vector<std::filesystem::path> inputs,
                       const io::Scene& scene, bool overwrite);

/// Writes the archive of a result with its provenance; `what`: "stability", "boundary".  The file appears when it is
/// complete.  Throws as check_result_file and files::write_archive.
void write_result(const run::Result& result, const std::filesystem::path& file, const std::string& what,
                  const io::Scene& scene, int threads, bool overwrite);

}  // namespace drover::report
