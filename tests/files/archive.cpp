// tests/files/archive.cpp: tests of the writer: rows, commits, resuming, results, a full disk.
#include "files/archive.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>

#include "files/support.hpp"
#include "files/system_calls.hpp"

namespace drover::files::archive_tests {
namespace {

using namespace testing_support;
using ::testing::AllOf;
using ::testing::HasSubstr;

ResultTable sample_results(double first) {
    const Axis box{"box", "mm", "side of a box", numbers(3)};
    return {"/summary",
            {box},
            {{"order_mean", "1", "mean of the order", {}}, {"number_variance", "1", "variance in boxes", {"box"}}},
            {{first}, numbers(3, first)}};
}

TEST(Archive, committed_rows_read_back_unchanged) {
    const Folder folder;
    make_sample(folder / "run.h5", 6);
    EXPECT_EQ(checked_rows(folder / "run.h5", sample_recordings()), 6u);
    const ArchiveReader reader(folder / "run.h5");
    EXPECT_EQ(reader.shape("/rod_density"), (std::vector<std::size_t>{6, 4, 5}));
    EXPECT_EQ(reader.read("/x").values, numbers(5, 0.5));
    EXPECT_EQ(reader.text_attribute("Conventions"), "CF-1.8");
    EXPECT_EQ(reader.attributes().size(), sample_attributes.size() + 1);
    for (const Attribute& attribute : sample_attributes)
        EXPECT_THAT(reader.attributes(), ::testing::Contains(attribute));
}

TEST(Archive, uncommitted_rows_do_not_reach_the_file) {
    const Folder folder;
    const auto recordings = sample_recordings();
    make_sample(folder / "run.h5", 2);
    const std::string before = contents(folder / "run.h5");
    {
        Archive archive =
            Archive::resume(folder / "run.h5", recordings, sample_attributes, std::vector<std::size_t>{2, 2});
        for (int i = 0; i < 50; ++i) append_samples(archive, recordings);
        archive.replace(sample_results(1.0));
        EXPECT_EQ(contents(folder / "run.h5"), before);
    }
    EXPECT_EQ(contents(folder / "run.h5"), before);
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Archive, an_existing_file_is_rejected_and_unchanged) {
    const Folder folder;
    write_contents(folder / "run.h5", "precious");
    EXPECT_THAT(sentence_of([&] { Archive::create(folder / "run.h5", sample_recordings(), {}, false); }),
                HasSubstr("run.h5: exists already; choose another name"));
    EXPECT_EQ(contents(folder / "run.h5"), "precious");
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Archive, overwriting_replaces_the_file_and_removes_its_journal) {
    const Folder folder;
    make_sample(folder / "run.h5", 3);
    write_contents(folder / "run.h5.journal", "of the old file");
    Archive archive = Archive::create(folder / "run.h5", sample_recordings(), {}, true);
    EXPECT_EQ(checked_rows(folder / "run.h5", sample_recordings()), 0u);
    EXPECT_EQ(folder.count(), 1u);
}

TEST(Archive, a_file_that_cannot_be_created_is_an_input_error_and_leaves_nothing) {
    const Folder folder;
    EXPECT_THAT(sentence_of([&] { Archive::create(folder / "no/run.h5", sample_recordings(), {}, false); }),
                HasSubstr("cannot be written: open: No such file or directory; expected"));
    auto recordings = sample_recordings();
    recordings[1].quantities[1].name = "shell";
    EXPECT_THAT(sentence_of([&] { Archive::create(folder / "run.h5", recordings, {}, false); }),
                HasSubstr("group /observables has two datasets named shell"));
    EXPECT_EQ(folder.count(), 0u);
}

TEST(Archive, a_second_writer_is_rejected_while_the_first_is_open) {
    const Folder folder;
    const auto recordings = sample_recordings();
    const std::vector<std::size_t> none{0, 0};
    {
        const Archive first = Archive::create(folder / "run.h5", recordings, {}, false);
        EXPECT_THAT(sentence_of([&] { Archive::resume(folder / "run.h5", recordings, {}, none); }),
                    HasSubstr("run.h5: another process is writing this file; wait for it"));
        EXPECT_THAT(sentence_of([&] { Archive::create(folder / "run.h5", recordings, {}, true); }),
                    HasSubstr("another process is writing this file"));
        try {
            Archive::create(folder / "run.h5", recordings, {}, true);
            FAIL();
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::unavailable);  // a campaign tries it again
        }
    }
    EXPECT_EQ(sentence_of([&] { Archive::resume(folder / "run.h5", recordings, {}, none); }), "");
}

TEST(Archive, a_run_resumed_from_fewer_rows_ends_with_identical_data) {
    const Folder folder;
    const auto recordings = sample_recordings();
    make_sample(folder / "whole.h5", 9);
    make_sample(folder / "resumed.h5", 7);
    {
        Archive archive = Archive::resume(folder / "resumed.h5", recordings, {{"seed", std::int64_t{8}}},
                                          std::vector<std::size_t>{7, 7});
        archive.replace(sample_results(1.0));
        archive.commit();
    }
    {
        const std::vector<Attribute> anew{{"seed", std::int64_t{9}}};
        Archive archive = Archive::resume(folder / "resumed.h5", recordings, anew, std::vector<std::size_t>{5, 5});
        for (int row = 5; row < 9; ++row) append_samples(archive, recordings), archive.commit();
    }
    EXPECT_EQ(checked_rows(folder / "resumed.h5", recordings), 9u);
    const ArchiveReader whole(folder / "whole.h5"), resumed(folder / "resumed.h5");
    for (const std::string name : {"/time", "/x", "/y", "/rod_density", "/polar_order_x", "/observables/time",
                                   "/observables/shell", "/observables/order", "/observables/spectrum_density"}) {
        EXPECT_EQ(whole.shape(name), resumed.shape(name)) << name;
        EXPECT_EQ(whole.read(name).values, resumed.read(name).values) << name;
    }
    EXPECT_FALSE(resumed.has("/summary/order_mean")) << "results of rows that were cut";
    EXPECT_EQ(resumed.attributes(),
              (std::vector<Attribute>{{"Conventions", std::string("CF-1.8")}, {"seed", std::int64_t{9}}}));
}

TEST(Archive, rows_cut_from_a_partial_chunk_leave_nothing_behind) {
    const Folder folder;
    const auto recordings = sample_recordings();
    make_sample(folder / "run.h5", 7);  // observables: a complete chunk of 4 rows, and 3 rows
    {
        Archive archive = Archive::resume(folder / "run.h5", recordings, {}, std::vector<std::size_t>{2, 6});
        EXPECT_EQ(archive.rows(), (std::vector<std::size_t>{2, 6}));
        archive.commit();
    }
    const ArchiveReader reader(folder / "run.h5");
    EXPECT_EQ(reader.shape("/time"), (std::vector<std::size_t>{2}));
    EXPECT_EQ(reader.shape("/observables/order"), (std::vector<std::size_t>{6}));
    EXPECT_EQ(reader.read_row("/observables/spectrum_density", 5).values, sample_array(recordings, 1, 1, 5));
}

TEST(Archive, resuming_the_archive_of_another_scene_is_an_input_error) {
    const Folder folder;
    make_sample(folder / "run.h5", 2);
    const auto why_no_error = [&](const std::vector<Recording>& recordings, std::size_t rows) {
        return sentence_of([&] {
            Archive::resume(folder / "run.h5", recordings, {}, std::vector<std::size_t>{rows, rows});
        });
    };
    EXPECT_THAT(why_no_error(sample_recordings(), 3),
                HasSubstr("/time has 2 rows; expected at least the 3 of the checkpoint"));
    EXPECT_THAT(why_no_error(sample_recordings(6, 4), 2), HasSubstr("/x has other coordinates than this scene"));
    auto recordings = sample_recordings();
    recordings[0].quantities[0].unit = "m-2";
    EXPECT_THAT(why_no_error(recordings, 2), HasSubstr("/rod_density has the unit mm-2; expected m-2"));
    recordings = sample_recordings();
    recordings[0].quantities[0].axes = {"y"};
    EXPECT_THAT(why_no_error(recordings, 2), HasSubstr("/rod_density has the shape (2, 4, 5); expected (2, 4)"));
    recordings = sample_recordings();
    recordings[1].quantities[0].name = "disorder";
    EXPECT_THAT(why_no_error(recordings, 2),
                HasSubstr("has no /observables/disorder; expected an archive of the same scene"));
    EXPECT_EQ(why_no_error(sample_recordings(), 2), "");
}

TEST(Archive, resuming_a_single_precision_file_is_an_input_error) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    make_sample(folder / "run.h5", 2);
    ASSERT_EQ(python(R"(
import h5py, sys
with h5py.File(sys.argv[1], "r+") as file:
    rounded = file["rod_density"][...].astype("f4")
    del file["rod_density"]
    file.create_dataset("rod_density", data=rounded, chunks=(1, 4, 5), maxshape=(None, 4, 5))
)",
                     folder / "run.h5"),
              "");
    EXPECT_THAT(sentence_of([&] {
                    Archive::resume(folder / "run.h5", sample_recordings(), {}, std::vector<std::size_t>{2, 2});
                }),
                HasSubstr("/rod_density holds neither float64 nor int64 numbers"));
}

