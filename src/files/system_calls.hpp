// files/system_calls.hpp: the system calls that make a file durable, with every failure as an exception.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/memory.hpp"
#include "drover/base/error.hpp"

namespace drover::files {

using Bytes = std::span<const std::byte>;

/// An owning file descriptor; -1 if there is none.
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

// Unless documented otherwise, these functions throw std::system_error with the name of the failing call.

/// Returns a closed descriptor, with errno set, when the file cannot be opened.  Never returns 0, 1 or 2, the standard
/// streams, even if they are closed.  Throws an input Error when the file is not a plain file (or, with O_DIRECTORY,
/// not a folder): a pipe would wait for its other end.
Descriptor try_open(const std::filesystem::path& file, int flags);
Descriptor open_file(const std::filesystem::path& file, int flags);

/// A new file of this process alone, open for reading and writing.  What has the name is removed first: what a killed
/// process left, or a link, never what that leads to.  Throws an input Error when another process has locked it for
/// writing.
Descriptor create_file(const std::filesystem::path& file);

std::filesystem::path folder_of(const std::filesystem::path& file);  ///< "." for a name alone

/// The name under which a new file is written before it takes the name `file`.
std::filesystem::path partial_name(const std::filesystem::path& file);

void write_at(const Descriptor& to, std::uint64_t offset, Bytes bytes);

/// Bytes read: fewer than asked only at the end of the file.
std::size_t read_at(const Descriptor& from, std::uint64_t offset, std::span<std::byte> bytes);

/// Allocates the disk blocks of [begin, end), so that a later write there cannot fail on a full disk.
void allocate(const Descriptor& file, std::uint64_t begin, std::uint64_t end);
void truncate_to(const Descriptor& file, std::uint64_t length);
void sync(const Descriptor& file);
void sync_folder_of(const std::filesystem::path& file);
void rename_over(const std::filesystem::path& from, const std::filesystem::path& to);
void remove_if_exists(const std::filesystem::path& file);
/// Removes a file at the end of a scope, unless it is not needed any more; what it meets is ignored.
struct Cleanup {
    std::filesystem::path file;
    bool is_needed = true;
    ~Cleanup() {
        std::error_code ignored;
        if (is_needed) std::filesystem::remove(file, ignored);
    }
};
/// A second name of an open file; false when that name is taken by another file, on NFS too: a server that has made the
/// link may report, to a request that was repeated, that the name is taken.  Throws an input Error where the file
/// system has no such names.
bool link_to(const Descriptor& open, const std::filesystem::path& from, const std::filesystem::path& name);
/// Sets the time of an open file to that of the file server.
void touch(const Descriptor& open);
std::uint64_t length_of(const Descriptor& file);

/// What changes when a file is written, replaced or removed.  File times advance in steps of some milliseconds.
struct FileState {
    std::uint64_t device = 0, number = 0, length = 0;
    std::int64_t seconds = 0, nanoseconds = 0;
    bool operator==(const FileState&) const = default;
};
FileState state_of(const std::filesystem::path& file);  ///< all zero if there is none
FileState state_of(const Descriptor& open);

/// What a name refers to, beside an open file.
enum class Named { nothing, this_file, another_file };
Named named(const Descriptor& open, const std::filesystem::path& file);

/// Number of hard links of an open file.
std::uint64_t link_count(const Descriptor& open);
/// A name that the open file has now; empty if that is not known.
std::filesystem::path name_of(const Descriptor& open);

/// Whether the name `file` still refers to the open file.
bool is_at(const Descriptor& open, const std::filesystem::path& file);

/// The content of a file; nothing if it does not exist.  Throws an input Error when it is larger than half of the free
/// memory.
std::optional<std::vector<std::byte>> read_file(const std::filesystem::path& file);

// Locks are fcntl locks on the open file description, not flock: HDF5 readers take a flock, and a writer must not block
// them.

/// Set to 1, it allows writing on a file system without locks.
inline constexpr const char* no_locks_variable = "DROVER_NO_LOCKS";

/// Locks a file for writing until its descriptor closes; false when another writer has locked it.  On a file system
/// without locks throws an input Error, or warns and returns true where no_locks_variable allows it.
bool lock_for_writing(const Descriptor& file);
/// Whether another descriptor has it, or may have it on a file system without locks.
bool has_writer(const Descriptor& file);
/// Whether its file system has locks at all, or the user has not said that it has none.
bool has_locks(const Descriptor& file);

/// The wait of a commit: a reader that was stopped must not stop the run.
inline constexpr std::chrono::milliseconds patience_with_readers(200);

/// Excludes commits by others while it lives (a reader), or readers (a commit).  Waits for the other side no longer
/// than `patience`; is_held() is false when that was too short, and on a file system without locks.
class CommitLock {
public:
    enum class Side { reader, commit };
    CommitLock(const Descriptor& file, Side side, std::chrono::milliseconds patience);
    ~CommitLock();
    CommitLock(const CommitLock&) = delete;
    CommitLock& operator=(const CommitLock&) = delete;
    bool is_held() const { return is_held_; }

private:
    int file_;
    bool is_held_ = false;
};

/// 128 random bits of the kernel as hexadecimal digits.  A run id is drawn once for each archive that a run creates; a
/// restart keeps it.
std::string draw_run_id();

/// The kind of the Error for a failed call: unavailable where another name, folder or permission would help, else
/// environment.
Fault fault_of(const std::system_error& cause);

/// The environment Error for a failed read, and for any other failed call that writes nothing.
Error disk_failure(const std::filesystem::path& file, const std::system_error& cause);

/// The Error for a file that cannot be used: disk_failure where the disk itself, or the server behind it, failed; else
/// "cannot be read: <the failed call>; expected a checkpoint".
Error access_failure(const std::filesystem::path& file, const std::system_error& cause, std::string_view what,
                     std::string_view advice);

/// The environment Error for a failed write; reports a full disk explicitly, with the bytes needed and free.
/// consequence: the state after the failure, such as "the file stays as it was at the last commit".
Error write_failure(const std::filesystem::path& file, const std::system_error& cause, std::uint64_t needed,
                    std::string_view consequence);

}  // namespace drover::files
