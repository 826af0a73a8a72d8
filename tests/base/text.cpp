// tests/base/text.cpp: texts for people.
#include "drover/base/text.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "drover/base/error.hpp"

namespace drover {
namespace {

TEST(Text, puts_values_in_their_places) {
    EXPECT_EQ(text("{} of {:.2f} {}: {}", 3, 2.5, "mm", true), "3 of 2.50 mm: true");
    EXPECT_EQ(text("{}", 0.1), "0.1");
    EXPECT_THROW(text("{} {}", 1), std::runtime_error);
}

TEST(Text, finds_the_name_that_was_meant_and_none_that_is_far) {
    const std::vector<std::string> names{"relaxation", "elasticity", "noise"};
    EXPECT_EQ(nearest_name("relaxtion", names), "relaxation");
    EXPECT_EQ(nearest_name("nosie", names), "noise") << "two letters swapped";
    EXPECT_EQ(nearest_name("nxisz", names), "") << "two of five letters are other ones";
    EXPECT_EQ(nearest_name("gravity", names), "");
}

TEST(Text, tells_sizes_and_times) {
    EXPECT_EQ(bytes_text(12), "12 B");
    EXPECT_EQ(bytes_text(1.5e6), "1.5 MB");
    EXPECT_EQ(bytes_text(4.123e11), "412 GB");
    EXPECT_EQ(duration_text(3.14159), "3.14 s");
    EXPECT_EQ(duration_text(125), "2 min 05 s");
    EXPECT_EQ(duration_text(7500), "2 h 05 min");
}

TEST(Text, writes_a_letter_as_a_letter) { EXPECT_EQ(text("\"{}\" and \"{}\"", ')', "b"[0]), "\")\" and \"b\""); }

TEST(Place, names_what_is_known) {
    EXPECT_EQ(location_text({"flock.toml", 14, 3}), "flock.toml:14:3");
    EXPECT_EQ(location_text({"flock.toml", 14, 0}), "flock.toml:14");
    EXPECT_EQ(location_text({"flock.toml", 0, 0}), "flock.toml");
    EXPECT_STREQ(Error(Fault::input, {}, "sentence").what(), "sentence");
    EXPECT_STREQ(Error(Fault::input, {"a", 1, 0}, "sentence").what(), "a:1: sentence");
}

}  // namespace
}  // namespace drover