TEST(Archive, results_replace_those_of_the_same_name) {
    const Folder folder;
    Archive archive = Archive::create(folder / "run.h5", sample_recordings(), {}, false);
    for (const double first : {1.0, 2.0, 5.0}) {
        archive.replace(sample_results(first));
        archive.commit();
        const ArchiveReader reader(folder / "run.h5");
        EXPECT_EQ(reader.read("/summary/order_mean").values, (std::vector<double>{first}));
        EXPECT_EQ(reader.shape("/summary/order_mean"), (std::vector<std::size_t>{}));
        EXPECT_EQ(reader.read("/summary/number_variance").values, numbers(3, first));
    }
}

TEST(Archive, a_non_ascii_text_above_64_kilobytes_survives_a_resume) {
    const Folder folder;
    std::string scene;
    while (scene.size() < 300000) scene += "# λ = 3 µm, Γ ≥ 0\n";
    const std::vector<Attribute> attributes{{"scene", scene}, {"empty", std::string()}};
    const auto recordings = sample_recordings();
    { const Archive made = Archive::create(folder / "run.h5", recordings, attributes, false); }
    EXPECT_EQ(ArchiveReader(folder / "run.h5").text_attribute("scene"), scene);
    EXPECT_EQ(ArchiveReader(folder / "run.h5").text_attribute("empty"), "");
    Archive::resume(folder / "run.h5", recordings, attributes, std::vector<std::size_t>{0, 0}).commit();
    EXPECT_EQ(ArchiveReader(folder / "run.h5").text_attribute("scene"), scene);
}

