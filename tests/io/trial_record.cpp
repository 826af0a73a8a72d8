// tests/io/trial_record.cpp: trials to bytes and back.
#include "io/calibration.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"

namespace drover::io::trial_record_tests {
namespace {

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

}  // namespace
}  // namespace drover::io::trial_record_tests
