// tests/io/trial_file.cpp: trials to records and back.
#include "drover/io/trial_file.hpp"

#include "base/refusal.hpp"
#include "files/support.hpp"

namespace drover::io::trial_file_tests {
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

TEST(TrialFile, appended_trials_read_back_in_order) {
    const Folder folder;
    {
        TrialFile file(folder / "drag.trials", {9});
        for (const std::uint64_t number : {4u, 2u, 0u}) file.append(attempt(number));
        expect_same(read_trials(folder / "drag.trials", {9}), {4, 2, 0});  // also while a writer has it
    }
    TrialFile file(folder / "drag.trials", {9});
    expect_same(file.attempts(), {4, 2, 0});
    EXPECT_EQ(file.cut(), 0u);
    file.append(attempt(1));
    expect_same(read_trials(folder / "drag.trials", {9}), {4, 2, 0, 1});
    EXPECT_TRUE(read_trials(folder / "other.trials", {9}).empty());
}

TEST(TrialFile, a_record_that_is_not_a_trial_is_an_input_error) {
    const Folder folder;
    files::RecordFile(folder / "drag.trials", {9}).append("no trial");
    EXPECT_EQ(refusal_of([&] { TrialFile(folder / "drag.trials", {9}); }),
              (folder / "drag.trials").string() +
                  ": record 0 is not a trial; expected a file of this version of drover");
}

TEST(TrialFile, a_trial_passes_through_a_pipe_and_other_bytes_are_rejected) {
    for (std::uint64_t number : {0u, 2u}) expect_same({attempt_of(attempt_bytes(attempt(number)))}, {number});
    EXPECT_THROW(attempt_of(""), Error);
    EXPECT_THROW(attempt_of(attempt_bytes(attempt(1)).substr(1)), Error);
}

}  // namespace
}  // namespace drover::io::trial_file_tests
