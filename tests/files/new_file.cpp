// tests/files/new_file.cpp: files that appear under their name only when they are complete.
#include "drover/files/new_file.hpp"

#include <gtest/gtest.h>

#include "files/support.hpp"

namespace drover::files {
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

}  // namespace
}  // namespace drover::files
