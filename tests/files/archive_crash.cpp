// tests/files/archive_crash.cpp: the state of an archive after its writer dies, or the disk fails, at any system call.
//
// This file overrides the C library functions that write to disk.  The overrides behave the same until a trial makes
// the n-th call kill the process or fail.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "files/checkpoint.hpp"
#include "files/support.hpp"

namespace {

enum class Trial {
    none,
    count,     ///< only counts calls and journal bytes
    kill,      ///< the process ends before the call
    torn,      ///< the process ends half-way through a write, or before another call
    power,     ///< as kill; arbitrary parts of the unsynced data are lost
    full_disk  ///< the call, and all later calls that need space, fail: the disk is full
};

/// The content of the disk before an unsynced write.
struct Unsynced {
    int descriptor;
    off_t offset;
    std::string before;
};

struct Faults {
    Trial trial = Trial::none;
    long calls = 0;
    std::size_t journal_bytes = 0;
    long at = -1;                          ///< the call at which it happens
    std::vector<std::string> points = {};  ///< of Trial::count: the calls in order, repetitions left out
    bool fails_reading = false;            ///< every pread
    unsigned dice = 1;                     ///< determines what a power cut loses
    std::vector<Unsynced> unsynced;
    std::vector<std::string> entries_made;                             ///< in a folder that is not yet synced
    std::vector<std::pair<std::string, std::string>> entries_removed;  ///< name, and name of the copy
} faults;

bool lost() {
    faults.dice = faults.dice * 1664525u + 1013904223u;  // Numerical Recipes' quick generator
    return (faults.dice >> 16) % 2 == 0;
}

void cut_power() {
    for (auto one = faults.unsynced.rbegin(); one != faults.unsynced.rend(); ++one)
        if (lost()) ::syscall(SYS_pwrite64, one->descriptor, one->before.data(), one->before.size(), one->offset);
    for (const auto& [name, kept] : faults.entries_removed)
        if (lost()) ::syscall(SYS_rename, kept.c_str(), name.c_str());
    for (const std::string& name : faults.entries_made)
        if (lost()) ::syscall(SYS_unlink, name.c_str());
}

/// Counts a call; returns whether it must fail.
bool strikes(bool needs_room, int descriptor = -1, const void* data = nullptr, size_t size = 0, off_t offset = 0) {
    if (faults.trial == Trial::none) return false;
    const bool is_now = faults.calls++ == faults.at;
    if (faults.trial == Trial::full_disk) return needs_room && faults.calls > faults.at;
    if (!is_now || faults.trial == Trial::count) return false;
    if (faults.trial == Trial::torn && data != nullptr) ::syscall(SYS_pwrite64, descriptor, data, size / 2, offset);
    if (faults.trial == Trial::power) cut_power();
    ::_exit(9);
}

std::string name_of(int descriptor) {
    std::error_code ignored;
    return std::filesystem::read_symlink("/proc/self/fd/" + std::to_string(descriptor), ignored).string();
}

}  // namespace

/// "write archive", "sync journal", "sync folder".
void note(const std::string& call, const std::string& name) {
    if (faults.trial != Trial::count) return;
    const std::string point = call + (std::filesystem::is_directory(name)    ? " folder"
                                      : name.ends_with(".journal")           ? " journal"
                                      : name.find("checkpoint") != name.npos ? " checkpoint"
                                                                             : " archive");
    if (faults.points.empty() || faults.points.back() != point) faults.points.push_back(point);
}

