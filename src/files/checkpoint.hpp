// files/checkpoint.hpp: the state of a run, from which it resumes to bitwise identical results.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace drover::files {

struct Checkpoint {
    std::string scene;                              ///< resolved scene text
    std::int64_t step = 0;                          ///< completed steps
    double time = 0.0;                              ///< [s]
    std::vector<std::uint64_t> rows;                ///< rows of each recording of the archive at this step
    std::vector<double> state;                      ///< the stepper's state, in the model's layout
    std::string run_id = {};                        ///< of the archive; empty if that has none
    std::string program = {};                       ///< version and commit of the drover that wrote it
    std::vector<std::uint64_t> row_checksums = {};  ///< of the archive at this step
};

/// The two files of a run: "flock.h5" has flock.h5.checkpoint-a and flock.h5.checkpoint-b; beside the file itself when
/// the name is a symbolic link.
std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& archive);
/// Throws an unavailable Error where their names are too long for the disk.
void require_checkpoint_names(const std::filesystem::path& archive, const SourceLocation& where);
/// Whether one of them exists.
bool has_checkpoint(const std::filesystem::path& archive);

/// Writes a temporary file, syncs it, renames it over the older of the two and syncs the folder; never touches the
/// newer one.  Throws a run Error with the bytes needed and free when the disk is full.
void write_checkpoint(const std::filesystem::path& archive, const Checkpoint& checkpoint);

/// The latest valid checkpoint.  Logs a warning that names a damaged one (checksum, length, version).  Throws an input
/// Error, with the names looked for, when there is none.
Checkpoint read_newest_checkpoint(const std::filesystem::path& archive);

/// Removes both and their temporary files, if they exist.
void remove_checkpoints(const std::filesystem::path& archive);

}  // namespace drover::files
