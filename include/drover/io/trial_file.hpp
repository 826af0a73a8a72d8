// io/trial_file.hpp: the durable record of the trials of one assay at one point: a file that grows by whole records.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drover/calibrate/trial_set.hpp"

namespace drover::io {

/// One file, claimed for writing as long as this lives.  A record is on the disk, with its checksum, when append() returns; one that a kill tore is cut
/// off when the file is opened again.
class TrialFile {
public:
    /// Opens a file or makes it.  `identity`: of all that its trials depend on.  Waits a moment for another writer, which may be ending; throws an input
    /// Error when it does not, when the file is not one of trials, or when its trials are of another identity.
    TrialFile(const std::filesystem::path& file, std::uint64_t identity);
    TrialFile(TrialFile&&) noexcept;
    ~TrialFile();

    /// What it held when it was opened, in the order in which they ended.
    const std::vector<calibrate::Attempt>& attempts() const;
    /// Bytes at its end that were no whole record and were cut off.
    std::uint64_t cut() const;

    /// Throws a run Error, with the bytes that were needed and are free, when the disk is full; what it held before stays whole.
    void append(const calibrate::Attempt& attempt);

private:
    struct File;
    std::unique_ptr<File> file_;
};

/// What a file holds now, without claiming it: another may be writing.  Nothing when there is none.  Throws as TrialFile.
std::vector<calibrate::Attempt> read_trials(const std::filesystem::path& file, std::uint64_t identity);

/// What becomes of a trial as bytes, for a pipe; and back.  Throws a run Error for bytes that are none.
std::string attempt_bytes(const calibrate::Attempt& attempt);
calibrate::Attempt attempt_of(const std::string& bytes);

/// A folder for files of trials that belong together, which a text says what they depend on: kept there as `name`, below a line that says which drover made
/// it.  Makes the folder.  Throws an input Error, which says what differs, when it is not empty and holds another text or none.
/// Gives the line of the drover that made it.
std::string claim_folder(const std::filesystem::path& folder, const std::string& name, const std::string& factory,
                         const std::string& content);

/// 64 bits of a text.
std::uint64_t fingerprint(const std::string& words);

/// Writes a whole file beside the old one and puts it in its place.  Throws a run Error, and leaves the old one, when the disk is full.
void replace_file(const std::filesystem::path& file, const std::string& content);

}  // namespace drover::io
