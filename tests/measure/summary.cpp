// tests/measure/summary.cpp: the summary of a recorded run of fields or particles against series of known statistics.
#include "measure/fields.hpp"
#include "measure/particles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"
#include "measure/fields_support.hpp"
#include "measure/replicates.hpp"

namespace drover::measure::summary_tests {
namespace {

const FieldSetting setting = rods_on({.nx = 16, .ny = 32, .lx = 4.0, .ly = 8.0}, 3);

/// Recorded values of every observable: `mean(name, k)` of the k-th value, times 1 + 0.1 noise at each sample.
struct Recording {
    std::vector<RecordedSeries> series;
    std::size_t samples;

    template <class Mean>
    Recording(std::size_t count, const Mean& mean) : samples(count) {
        for (const auto& row : field_observables(setting)) {
            const std::size_t size = size_of(row.axes);
            std::vector<double> values(size * samples);
            fill_normal({.seed = series.size(), .stream = Stream::test}, 0, 1, values);
            for (std::size_t n = 0; n < values.size(); ++n)
                values[n] = mean(row.name, n % size) * (1.0 + 0.1 * values[n]);
            series.push_back(recorded_series(row, std::move(values)));
        }
        if (count > 0) std::ranges::fill((*this)["rods_total"], 1024.0);
    }

    std::vector<double>& operator[](const std::string& name) {
        for (RecordedSeries& one : series)
            if (one.name == name) return one.values;
        throw std::out_of_range(name);
    }