TEST(Archive, the_same_run_writes_the_same_bytes) {
    const Folder folder;
    make_sample(folder / "a.h5", 6);
    make_sample(folder / "b.h5", 6);
    EXPECT_EQ(contents(folder / "a.h5"), contents(folder / "b.h5"));
}

/// Runs `work` in a child process with a file size limit; 0 if all expectations held.
template <class Work>
int status_under_file_limit(std::uintmax_t bytes, Work work) {
    const pid_t child = ::fork();
    if (child == 0) {
        std::signal(SIGXFSZ, SIG_IGN);
        struct rlimit limit {};
        ::getrlimit(RLIMIT_FSIZE, &limit);
        limit.rlim_cur = bytes;
        ::setrlimit(RLIMIT_FSIZE, &limit);
        work();
        ::_exit(::testing::Test::HasFailure() ? 1 : 0);
    }
    int status = -1;
    ::waitpid(child, &status, 0);
    return status;
}

TEST(Archive, a_full_disk_leaves_the_last_commit_and_the_run_continues_once_there_is_space) {
    const Folder folder;
    const auto file = folder / "run.h5";
    const auto recordings = sample_recordings();
    make_sample(file, 2);
    const auto size = std::filesystem::file_size(file);
    const int status = status_under_file_limit(size + 10000, [&] {
        Archive archive = Archive::resume(file, recordings, sample_attributes, std::vector<std::size_t>{2, 2});
        for (int i = 0; i < 100; ++i) append_samples(archive, recordings);
        const std::string sentence = sentence_of([&] { archive.commit(); });
        EXPECT_THAT(sentence, AllOf(HasSubstr("run.h5: the largest file size allowed (ulimit -f) is reached: "),
                                    HasSubstr(" were needed and "), HasSubstr(" are free; the file stays as it was")));
        EXPECT_EQ(std::filesystem::file_size(file), size);
        EXPECT_EQ(checked_rows(file, recordings), 2u);
        struct rlimit room {};
        ::getrlimit(RLIMIT_FSIZE, &room);
        room.rlim_cur = room.rlim_max;
        ::setrlimit(RLIMIT_FSIZE, &room);
        EXPECT_EQ(sentence_of([&] { archive.commit(); }), "");
        EXPECT_EQ(checked_rows(file, recordings), 102u);
    });
    EXPECT_EQ(status, 0);
    EXPECT_EQ(checked_rows(file, recordings), 102u);
}

