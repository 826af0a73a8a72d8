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
#include <string>
#include <vector>

#include "files/system_calls.hpp"

namespace drover::files {

struct Patch {
    std::uint64_t offset = 0;
    std::vector<std::byte> bytes;
};

/// How a file and its last commit are recognised without HDF5: by the id of its run, and by its first sector, which is
/// written as a whole and changes with the length of the file.
struct FileMark {
    std::string run_id;        ///< "" if the file has none
    std::uint64_t offset = 0;  ///< of the run id in the file; commits do not move it
    std::uint64_t head = 0;    ///< checksum of the first sector
};
inline constexpr std::size_t sector_bytes = 512;

/// Bytes of a file as text; fewer at its end.
std::string text_at(const Descriptor& file, std::uint64_t offset, std::size_t size);
/// Checksum of the first sector.
std::uint64_t head_of(const Descriptor& file);

struct Journal {
    std::uint64_t length = 0;  ///< of the file after the commit; at most its length before
    std::vector<Patch> patches;
    FileMark before = {};          ///< of the file that it is for
    std::uint64_t head_after = 0;  ///< of the same file after the commit
};

std::filesystem::path journal_of(const std::filesystem::path& file);

std::vector<std::byte> encoded(const Journal& journal);

/// Nothing unless the bytes are a complete journal.
std::optional<Journal> decoded(Bytes bytes);

/// Makes the journal durable under its name.
void write_journal(const std::filesystem::path& file, Bytes journal);

/// Writes the patches to the file, durably.  Idempotent.
void apply(const Journal& journal, const Descriptor& file);

/// Applies the journal beside the file if it is complete, then removes it.  The file must be locked for writing.  Both
/// throw an input Error for a complete journal of another file, or of another commit of this one.
void recover(const Descriptor& open, const std::filesystem::path& file);

/// The complete journal beside a file that may not be written; nothing if there is none.
std::optional<Journal> read_journal(const Descriptor& open, const std::filesystem::path& file);

}  // namespace drover::files
