// tests/measure/path_summary.cpp: results from paths of rods and beads with known speeds and diffusion.
#include "measure/trajectories.hpp"

#include <gtest/gtest.h>

#include "drover/base/error.hpp"
#include "measure/particles_support.hpp"

namespace drover::measure::path_summary_tests {
namespace {

const Estimate& estimate_of(const std::vector<SummaryRow>& rows, const std::string& name) {
    static const Estimate none;
    for (const SummaryRow& row : rows)
        if (row.name == name) return row.estimates.front();
    ADD_FAILURE() << "there is no row " << name;
    return none;
}

bool has_row(const std::vector<SummaryRow>& rows, const std::string& name) {
    return std::any_of(rows.begin(), rows.end(), [&](const SummaryRow& row) { return row.name == name; });
}

/// Rods of given speeds along n, whose angles turn by `turn` [rod * (frames - 1) + frame] after each frame.
Paths rods_of(const std::vector<double>& speeds, std::size_t frames, double spacing, const std::vector<double>& turn) {
    Paths paths = make_paths(spacing, frames, speeds.size(), 0);
    std::vector<double> position(3 * speeds.size()), axis(3 * speeds.size()), angle(speeds.size());
    for (std::size_t r = 0; r < speeds.size(); ++r) angle[r] = 0.7 * static_cast<double>(r);
    for (std::size_t i = 0; i < frames; ++i)
        for (std::size_t r = 0; r < speeds.size(); ++r) {
            axis[3 * r] = std::cos(angle[r]);
            axis[3 * r + 1] = std::sin(angle[r]);
            if (r + 1 == speeds.size()) add_frame(paths, position, axis, {});
            if (r + 1 < speeds.size() || i + 1 == frames) continue;
            for (std::size_t k = 0; k < speeds.size(); ++k) {
                position[3 * k] += spacing * speeds[k] * axis[3 * k];
                position[3 * k + 1] += spacing * speeds[k] * axis[3 * k + 1];
                angle[k] += turn.empty() ? 0.0 : turn[k * (frames - 1) + i];
            }
        }
    return paths;
}

TEST(PathSummary, of_rods_with_known_speeds_has_their_mean_spread_and_head_first_fraction) {
    const auto rows = path_rows(rods_of({12.0, 13.0, -7.0, 14.0}, 41, 0.025, {}));
    EXPECT_NEAR(estimate_of(rows, "rod_speed").mean, 8.0, 1e-11);  // rounding
    // Deviations of 4, 5, -15 and 6 from the mean, over n - 1.
    EXPECT_NEAR(estimate_of(rows, "rod_speed_deviation").mean, std::sqrt(302.0 / 3.0), 1e-11);
    const Estimate fraction = estimate_of(rows, "rod_head_first_fraction");
    EXPECT_NEAR(fraction.mean, 0.75, 1e-12);
    EXPECT_NEAR(fraction.error.value_or(0.0), std::sqrt(0.75 * 0.25 / 3.0), 1e-12);  // the binomial's
    for (const SummaryRow& row : rows) EXPECT_FALSE(row.unit.empty() || row.formula.empty()) << row.name;
}

TEST(PathSummary, persistence_is_the_mean_cosine_of_turns_between_frames) {
    EXPECT_NEAR(persistence(rods_of({12.0, 13.0}, 3, 0.1, {0.3, -0.5, 0.2, 0.1})),
                (std::cos(0.3) + std::cos(0.5) + std::cos(0.2) + std::cos(0.1)) / 4.0, 1e-14);  // rounding
    EXPECT_TRUE(std::isnan(persistence(rods_of({12.0}, 1, 0.1, {}))));
}

TEST(PathSummary, of_few_rods_of_two_gaits_has_the_errors_of_so_few) {
    const auto two = path_rows(rods_of({12.0, -8.0}, 401, 0.025, {}));
    EXPECT_NEAR(estimate_of(two, "rod_speed").error.value_or(0.0), 10.0, 1e-10);  // |x - y|/2
    EXPECT_NEAR(estimate_of(two, "rod_speed_deviation").mean, 20.0 / std::sqrt(2.0), 1e-10);
    EXPECT_FALSE(estimate_of(two, "rod_speed_deviation").error.has_value());
    const auto four = path_rows(rods_of({12.0, -8.0, 12.0, -8.0}, 401, 0.025, {}));
    // s^2 = 4 100/3, m_4 = 1e4: var s^2 = (m_4 - s^4/3)/4.
    const double square = 400.0 / 3.0, error = 0.5 * std::sqrt((1e4 - square * square / 3.0) / 4.0) / std::sqrt(square);
    EXPECT_NEAR(estimate_of(four, "rod_speed_deviation").error.value_or(0.0), error, 1e-10);
}

TEST(PathSummaryStatistics, of_the_spread_among_rods_has_the_error_of_its_scatter) {
    constexpr std::size_t repeats = 400, rods = 20;
    double sum = 0.0, squares = 0.0, errors = 0.0;
    for (std::size_t n = 0; n < repeats; ++n) {
        const auto rows = path_rows(rods_of(normal_numbers(rods, 700 + n), 3, 1.0, {}));
        const Estimate found = estimate_of(rows, "rod_speed_deviation");
        sum += found.mean / repeats;
        squares += found.mean * found.mean / repeats;
        errors += *found.error / repeats;
    }
    // The scatter of 400 is known to 1/28.
    EXPECT_NEAR(errors / std::sqrt(squares - sum * sum), 1.0, 0.11);
}

TEST(PathSummaryStatistics, of_beads_that_flow_together_has_the_error_of_the_flow) {
    constexpr std::size_t repeats = 40, beads = 30, frames = 4001;
    double sum = 0.0, squares = 0.0, errors = 0.0;
    for (std::size_t n = 0; n < repeats; ++n) {
        const std::vector<double> kicks = normal_numbers(frames, 40 + n), own = normal_numbers(frames * beads, 90 + n);
        Paths paths = make_paths(1.0, frames, 0, beads);
        std::vector<double> position(3 * beads);
        double flow = 0.0;
        for (std::size_t i = 0; i < frames; ++i) {
            add_frame(paths, {}, {}, position);
            flow += 0.3 * kicks[i] - 0.1 * flow;  // remembered for ten frames
            for (std::size_t b = 0; b < beads; ++b) position[3 * b] += flow + 0.3 * own[i * beads + b];
        }
        const Estimate found = estimate_of(path_rows(paths), "bead_displacement_squared");
        ASSERT_TRUE(found.error.has_value()) << found.why_no_error;
        sum += found.mean / repeats;
        squares += found.mean * found.mean / repeats;
        errors += *found.error / repeats;
    }
    // The scatter of 40 is known to 1/9; over beads alone the error would be a tenth of it.
    EXPECT_NEAR(errors / std::sqrt(squares - sum * sum), 1.0, 0.3);
}

TEST(PathSummary, weights_every_frame_equally_in_unequal_segments) {
    // 40 frames in 16 segments of two and of three: the first 19 head-first, the others tail-first.
    Paths paths = make_paths(1.0, 41, 1, 0);
    double x = 0.0;
    for (std::size_t i = 0; i < 41; ++i) {
        add_frame(paths, std::vector<double>{x, 0.0, 0.0}, std::vector<double>{1.0, 0.0, 0.0}, {});
        x += i < 19 ? 2.0 : -1.0;
    }
    EXPECT_NEAR(estimate_of(path_rows(paths), "rod_speed").mean, (19 * 2.0 - 21) / 40, 1e-12);
}

TEST(PathSummary, projects_on_the_direction_at_the_start_of_a_frame) {
    const std::vector<double> quarter_turns(20, 0.5 * pi);
    EXPECT_NEAR(estimate_of(path_rows(rods_of({3.0}, 21, 0.5, quarter_turns)), "rod_speed").mean, 3.0, 1e-12);
}

TEST(PathSummary, finds_the_rotational_diffusion) {
    constexpr double diffusion = 0.4, spacing = 0.05;
    constexpr std::size_t rods = 60, frames = 800;
    std::vector<double> turn = normal_numbers(rods * (frames - 1), 3);
    for (double& angle : turn) angle *= std::sqrt(2.0 * diffusion * spacing);
    const auto rows = path_rows(rods_of(std::vector<double>(rods, 5.0), frames, spacing, turn));
    const Estimate found = estimate_of(rows, "rotational_diffusion"), time = estimate_of(rows, "relaxation_time");
    ASSERT_TRUE(found.error && time.error) << found.why_no_error;
    EXPECT_NEAR(found.mean, diffusion, 4.0 * *found.error);
    EXPECT_LT(*found.error, 0.1 * diffusion);
    EXPECT_DOUBLE_EQ(time.mean, 1.0 / found.mean);
    EXPECT_DOUBLE_EQ(*time.error, *found.error / (found.mean * found.mean));
}

TEST(PathSummary, has_no_error_where_it_cannot_be_estimated) {
    const auto one = path_rows(rods_of({12.0}, 41, 0.025, {}));
    EXPECT_FALSE(has_row(one, "rod_speed_deviation"));
    EXPECT_EQ(estimate_of(one, "rod_head_first_fraction").mean, 1.0);
    EXPECT_FALSE(estimate_of(one, "rod_head_first_fraction").error);
    EXPECT_FALSE(estimate_of(one, "rotational_diffusion").error && estimate_of(one, "relaxation_time").error);
    const auto all_head_first = path_rows(rods_of({12.0, 11.0, 10.0}, 41, 0.025, {}));
    EXPECT_EQ(estimate_of(all_head_first, "rod_head_first_fraction").why_no_error,
              "no error estimate: all 3 rods move the same way, so the binomial error is not known");
}

TEST(PathSummary, of_fewer_than_two_frames_is_nan_with_the_reason) {
    for (const std::size_t frames : {0u, 1u}) {
        const auto rows = path_rows(rods_of({12.0, 11.0}, frames, 0.025, {}));
        for (const char* name : {"rod_speed", "rod_head_first_fraction", "rotational_diffusion", "relaxation_time"}) {
            EXPECT_TRUE(std::isnan(estimate_of(rows, name).mean)) << name;
            EXPECT_NE(estimate_of(rows, name).why_no_error.find("expected two or more"), std::string::npos);
        }
    }
    const auto two = path_rows(rods_of({12.0, 11.0}, 2, 0.025, {}));
    EXPECT_NEAR(estimate_of(two, "rod_speed").mean, 11.5, 1e-12);
    EXPECT_FALSE(estimate_of(two, "rotational_diffusion").why_no_error.empty());
}

TEST(PathSummary, of_beads_is_their_displacement_over_a_frame) {
    for (const std::size_t beads : {std::size_t{3}, std::size_t{50}, 3 * max_beads_followed}) {
        constexpr std::size_t frames = 33;
        Paths paths = make_paths(0.1, frames, 0, beads);
        EXPECT_LE(paths.followed.size(), max_beads_followed);
        std::vector<double> position(3 * beads);
        for (std::size_t i = 0; i < frames; ++i) {
            add_frame(paths, {}, {}, position);
            for (std::size_t b = 0; b < beads; ++b) position[3 * b + i % 2] += b % 2 == 0 ? 0.3 : -0.3;
            for (std::size_t b = 0; b < beads; ++b) position[3 * b + 2] += 1.0;  // heights do not count
        }
        const auto rows = path_rows(paths);
        ASSERT_EQ(rows.size(), 1u);
        const Estimate squared = estimate_of(rows, "bead_displacement_squared");
        EXPECT_NEAR(squared.mean, 0.09, 1e-12);  // rounding
        EXPECT_NEAR(squared.error.value_or(1.0), 0.0, 1e-9);
        EXPECT_EQ(squared.samples, paths.followed.size() * (frames - 1));
    }
}

TEST(PathSummary, rejects_frames_of_other_bodies) {
    EXPECT_THROW(make_paths(0.0, 2, 1, 0), Error);
    Paths paths = make_paths(0.1, 1, 1, 2);
    const std::vector<double> one(3), two(6);
    EXPECT_THROW(add_frame(paths, two, one, two), Error);
    EXPECT_THROW(add_frame(paths, one, one, one), Error);
    add_frame(paths, one, one, two);
    EXPECT_THROW(add_frame(paths, one, one, two), Error);  // one was expected
}

}  // namespace
}  // namespace drover::measure::path_summary_tests