TEST(Archive, a_full_disk_at_creation_leaves_nothing) {
    const Folder folder;
    const int status = status_under_file_limit(4096, [&] {
        EXPECT_THAT(sentence_of([&] { Archive::create(folder / "run.h5", sample_recordings(), {}, false); }),
                    HasSubstr("the new file is not kept"));
    });
    EXPECT_EQ(status, 0);
    EXPECT_EQ(folder.count(), 0u);
}

TEST(Archive, the_checksums_of_the_last_rows_are_those_of_what_was_appended) {
    const Folder folder;
    const auto recordings = sample_recordings();
    std::vector<std::vector<std::uint64_t>> written;
    {
        Archive archive = Archive::create(folder / "run.h5", recordings, sample_attributes, false);
        EXPECT_EQ(archive.row_checksums(), (std::vector<std::uint64_t>{0, 0}));
        for (int row = 0; row < 3; ++row) {
            append_samples(archive, recordings);
            written.push_back(archive.row_checksums());
        }
        archive.commit();
    }
    EXPECT_NE(written[0], written[1]);
    for (const std::size_t rows : {3u, 2u}) {
        const Archive archive =
            Archive::resume(folder / "run.h5", recordings, sample_attributes, std::vector<std::size_t>{rows, rows});
        EXPECT_EQ(archive.row_checksums(), written[rows - 1]);
    }
}

TEST(Archive, a_run_id_stays_when_a_run_is_resumed_and_a_check_may_reject_the_archive) {
    const Folder folder;
    const auto recordings = sample_recordings();
    const std::string id = draw_run_id();
    EXPECT_THAT(id, ::testing::MatchesRegex("[0-9a-f]{32}"));
    EXPECT_NE(draw_run_id(), id);
    std::vector<Attribute> attributes = sample_attributes;
    attributes.emplace_back(run_id_name, id);
    { Archive::create(folder / "run.h5", recordings, attributes, false).commit(); }
    const std::string before = contents(folder / "run.h5");
    const std::vector<std::size_t> none{0, 0};
    EXPECT_EQ(sentence_of([&] {
                  Archive::resume(folder / "run.h5", recordings, sample_attributes, none,
                                  [](const ArchiveReader& reader) { fail_input({}, "{}", run_id_of(reader)); });
              }),
              id);
    EXPECT_EQ(contents(folder / "run.h5"), before);
    for (int times = 0; times < 3; ++times) {
        Archive archive = Archive::resume(folder / "run.h5", recordings, sample_attributes, none);
        append_samples(archive, recordings);
        archive.commit();
        EXPECT_EQ(run_id_of(ArchiveReader(folder / "run.h5")), id);
    }
    { Archive::create(folder / "old.h5", recordings, sample_attributes, false).commit(); }
    EXPECT_EQ(run_id_of(ArchiveReader(folder / "old.h5")), "");
}

}  // namespace
}  // namespace drover::files::archive_tests
