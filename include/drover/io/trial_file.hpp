// io/trial_file.hpp: the durable record of the trials of one assay at one point.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drover/calibrate/trial_set.hpp"
#include "drover/files/record_file.hpp"

namespace drover::io {

/// A files::RecordFile whose records are trials; see there for locking, durability and errors.
class TrialFile {
public:
    /// Opens or creates a file.
    TrialFile(const std::filesystem::path& file, const files::RecordIdentity& identity);

    /// The trials found at opening, in the order in which they ended.
    const std::vector<calibrate::Attempt>& attempts() const;
    /// Bytes of an incomplete record that were cut off the end at opening.
    std::uint64_t cut() const;

    void append(const calibrate::Attempt& attempt);

private:
    files::RecordFile file_;
    std::vector<calibrate::Attempt> attempts_;
};

/// The trials that a file holds now, without locking it: another process may be writing.  None if there is no file.
std::vector<calibrate::Attempt> read_trials(const std::filesystem::path& file, const files::RecordIdentity& identity);

/// A trial as bytes for a pipe, with a checksum; and back.  Throws a run Error for other bytes.
std::string attempt_bytes(const calibrate::Attempt& attempt);
calibrate::Attempt attempt_of(const std::string& bytes);

}  // namespace drover::io