extern "C" {
ssize_t pread(int descriptor, void* data, size_t size, off_t offset) {
    if (faults.fails_reading) return errno = EIO, -1;
    return ::syscall(SYS_pread64, descriptor, data, size, offset);
}

ssize_t pwrite(int descriptor, const void* data, size_t size, off_t offset) {
    if (strikes(true, descriptor, data, size, offset)) return errno = ENOSPC, -1;
    note("write", name_of(descriptor));
    if (faults.trial == Trial::count && name_of(descriptor).ends_with(".journal")) faults.journal_bytes += size;
    if (faults.trial == Trial::power) {
        std::string before(size, '\0');
        ::syscall(SYS_pread64, descriptor, before.data(), size, offset);
        faults.unsynced.push_back({::dup(descriptor), offset, before});
        if (name_of(descriptor).ends_with(".journal")) faults.entries_made.push_back(name_of(descriptor));
    }
    return ::syscall(SYS_pwrite64, descriptor, data, size, offset);
}

int fsync(int descriptor) {
    if (strikes(false)) return -1;
    note("sync", name_of(descriptor));
    struct stat mine {};
    ::fstat(descriptor, &mine);
    if (S_ISDIR(mine.st_mode)) faults.entries_made.clear(), faults.entries_removed.clear();
    std::erase_if(faults.unsynced, [&](const Unsynced& one) {
        struct stat its {};
        ::fstat(one.descriptor, &its);
        return its.st_ino == mine.st_ino;
    });
    return 0;  // the page cache survives the process, which suffices here
}

int posix_fallocate(int descriptor, off_t offset, off_t length) {
    if (strikes(true)) return ENOSPC;
    note("allocate", name_of(descriptor));
    return ::syscall(SYS_fallocate, descriptor, 0, offset, length) == 0 ? 0 : errno;
}

int ftruncate(int descriptor, off_t length) noexcept {
    if (strikes(false)) return -1;
    return static_cast<int>(::syscall(SYS_ftruncate, descriptor, length));
}

int rename(const char* from, const char* to) noexcept {
    if (strikes(false)) return -1;
    note("rename", from);
    return static_cast<int>(::syscall(SYS_rename, from, to));
}

int unlink(const char* name) noexcept {
    if (strikes(false)) return -1;
    note("remove", name);
    if (faults.trial != Trial::power) return static_cast<int>(::syscall(SYS_unlink, name));
    const std::string kept = std::string(name) + ".kept" + std::to_string(faults.calls);
    if (::syscall(SYS_rename, name, kept.c_str()) != 0) return -1;
    faults.entries_removed.emplace_back(name, kept);
    return 0;
}
}

