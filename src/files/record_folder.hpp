// files/record_folder.hpp: what records depend on, and the first difference of two such texts; records that many
// processes append in one folder, each to a file of its own.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "files/system_calls.hpp"

namespace drover::files {

/// What the records of a file depend on.
struct RecordIdentity {
    std::uint64_t hash = 0;  ///< of all of it
    std::string content;     ///< scene text of which the file keeps a copy, to name a difference
};

/// A key of two scene texts whose values differ, and these; none where a text lacks the key.
struct TextDifference {
    std::string key;
    std::optional<std::string> one, other;
};
/// One of the values, for people.
inline std::string shown(const std::optional<std::string>& value) { return value.value_or("absent"); }

/// In the order of `one`, then those that it lacks.
std::vector<TextDifference> differences(const std::string& one, const std::string& other);
std::optional<TextDifference> first_difference(const std::string& one, const std::string& other);

/// Whether the values of two scene texts are the same, where a key that one of them lacks has its value in `defaults`.
bool are_same(const std::string& one, const std::string& other, const std::string& defaults);

/// 64-bit hash of a text.
std::uint64_t fingerprint(const std::string& content);

/// Of the records of a job, such as "sweep", which depend on this text alone.
RecordIdentity identity_of(const std::string& job, const std::string& content);

// The bytes of a file of records: "drvtrls1", the hash of the identity, then records: length, bytes, checksum.  The
// first is the content of the identity.

/// A file without records.
std::vector<std::byte> start_of(const RecordIdentity& identity);

struct RecordContent {
    std::string of;  ///< the content of the identity; "" if the file has none
    std::vector<std::string> records;
    std::uint64_t valid_bytes = 0;  ///< of the head and of complete records
};

/// The complete records that follow one another from the front of some bytes.
RecordContent records_in(Bytes bytes);

/// Of a whole file.  A truncated head is valid: a kill interrupted the creation of the file.  Throws an input Error for
/// another file, and one of another identity.
RecordContent content_of(Bytes bytes, const RecordIdentity& identity, const std::string& file);

/// Of the words that claim a folder: the name of the program that claimed it.
std::string first_line(const std::string& words);

/// The first difference of two identities, "a = 1 there, 2 here"; "" if there is none.
std::string difference(const std::string& there, const std::string& here);

/// The records of a folder.  No file is written by two processes, so that none needs a lock, and what a killed process
/// has left half written is passed over.
class RecordFolder {
public:
    /// Creates the folder if there is none.  `name` begins the name of this process's file, "share-0003".
    RecordFolder(const std::filesystem::path& folder, const RecordIdentity& identity, const std::string& name);

    /// The complete records that other processes have appended since the last call, all at first: file by file in the
    /// order of their names, in each in the order in which they were appended.  Throws an input Error for a file that
    /// is not one of records, and, with the first difference, for one of another identity.
    std::vector<std::string> read_new();

    /// A kill of this process does not lose the record when this returns, and a power cut does not after the next
    /// sync().  Throws an environment Error, with the bytes needed and free, when the disk is full; earlier records
    /// stay valid.
    void append(const std::string& record);
    void sync();

private:
    void read_file_from(const std::filesystem::path& file, std::uint64_t& done, std::vector<std::string>& records);

    std::filesystem::path folder_;
    RecordIdentity identity_;
    std::filesystem::path own_file_;
    Descriptor own_;
    std::uint64_t end_ = 0;
    bool is_durable_ = true;
    std::map<std::filesystem::path, std::uint64_t> read_;  ///< bytes of complete records, by file
};

/// Takes part in a folder of files that depend on the same text, `content`, which is kept in the folder as `name` below
/// a first line, `factory`, that names the drover that made it; "": no such line.  Any number of processes may, at a
/// time, and none needs a lock.  Returns the first line.  Throws an input Error when the folder is not empty and holds
/// no such file, or, with the first difference, another content.
std::string join_folder(const std::filesystem::path& folder, const std::string& name, const std::string& factory,
                        const std::string& content);

/// Throws an input Error where files in this folder cannot be locked, as archives are, unless the user allows that.
void require_locks(const std::filesystem::path& file_in_it);

}  // namespace drover::files
