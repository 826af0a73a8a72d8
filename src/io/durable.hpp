// io/durable.hpp: the few system calls by which a file becomes durable, each failing loudly.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::io {

using Bytes = std::span<const std::byte>;

/// An open file descriptor that closes itself; -1 when there is none.
class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : number_(number) {}
    Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept {
        std::swap(number_, other.number_);
        return *this;
    }
    ~Descriptor();
    int number() const { return number_; }
    bool is_open() const { return number_ >= 0; }

private:
    int number_ = -1;
};

// All of these throw std::system_error with the failing call in its text, unless they say otherwise.

/// A descriptor that is not open, with errno set, when the file cannot be opened.
Descriptor try_open(const std::filesystem::path& file, int flags);
Descriptor open_file(const std::filesystem::path& file, int flags);

void write_at(const Descriptor& to, std::uint64_t offset, Bytes bytes);

/// Bytes read: fewer than asked only at the end of the file.
std::size_t read_at(const Descriptor& from, std::uint64_t offset, std::span<std::byte> bytes);

/// Takes the disk blocks of [begin, end), so that writing there later cannot find the disk full.
void allocate(const Descriptor& file, std::uint64_t begin, std::uint64_t end);
void truncate_to(const Descriptor& file, std::uint64_t length);
void sync(const Descriptor& file);
void sync_folder_of(const std::filesystem::path& file);
void rename_over(const std::filesystem::path& from, const std::filesystem::path& to);
void remove_if_there(const std::filesystem::path& file);
std::uint64_t length_of(const Descriptor& file);

/// Whether the name `file` still leads to the open file.
bool is_at(const Descriptor& open, const std::filesystem::path& file);

/// The whole file; nothing when there is none.  Throws an input Error when it is larger than half of the free memory.
std::optional<std::vector<std::byte>> read_whole(const std::filesystem::path& file);

/// Claims a file for writing until its descriptor closes; false when another writer has it.  The lock is one of fcntl's on
/// the open file description and not a flock: flock is what HDF5 takes to read, and a writer must not shut readers out.
bool lock_for_writing(const Descriptor& file);

/// Bytes of memory that can be taken without harm, as the system tells; a large number when it does not.
std::uint64_t memory_available();

/// The run Error for a write that failed: a full disk is told with the bytes needed and free.
/// consequence: what the failure leaves behind, "the file stays as it was at the last commit".
Error write_failure(const std::filesystem::path& file, const std::system_error& cause, std::uint64_t needed,
                    std::string_view consequence);

}  // namespace drover::io
