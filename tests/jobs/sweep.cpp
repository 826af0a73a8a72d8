// tests/jobs/sweep.cpp: records of a sweep that another version of drover computed.
#include "jobs/sweep/sweep.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "files/input_file.hpp"
#include "files/support.hpp"
#include "io/scene.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "jobs/sweep/sweep_plan.hpp"

namespace drover::jobs::sweep_tests {

TEST(Sweep, a_table_of_records_of_two_versions_says_so) {
    const testing_support::Folder folder;
    const io::Scene scene = io::parse_scene(R"(
[grid]
nx = 8
ny = 8
[time]
dt = 0.1
end = 2.0
[sweep]
vary = ["relaxation.rate = 0.5, 1, 2"]
keep = "table"
)",
                                            "tiny.toml", {});
    const JobOptions options{.folder = folder / "swept", .workers = 1, .quiet = true};
    const auto is_of_other = [](const SweepOutcome& outcome) {
        const std::vector<std::string>& warnings = outcome.table.value().warnings;
        return std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
            return warning.starts_with("point-0001-seed-1 was made by drover 0.1 (old)");
        });
    };
    EXPECT_FALSE(is_of_other(run_sweep(scene, options)));
    const files::RecordIdentity identity =
        files::identity_of("sweep", files::read_text(options.folder / "sweep.toml", "a scene", 1 << 20));
    std::vector<UnitRecord> records = campaign_records(options.folder, identity);
    ASSERT_EQ(records.size(), 3u);
    std::filesystem::remove_all(options.folder / "records");
    records[1].program = "0.1 (old)";
    UnitStore store(options.folder, identity, {});
    for (const UnitRecord& record : records) store.append(record);
    store.sync();
    EXPECT_TRUE(is_of_other(run_sweep(scene, options)));
}

TEST(SweepPlan, tells_whether_results_may_ask_for_more_runs) {
    const io::Scene plain = io::parse_scene("[sweep]\nvary = [\"relaxation.rate = 0.5, 1\"]\n", "plain.toml", {});
    const auto is_adaptive = [&](const std::string& change) {
        const io::Scene scene = change.empty() ? plain : io::changed(plain, {change});
        return plan_sweep(scene, {}, numbered_points(scene)).is_adaptive;
    };
    EXPECT_FALSE(is_adaptive(""));
    EXPECT_TRUE(is_adaptive("sweep.refine=[\"polar_order = 0.1\"]"));
    EXPECT_TRUE(is_adaptive("sweep.want=[\"polar_order=2%\"]"));
}

TEST(SweepPlan, a_point_with_fewer_than_two_ended_runs_misses_the_error_that_was_wanted) {
    const io::Scene scene =
        io::parse_scene("[sweep]\nvary = [\"relaxation.rate = 0.5, 1, 2\"]\nseeds = 4\nwant = [\"polar_order=2%\"]\n",
                        "wanted.toml", {});
    const SweepLayout layout = plan_sweep(scene, {}, numbered_points(scene));
    std::map<std::string, RunResults> results;
    std::array<int, 3> to_end{4, 1, 0};  // runs of each point
    for (const SweepRun& run : layout.runs)
        if (--to_end.at(run.point) >= 0)
            results[run.name].rows = {{.name = "polar_order",
                                       .unit = "1",
                                       .formula = "",
                                       .axes = {},
                                       .estimates = {{.mean = 0.5, .error = 1e-3}}}};
    const auto misses = [](const std::string& point, const std::string& runs) {
        return testing::StartsWith(point + ": polar_order has no error of the seeds, since " + runs + " run ended");
    };
    EXPECT_THAT(unmet_targets(scene, layout, sweep_table(layout, results)),
                testing::ElementsAre(misses("at relaxation.rate = 1", "only one"),
                                     misses("at relaxation.rate = 2", "no")));
}

TEST(SweepPlan, a_limit_without_what_it_limits_is_rejected) {
    for (const std::string limit : {"max_seeds = 8", "refine_levels = 2"}) {
        const io::Scene scene =
            io::parse_scene("[sweep]\nvary = [\"relaxation.rate = 0.5, 1\"]\n" + limit + "\n", "plain.toml", {});
        try {
            plan_sweep(scene, {}, numbered_points(scene));
            ADD_FAILURE() << limit << " was accepted";
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("plain.toml:3:1"));
        }
    }
}

TEST(SweepPlan, a_value_between_two_of_opposite_sign_is_zero) {
    const io::Scene scene = io::parse_scene("[sweep]\nvary = [\"relaxation.rate = -0.3:0.3:7\"]\n", "plain.toml", {});
    const SweepLayout layout = plan_sweep(scene, {}, numbered_points(scene));
    EXPECT_EQ(layout.points.at(3).values.at(0), 0.0);  // and not 5.6e-17, a rounding error of -0.3 + 0.3
}

}  // namespace drover::jobs::sweep_tests
