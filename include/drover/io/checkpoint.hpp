// io/checkpoint.hpp: the state of a run from which it goes on to the same bytes.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace drover::io {

struct Checkpoint {
    std::string scene;                ///< resolved scene text
    std::int64_t step = 0;            ///< steps done
    double time = 0.0;                ///< [s]
    std::vector<std::uint64_t> rows;  ///< rows of each recording of the archive at this step
    std::vector<double> state;        ///< the stepper's state, as the model lays it out
};

/// The two files of a run: "flock.h5" has flock.h5.checkpoint-a and flock.h5.checkpoint-b.
std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& archive);

/// Writes beside, closes, syncs, renames over the older of the two, syncs the folder: the newer one is never touched.
/// Throws a run Error with the bytes needed and free when the disk is full.
void write_checkpoint(const std::filesystem::path& archive, const Checkpoint& checkpoint);

/// The newest of the two that is whole.  A damaged one (checksum, length, version) is told in a warning that names it.  Throws
/// an input Error when there is none, saying what was looked for.
Checkpoint read_newest_checkpoint(const std::filesystem::path& archive);

/// Removes both and their leftovers, if they exist.
void remove_checkpoints(const std::filesystem::path& archive);

}  // namespace drover::io
