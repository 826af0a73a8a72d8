// tests/files/record_folder.cpp: records of many writers in one folder, and the text that claims it.
#include "files/record_folder.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include "base/refusal.hpp"
#include "files/support.hpp"

namespace drover::files::record_folder_tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;
using testing_support::Folder;

const RecordIdentity identity{5, "[run]\nseed = 1\n"};

std::filesystem::path only_file(const std::filesystem::path& folder) {
    return std::filesystem::directory_iterator(folder)->path();
}

TEST(RecordFolder, each_process_reads_what_the_others_append_once_and_not_its_own) {
    const Folder folder;
    RecordFolder one(folder / "records", identity, "share-1"), other(folder / "records", identity, "share-2");
    EXPECT_TRUE(std::filesystem::is_empty(folder / "records"));  // no file before the first record
    one.append("a");
    other.append("b");
    EXPECT_THAT(one.read_new(), ElementsAre("b"));
    EXPECT_THAT(one.read_new(), IsEmpty());
    other.append("c");
    other.append("");
    EXPECT_THAT(one.read_new(), ElementsAre("c", ""));
    EXPECT_THAT(other.read_new(), ElementsAre("a"));
    RecordFolder later(folder / "records", identity, "share-1");  // the same share again: a file of its own
    EXPECT_THAT(later.read_new(), UnorderedElementsAre("a", "b", "c", ""));
    later.append("d");
    EXPECT_THAT(one.read_new(), ElementsAre("d"));
}

TEST(RecordFolder, a_record_torn_at_any_byte_is_passed_over_until_it_is_complete) {
    const Folder folder;
    {
        RecordFolder writer(folder / "records", identity, "share-1");
        writer.append("first");
        writer.append("second");
    }
    const auto file = only_file(folder / "records");
    const auto whole = std::filesystem::file_size(file);
    std::string bytes(whole, '\0');
    std::ifstream(file, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(whole));
    RecordFolder reader(folder / "records", identity, "share-2");  // one that looks again as the file grows
    std::vector<std::string> seen;
    for (std::size_t length = 0; length <= whole; ++length) {
        std::ofstream(file, std::ios::binary | std::ios::trunc)
            .write(bytes.data(), static_cast<std::streamsize>(length));
        for (const std::string& record : reader.read_new()) seen.push_back(record);
        constexpr std::size_t second = 8 + 6 + 8;  // bytes of length, record and checksum
        const std::size_t expected = length == whole ? 2 : length >= whole - second ? 1 : 0;
        ASSERT_EQ(seen.size(), expected) << length;
        const auto fresh = RecordFolder(folder / "records", identity, "share-3").read_new();
        ASSERT_EQ(fresh, seen) << length;
    }
    EXPECT_THAT(seen, ElementsAre("first", "second"));
}

TEST(RecordFolder, a_flipped_bit_hides_its_record_and_what_follows_in_that_file_alone) {
    const Folder folder;
    {
        RecordFolder damaged(folder / "records", identity, "share-1"), whole(folder / "records", identity, "share-2");
        damaged.append("lost");
        whole.append("kept");
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder / "records")) {
        if (!entry.path().filename().string().starts_with("share-1")) continue;
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-10, std::ios::end);
        file.put('x');
    }
    EXPECT_THAT(RecordFolder(folder / "records", identity, "share-3").read_new(), ElementsAre("kept"));
}

TEST(RecordFolder, records_of_another_scene_are_rejected_with_the_first_difference) {
    const Folder folder;
    RecordFolder(folder / "records", identity, "share-1").append("a");
    RecordFolder other(folder / "records", {6, "[run]\nseed = 2\n"}, "share-1");
    EXPECT_THAT(refusal_of([&] { other.read_new(); }), HasSubstr("run.seed = 1 there, 2 here"));
}

TEST(RecordFolder, a_file_of_another_kind_or_behind_a_link_is_rejected) {
    const Folder folder;
    std::filesystem::create_directory(folder / "records");
    const auto read = [&] { RecordFolder(folder / "records", identity, "share-1").read_new(); };
    for (const char* notes : {"my notes of the day", "x"}) {
        std::ofstream((folder / "records" / "notes.records").string()) << notes;
        EXPECT_EQ(refusal_of(read), (folder / "records" / "notes.records").string() +
                                        ": is not a file of records; expected one that drover wrote: put it back, or "
                                        "choose another folder with --output");
    }
    std::filesystem::remove(folder / "records" / "notes.records");
    std::filesystem::create_symlink("elsewhere", folder / "records" / "link.records");
    EXPECT_THAT([&] { read(); }, testing::ThrowsMessage<Error>(HasSubstr("link.records")));
}

TEST(JoinFolder, many_processes_join_at_the_same_moment_and_one_writes_the_text) {
    const Folder folder;
    std::vector<pid_t> children;
    for (int i = 0; i < 16; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            int status = 1;
            try {
                status = join_folder(folder / "sweep", "sweep.toml", "", "[run]\nseed = 1\n").empty() ? 0 : 2;
            } catch (const std::exception& error) {
                std::fprintf(stderr, "%s\n", error.what());
            }
            ::_exit(status);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = 0;
        ::waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
    }
    EXPECT_EQ(only_file(folder / "sweep").filename(), "sweep.toml");
}

TEST(JoinFolder, another_text_and_a_folder_of_other_files_are_rejected) {
    const Folder folder;
    EXPECT_EQ(join_folder(folder / "sweep", "sweep.toml", "# one", "[run]\nseed = 1\n"), "# one");
    EXPECT_EQ(join_folder(folder / "sweep", "sweep.toml", "# two", "[run]\nseed = 1\n"), "# one");
    EXPECT_THAT(refusal_of([&] { join_folder(folder / "sweep", "sweep.toml", "# one", "[run]\nseed = 2\n"); }),
                HasSubstr("run.seed = 1 there, 2 here"));
    std::filesystem::create_directory(folder / "full");
    std::ofstream((folder / "full" / "notes.txt").string());
    EXPECT_THAT(refusal_of([&] { join_folder(folder / "full", "sweep.toml", "", "a = 1\n"); }),
                HasSubstr("the folder is not empty and holds no sweep.toml"));
}

TEST(JoinFolder, what_a_killed_process_left_of_the_text_does_not_matter) {
    const Folder folder;
    std::filesystem::create_directory(folder / "sweep");
    std::ofstream((folder / "sweep" / ".sweep.toml.1234").string()) << "[ru";
    EXPECT_EQ(join_folder(folder / "sweep", "sweep.toml", "", "[run]\nseed = 1\n"), "");
}

}  // namespace
}  // namespace drover::files::record_folder_tests
