// tests/base/schema.cpp: reading values by their descriptions, TOML text, errors.
#include "drover/base/schema.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace drover {

enum class Feel { soft, very_hard };
constexpr auto names_of(Feel) { return std::array{"soft", "very-hard"}; }

struct Sample {
    bool loud = false;
    int count = 3;
    double rate = 0.5;
    Feel kind = Feel::soft;
    std::string tone = "low";
    std::vector<double> sizes;
    std::vector<std::string> words;

    static Rows<Sample> rows();
};

Rows<Sample> Sample::rows() {
    return Rows<Sample>{
        {"loud", &Sample::loud, "whether"},
        {"count", &Sample::count, "how many", "", within(1, 9)},
        {"rate", &Sample::rate, "how fast", "1/s", positive},
        {"kind", &Sample::kind, "which"},
        {"tone", &Sample::tone, "which of texts", "", any_number, {"low", "high"}},
        {"sizes", &Sample::sizes, "how large", "", not_negative},
        {"words", &Sample::words, "what"},
    };
}

namespace {

LocatedTable table(const std::string& key, const Value& value) {
    return {{"a.toml", 1, 1}, {{key, {value, {"a.toml", 7, 2}}}}};
}

std::string error_of(const std::string& key, const Value& value) {
    Sample sample;
    try {
        read_table(table(key, value), "sample", sample);
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "";
}

TEST(Schema, a_table_sets_members_and_absent_keys_keep_defaults) {
    Sample sample;
    read_table(table("rate", 2.5), "sample", sample);
    EXPECT_EQ(sample.rate, 2.5);
    EXPECT_EQ(sample.count, 3);
    read_table(table("rate", std::int64_t{4}), "sample", sample);
    EXPECT_EQ(sample.rate, 4.0) << "an integer serves as a number";
    read_table(table("words", std::vector<double>{}), "sample", sample);
    EXPECT_TRUE(sample.words.empty()) << "an empty list has no type of its own";
}

TEST(Schema, an_error_gives_location_value_found_value_expected_and_meaning) {
    EXPECT_EQ(error_of("rate", -1.0), "a.toml:7:2: sample.rate = -1.0; expected a number > 0 [1/s]: how fast");
    EXPECT_EQ(error_of("rate", std::string("fast")),
              "a.toml:7:2: sample.rate = \"fast\"; expected a number > 0 [1/s]: how fast");
    EXPECT_EQ(error_of("count", 2.5), "a.toml:7:2: sample.count = 2.5; expected an integer >= 1 and <= 9: how many");
    EXPECT_EQ(error_of("count", std::int64_t{10}),
              "a.toml:7:2: sample.count = 10; expected an integer >= 1 and <= 9: how many");
    EXPECT_EQ(error_of("kind", std::string("sotf")),
              "a.toml:7:2: sample.kind = \"sotf\"; expected one of [\"soft\", \"very-hard\"]; did you mean \"soft\"?");
    EXPECT_EQ(error_of("tone", std::string("heigh")),
              "a.toml:7:2: sample.tone = \"heigh\"; expected one of [\"low\", \"high\"]; did you mean \"high\"?");
    EXPECT_EQ(error_of("cuont", std::int64_t{1}), "a.toml:7:2: unknown key sample.cuont; did you mean sample.count?");
    EXPECT_EQ(error_of("zzzzzzzz", std::int64_t{1}),
              "a.toml:7:2: unknown key sample.zzzzzzzz; expected one of loud, count, rate, kind, tone, sizes, words");
    EXPECT_NE(error_of("rate", NAN), "");
    EXPECT_NE(error_of("rate", INFINITY), "");
    EXPECT_NE(error_of("sizes", std::vector<double>{1.0, -1.0}), "");
    EXPECT_NE(error_of("loud", std::int64_t{1}), "");
}

TEST(Schema, an_enum_is_read_and_written_by_its_names) {
    Sample sample;
    read_table(table("kind", std::string("very-hard")), "sample", sample);
    EXPECT_EQ(sample.kind, Feel::very_hard);
    EXPECT_EQ(values_of(sample)[3], (std::pair<std::string, Value>{"kind", std::string("very-hard")}));
    EXPECT_EQ(descriptions<Sample>()[3].choices, all_names<Feel>());
    EXPECT_EQ(text("{:>10}", sample.kind), " very-hard");
    EXPECT_EQ(value_named<Feel>("soft"), Feel::soft);
    EXPECT_EQ(value_named<Feel>("sof"), std::nullopt);
}

TEST(Schema, values_read_back_as_the_same_numbers) {
    for (const double value : {0.1, 1.0 / 3.0, 1e300, -2.5e-17, 3.0, 123456789.125})
        EXPECT_EQ(std::stod(toml_text(value)), value);
    EXPECT_EQ(toml_text(3.0), "3.0") << "a number stays a number, not an integer";
    EXPECT_EQ(toml_text(std::string("a\"b\\c\nd")), "\"a\\\"b\\\\c\\nd\"");
    EXPECT_EQ(toml_text(std::vector<std::string>{"x", "y"}), "[\"x\", \"y\"]");
}

TEST(Schema, a_text_with_any_bytes_is_toml_without_control_characters) {
    EXPECT_EQ(toml_text(std::string("\x1b\x7f\r\xc2\x9b")), R"("\u001b\u007f\u000d\u009b")");
    EXPECT_EQ(toml_text(std::string("\xe2\x82\xac")), "\"\xe2\x82\xac\"");
    EXPECT_EQ(toml_text(std::string("a\xff.h5")), R"("a\\xff.h5")");  // TOML cannot hold the byte
}

}  // namespace
}  // namespace drover
