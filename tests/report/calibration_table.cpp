// tests/report/calibration_table.cpp: the columns of the text table of a calibration.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/shown.hpp"

namespace drover::report::calibration_table_tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

calibrate::TableRow row_of(const std::string& name, calibrate::TableEntry entry) {
    return {.name = name, .unit = "1/s", .formula = "", .by_rods = true, .entries = {std::move(entry)}};
}

calibrate::Table table_of_one_point(std::vector<calibrate::TableRow> rows) {
    return {.varied_key = "", .bead_fractions = {0.3}, .rod_fractions = {0.1}, .rows = std::move(rows)};
}

TEST(CalibrationText, has_a_column_for_what_any_assay_was_made_for) {
    calibrate::TableEntry entry{.value = 0.5, .error = 0.1, .trials = 8, .origin = calibrate::Origin::measured_short};
    entry.remark = "too few trials";
    const std::string alone =
        text_of(table_of_one_point({row_of("contact_reference", entry), row_of("contact_steady", entry)}));
    EXPECT_THAT(alone, HasSubstr("contact_reference [1/s]\n"));
    EXPECT_THAT(alone, HasSubstr(" !\n"));
    EXPECT_THAT(alone,
                HasSubstr("! contact_reference at bead area fraction 0.3, rod area fraction 0.1: too few trials"));
    EXPECT_THAT(alone, Not(HasSubstr("contact_steady")));  // a by-product

    const std::string with_g =
        text_of(table_of_one_point({row_of("contact_reference", entry), row_of("alignment", entry)}));
    EXPECT_THAT(with_g, HasSubstr("g [1/s]\n"));
    EXPECT_THAT(with_g, Not(HasSubstr("contact_reference")));  // a part of g
    const std::string half =
        text_of(table_of_one_point({row_of("weathercock_single", entry), row_of("weathercock", entry)}));
    EXPECT_THAT(half, HasSubstr("lambda [1/s]\n"));  // half of lambda_s
    EXPECT_THAT(half, Not(HasSubstr("weathercock_single")));
}

}  // namespace
}  // namespace drover::report::calibration_table_tests
