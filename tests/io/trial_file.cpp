// tests/io/trial_file.cpp: trials that are there once they were appended, whatever cut the file short afterwards.
#include "drover/io/trial_file.hpp"

#include "base/refusal.hpp"
#include "io/archive_support.hpp"

namespace drover::io {
namespace {

using testing_support::Folder;

calibrate::Attempt attempt(std::uint64_t number) {
    if (number % 3 == 2) return {.number = number, .numbers = {}, .failure = "rod 7 is lost"};
    return {.number = number, .numbers = {0.1 * static_cast<double>(number), -0.0, 1e300}, .failure = {}};
}

void expect_same(const std::vector<calibrate::Attempt>& found, const std::vector<std::uint64_t>& numbers) {
    ASSERT_EQ(found.size(), numbers.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_EQ(found[i].number, numbers[i]);
        EXPECT_EQ(found[i].numbers, attempt(numbers[i]).numbers);
        EXPECT_EQ(found[i].failure, attempt(numbers[i]).failure);
    }
}

TEST(TrialFile, gives_back_what_was_appended_in_any_order) {
    const Folder folder;
    {
        TrialFile file(folder / "drag.trials", 9);
        for (const std::uint64_t number : {4u, 2u, 0u}) file.append(attempt(number));
        expect_same(read_trials(folder / "drag.trials", 9), {4, 2, 0});  // also while it is held
    }
    TrialFile file(folder / "drag.trials", 9);
    expect_same(file.attempts(), {4, 2, 0});
    EXPECT_EQ(file.cut(), 0u);
    file.append(attempt(1));
    expect_same(read_trials(folder / "drag.trials", 9), {4, 2, 0, 1});
    EXPECT_TRUE(read_trials(folder / "other.trials", 9).empty());
}

TEST(TrialFile, cuts_off_a_record_that_was_torn_at_any_byte_and_goes_on) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    std::vector<std::uint64_t> lengths;
    {
        TrialFile file(path, 9);
        lengths.push_back(std::filesystem::file_size(path));
        for (std::uint64_t number = 0; number < 3; ++number) {
            file.append(attempt(number));
            lengths.push_back(std::filesystem::file_size(path));
        }
    }
    for (std::uint64_t length = lengths.back(); length-- > 0;) {
        std::filesystem::resize_file(path, length);
        const auto whole =
            static_cast<std::size_t>(std::upper_bound(lengths.begin(), lengths.end(), length) - lengths.begin());
        std::vector<std::uint64_t> kept;
        for (std::uint64_t number = 0; number + 1 < whole; ++number) kept.push_back(number);
        expect_same(read_trials(path, 9), kept);
        TrialFile file(path, 9);
        expect_same(file.attempts(), kept);
        EXPECT_EQ(file.cut(), whole == 0 ? length : length - lengths[whole - 1]);
        EXPECT_EQ(std::filesystem::file_size(path), lengths[whole == 0 ? 0 : whole - 1]);
        for (std::uint64_t number = kept.size(); number < 3; ++number) file.append(attempt(number));
        expect_same(read_trials(path, 9), {0, 1, 2});
    }
}

TEST(TrialFile, takes_no_trial_whose_bytes_have_changed) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    {
        TrialFile file(path, 9);
        file.append(attempt(0));
        file.append(attempt(1));
    }
    const auto size = std::filesystem::file_size(path);
    std::fstream stream(path, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(static_cast<std::streamoff>(size - 12));
    stream.put('\x55');
    stream.close();
    expect_same(TrialFile(path, 9).attempts(), {0});
}

TEST(TrialFile, refuses_another_scene_a_foreign_file_and_a_second_writer) {
    const Folder folder;
    const auto path = folder / "drag.trials";
    TrialFile file(path, 9);
    EXPECT_EQ(refusal_of([&] { read_trials(path, 8); }),
              path.string() +
                  ": holds the trials of another scene or point; expected its own: name another folder with "
                  "--output");
    EXPECT_NE(refusal_of([&] { TrialFile(path, 9); }).find("another drover calibrate is at work on it"),
              std::string::npos);
    std::ofstream(folder / "notes.trials") << "my notes of the day";
    EXPECT_EQ(refusal_of([&] { TrialFile(folder / "notes.trials", 9); }),
              (folder / "notes.trials").string() +
                  ": is not a file of trials; expected a folder that drover calibrate made");
    std::ofstream(folder / "short.trials") << "x";
    EXPECT_NE(refusal_of([&] { TrialFile(folder / "short.trials", 9); }).find("is not a file of trials"),
              std::string::npos);
}

TEST(TrialFile, carries_a_trial_through_a_pipe_and_refuses_what_is_none) {
    for (std::uint64_t number : {0u, 2u}) expect_same({attempt_of(attempt_bytes(attempt(number)))}, {number});
    EXPECT_THROW(attempt_of(""), Error);
    EXPECT_THROW(attempt_of(attempt_bytes(attempt(1)).substr(1)), Error);
}

TEST(ClaimedFolder, is_made_taken_again_and_refused_to_another_scene) {
    const Folder folder;
    const auto claim = [&](const std::string& name, const std::string& factory, const std::string& content) {
        return claim_folder(folder / name, "calibrate.toml", factory, content);
    };
    const std::string scene = "[kick]\nstrength = 0.015\n";
    EXPECT_EQ(claim("new", "# one", scene), "# one");
    EXPECT_EQ(claim("new", "# two", scene), "# one");
    std::ofstream(folder / "new/drag.trials") << "";
    EXPECT_EQ(claim("new", "# two", scene), "# one");
    EXPECT_EQ(refusal_of([&] { claim("new", "# one", "[kick]\nstrength = 0.02\n"); }),
              (folder / "new").string() +
                  ": the folder holds the trials of another scene (see calibrate.toml there): kick.strength = 0.015 "
                  "there, 0.02 here; name another folder with --output");
    std::filesystem::create_directory(folder / "mine");
    std::ofstream(folder / "mine/thesis.tex") << "x";
    EXPECT_EQ(refusal_of([&] { claim("mine", "# one", scene); }),
              (folder / "mine").string() +
                  ": the folder is not empty and holds no calibrate.toml; name another with --output");
    // What a crash left of a folder that was just being made.
    std::filesystem::create_directory(folder / "torn");
    std::ofstream(folder / "torn/calibrate.toml") << "# one\n[ki";
    EXPECT_EQ(claim("torn", "# one", scene), "# one");
    EXPECT_EQ(claim("torn", "# two", scene), "# one");
}

}  // namespace
}  // namespace drover::io
