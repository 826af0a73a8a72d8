// files/input_file.hpp: checked reads of files by others: plain files only, every read checked, sizes bounded.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "files/system_calls.hpp"

namespace drover::files {

// An Error of these functions is an input Error for a file that does not exist, is no plain file or is too large, an
// unavailable one without the permission to read it, and an environment one when a read fails.  `expected` ends its
// sentence: "a scene in TOML".

/// The content of a file of at most max_bytes.
std::string read_text(const std::filesystem::path& file, const std::string& expected,
                      std::uint64_t max_bytes = 1 << 24);

/// The first `count` bytes, fewer of a shorter file; "" if there is no plain file of this name or it may not be read.
/// Throws an environment Error when a read fails.
std::string read_start(const std::filesystem::path& file, std::size_t count);

/// Of all its bytes.
std::uint64_t file_checksum(const std::filesystem::path& file, const std::string& expected);

/// A file of any length, line by line.
class LineReader {
public:
    LineReader(const std::filesystem::path& file, const std::string& expected);

    /// The next line without its end; false at the end of the file.  Rejects a line of more than 1 MiB.
    bool next(std::string& line);

private:
    bool fill();

    std::filesystem::path file_;
    Descriptor from_;
    std::uint64_t offset_ = 0;  ///< of the next block
    std::string block_;
    std::size_t done_ = 0;  ///< bytes of the block that were returned
    int number_ = 0;        ///< of the last line
};

}  // namespace drover::files
