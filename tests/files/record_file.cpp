// tests/files/record_file.cpp: records that survive a truncation of their file at any byte; folders of such files.
#include "drover/files/record_file.hpp"

#include <algorithm>

#include "base/refusal.hpp"
#include "files/support.hpp"

namespace drover::files::record_file_tests {
namespace {

using testing_support::Folder;
using Records = std::vector<std::string>;

/// Every third record is empty; the others contain zero bytes.
std::string record(std::size_t i) { return i % 3 == 2 ? "" : "record " + std::string(i, '\0') + std::to_string(i); }

Records records(std::initializer_list<std::size_t> numbers) {
    Records result;
    for (const std::size_t i : numbers) result.push_back(record(i));
    return result;
}

TEST(RecordFile, appended_records_read_back_in_order) {
    const Folder folder;
    {
        RecordFile file(folder / "drag.trials", {9});
        for (const std::size_t i : {4u, 2u, 0u}) file.append(record(i));
        EXPECT_EQ(read_records(folder / "drag.trials", {9}), records({4, 2, 0}));  // also while a writer has it
    }
    RecordFile file(folder / "drag.trials", {9});
    EXPECT_EQ(file.records(), records({4, 2, 0}));
    EXPECT_EQ(file.cut(), 0u);
    file.append(record(1));
    EXPECT_EQ(read_records(folder / "drag.trials", {9}), records({4, 2, 0, 1}));
    EXPECT_TRUE(read_records(folder / "other.trials", {9}).empty());
}

TEST(RecordFile, a_record_torn_at_any_byte_is_cut_off_and_can_be_appended_again) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    const RecordIdentity identity{9, "[cell]\nlx = 45.0\n"};  // which may be torn, too
    std::vector<std::uint64_t> lengths;
    {
        RecordFile file(path, identity);
        lengths.push_back(std::filesystem::file_size(path));
        for (std::size_t i = 0; i < 3; ++i) {
            file.append(record(i));
            lengths.push_back(std::filesystem::file_size(path));
        }
    }
    for (std::uint64_t length = lengths.back(); length-- > 0;) {
        std::filesystem::resize_file(path, length);
        const auto complete =
            static_cast<std::size_t>(std::upper_bound(lengths.begin(), lengths.end(), length) - lengths.begin());
        Records kept;
        for (std::size_t i = 0; i + 1 < complete; ++i) kept.push_back(record(i));
        EXPECT_EQ(read_records(path, identity), kept);
        RecordFile file(path, identity);
        EXPECT_EQ(file.records(), kept);
        EXPECT_EQ(file.cut(), complete == 0 ? 0 : length - lengths[complete - 1]);
        EXPECT_EQ(std::filesystem::file_size(path), lengths[complete == 0 ? 0 : complete - 1]);
        for (std::size_t i = kept.size(); i < 3; ++i) file.append(record(i));
        EXPECT_EQ(read_records(path, identity), records({0, 1, 2}));
    }
}

TEST(RecordFile, a_record_with_a_changed_byte_is_cut_off) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    {
        RecordFile file(path, {9});
        file.append(record(0));
        file.append(record(1));
    }
    std::string bytes = testing_support::contents(path);
    bytes[bytes.size() - 12] ^= 4;
    testing_support::write_contents(path, bytes);
    EXPECT_EQ(RecordFile(path, {9}).records(), records({0}));
}

TEST(RecordFile, another_identity_a_foreign_file_and_a_second_writer_are_rejected) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    RecordFile file(path, {9});
    EXPECT_EQ(refusal_of([&] { read_records(path, {8}); }),
              path.string() +
                  ": holds the trials of another scene or measurement; expected those that were written "
                  "here: put them back, or choose another folder with --output");
    EXPECT_NE(refusal_of([&] { RecordFile(path, {9}); }).find("another drover calibrate is using it"),
              std::string::npos);
    std::ofstream(folder / "notes.trials") << "my notes of the day";
    EXPECT_EQ(refusal_of([&] { RecordFile(folder / "notes.trials", {9}); }),
              (folder / "notes.trials").string() +
                  ": is not a file of trials; expected a folder that drover calibrate created");
    std::ofstream(folder / "short.trials") << "x";
    EXPECT_NE(refusal_of([&] { RecordFile(folder / "short.trials", {9}); }).find("is not a file of trials"),
              std::string::npos);
}

TEST(RecordFile, another_content_is_rejected_by_its_first_difference_and_one_of_an_earlier_version_by_its_hash) {
    const Folder folder;
    const auto path = folder / "drag.trials", earlier = folder / "earlier.trials";
    const RecordIdentity mine{9, "[cell]\nlx = 45.0\nly = 45.0\n"}, other{8, "[cell]\nlx = 45.0\nly = 30.0\n"};
    for (int opening = 0; opening < 2; ++opening)
        RecordFile(path, mine).append(record(static_cast<std::size_t>(opening)));
    EXPECT_EQ(read_records(path, mine), records({0, 1}));
    for (const RecordIdentity& wrong : {other, RecordIdentity{9, other.content}})
        EXPECT_THAT(refusal_of([&] { RecordFile(path, wrong); }),
                    ::testing::HasSubstr("of another scene or measurement: cell.ly = 45.0 there, 30.0 here; expected"));
    RecordFile(earlier, {9}).append(record(0));
    EXPECT_EQ(RecordFile(earlier, mine).records(), records({0}));
    EXPECT_THAT(refusal_of([&] { RecordFile(earlier, other); }), ::testing::HasSubstr("or measurement; expected"));
}

TEST(ClaimFolder, a_folder_is_created_then_reused_and_rejected_for_another_scene) {
    const Folder folder;
    const auto claim = [&](const std::string& name, const std::string& factory, const std::string& content) {
        return claim_folder(folder / name, "calibrate.toml", factory, content).first_line;
    };
    const std::string scene = "[kick]\nstrength = 0.015\n";
    EXPECT_EQ(claim("new", "# one", scene), "# one");
    EXPECT_EQ(claim("new", "# two", scene), "# one");
    std::ofstream(folder / "new/drag.trials") << "";
    EXPECT_EQ(claim("new", "# two", scene), "# one");
    EXPECT_EQ(refusal_of([&] { claim("new", "# one", "[kick]\nstrength = 0.02\n"); }),
              (folder / "new").string() +
                  ": the folder holds the results of another scene (see calibrate.toml there): kick.strength = 0.015 "
                  "there, 0.02 here; choose another folder with --output");
    std::filesystem::create_directory(folder / "mine");
    std::ofstream(folder / "mine/thesis.tex") << "x";
    EXPECT_EQ(refusal_of([&] { claim("mine", "# one", scene); }),
              (folder / "mine").string() +
                  ": the folder is not empty and holds no calibrate.toml; choose another with --output");
    // The remains of a crash during the creation of a folder.
    std::filesystem::create_directory(folder / "torn");
    std::ofstream(folder / "torn/calibrate.toml") << "# one\n[ki";
    EXPECT_EQ(claim("torn", "# one", scene), "# one");
    EXPECT_EQ(claim("torn", "# two", scene), "# one");
}

}  // namespace
}  // namespace drover::files::record_file_tests