    Summary summary(std::optional<std::size_t> warm_up = 0) const {
        Recorded recorded = field_recording(setting, series);
        recorded.spacing = 0.5;
        recorded.warm_up = warm_up;
        return summarise(recorded);
    }
};

const SummaryRow& row_of(const Summary& summary, const std::string& name) {
    const SummaryRow* row = find_row(summary.rows, name);
    if (row == nullptr) throw std::out_of_range(name);
    return *row;
}

double box_rods(std::size_t b) { return 1024.0 * setting.boxes[b] * setting.boxes[b] / 512.0; }

TEST(Summary, every_value_of_every_observable_has_its_own_mean_and_error) {
    const Recording recording(2000, [](const std::string&, std::size_t k) { return 1.0 + static_cast<double>(k); });
    const Summary summary = recording.summary();
    EXPECT_EQ(summary.samples, 2000u);
    for (const RecordedSeries& series : recording.series) {
        if (series.name == "rods_total") continue;  // conserved
        const SummaryRow& row = row_of(summary, series.name);
        EXPECT_EQ(row.unit, series.unit);
        EXPECT_EQ(names_of(row.axes), names_of(series.axes));
        ASSERT_EQ(row.estimates.size(), size_of(series.axes));
        for (std::size_t k = 0; k < row.estimates.size(); ++k) {
            ASSERT_TRUE(row.estimates[k].error) << row.estimates[k].why_no_error;
            const double value = 1.0 + static_cast<double>(k), error = 0.1 * value / std::sqrt(2000.0);
            EXPECT_NEAR(row.estimates[k].mean, value, 5.0 * error);  // five errors: some hundred numbers are looked at
            // An error from 64 blocks has the deviation 9 %; the measured autocorrelation time shortens their number
            // at times.
            EXPECT_NEAR(*row.estimates[k].error, error, 0.5 * error);
        }
    }
}

TEST(Summary, the_mean_of_a_direction_follows_its_turns) {
    // It drifts evenly from 3.0 to 3.6 rad, beyond pi: the mean is 3.3 rad, which is 3.3 - 2 pi.
    RecordedSeries direction{.name = "direction", .unit = "rad", .formula = {}, .axes = {}, .values = {}};
    for (int i = 0; i <= 60; ++i) direction.values.push_back(std::remainder(3.0 + 0.01 * i, 2.0 * std::numbers::pi));
    for (const Averaging averaging : {Averaging::direction, Averaging::mean}) {
        direction.averaging = averaging;
        Recorded recorded{.series = {direction}};
        recorded.warm_up = 0;
        const double mean = summarise(recorded).rows.front().estimates.front().mean;
        if (averaging == Averaging::direction) EXPECT_NEAR(mean, 3.3 - 2.0 * std::numbers::pi, 1e-12);  // rounding
        else EXPECT_GT(std::abs(mean - (3.3 - 2.0 * std::numbers::pi)), 0.5);
    }
}

TEST(Summary, finds_the_exponent_of_giant_number_fluctuations) {
    const Recording recording(4000, [](const std::string& name, std::size_t k) {
        if (name == "rod_number_variance") return std::pow(box_rods(k), 1.6);
        return name == "rod_number_variance_long_y" ? std::pow(4.0 * setting.long_boxes[k] * setting.long_boxes[k], 1.4)
                                                    : 1.0;
    });
    const Summary summary = recording.summary();
    const SummaryRow& narrow = row_of(summary, "rod_number_exponent_long_y");
    ASSERT_GE(narrow.estimates.size(), 2u);
    EXPECT_NEAR(narrow.estimates[0].mean, 0.7, 5.0 * *narrow.estimates[0].error);
    EXPECT_NEAR(row_of(summary, "rod_number_long_x").estimates[1].mean, 4.0 * box_rods(1), 1e-12);
    const SummaryRow &number = row_of(summary, "rod_number"), &deviation = row_of(summary, "rod_number_deviation"),
                     &exponent = row_of(summary, "rod_number_exponent");
    ASSERT_EQ(exponent.estimates.size(), setting.boxes.size());
    for (std::size_t b = 0; b < setting.boxes.size(); ++b) {
        EXPECT_DOUBLE_EQ(number.estimates[b].mean, box_rods(b));
        ASSERT_TRUE(deviation.estimates[b].error);
        EXPECT_NEAR(deviation.estimates[b].mean, std::pow(box_rods(b), 0.8), 5.0 * *deviation.estimates[b].error);
        if (b + 1 == setting.boxes.size()) {
            EXPECT_TRUE(std::isnan(exponent.estimates[b].mean));
            EXPECT_EQ(exponent.estimates[b].why_no_error, "there is no larger box");
        } else {
            ASSERT_TRUE(exponent.estimates[b].error);
            EXPECT_LT(*exponent.estimates[b].error, 0.01);  // 0.1 sqrt(2/4000)/(2 ln(16/9)) = 0.002
            EXPECT_NEAR(exponent.estimates[b].mean, 0.8, 5.0 * *exponent.estimates[b].error);
        }
    }
}

TEST(Summary, susceptibility_and_binder_cumulant_are_those_of_the_polar_order) {
    Recording recording(20000, [](const std::string&, std::size_t) { return 1.0; });
    std::vector<double> pairs(40000);
    fill_normal({.seed = 77, .stream = Stream::test}, 0, 1, pairs);
    for (std::size_t i = 0; i < 20000; ++i) recording["polar_order"][i] = std::hypot(pairs[2 * i], pairs[2 * i + 1]);
    const Summary summary = recording.summary();
    const Estimate &chi = row_of(summary, "polar_order_susceptibility").estimates.at(0),
                   &binder = row_of(summary, "polar_order_binder").estimates.at(0);
    ASSERT_TRUE(chi.error && binder.error);
    EXPECT_NEAR(chi.mean, 32.0 * 2.0 * (1.0 - std::numbers::pi / 4.0), 4.0 * *chi.error);  // area <P^2> (1 - pi/4)
    EXPECT_NEAR(binder.mean, 1.0 / 3.0, 4.0 * *binder.error);
    EXPECT_LT(*binder.error, 0.01);  // 2/3/sqrt(20000) = 0.005
}

TEST(Summary, leaves_the_longest_warm_up_of_order_and_powers_out_of_all_means) {
    for (const std::string slow : {"polar_order", "structure_factor_rods", "structure_factor_order_across"}) {
        Recording recording(4000, [](const std::string&, std::size_t) { return 1.0; });
        std::vector<double>& series = recording[slow];
        const std::size_t size = series.size() / 4000;
        for (std::size_t n = 0; n < series.size(); ++n)
            series[n] += 30.0 * std::exp(-static_cast<double>(n / size) / 100.0);
        const Summary summary = recording.summary(std::nullopt);
        // Batch means scatter by 0.05 at most: the relaxation sinks below at i = 100 ln(30/0.05) = 640; half of that
        // at least.
        EXPECT_GT(summary.warm_up, 320u) << slow;
        EXPECT_LT(summary.warm_up, 2000u) << slow;
        EXPECT_EQ(summary.note, "");
        for (const SummaryRow& row : summary.rows)
            for (const Estimate& estimate : row.estimates)
                if (!(row.name == "rod_number" || row.name.starts_with("rod_number_long")) && estimate.error) {
                    EXPECT_GE(estimate.warm_up, 0.5 * static_cast<double>(summary.warm_up)) << row.name;
                }
    }
}

TEST(Summary, the_mean_of_many_runs_shows_nothing_of_their_start) {
    // x' = r x + noise, of unit variance, from x = 20, in 400 runs of 200 autocorrelation times: their mean has the
    // error sqrt(2 tau/(n runs)); several times as much is left of the start where each run is cut at its own noise.
    const int runs = 400, samples = 800;
    const double rate = std::exp(-0.25), tau = 4.0, error = std::sqrt(2.0 * tau / (samples * runs));
    double mean = 0.0;
    for (int run = 0; run < runs; ++run) {
        std::vector<double> values(samples);
        fill_normal({.seed = static_cast<std::uint64_t>(run), .stream = Stream::test}, 0, 1, values);
        double last = 20.0;
        for (double& value : values) value = last = rate * last + std::sqrt(1.0 - rate * rate) * value;
        const Summary summary = summarise({.series = {{.name = "x", .values = values}}, .indicators = {values}});
        mean += summary.rows.front().estimates.front().mean / runs;
    }
    EXPECT_NEAR(mean, 0.0, 3.5 * error);
}

TEST(Summary, the_mean_of_many_runs_of_a_skewed_observable_is_not_biased) {
    // (x^2 + y^2)/2 of x' = r x + noise of unit variance, from 0: the mean is 1, and its relative error in a run of
    // `samples` is sqrt(2 tau/samples), tau = 1/(2 (1 - r)) of the squares.  A cut after large values alone, as the one
    // with the smallest error of the rest, lowers the mean of all runs by a fifth of that: eight errors of this mean.
    // A third of it is left in runs as short as these.
    const int runs = 1600, samples = 800;
    const double rate = std::exp(-0.1), tau = 5.0, error = std::sqrt(2.0 * tau / (samples * runs));
    double mean = 0.0;
    for (int run = 0; run < runs; ++run) {
        std::vector<double> noise(2 * samples), values;
        fill_normal({.seed = static_cast<std::uint64_t>(run), .stream = Stream::test}, 0, 1, noise);
        double x = 0.0, y = 0.0;
        for (std::size_t n = 0; n < noise.size(); n += 2) {
            x = rate * x + std::sqrt(1.0 - rate * rate) * noise[n];
            y = rate * y + std::sqrt(1.0 - rate * rate) * noise[n + 1];
            values.push_back(0.5 * (x * x + y * y));
        }
        const Summary summary = summarise({.series = {{.name = "x", .values = values}}, .indicators = {values}});
        mean += summary.rows.front().estimates.front().mean / runs;
    }
    EXPECT_NEAR(mean, 1.0, 5.0 * error);
}

TEST(Summary, a_warm_up_that_does_not_end_is_reported) {
    Recording recording(1000, [](const std::string&, std::size_t) { return 1.0; });
    for (std::size_t i = 0; i < 1000; ++i) recording["polar_order"][i] = static_cast<double>(i);
    const Summary summary = recording.summary(std::nullopt);
    EXPECT_EQ(summary.warm_up, 500u);
    EXPECT_THAT(summary.note, testing::HasSubstr("may not have ended"));
    EXPECT_FALSE(row_of(summary, "polar_order").estimates[0].error);
    EXPECT_EQ(recording.summary(200).warm_up, 200u);
    EXPECT_EQ(recording.summary(200).note, "");
    // Or where ten times the memory is more than half of the run, although it starts as it goes on.
    std::vector<double> slow(1000);
    fill_normal({.seed = 1, .stream = Stream::test}, 0, 1, slow);
    double last = slow[0];
    for (double& value : slow) value = last = 0.99 * last + std::sqrt(1.0 - 0.99 * 0.99) * value;
    const Summary half = summarise({.series = {{.name = "x", .values = slow}}, .indicators = {slow}});
    EXPECT_EQ(half.warm_up, 500u);
    EXPECT_THAT(half.note, testing::HasSubstr("500 of 1000 samples are left out"));
}

TEST(Summary, directions_without_modes_are_reported_as_undefined) {
    Recording recording(100, [](const std::string&, std::size_t) { return 1.0; });
    const std::vector<double> ones(numerics::modes(setting.grid), 1.0);
    const auto present = numerics::sector_means(setting.grid, setting.shells, setting.sectors, ones);
    std::vector<double>& series = recording["structure_factor_rods_direction"];
    for (std::size_t n = 0; n < series.size(); ++n)
        if (std::isnan(present[n % present.size()])) series[n] = std::numeric_limits<double>::quiet_NaN();
    const Summary summary = recording.summary();
    const SummaryRow& row = row_of(summary, "structure_factor_rods_direction");
    int empty = 0;
    for (std::size_t k = 0; k < present.size(); ++k) {
        EXPECT_EQ(row.estimates[k].why_no_error == "no mean: the value is undefined (NaN) in every sample",
                  std::isnan(present[k]));
        empty += std::isnan(present[k]) ? 1 : 0;
    }
    EXPECT_GT(empty, 0);
}

TEST(Summary, of_few_or_no_samples_has_means_without_errors) {
    for (const std::size_t samples : {0u, 1u, 3u}) {
        const Recording recording(samples, [](const std::string&, std::size_t) { return 1.0; });
        const Summary summary = recording.summary(std::nullopt);
        const Estimate& order = row_of(summary, "polar_order").estimates[0];
        EXPECT_FALSE(order.error);
        EXPECT_EQ(std::isnan(order.mean), samples == 0);
        EXPECT_THAT(order.why_no_error, testing::HasSubstr("run for 20 s"));
    }
}

TEST(Summary, incomplete_samples_are_rejected_by_name) {
    Recording recording(100, [](const std::string&, std::size_t) { return 1.0; });
    recording["rod_number_variance"].pop_back();
    try {
        recording.summary();
        FAIL() << "not rejected";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("rod_number_variance"));
    }
}

/// A setting of rods in a cell of 200 mm^2, without pairs and flow.
ParticleSetting plain_setting() {
    ParticleSetting plain;
    plain.cell.lx = 20.0;
    plain.cell.ly = 10.0;
    plain.rods = 50;
    plain.fractions = {0.01, 0.04, 0.16};
    return plain;
}

TEST(ParticleSummary, a_series_has_its_mean_and_an_accumulating_one_its_rate) {
    std::vector<RecordedSeries> series{
        {.name = "polar_order", .unit = "1", .formula = ""},
        {.name = "impacts_rod_plate", .unit = "1", .formula = "", .averaging = Averaging::rate}};
    for (int i = 0; i < 4000; ++i) {
        series[0].values.push_back(0.5 + 0.1 * std::sin(12.9898 * i * i));  // all different, uncorrelated
        series[1].values.push_back(3.0 * i);
    }
    Recorded recorded = particle_recording(plain_setting(), series);
    recorded.spacing = 0.5;
    recorded.warm_up = 100;
    const Summary summary = summarise(recorded);
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
    EXPECT_NE(find_row(summary.rows, "polar_order_binder"), nullptr);
}

TEST(ParticleSummary, a_running_maximum_has_its_last_value_without_an_error) {
    Recorded recorded =
        particle_recording(plain_setting(),
                           {{.name = "overlap_largest", .unit = "1", .formula = "", .averaging = Averaging::maximum}});
    for (int i = 0; i < 400; ++i) recorded.series[0].values.push_back(1.0 - 1.0 / (1.0 + i));
    recorded.warm_up = 0;
    const Summary summary = summarise(recorded);
    const Estimate& largest = row_of(summary, "overlap_largest").estimates.front();
    EXPECT_EQ(largest.mean, 1.0 - 1.0 / 400.0);
    EXPECT_FALSE(largest.error);
    // Seeds scatter, and none is said to be too short for an error.
    Estimate other = largest;
    other.mean = 0.9;
    const Replicates both = combine(std::array{largest, other});
    EXPECT_TRUE(both.mean.error);
    EXPECT_EQ(both.without_error, 0u);
}

TEST(ParticleSummary, a_rate_of_nothing_that_happened_has_no_error) {
    Recorded recorded =
        particle_recording(plain_setting(),
                           {{.name = "impacts_rod_rod", .unit = "1", .formula = "", .averaging = Averaging::rate}});
    recorded.series[0].values.assign(400, 0.0);
    recorded.spacing = 0.5;
    recorded.warm_up = 0;
    const Summary summary = summarise(recorded);
    const Estimate& rate = row_of(summary, "impacts_rod_rod_rate").estimates.front();
    EXPECT_EQ(rate.mean, 0.0);
    EXPECT_FALSE(rate.error);
    EXPECT_THAT(rate.why_no_error,
                testing::HasSubstr("no event in 200 s, so the rate is below about one in that time"));
}

TEST(ParticleSummary, series_of_different_lengths_are_rejected) {
    EXPECT_THROW(summarise({.series = {{.name = "a", .values = {1.0, 2.0}}, {.name = "b", .values = {1.0}}}}), Error);
}

TEST(ParticleSummary, boxes_of_poisson_numbers_have_the_exponent_one_half) {
    RecordedSeries variance{.name = "rod_number_variance",
                            .unit = "1",
                            .axes = {{"box_side", "mm", "", {1.0, 2.0, 4.0}}}};
    for (int i = 0; i < 1000; ++i)
        for (const double fraction : {0.01, 0.04, 0.16}) variance.values.push_back(50.0 * fraction);  // variance N
    const Summary summary = summarise(particle_recording(plain_setting(), {variance}));
    EXPECT_DOUBLE_EQ(row_of(summary, "rod_number").estimates[1].mean, 2.0);
    EXPECT_DOUBLE_EQ(row_of(summary, "rod_number_deviation").estimates[1].mean, std::sqrt(2.0));
    const SummaryRow& exponent = row_of(summary, "rod_number_exponent");
    EXPECT_NEAR(exponent.estimates[0].mean, 0.5, 1e-14);  // rounding
    EXPECT_EQ(exponent.estimates[2].why_no_error, "there is no larger box");
}

/// The mean of a b, whose squares are known to the summary: b is remembered for 100 samples, and most of the variance
/// of a b is that of the fast part of a.
Estimate mean_of_product(std::size_t samples, std::uint64_t seed, bool with_squares) {
    const std::vector<double> fast = normal_numbers(samples, seed), kicks = normal_numbers(samples, 900 + seed);
    Recorded recorded{.series = {{.name = "ab"}, {.name = "aa"}, {.name = "bb"}}, .warm_up = 0};
    double b = kicks[0];
    for (std::size_t i = 0; i < samples; ++i) {
        b += -0.01 * b + std::sqrt(0.0199) * kicks[i];
        const double a = 3.0 * fast[i] + b;
        const std::array products{a * b, a * a, b * b};
        for (std::size_t k = 0; k < 3; ++k) recorded.series[k].values.push_back(products[k]);
    }
    for (RecordedSeries& series : recorded.series) series.unit = "1";
    if (with_squares) recorded.products = {{.name = "ab", .squares = {"aa", "bb"}}};
    return find_row(summarise(recorded).rows, "ab")->estimates[0];
}

TEST(SummaryStatistics, of_a_product_has_the_error_of_the_slower_factor) {
    constexpr std::size_t repeats = 60;
    double sum = 0.0, squares = 0.0, errors = 0.0;
    for (std::size_t n = 0; n < repeats; ++n) {
        const Estimate found = mean_of_product(20000, 10 + n, true);
        ASSERT_TRUE(found.error.has_value()) << found.why_no_error;
        sum += found.mean / repeats;
        squares += found.mean * found.mean / repeats;
        errors += *found.error / repeats;
    }
    EXPECT_NEAR(errors / std::sqrt(squares - sum * sum), 1.0, 0.25);  // the scatter of 60 is known to 1/11
}

TEST(Summary, of_a_product_has_no_error_where_that_of_its_slower_factor_is_not_known) {
    std::size_t own = 0, with_squares = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {  // runs of 12 times the memory of b
        own += mean_of_product(1200, seed, false).error.has_value() ? 1u : 0u;
        const Estimate found = mean_of_product(1200, seed, true);
        with_squares += found.error.has_value() ? 1u : 0u;
        EXPECT_EQ(found.why_no_error.empty(), found.error.has_value());
    }
    EXPECT_GE(own, 10u);
    EXPECT_LE(with_squares, 2u);
}

}  // namespace
}  // namespace drover::measure::summary_tests
