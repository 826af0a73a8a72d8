// tests/base/text.cpp: formatting, nearest names, sizes and durations.
#include "drover/base/text.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "drover/base/error.hpp"

namespace drover::text_tests {
namespace {

TEST(Text, values_replace_braces_in_order) {
    EXPECT_EQ(text("{} of {:.2f} {}: {}", 3, 2.5, "mm", true), "3 of 2.50 mm: true");
    EXPECT_EQ(text("{}", 0.1), "0.1");
    EXPECT_THROW(text("{} {}", 1), std::runtime_error);
}

TEST(Text, a_suggestion_asks_for_the_nearest_name_or_says_something_else) {
    const std::vector<std::string> names{"relaxation", "noise"};
    EXPECT_EQ(suggestion("nosie", names, "expected one of two"), "did you mean noise?");
    EXPECT_EQ(suggestion("nosie", names, "", " (did you mean [{}]?)"), " (did you mean [noise]?)");
    EXPECT_EQ(suggestion("gravity", names, "expected one of two"), "expected one of two");
    EXPECT_EQ(suggestion("gravity", names), "");
}

TEST(Text, nearest_name_finds_a_similar_name_or_none) {
    const std::vector<std::string> names{"relaxation", "elasticity", "noise"};
    EXPECT_EQ(nearest_name("relaxtion", names), "relaxation");
    EXPECT_EQ(nearest_name("nosie", names), "noise") << "two letters swapped";
    EXPECT_EQ(nearest_name("nxisz", names), "") << "two of five letters are other ones";
    EXPECT_EQ(nearest_name("gravity", names), "");
    const std::vector<std::string> letters{"D", "kappa", "Du"};
    EXPECT_EQ(nearest_name("q", letters), "") << "any letter is one edit from another";
    EXPECT_EQ(nearest_name("Dv", letters), "");
    EXPECT_EQ(nearest_name("d", letters), "D");
    EXPECT_EQ(nearest_name("Kappa", letters), "kappa");
}

TEST(Text, sizes_and_durations_have_units) {
    EXPECT_EQ(bytes_text(12), "12 B");
    EXPECT_EQ(bytes_text(1.5e6), "1.5 MB");
    EXPECT_EQ(bytes_text(4.123e11), "412 GB");
    EXPECT_EQ(duration_text(3.14159), "3.14 s");
    EXPECT_EQ(duration_text(125), "2 min 05 s");
    EXPECT_EQ(duration_text(7500), "2 h 05 min");
}

TEST(Text, a_measured_number_has_the_digits_that_its_error_supports) {
    EXPECT_EQ(measured_text(15.8912, 0.079), "15.891");
    EXPECT_EQ(measured_text(-0.66272, 0.0012), "-0.6627");
    EXPECT_EQ(measured_text(1234.4, 56.0), "1234");
    EXPECT_EQ(measured_text(1234.4, 560.0), "1230");
    EXPECT_EQ(measured_text(0.004, 0.23), "0.00");  // zero within its error
    EXPECT_EQ(measured_text(1.23456e-7, 1e-10), "1.2346e-07");
    EXPECT_EQ(measured_text(9.87654321e8, 1e5), "9.8765e+08");
    EXPECT_EQ(measured_text(3.14159265, 1e-12), "3.14159");  // never more than six
    EXPECT_EQ(measured_text(9216.0, 0.0), "9216");           // exact
    EXPECT_EQ(measured_text_with_error(15.8912, 0.079), "15.891 +- 0.079");
}

TEST(Text, is_printable_as_utf_8_whatever_its_bytes) {
    EXPECT_EQ(printable("m\xc2\xb2 \xe2\x82\xac \xf0\x9f\x90\x91"), "m\xc2\xb2 \xe2\x82\xac \xf0\x9f\x90\x91");
    EXPECT_EQ(printable("\x1b[2J\x7f\xc2\x9b"), "\\x1b[2J\\x7f\\xc2\\x9b");
    EXPECT_EQ(printable("\xff"), "\\xff");
    EXPECT_EQ(printable("\xe0\x80\x80"), "\\xe0\\x80\\x80");           // longer than necessary
    EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // half of a surrogate pair
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond U+10FFFF
}

TEST(Text, a_word_for_the_shell_is_in_quotes_where_it_needs_them) {
    EXPECT_EQ(shell_word("runs/flock-1.h5"), "runs/flock-1.h5");
    EXPECT_EQ(shell_word(""), "''");
    EXPECT_EQ(shell_word("a b"), "'a b'");
    EXPECT_EQ(shell_word("it's $(x)\n"), "'it'\\''s $(x)\n'");
}

TEST(Text, a_character_is_written_as_a_character) {
    EXPECT_EQ(text("\"{}\" and \"{}\"", ')', "b"[0]), "\")\" and \"b\"");
}

TEST(SourceLocation, text_contains_the_known_parts) {
    EXPECT_EQ(location_text({"flock.toml", 14, 3}), "flock.toml:14:3");
    EXPECT_EQ(location_text({"flock.toml", 14, 0}), "flock.toml:14");
    EXPECT_EQ(location_text({"flock.toml", 0, 0}), "flock.toml");
    EXPECT_STREQ(Error(Fault::input, {}, "sentence").what(), "sentence");
    EXPECT_STREQ(Error(Fault::input, {"a", 1, 0}, "sentence").what(), "a:1: sentence");
}

}  // namespace
}  // namespace drover::text_tests
