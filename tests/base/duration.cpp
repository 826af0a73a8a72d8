// tests/base/duration.cpp: durations from their texts.
#include "base/duration.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"

namespace drover::duration_tests {
namespace {

TEST(Duration, is_read_in_seconds_minutes_hours_and_as_a_clock) {
    const auto read = [](const char* given) { return seconds_of(given, "--max-time"); };
    EXPECT_EQ(read("3600"), 3600.0);
    EXPECT_EQ(read("90s"), 90.0);
    EXPECT_EQ(read("20min"), 1200.0);
    EXPECT_EQ(read("90m"), 5400.0);
    EXPECT_EQ(read("1.5 h"), 5400.0);
    EXPECT_EQ(read("11:30"), 690.0);
    EXPECT_EQ(read("11:30:00"), 41400.0);
    EXPECT_EQ(read("2-01:00:05"), 176405.0);
    for (const char* given : {"",        "min",  "0s",   "-1s",   "5 days",    "nans",       "inf",         "1e400",
                              "1:2:3:4", "1:60", "0:00", "-1:00", "1:-2:03",   "1-24:00:00", "1-2-3:04:05", "1-2:3",
                              ":30",     "1:",   "1:+1", "1: 1",  "11:30:00 ", "1:30h"})
        EXPECT_THROW(read(given), Error) << given;
}

}  // namespace
}  // namespace drover::duration_tests
