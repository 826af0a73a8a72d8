// tests/files/checkpoint.cpp: checkpoints: round trip, damage, a full disk.
#include "files/checkpoint.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include <limits>

#include "files/support.hpp"

namespace drover::files::checkpoint_tests {
namespace {

using namespace testing_support;
using ::testing::AllOf;
using ::testing::HasSubstr;

Checkpoint sample_checkpoint(std::int64_t step) {
    return {.scene = "title = \"λ\"\n",
            .step = step,
            .time = 0.1 * static_cast<double>(step),
            .rows = {3, 40},
            .state = numbers(50, static_cast<double>(step)),
            .run_id = "90f3a1",
            .program = "0.1.0 (b7)",
            .row_checksums = {1, ~std::uint64_t{0}}};
}

void expect_same(const Checkpoint& found, const Checkpoint& expected) {
    EXPECT_EQ(found.scene, expected.scene);
    EXPECT_EQ(found.step, expected.step);
    EXPECT_EQ(found.time, expected.time);
    EXPECT_EQ(found.rows, expected.rows);
    EXPECT_EQ(found.state, expected.state);
    EXPECT_EQ(found.run_id, expected.run_id);
    EXPECT_EQ(found.program, expected.program);
    EXPECT_EQ(found.row_checksums, expected.row_checksums);
}

/// The newest checkpoint, and the warning at its reading.
struct Taken {
    Checkpoint checkpoint;
    std::string warning;
};

Taken take(const std::filesystem::path& archive) {
    ::testing::internal::CaptureStderr();
    Checkpoint checkpoint = read_newest_checkpoint(archive);
    return {std::move(checkpoint), ::testing::internal::GetCapturedStderr()};
}

/// The bytes of a checkpoint file with some of them replaced.
std::string with(std::string bytes, std::size_t place, const std::string& other) {
    return bytes.replace(place, other.size(), other);
}

TEST(Checkpoint, a_checkpoint_reads_back_bitwise_identical) {
    const Folder folder;
    Checkpoint odd = sample_checkpoint(1);
    odd.state = {-0.0, std::numeric_limits<double>::denorm_min(), std::numeric_limits<double>::max(), 0.1};
    odd.rows = {};
    odd.scene = std::string("a\0b", 3);
    write_checkpoint(folder / "run.h5", odd);
    const Checkpoint found = read_newest_checkpoint(folder / "run.h5");
    expect_same(found, odd);
    EXPECT_TRUE(std::signbit(found.state[0]));
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Checkpoint, the_newer_of_two_is_read_and_the_older_overwritten) {
    const Folder folder;
    for (const std::int64_t step : {10, 20, 30, 40, 50}) {
        write_checkpoint(folder / "run.h5", sample_checkpoint(step));
        expect_same(read_newest_checkpoint(folder / "run.h5"), sample_checkpoint(step));
        EXPECT_EQ(folder.count(), step == 10 ? 1u : 2u);
    }
    std::filesystem::remove(checkpoint_files(folder / "run.h5")[0]);  // the fifth
    expect_same(read_newest_checkpoint(folder / "run.h5"), sample_checkpoint(40));
}

TEST(Checkpoint, of_two_at_the_same_step_the_one_written_last_is_read) {
    const Folder folder;
    for (const double time : {1.0, 2.0, 3.0, 4.0}) {
        Checkpoint checkpoint = sample_checkpoint(10);
        checkpoint.time = time;
        write_checkpoint(folder / "run.h5", checkpoint);
        EXPECT_EQ(read_newest_checkpoint(folder / "run.h5").time, time);
    }
}

TEST(Checkpoint, damage_to_any_byte_of_the_newest_falls_back_to_the_other_with_a_warning) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    write_checkpoint(archive, sample_checkpoint(10));
    write_checkpoint(archive, sample_checkpoint(20));
    const auto newest = checkpoint_files(archive)[1];
    const std::string whole = contents(newest);
    for (std::size_t place = 0; place < whole.size(); ++place) {
        write_contents(newest, with(whole, place, std::string(1, static_cast<char>(whole[place] ^ 4))));
        const Taken taken = take(archive);
        EXPECT_EQ(taken.checkpoint.step, 10) << "byte " << place;
        EXPECT_THAT(taken.warning,
                    AllOf(HasSubstr("run.h5.checkpoint-b: "), HasSubstr("using the other one, of step 10")));
    }
    write_contents(newest, whole);
    const Taken taken = take(archive);
    expect_same(taken.checkpoint, sample_checkpoint(20));
    EXPECT_EQ(taken.warning, "");
}

TEST(Checkpoint, each_kind_of_damage_has_its_own_message) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    write_checkpoint(archive, sample_checkpoint(10));
    const auto file = checkpoint_files(archive)[0];
    const std::string whole = contents(file);
    const auto sentence = [&](const std::string& bytes) {
        write_contents(file, bytes);
        return sentence_of([&] { read_newest_checkpoint(archive); });
    };
    EXPECT_THAT(sentence(""), HasSubstr("is not a checkpoint of drover"));
    EXPECT_THAT(sentence(with(whole, 0, "HDF")), HasSubstr("is not a checkpoint of drover"));
    EXPECT_THAT(sentence(with(whole, 8, "\x7")), HasSubstr("is a checkpoint of version 7; expected version 2"));
    EXPECT_THAT(sentence(whole.substr(0, 100)), HasSubstr(text("has 100 bytes; expected {}", whole.size())));
    EXPECT_THAT(sentence(whole + "more"), HasSubstr(text("has {} bytes; expected {}", whole.size() + 4, whole.size())));
    EXPECT_THAT(sentence(with(whole, 12, std::string(8, '\xff'))), HasSubstr("expected 18446744073709551615"));
    EXPECT_THAT(sentence(with(whole, 60, "?")), HasSubstr("has a wrong checksum"));
}

