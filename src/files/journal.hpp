// files/journal.hpp: the redo journal beside a file, which makes a commit of many writes atomic.
//
// The journal holds every byte that a commit will overwrite in the file.  It is complete on the disk before the first
// of them is overwritten and is removed after the last.  A process that finds a complete journal applies it (again);
// one that finds an incomplete journal discards it: the file is then as the last commit left it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "files/system_calls.hpp"

namespace drover::files {

struct Patch {
    std::uint64_t offset = 0;
    std::vector<std::byte> bytes;
};

struct Journal {
    std::uint64_t length = 0;  ///< of the file after the commit; at most its length before
    std::vector<Patch> patches;
};

std::filesystem::path journal_of(const std::filesystem::path& file);

std::vector<std::byte> encoded(const Journal& journal);

/// Nothing unless the bytes are a complete journal for a file that is now file_length bytes long.
std::optional<Journal> decoded(Bytes bytes, std::uint64_t file_length);

/// Makes the journal durable under its name.
void write_journal(const std::filesystem::path& file, Bytes journal);

/// Writes the patches to the file, durably.  Idempotent.
void apply(const Journal& journal, const Descriptor& file);

/// Applies the journal beside the file if it is complete, then removes it.  The file must be locked for writing.
void recover(const Descriptor& open, const std::filesystem::path& file);

/// The complete journal beside a file that may not be written; nothing if there is none.
std::optional<Journal> read_journal(const Descriptor& open, const std::filesystem::path& file);

}  // namespace drover::files
