// files/system_calls.cpp: system calls with retries and errors.
#include "files/system_calls.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <thread>

#include "base/duration.hpp"
#include "base/log.hpp"

namespace drover::files {
namespace {

[[noreturn]] void fail_call(const char* call, int error) {
    throw std::system_error(error, std::generic_category(), call);
}

/// Repeats a call while signals interrupt it.
template <class Call>
auto uninterrupted(Call call) {
    auto result = call();
    while (result < 0 && errno == EINTR) result = call();
    return result;
}

struct stat stat_of(const Descriptor& open) {
    struct stat status {};
    if (::fstat(open.number(), &status) < 0) fail_call("stat", errno);
    return status;
}

FileState state_of(const struct stat& found) {
    return {.device = found.st_dev,
            .number = found.st_ino,
            .length = static_cast<std::uint64_t>(found.st_size),
            .seconds = found.st_mtim.tv_sec,
            .nanoseconds = found.st_mtim.tv_nsec};
}

// Bytes beyond any file: the writer's lock takes those before commit_byte, and a CommitLock takes commit_byte.
constexpr off_t commit_byte = off_t{1} << 62;

struct flock range(short type, off_t begin, off_t length) {
    return {.l_type = type, .l_whence = SEEK_SET, .l_start = begin, .l_len = length, .l_pid = 0};
}

bool is_without_locks(int error) {
    return error == ENOLCK || error == EOPNOTSUPP || error == ENOSYS || error == EINVAL;
}

/// For a file system without locks: allowed, with a warning for each process, if the user says so.
void require_leave_to_go_without_locks(int file, int error) {
    const std::string name = std::filesystem::read_symlink(text("/proc/self/fd/{}", file)).string();
    const std::string reason = std::generic_category().message(error);
    const char* leave = std::getenv(no_locks_variable);
    require(leave != nullptr && std::string_view(leave) == "1", {name},
            "cannot be locked against a second drover process ({}); choose a folder on another file system, or set "
            "{}=1 and let no other drover process use this folder meanwhile",
            reason, no_locks_variable);
    [[maybe_unused]] static const bool warned = [&] {
        log_warning("{} is written without a lock ({}): let no other drover process use its folder meanwhile", name,
                    reason);
        return true;
    }();
}

bool try_lock(int file, struct flock bytes) {
    if (::fcntl(file, F_OFD_SETLK, &bytes) == 0) return true;
    if (errno == EAGAIN || errno == EACCES) return false;
    if (!is_without_locks(errno)) fail_call("lock", errno);
    require_leave_to_go_without_locks(file, errno);
    return true;
}

}  // namespace

std::filesystem::path folder_of(const std::filesystem::path& file) {
    return file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
}

Descriptor::~Descriptor() {
    if (number_ >= 0) ::close(number_);
}

Descriptor try_open(const std::filesystem::path& file, int flags) {
    require(file.native().find('\0') == std::string::npos, {file.string()},
            "the name of a file has a zero byte; expected one without");
    constexpr mode_t everyone_as_the_umask_allows = 0666;
    // O_NONBLOCK: the opening of a pipe must not wait; it changes nothing for a plain file.
    Descriptor opened(uninterrupted(
        [&] { return ::open(file.c_str(), flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, everyone_as_the_umask_allows); }));
    if (opened.is_open() && opened.number() <= STDERR_FILENO)
        opened = Descriptor(::fcntl(opened.number(), F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
    if (!opened.is_open() && errno != ENXIO) return opened;  // ENXIO: a pipe without a reader
    struct stat status {};
    if (opened.is_open() && ::fstat(opened.number(), &status) < 0) fail_call("stat", errno);
    const bool is_expected = (flags & O_DIRECTORY) != 0 || S_ISREG(status.st_mode);
    require(opened.is_open() && is_expected, {file.string()}, "is not a plain file; expected the name of one");
    return opened;
}

Descriptor open_file(const std::filesystem::path& file, int flags) {
    Descriptor result = try_open(file, flags);
    if (!result.is_open()) fail_call("open", errno);
    return result;
}

std::filesystem::path partial_name(const std::filesystem::path& file) { return file.string() + ".partial"; }

Descriptor create_file(const std::filesystem::path& file) {
    constexpr int exclusively = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW;
    Descriptor created = try_open(file, exclusively);
    if (!created.is_open() && errno == EEXIST) {
        const Descriptor left_over = try_open(file, O_RDWR | O_NOFOLLOW);
        // The lock also excludes a process that has created the file, but not locked it yet.
        if (left_over.is_open() && !(lock_for_writing(left_over) && is_at(left_over, file)))
            throw Error(Fault::unavailable, {file.string()},
                        "another process is writing this file; wait for it, or choose another file");
        remove_if_exists(file);
        created = try_open(file, exclusively);
    }
    if (!created.is_open()) fail_call("open", errno);
    return created;
}

void write_at(const Descriptor& to, std::uint64_t offset, Bytes bytes) {
    while (!bytes.empty()) {
        const auto written = uninterrupted(
            [&] { return ::pwrite(to.number(), bytes.data(), bytes.size(), static_cast<off_t>(offset)); });
        if (written < 0) fail_call("write", errno);
        if (written == 0) fail_call("write", ENOSPC);
        offset += static_cast<std::uint64_t>(written);
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
}

std::size_t read_at(const Descriptor& from, std::uint64_t offset, std::span<std::byte> bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const auto got = uninterrupted([&] {
            return ::pread(from.number(), bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
        });
        if (got < 0) fail_call("read", errno);
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    return done;
}

void allocate(const Descriptor& file, std::uint64_t begin, std::uint64_t end) {
    if (end <= begin) return;
    int error = EINTR;
    while (error == EINTR)
        error = ::posix_fallocate(file.number(), static_cast<off_t>(begin), static_cast<off_t>(end - begin));
    if (error != 0) fail_call("allocate", error);
}

void truncate_to(const Descriptor& file, std::uint64_t length) {
    if (uninterrupted([&] { return ::ftruncate(file.number(), static_cast<off_t>(length)); }) < 0)
        fail_call("truncate", errno);
}

void sync(const Descriptor& file) {
    if (uninterrupted([&] { return ::fsync(file.number()); }) < 0) fail_call("sync", errno);
}

void sync_folder_of(const std::filesystem::path& file) {
    const Descriptor folder = open_file(folder_of(file), O_RDONLY | O_DIRECTORY);
    const int result = uninterrupted([&] { return ::fsync(folder.number()); });
    if (result < 0 && errno != EINVAL) fail_call("sync of the folder", errno);  // EINVAL: a file system without it
}

void rename_over(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (::rename(from.c_str(), to.c_str()) < 0) fail_call("rename", errno);
}

void remove_if_exists(const std::filesystem::path& file) {
    if (::unlink(file.c_str()) < 0 && errno != ENOENT) fail_call("remove", errno);
}

bool link_to(const Descriptor& open, const std::filesystem::path& from, const std::filesystem::path& name) {
    if (::link(from.c_str(), name.c_str()) == 0) return true;
    const int error = errno;
    if (is_at(open, name)) return true;
    if (error == EEXIST) return false;
    require(error != EPERM && error != EOPNOTSUPP && error != ENOSYS && error != EMLINK,
            {.file = folder_of(name).string()},
            "the file system does not support hard links, by which processes claim a folder and its work (link: {}); "
            "choose a folder on another file system: a local disk, NFS, Lustre or BeeGFS",
            std::generic_category().message(error));
    fail_call("link", error);
}

void touch(const Descriptor& open) {
    if (::futimens(open.number(), nullptr) < 0) fail_call("setting the time", errno);
}

std::uint64_t length_of(const Descriptor& file) { return static_cast<std::uint64_t>(stat_of(file).st_size); }

FileState state_of(const std::filesystem::path& file) {
    struct stat found {};
    if (::stat(file.c_str(), &found) < 0) return {};
    return state_of(found);
}

FileState state_of(const Descriptor& open) { return state_of(stat_of(open)); }

Named named(const Descriptor& open, const std::filesystem::path& file) {
    const struct stat mine = stat_of(open);
    struct stat there {};
    if (::stat(file.c_str(), &there) < 0) {
        if (errno != ENOENT && errno != ENOTDIR) fail_call("stat", errno);
        return Named::nothing;
    }
    const bool is_same = mine.st_ino == there.st_ino && mine.st_dev == there.st_dev;
    return is_same ? Named::this_file : Named::another_file;
}

std::uint64_t link_count(const Descriptor& open) { return stat_of(open).st_nlink; }

std::filesystem::path name_of(const Descriptor& open) {
    std::error_code unknown;
    const auto name = std::filesystem::read_symlink(text("/proc/self/fd/{}", open.number()), unknown);
    return is_at(open, name) ? name : std::filesystem::path();
}

bool is_at(const Descriptor& open, const std::filesystem::path& file) {
    struct stat mine {
    }, there{};
    return ::fstat(open.number(), &mine) == 0 && ::stat(file.c_str(), &there) == 0 && mine.st_ino == there.st_ino &&
           mine.st_dev == there.st_dev;
}

std::optional<std::vector<std::byte>> read_file(const std::filesystem::path& file) {
    const Descriptor from = try_open(file, O_RDONLY);
    if (!from.is_open() && errno == ENOENT) return std::nullopt;
    if (!from.is_open()) fail_call("open", errno);
    const std::uint64_t length = length_of(from);
    const std::uint64_t memory = memory_available();
    require(length <= memory / 2, {file.string()},
            "the file has {}, more than half of the {} of free memory; expected a smaller file",
            bytes_text(static_cast<double>(length)), bytes_text(static_cast<double>(memory)));
    std::vector<std::byte> bytes(static_cast<std::size_t>(length));
    bytes.resize(read_at(from, 0, bytes));
    return bytes;
}

bool lock_for_writing(const Descriptor& file) { return try_lock(file.number(), range(F_WRLCK, 0, commit_byte)); }

bool has_locks(const Descriptor& file) {
    struct flock found = range(F_RDLCK, 0, commit_byte);
    return ::fcntl(file.number(), F_OFD_GETLK, &found) == 0 || std::getenv(no_locks_variable) == nullptr;
}

bool has_writer(const Descriptor& file) {
    struct flock found = range(F_RDLCK, 0, commit_byte);
    return ::fcntl(file.number(), F_OFD_GETLK, &found) < 0 || found.l_type != F_UNLCK;
}

CommitLock::CommitLock(const Descriptor& file, Side side, std::chrono::milliseconds patience) : file_(file.number()) {
    const struct flock byte = range(side == Side::reader ? F_RDLCK : F_WRLCK, commit_byte, 1);
    const auto end = Clock::now() + patience;
    for (;;) {
        struct flock wanted = byte;
        is_held_ = ::fcntl(file_, F_OFD_SETLK, &wanted) == 0;
        const bool is_taken = !is_held_ && (errno == EAGAIN || errno == EACCES);  // else: a file system without locks
        if (!is_taken || Clock::now() >= end) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

CommitLock::~CommitLock() {
    struct flock byte = range(F_UNLCK, commit_byte, 1);
    if (is_held_) ::fcntl(file_, F_OFD_SETLK, &byte);
}

std::string draw_run_id() {
    std::array<unsigned char, 16> bits{};
    if (::getentropy(bits.data(), bits.size()) < 0) fail_call("drawing random bits", errno);
    std::string digits;
    for (const unsigned char byte : bits) digits += text("{:02x}", byte);
    return digits;
}

Fault fault_of(const std::system_error& cause) {
    switch (cause.code().value()) {
        case EACCES:
        case EISDIR:
        case ELOOP:
        case ENAMETOOLONG:
        case ENOENT:
        case ENOTDIR:
        case EPERM:
        case EROFS: return Fault::unavailable;
        default: return Fault::environment;
    }
}

Error disk_failure(const std::filesystem::path& file, const std::system_error& cause) {
    return Error(Fault::environment, {file.string()},
                 text("the disk reports a failure: {}; nothing was changed; check the disk, then run the same command "
                      "again",
                      std::string(cause.what())));
}

Error access_failure(const std::filesystem::path& file, const std::system_error& cause, std::string_view what,
                     std::string_view advice) {
    const int error = cause.code().value();
    const bool is_of_disk = error == EIO || error == ESTALE || error == ETIMEDOUT || error == EREMOTEIO;
    if (is_of_disk) return disk_failure(file, cause);
    return Error(fault_of(cause), {file.string()}, text("{}: {}; {}", what, std::string(cause.what()), advice));
}

Error write_failure(const std::filesystem::path& file, const std::system_error& cause, std::uint64_t needed,
                    std::string_view consequence) {
    constexpr const char* again = "run the same command again; a run with a checkpoint resumes by drover restart";
    const int error = cause.code().value();
    const bool is_full = error == ENOSPC || error == EDQUOT || error == EFBIG;
    if (!is_full) {
        const bool is_of_process = error == EMFILE || error == ENFILE;
        return Error(Fault::environment, {file.string()},
                     text("cannot write: {}; {}; {}, then {}", std::string(cause.what()), consequence,
                          is_of_process ? "close files or raise the limit (ulimit -n)" : "check the disk", again));
    }
    struct statvfs disk {};
    const bool is_known = ::statvfs(folder_of(file).c_str(), &disk) == 0;
    const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
    const char* what = error == ENOSPC   ? "the disk is full"
                       : error == EDQUOT ? "the disk quota is used up"
                                         : "the largest file size allowed (ulimit -f) is reached";
    return Error(Fault::environment, {file.string()},
                 text("{}: {} were needed and {} are free; {}; {}, then {}", what,
                      bytes_text(static_cast<double>(needed)), is_known ? bytes_text(free) : std::string("?"),
                      consequence, error == EFBIG ? "raise this limit" : "make room", again));
}

}  // namespace drover::files
