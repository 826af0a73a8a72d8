// tests/measure/particle_summary.cpp: means, rates and box rows of recorded particles.
#include "drover/measure/particle_summary.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace drover::measure {
namespace {

/// A setting of rods and nothing to divide: the quotients of the world's own observables stay out.
ParticleSetting plain_setting() {
    ParticleSetting setting;
    setting.cell.lx = 20.0;
    setting.cell.ly = 10.0;
    setting.rods = 50;
    setting.boxes = {1, 2, 4};
    setting.part = {0.01, 0.04, 0.16};
    return setting;
}

ParticleObservable observable(const std::string& name, bool accumulates = false) {
    ParticleObservable row;
    row.name = name;
    row.unit = "1";
    row.formula = name;
    row.accumulates = accumulates;
    return row;
}

const SummaryRow& row_of(const Summary& summary, const std::string& name) {
    const SummaryRow* row = find_row(summary, name);
    EXPECT_NE(row, nullptr) << name;
    return *row;
}

TEST(ParticleSummary, a_series_has_its_mean_and_an_accumulating_one_its_rate) {
    const ParticleSetting setting = plain_setting();
    const std::vector<ParticleObservable> rows{observable("polar_order"), observable("impacts_rod_plate", true)};
    std::vector<std::vector<double>> series(2);
    for (int i = 0; i < 4000; ++i) {
        series[0].push_back(0.5 + 0.1 * std::sin(12.9898 * i * i));  // no two alike, without memory
        series[1].push_back(3.0 * i);
    }
    const Summary summary = summarise(
        ParticleRecorded{.setting = setting, .observables = rows, .series = series, .spacing = 0.5, .warm_up = 100});
    EXPECT_EQ(summary.samples, 4000u);
    EXPECT_EQ(summary.warm_up, 100u);
    const Estimate& order = row_of(summary, "polar_order").estimates.front();
    ASSERT_TRUE(order.error);
    EXPECT_NEAR(order.mean, 0.5, 5.0 * 0.1 / std::sqrt(2.0 * 3900.0));  // five standard errors
    const SummaryRow& rate = row_of(summary, "impacts_rod_plate_rate");
    EXPECT_EQ(rate.unit, "s-1");
    EXPECT_EQ(rate.estimates.front().mean, 6.0);
    EXPECT_EQ(rate.estimates.front().error, 0.0);
    // area (<P^2> - <P>^2) = 200 0.1^2/2
    EXPECT_NEAR(row_of(summary, "polar_order_susceptibility").estimates.front().mean, 1.0, 0.1);
    EXPECT_NE(find_row(summary, "polar_order_binder"), nullptr);
}

TEST(ParticleSummary, series_of_different_lengths_are_refused) {
    const ParticleSetting setting = plain_setting();
    const std::vector<ParticleObservable> rows{observable("polar_order"), observable("energy_kinetic")};
    const std::vector<std::vector<double>> series{{1.0, 2.0}, {1.0}};
    EXPECT_THROW(summarise(ParticleRecorded{.setting = setting, .observables = rows, .series = series}), Error);
}

TEST(ParticleSummary, boxes_of_poisson_numbers_have_the_exponent_one_half) {
    BoxSeries boxes{.variance = {"rod_number_variance", "1", "", {"box_side"}, 3, {}},
                    .what = "rod",
                    .ending = "",
                    .shape = "square",
                    .total = 50.0,
                    .parts = {0.01, 0.04, 0.16}};
    std::vector<double> values;
    for (int i = 0; i < 1000; ++i)
        for (const double part : boxes.parts) values.push_back(50.0 * part);  // variance N
    boxes.variance.values = values;
    std::vector<SummaryRow> rows;
    add_box_rows(boxes, 1.0, 0, rows);
    ASSERT_EQ(rows.size(), 3u);
    EXPECT_EQ(rows[0].name, "rod_number");
    EXPECT_DOUBLE_EQ(rows[0].estimates[1].mean, 2.0);
    EXPECT_DOUBLE_EQ(rows[1].estimates[1].mean, std::sqrt(2.0));
    EXPECT_NEAR(rows[2].estimates[0].mean, 0.5, 1e-14);  // rounding
    EXPECT_EQ(rows[2].estimates[2].refusal, "there is no larger box");
}

}  // namespace
}  // namespace drover::measure
