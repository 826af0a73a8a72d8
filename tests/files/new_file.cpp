// tests/files/new_file.cpp: files that appear under their name only when they are complete.
#include "files/new_file.hpp"

#include <gtest/gtest.h>

#include "files/checkpoint.hpp"
#include "files/support.hpp"

namespace drover::files::new_file_tests {
namespace {

using namespace testing_support;

TEST(NewFile, an_unfinished_file_leaves_the_old_one_and_nothing_else) {
    const Folder folder;
    write_contents(folder / "run.xyz", "old");
    { NewFile(folder / "run.xyz").write("new"); }
    EXPECT_EQ(contents(folder / "run.xyz"), "old");
    EXPECT_EQ(folder.count(), 1u);
}

TEST(NewFile, a_finished_file_holds_its_parts_in_order) {
    const Folder folder;
    NewFile file(folder / "run.xyz");
    for (const char* part : {"one ", "", "two"}) file.write(part);
    EXPECT_FALSE(std::filesystem::exists(folder / "run.xyz"));
    file.finish();
    EXPECT_EQ(contents(folder / "run.xyz"), "one two");
    EXPECT_EQ(folder.count(), 1u);
}

TEST(NewFile, a_folder_that_does_not_exist_is_an_input_error) {
    const Folder folder;
    EXPECT_THAT(sentence_of([&] { NewFile(folder / "no/run.xyz"); }),
                ::testing::HasSubstr("cannot be written: open: No such file or directory; expected a file in a"));
}

TEST(NewFile, a_replaced_file_has_the_new_content) {
    const Folder folder;
    for (const std::string content : {"first", "second", ""}) {
        replace_file(folder / "table.toml", content);
        EXPECT_EQ(contents(folder / "table.toml"), content);
        EXPECT_EQ(folder.count(), 1u);
    }
}

TEST(NewFile, of_two_that_are_written_to_one_name_at_a_time_the_first_to_start_fails_and_none_is_torn) {
    const Folder folder;
    NewFile first(folder / "table.toml");
    first.write("first");
    replace_file(folder / "table.toml", "second");
    EXPECT_THAT(sentence_of([&] { first.finish(); }), ::testing::HasSubstr("another process wrote this file"));
    NewFile slow(folder / "table.toml");
    slow.write("slow");
    NewFile fast(folder / "table.toml");
    fast.write("fast");
    EXPECT_THAT(sentence_of([&] { slow.finish(); }), ::testing::HasSubstr("another process wrote this file"));
    fast.finish();
    EXPECT_EQ(contents(folder / "table.toml"), "fast");
}

/// Puts a link to a file of the user at a name that drover is about to create, runs `work`, and checks the file.
template <class Work>
void expect_link_not_followed(const std::filesystem::path& name, Work work) {
    const Folder other;
    for (const bool exists : {true, false}) {
        if (exists) write_contents(other / "diary.txt", "dear diary");
        else std::filesystem::remove(other / "diary.txt");
        std::filesystem::remove(name);
        std::filesystem::create_symlink(other / "diary.txt", name);
        work();
        EXPECT_EQ(std::filesystem::exists(other / "diary.txt"), exists) << name;
        EXPECT_EQ(contents(other / "diary.txt"), exists ? "dear diary" : "") << name;
    }
}

TEST(NewFile, a_link_at_a_temporary_name_is_replaced_and_not_followed) {
    const Folder folder;
    expect_link_not_followed(folder / "run.xyz.partial", [&] {
        NewFile file(folder / "run.xyz");
        file.write("new");
        file.finish();
        EXPECT_EQ(contents(folder / "run.xyz"), "new");
    });
    expect_link_not_followed(folder / "table.toml.partial", [&] { replace_file(folder / "table.toml", "new"); });
    expect_link_not_followed(folder / "run.h5.partial", [&] {
        Archive::create(folder / "run.h5", sample_recordings(), {}, true);
        checked_rows(folder / "run.h5", sample_recordings());
    });
    for (int writes = 0; writes < 2; ++writes)
        expect_link_not_followed(checkpoint_files(folder / "run.h5")[0].string() + ".partial", [&] {
            write_checkpoint(folder / "run.h5", {.scene = "", .state = {1.0}});
            std::filesystem::remove(checkpoint_files(folder / "run.h5")[1]);
            EXPECT_EQ(read_newest_checkpoint(folder / "run.h5").state.size(), 1u);
            std::filesystem::remove(checkpoint_files(folder / "run.h5")[0]);
        });
    Archive archive = Archive::create(folder / "run.h5", sample_recordings(), {}, true);
    expect_link_not_followed(folder / "run.h5.journal", [&] {
        append_samples(archive, sample_recordings());
        archive.commit();
    });
    EXPECT_EQ(checked_rows(folder / "run.h5", sample_recordings()), 2u);
}

TEST(NewFile, two_processes_do_not_mix_what_they_write) {
    const Folder folder;
    NewFile first(folder / "run.xyz"), second(folder / "run.xyz");
    first.write("first");
    second.write("sec");
    EXPECT_THAT(sentence_of([&] { first.finish(); }), ::testing::HasSubstr("another process wrote this file"));
    second.write("ond");
    second.finish();
    EXPECT_EQ(contents(folder / "run.xyz"), "second");
}

}  // namespace
}  // namespace drover::files::new_file_tests