namespace drover::files::archive_crash_tests {
namespace {

using namespace testing_support;

constexpr std::size_t rows_before = 2, commits = 3;

/// Frames of 2 kB to 7 kB, so that each commit both adds and overwrites pages.
std::vector<Recording> crash_recordings() { return sample_recordings(40, 20); }

/// A number shared by a child process with its parent.
std::size_t* shared_number() {
    void* memory = ::mmap(nullptr, sizeof(std::size_t), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    return new (memory) std::size_t(0);
}

/// Continues the archive in a child process that dies at a call; true if it survived.  `done` counts the commits that
/// returned.
bool survives(const std::filesystem::path& file, Trial trial, long at, unsigned dice, std::size_t* done) {
    *done = 0;
    const pid_t child = ::fork();
    if (child == 0) {
        const auto recordings = crash_recordings();
        Archive archive =
            Archive::resume(file, recordings, sample_attributes, std::vector<std::size_t>{rows_before, rows_before});
        faults = {.trial = trial, .at = at, .dice = dice, .unsynced = {}, .entries_made = {}, .entries_removed = {}};
        for (std::size_t commit = 0; commit < commits; ++commit) {
            append_samples(archive, recordings);
            archive.commit();
            ++*done;
        }
        ::_exit(0);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Tries every call in turn; returns their number.
long kill_at_every_call(Trial trial, unsigned dice) {
    const Folder base;
    make_sample(base / "run.h5", rows_before, crash_recordings());
    std::size_t* const done = shared_number();
    for (long at = 0;; ++at) {
        const Folder folder;
        const auto file = folder / "run.h5";
        std::filesystem::copy_file(base / "run.h5", file);
        const bool lived = survives(file, trial, at, dice + static_cast<unsigned>(at), done);
        const std::size_t rows = checked_rows(file, crash_recordings());
        EXPECT_TRUE(rows == rows_before + *done || (rows == rows_before + *done + 1 && !lived))
            << rows << " rows after " << *done << " commits, killed at call " << at;
        EXPECT_FALSE(std::filesystem::exists(folder / "run.h5.journal")) << "killed at call " << at;
        EXPECT_EQ(checked_rows(file, crash_recordings()), rows) << "on a second opening";
        if (lived || ::testing::Test::HasFailure()) return at;
    }
}

/// The calls of `work`, in order.
template <class Work>
std::vector<std::string> points_of(Work work) {
    faults = {.trial = Trial::count, .unsynced = {}, .entries_made = {}, .entries_removed = {}};
    work();
    const std::vector<std::string> points = faults.points;
    faults = {};
    return points;
}

// These are the crash points of src/files/README.md; the tests below end the process at each of them, that is, before
// each call.
TEST(ArchiveCrash, a_commit_makes_the_calls_of_its_protocol_in_their_order) {
    const Folder folder;
    const auto recordings = crash_recordings();
    make_sample(folder / "run.h5", rows_before, recordings);
    Archive archive = Archive::resume(folder / "run.h5", recordings, sample_attributes,
                                      std::vector<std::size_t>{rows_before, rows_before});
    append_samples(archive, recordings);
    EXPECT_EQ(points_of([&] { archive.commit(); }),
              (std::vector<std::string>{"allocate archive", "write archive", "sync archive", "write journal",
                                        "sync journal", "sync folder", "write archive", "sync archive",
                                        "remove journal"}));
    EXPECT_EQ(points_of([&] { write_checkpoint(folder / "run.h5", {.scene = "", .state = {1.0}}); }),
              (std::vector<std::string>{"allocate checkpoint", "write checkpoint", "sync checkpoint",
                                        "rename checkpoint", "sync folder"}));
}

TEST(ArchiveCrash, a_read_that_fails_within_hdf5_is_reported_by_the_commit_and_nothing_is_written) {
    const Folder folder;
    const auto file = folder / "run.h5";
    const auto recordings = crash_recordings();
    make_sample(file, rows_before, recordings);
    const std::string before = contents(file);
    {
        Archive archive =
            Archive::resume(file, recordings, sample_attributes, std::vector<std::size_t>{rows_before, rows_before});
        faults.fails_reading = true;
        const std::string first = sentence_of([&] { append_samples(archive, recordings); });
        faults = {};
        const std::string at_commit = sentence_of([&] { archive.commit(); });
        EXPECT_TRUE(first.empty() || first.find("Input/output error") != first.npos) << first;
        EXPECT_THAT(at_commit, ::testing::HasSubstr("run.h5: the disk reports a failure: read: Input/output error"));
    }
    EXPECT_EQ(contents(file), before);
}

// Each commit writes new pages, allocates, syncs four times and removes its journal: at least 10 calls.
TEST(ArchiveCrash, a_writer_killed_before_any_call_leaves_the_last_commit_or_the_next) {
    EXPECT_GT(kill_at_every_call(Trial::kill, 0), 30);
}

TEST(ArchiveCrash, a_partial_write_leaves_the_last_commit_or_the_next) {
    EXPECT_GT(kill_at_every_call(Trial::torn, 0), 30);
}

TEST(ArchiveCrashLong, a_power_cut_that_loses_any_unsynced_data_leaves_the_last_commit_or_the_next) {
    for (const unsigned dice : {1000u, 2000u, 3000u, 4000u}) EXPECT_GT(kill_at_every_call(Trial::power, dice), 30);
}

TEST(ArchiveCrash, a_disk_that_fills_up_at_any_call_is_a_run_error_and_leaves_the_last_commit_or_the_next) {
    const Folder base;
    const auto recordings = crash_recordings();
    make_sample(base / "run.h5", rows_before, crash_recordings());
    for (long at = 0;; ++at) {
        const Folder folder;
        const auto file = folder / "run.h5";
        std::filesystem::copy_file(base / "run.h5", file);
        std::string sentence, again;
        {
            Archive archive = Archive::resume(file, recordings, sample_attributes,
                                              std::vector<std::size_t>{rows_before, rows_before});
            append_samples(archive, recordings);
            faults = {.trial = Trial::full_disk, .at = at, .unsynced = {}, .entries_made = {}, .entries_removed = {}};
            sentence = sentence_of([&] { archive.commit(); });
            faults = {};
            if (sentence.empty()) break;
            const std::size_t rows =
                checked_rows(file, recordings);  // the writer is open: the journal is read, not applied
            EXPECT_THAT(sentence, ::testing::HasSubstr("run.h5: the disk is full: "));
            const bool waits = sentence.find("the complete commit is in the journal") != std::string::npos;
            EXPECT_EQ(rows, rows_before + (waits ? 1 : 0)) << "full at call " << at;
            EXPECT_EQ(std::filesystem::exists(folder / "run.h5.journal"), waits);
            again = sentence_of([&] { archive.commit(); });
            EXPECT_EQ(again.empty(), !waits) << "there is room again, full at call " << at;
        }
        EXPECT_EQ(checked_rows(file, recordings), rows_before + 1) << "full at call " << at;
        EXPECT_EQ(folder.count(), 1u) << "full at call " << at;
        ASSERT_LT(at, 1000);
    }
}

TEST(ArchiveCrash, a_killed_creation_leaves_no_file_or_a_complete_one_and_does_not_block_the_next) {
    for (long at = 0;; ++at) {
        const Folder folder;
        const pid_t child = ::fork();
        if (child == 0) {
            faults = {.trial = Trial::power, .at = at, .unsynced = {}, .entries_made = {}, .entries_removed = {}};
            const Archive archive = Archive::create(folder / "run.h5", crash_recordings(), sample_attributes, false);
            ::_exit(0);
        }
        int status = -1;
        ::waitpid(child, &status, 0);
        const bool there = std::filesystem::exists(folder / "run.h5");
        if (there) {
            EXPECT_EQ(checked_rows(folder / "run.h5", crash_recordings()), 0u);
        }
        EXPECT_EQ(sentence_of([&] { Archive::create(folder / "run.h5", crash_recordings(), {}, there); }), "");
        if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
        ASSERT_LT(at, 1000);
    }
}

TEST(ArchiveCrash, other_programs_can_open_the_file_when_no_journal_is_left) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder base, all;
    make_sample(base / "run.h5", rows_before, crash_recordings());
    std::size_t* const done = shared_number();
    int without_journal = 0, with_journal = 0;
    for (long at = 0;; ++at) {
        const auto file = all / text("{}.h5", at);
        std::filesystem::copy_file(base / "run.h5", file);
        const bool lived = survives(file, Trial::torn, at, 0, done);
        if (std::filesystem::exists(file.string() + ".journal")) {
            ++with_journal;
            EXPECT_GE(checked_rows(file, crash_recordings()), rows_before + *done);  // which completes or discards it
        } else {
            ++without_journal;
        }
        if (lived) break;
    }
    EXPECT_GT(without_journal, 10);
    EXPECT_GT(with_journal, 10);
    const std::string script = R"(
import glob, h5py, numpy, sys
for name in glob.glob(sys.argv[1] + "/*.h5"):
    with h5py.File(name) as file:
        rows = file["time"].shape[0]
        assert rows >= 2 and file["observables/time"].shape == (rows,), name
        assert numpy.isfinite(file["rod_density"][...]).all() and file["observables/order"][...].shape == (rows,), name
        assert (file["time"][...] == 0.5*numpy.arange(rows)).all(), name
print("all open")
)";
    EXPECT_EQ(python(script, all / "."), "all open\n");
}

TEST(ArchiveCrash, an_invalid_journal_is_discarded) {
    const Folder folder;
    const auto file = folder / "run.h5";
    make_sample(file, rows_before, crash_recordings());
    const std::string before = contents(file);
    for (const std::string& junk : {std::string(), std::string("drvjrnl2"), std::string(5000, 'x')}) {
        write_contents(folder / "run.h5.journal", junk);
        EXPECT_EQ(checked_rows(file, crash_recordings()), rows_before);
        EXPECT_FALSE(std::filesystem::exists(folder / "run.h5.journal"));
        EXPECT_EQ(contents(file), before);
    }
}

TEST(ArchiveCrash, a_frame_of_a_large_run_overwrites_few_pages) {
    const Folder folder;
    auto recordings = sample_recordings(256, 256);
    for (int i = 0; i < 20; ++i) recordings[1].quantities.push_back({text("moment_{}", i), "1", "one of many", {}});
    Archive archive = Archive::create(folder / "run.h5", recordings, sample_attributes, false);
    for (int row = 0; row < 5; ++row) {
        append_samples(archive, recordings);
        archive.commit();
    }
    append_samples(archive, recordings);
    faults = {.trial = Trial::count, .unsynced = {}, .entries_made = {}, .entries_removed = {}};
    archive.commit();
    const std::size_t bytes = faults.journal_bytes;
    faults = {};
    // 26 datasets, each with an object header and a node of its chunk index, each across two pages at most, and the
    // superblock
    EXPECT_LT(bytes, 105u * 4096u);
    EXPECT_GT(bytes, 4096u);
}

}  // namespace
}  // namespace drover::files::archive_crash_tests
