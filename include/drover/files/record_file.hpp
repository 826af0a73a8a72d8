// files/record_file.hpp: a durable file of trials that grows by complete records of bytes; and the folder of such
// files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "drover/files/record_identity.hpp"

namespace drover::files {

/// One file of trials, locked for writing while this object lives.  A record is on the disk, with its checksum, when
/// append() returns; a record torn by a kill is cut off when the file is next opened.
class RecordFile {
public:
    /// Opens or creates a file.  Waits up to two seconds for another writer, which may be exiting.  Throws an input
    /// Error if that writer stays, if the file is not a file of trials, or if its identity differs; it names the first
    /// difference where the file has the content, which those of earlier versions of drover calibrate have not.
    RecordFile(const std::filesystem::path& file, const RecordIdentity& identity);
    RecordFile(RecordFile&&) noexcept;
    ~RecordFile();

    /// The records found at opening, in the order in which they were appended.
    const std::vector<std::string>& records() const;
    /// Bytes of an incomplete record that were cut off the end at opening.
    std::uint64_t cut() const;

    /// Throws a run Error, with the bytes needed and free, when the disk is full; earlier records stay valid.
    void append(const std::string& record);

private:
    struct File;
    std::unique_ptr<File> file_;
};

/// The records that a file holds now, without locking it: another process may be writing.  None if there is no file.
/// Throws as RecordFile does.
std::vector<std::string> read_records(const std::filesystem::path& file, const RecordIdentity& identity);

/// A folder in use.
struct ClaimedFolder {
    std::string first_line;      ///< of the file that claims it
    std::shared_ptr<void> lock;  ///< nobody else can claim the folder while this and its copies in child processes live
};

/// Creates or reuses a folder of files that depend on the same text, `content`, which is kept in the folder as `name`
/// below a first line, `factory`, that names the drover that made it; "": no such line.  Waits up to two seconds for
/// another process.  Throws an input Error when the folder is not empty and holds no such file or another content; it
/// names the first difference.
ClaimedFolder claim_folder(const std::filesystem::path& folder, const std::string& name, const std::string& factory,
                           const std::string& content);

}  // namespace drover::files