TEST(Checkpoint, a_truncated_file_is_rejected) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    write_checkpoint(archive, sample_checkpoint(10));
    const std::string whole = contents(checkpoint_files(archive)[0]);
    for (std::size_t length = 0; length < whole.size(); length += 3) {
        write_contents(checkpoint_files(archive)[0], whole.substr(0, length));
        EXPECT_THAT(sentence_of([&] { read_newest_checkpoint(archive); }), HasSubstr("has no valid checkpoint"))
            << length;
    }
}

TEST(Checkpoint, two_damaged_checkpoints_are_an_input_error_that_names_both) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    for (const std::int64_t step : {10, 20}) write_checkpoint(archive, sample_checkpoint(step));
    for (const auto& file : checkpoint_files(archive)) write_contents(file, "no checkpoint");
    try {
        read_newest_checkpoint(archive);
        FAIL() << "expected an Error";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        EXPECT_THAT(error.what(), AllOf(HasSubstr("checkpoint-a: is not"), HasSubstr("checkpoint-b: is not")));
    }
}

TEST(Checkpoint, no_checkpoint_is_an_input_error_with_the_names_looked_for) {
    const Folder folder;
    EXPECT_THAT(sentence_of([&] { read_newest_checkpoint(folder / "run.h5"); }),
                AllOf(HasSubstr("run.h5: has no checkpoint; expected "), HasSubstr("run.h5.checkpoint-a or ")));
}

TEST(Checkpoint, a_damaged_checkpoint_is_overwritten_first_and_the_newest_never_touched) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    for (const std::int64_t step : {10, 20}) write_checkpoint(archive, sample_checkpoint(step));
    const auto files = checkpoint_files(archive);
    write_contents(files[1], with(contents(files[1]), 40, "?"));
    const std::string kept = contents(files[0]);
    ::testing::internal::CaptureStderr();
    write_checkpoint(archive, sample_checkpoint(30));
    EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("checkpoint-b: has a wrong checksum"));
    EXPECT_EQ(contents(files[0]), kept);
    EXPECT_EQ(take(archive).checkpoint.step, 30);
}

TEST(Checkpoint, temporary_files_of_a_killed_write_are_ignored_and_removed) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    for (const auto& file : checkpoint_files(archive))
        write_contents(file.string() + ".partial", std::string(9999, 'x'));
    for (const std::int64_t step : {10, 20}) write_checkpoint(archive, sample_checkpoint(step));
    expect_same(take(archive).checkpoint, sample_checkpoint(20));
    write_contents(checkpoint_files(archive)[0].string() + ".partial", "x");
    remove_checkpoints(archive);
    remove_checkpoints(archive);  // their absence is not an error
    EXPECT_EQ(folder.count(), 0u);
}

TEST(Checkpoint, a_full_disk_is_an_error_of_the_environment_and_leaves_both_unchanged) {
    const Folder folder;
    const auto archive = folder / "run.h5";
    for (const std::int64_t step : {10, 20}) write_checkpoint(archive, sample_checkpoint(step));
    const pid_t child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        const struct rlimit limit { 200, RLIM_INFINITY };
        ::setrlimit(RLIMIT_FSIZE, &limit);
        try {
            write_checkpoint(archive, sample_checkpoint(30));
            ADD_FAILURE() << "expected an Error";
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::environment);
            EXPECT_THAT(error.what(),
                        AllOf(HasSubstr("run.h5.checkpoint-a: the largest file size allowed"),
                              HasSubstr(" were needed and "), HasSubstr("the previous checkpoint is still valid")));
        }
        ::_exit(HasFailure() ? 1 : 0);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    EXPECT_EQ(folder.count(), 2u);
    expect_same(take(archive).checkpoint, sample_checkpoint(20));
    std::filesystem::remove(checkpoint_files(archive)[1]);
    expect_same(take(archive).checkpoint, sample_checkpoint(10));
}

}  // namespace
}  // namespace drover::files::checkpoint_tests
