// files/record_bytes.hpp: the bytes of a file of records: "drvtrls1", the hash of the identity, then records: length,
// bytes, checksum.  The first is the content of the identity.
#pragma once
#include <string>
#include <vector>

#include "files/record_identity.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

/// A record with its length and its checksum.
std::vector<std::byte> record_bytes(const std::string& record);

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

}  // namespace drover::files
