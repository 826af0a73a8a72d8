// tests/report/report.cpp: which numbers of the table of a run are rounding alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "report/shown.hpp"

namespace drover::report::report_tests {
namespace {

using measure::Nature;
using ::testing::ContainsRegex;

measure::SummaryRow row_of(const std::string& name, double mean, Nature nature) {
    return {.name = name, .unit = "1", .formula = "", .axes = {}, .estimates = {{.mean = mean}}, .nature = nature};
}

TEST(ReportText, shows_as_zero_what_is_rounding_of_its_field_and_keeps_ratios) {
    run::Report report;
    report.scene.kind = io::SceneKind::model;
    measure::MeasuredField& phi = report.setting.fields.emplace_back();
    phi.name = phi.symbol = phi.short_name = "phi";
    report.summary.rows = {row_of("max_phi", 1.0, Nature::number),       row_of("mean_phi", 1e-15, Nature::number),
                           row_of("skewness_phi", 2e-15, Nature::ratio), row_of("variance_phi", 3e-23, Nature::square),
                           row_of("energy_flow", 1e3, Nature::energy),   row_of("energy_other", 1e-10, Nature::energy)};
    const std::string table = text_of(report);
    EXPECT_THAT(table, ContainsRegex("mean_phi +1 +0 "));
    EXPECT_THAT(table, ContainsRegex("skewness_phi +1 +2e-15 "));
    EXPECT_THAT(table, ContainsRegex("variance_phi +1 +3e-23 "));  // above the square of 1e-12
    EXPECT_THAT(table, ContainsRegex("energy_other +1 +0 "));
}

}  // namespace
}  // namespace drover::report::report_tests
