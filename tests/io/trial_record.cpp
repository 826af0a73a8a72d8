// tests/io/trial_record.cpp: trials to bytes and back, and the files of earlier versions.
#include "io/trial_record.hpp"

#include "base/refusal.hpp"
#include "files/bytes.hpp"
#include "files/record_bytes.hpp"
#include "files/support.hpp"

namespace drover::io::trial_record_tests {
namespace {

using testing_support::Folder;

calibrate::Attempt attempt(std::uint64_t number) {
    if (number % 3 == 2) return {.number = number, .numbers = {}, .failure = "rod 7 is lost"};
    return {.number = number,
            .numbers = {0.1 * static_cast<double>(number), -0.0, 1e300},
            .failure = {},
            .core_seconds = static_cast<double>(number)};
}

void expect_same(const calibrate::Attempt& found, std::uint64_t number) {
    EXPECT_EQ(found.number, number);
    EXPECT_EQ(found.numbers, attempt(number).numbers);
    EXPECT_EQ(found.failure, attempt(number).failure);
    EXPECT_EQ(found.core_seconds, attempt(number).core_seconds);
}

TEST(TrialRecord, a_trial_is_read_back_and_other_bytes_are_rejected) {
    for (std::uint64_t number : {0u, 1u, 2u}) expect_same(attempt_of(attempt_bytes(attempt(number)), "x"), number);
    const std::string bytes = attempt_bytes(attempt(1));
    const std::size_t without_time = bytes.size() - sizeof(double);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
        if (length == without_time) continue;  // a trial of an earlier version
        EXPECT_THROW(attempt_of(bytes.substr(0, length), "x"), Error) << length;
    }
}

/// As drover calibrate wrote it before it had shares.
void write(const std::filesystem::path& file, const std::vector<std::string>& records) {
    std::vector<std::byte> bytes = files::start_of({9});
    for (const std::string& record : records) {
        const std::vector<std::byte> more = files::record_bytes(record);
        bytes.insert(bytes.end(), more.begin(), more.end());
    }
    std::ofstream(file, std::ios::binary) << files::text_of(bytes);
}

TEST(TrialRecord, files_of_earlier_versions_are_read) {
    const Folder folder;
    write(folder / "drag.trials", {attempt_bytes(attempt(4)), attempt_bytes(attempt(2))});
    const std::vector<calibrate::Attempt> found = read_trials(folder / "drag.trials", {9});
    ASSERT_EQ(found.size(), 2u);
    expect_same(found[0], 4);
    expect_same(found[1], 2);
    EXPECT_TRUE(read_trials(folder / "other.trials", {9}).empty());
    write(folder / "notes.trials", {attempt_bytes(attempt(4)), "no trial"});
    EXPECT_EQ(refusal_of([&] { read_trials(folder / "notes.trials", {9}); }),
              (folder / "notes.trials").string() +
                  ": record 1: is not a trial; expected a record of this version of drover");
}

}  // namespace
}  // namespace drover::io::trial_record_tests
