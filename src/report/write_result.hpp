// report/write_result.hpp: a result as an archive, and such an archive as text.
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

/// Whether an archive is that of a result, by its title, and not that of a run or a table.
bool is_result(const files::ArchiveReader& archive);

std::vector<files::StoredArray> arrays_by_path(const files::ArchiveReader& archive);

/// All arrays of an archive for people: a single number with its value, others with their shape and range.
std::string stored_text(const files::ArchiveReader& archive);

}  // namespace drover::report
