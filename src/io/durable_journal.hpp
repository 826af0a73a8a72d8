// io/durable_journal.hpp: the journal beside a file, by which many writes to it become one.
//
// The journal holds every byte that a commit is about to overwrite in the file.  It is whole on the disk before the first of
// them is touched and is removed after the last is there.  So whoever finds a whole journal writes it out (again), and whoever
// finds a broken one throws it away: the file is as the last commit left it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "io/durable.hpp"

namespace drover::io {

struct Patch {
    std::uint64_t offset = 0;
    std::vector<std::byte> bytes;
};

struct Journal {
    std::uint64_t length = 0;  ///< of the file afterwards; the file is at least as long before
    std::vector<Patch> patches;
};

std::filesystem::path journal_of(const std::filesystem::path& file);

std::vector<std::byte> encoded(const Journal& journal);

/// Nothing unless the bytes are a whole journal for a file that is now file_length bytes long.
std::optional<Journal> decoded(Bytes bytes, std::uint64_t file_length);

/// Makes the journal durable under its name.
void write_journal(const std::filesystem::path& file, Bytes journal);

/// Writes the patches to the file, durably.  May be done any number of times.
void apply(const Journal& journal, const Descriptor& file);

/// Applies a whole journal beside the file, then removes it, whole or broken.  The file must be locked for writing.
void recover(const Descriptor& open, const std::filesystem::path& file);

/// The whole journal beside a file that may not be written; nothing when there is none.
std::optional<Journal> read_journal(const Descriptor& open, const std::filesystem::path& file);

}  // namespace drover::io
