// tests/jobs/calibration.cpp: folders of trials of another version of drover, and what a table keeps of its trials.
#include "jobs/calibration/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

#include "files/input_file.hpp"
#include "files/record_folder.hpp"
#include "files/support.hpp"
#include "io/calibration.hpp"
#include "io/scene.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "jobs/normal_world.hpp"
#include "jobs/stop_rule.hpp"

namespace drover::jobs::calibration_tests {
namespace {

/// Without the line that begins with a key.
std::string without(std::string content, const std::string& key) {
    const std::size_t begin = content.find("\n" + key + " = ");
    EXPECT_NE(begin, std::string::npos) << key;
    return content.erase(begin, content.find('\n', begin + 1) - begin);
}

io::Scene tiny_scene() {
    return io::parse_scene(R"(
[cell]
lx = 10.0
ly = 10.0
[time]
dt = 5e-5
[calibrate]
bead_area_fractions = [0.3]
assays = ["damping"]
relative_error = 0.5
round = 4
max_trials = 8
[calibrate.damping]
warm_up = 0.05
hold = 0.02
time = 0.1
frame = 0.01
)",
                           "tiny.toml", {});
}

TargetOptions options_for(const std::filesystem::path& folder) {
    TargetOptions options;
    options.folder = folder;
    options.workers = 1;
    options.quiet = true;
    return options;
}

TEST(Calibration, resumes_in_a_folder_whose_version_lacked_keys_that_have_their_defaults) {
    const testing_support::Folder folder;
    const io::Scene scene = tiny_scene();
    const TargetOptions options = options_for(folder / "trials");
    const CalibrationLayout layout = plan_calibration(scene);
    const std::string older = without(layout.manifest, "skin"), older_plan = without(layout.plans[0], "releases");
    files::join_folder(options.folder, "calibrate.toml", "# made by drover 0.1", older);
    EXPECT_EQ(run_calibration(scene, options).trials, 8u);

    const files::RecordIdentity identity = files::identity_of("calibrate", older);
    std::vector<UnitRecord> records = campaign_records(options.folder, identity);
    ASSERT_EQ(records.size(), 8u);
    std::filesystem::remove_all(options.folder / "records");
    UnitStore store(options.folder, identity, {});
    for (UnitRecord& record : records) {
        record.result.shared = older_plan;
        store.append(record);
    }
    store.sync();
    const CalibrationOutcome resumed = run_calibration(scene, options);
    EXPECT_EQ(resumed.already, 8u);
    EXPECT_EQ(resumed.trials, 0u);

    const io::Scene other = io::changed(scene, {"contacts.skin=0.3"});
    EXPECT_THROW(run_calibration(other, options), Error);  // its value there was the default
    const io::Scene other_plan = io::changed(scene, {"calibrate.damping.releases=1"});
    EXPECT_THROW(run_calibration(other_plan, options), Error);
}

/// From -1 to 1.
double correlation(const std::vector<double>& a, const std::vector<double>& b) {
    const double count = static_cast<double>(a.size()), middle = 0.5 * (count - 1.0);
    double sum = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - middle) * (b[k] - middle);
    return sum * 12.0 / (count * (count * count - 1.0));  // of the numbers from 0 to count - 1
}

TEST(CalibrationTable, has_the_order_of_resamples_which_numbers_of_the_same_trials_share) {
    CalibrationLayout layout = normal_layout();
    layout.assays[2].quantities = {{"drag", "x", "mean"}, {"response_time", "x", "1/mean"}, {"flow_40", "x", "mean"}};
    layout.assays[2].estimator = [](std::span<const calibrate::Trial>) {
        return [](std::span<const double> means) { return std::vector{means[0], 1.0 / means[0], means[0]}; };
    };
    std::vector<calibrate::TrialSet> sets;
    for (std::size_t u = 0; u < layout.units.size(); ++u) {
        sets.emplace_back(layout.assays[layout.units[u].assay], calibrate::TrialSet::no_goal(), 0.0);
        for (std::uint64_t trial = 0; trial < 16; ++trial) sets.back().add(trial_of(layout, u, trial, 1));
        sets.back().take_all();
    }
    const calibrate::Table table = table_of(layout, sets);
    const auto ranks = [&](const char* name, std::size_t bead) {
        return calibrate::find_row(table, name)->entries[bead].ranks;
    };
    ASSERT_EQ(ranks("drag", 0).size(), calibrate::resample_count);
    EXPECT_TRUE(ranks("flow_40", 0).empty());  // nothing follows from it
    for (std::size_t bead = 0; bead < 6; ++bead) {
        EXPECT_NEAR(correlation(ranks("drag", bead), ranks("drag", bead)), 1.0, 1e-12);
        EXPECT_NEAR(correlation(ranks("drag", bead), ranks("response_time", bead)), -1.0, 1e-3);  // ties
        // Equally many trials have the same resamples: one order would leave 1/sqrt(16) of chance.  Four deviations of
        // 1/sqrt(400).
        EXPECT_LT(std::abs(correlation(ranks("drag", bead), ranks("drag", (bead + 1) % 6))), 0.2);
        EXPECT_LT(std::abs(correlation(ranks("drag", bead), ranks("relaxation_rate", bead))), 0.2);
    }
    // Where alpha/Gamma rises tau falls as much: alpha = (alpha/Gamma) m rho/tau, so both add.
    const calibrate::TableEntry &drag = calibrate::find_row(table, "drag")->entries[0],
                                &ratio = calibrate::find_row(table, "response_time")->entries[0];
    EXPECT_NEAR(drag.error / drag.value, ratio.error / ratio.value, 0.02 * drag.error / drag.value);
}

TEST(Calibration, counts_failed_trials_for_the_rules_and_reads_those_that_earlier_versions_recorded_as_done) {
    const testing_support::Folder folder;
    const io::Scene scene = io::changed(tiny_scene(), {"contacts.max_overlap=1e-4"});
    const TargetOptions options = options_for(folder / "trials");
    {
        const ScopedStopRule stop("failures=3");
        const CalibrationOutcome outcome = run_calibration(scene, options);
        EXPECT_TRUE(outcome.stopped);
        EXPECT_GE(outcome.trials, 3u);
    }
    const CalibrationOutcome resumed = run_calibration(scene, options);
    EXPECT_EQ(resumed.already + resumed.trials, 8u);
    EXPECT_EQ(resumed.failed, 1u);
    EXPECT_THAT(calibration_status(scene, options), testing::HasSubstr("0 of 8 done, 8 failed"));

    const files::RecordIdentity identity = files::identity_of("calibrate", plan_calibration(scene).manifest);
    std::vector<UnitRecord> records = campaign_records(options.folder, identity);
    ASSERT_EQ(records.size(), 8u);
    std::filesystem::remove_all(options.folder / "records");
    UnitStore store(options.folder, identity, {});
    for (UnitRecord& record : records) {
        EXPECT_EQ(record.state, UnitState::failed);
        calibrate::Attempt attempt = io::attempt_of(record.result.content, record.key);
        attempt.failure = std::exchange(record.reason, "");
        record.state = UnitState::done;
        record.result.content = io::attempt_bytes(attempt);
        store.append(record);
    }
    store.sync();
    const CalibrationOutcome again = run_calibration(scene, options);
    EXPECT_EQ(again.already, 8u);
    EXPECT_EQ(again.trials, 0u);
    EXPECT_EQ(again.failed, 1u);
    EXPECT_EQ(again.table->rows[0].entries[0].remark, resumed.table->rows[0].entries[0].remark);
}

}  // namespace
}  // namespace drover::jobs::calibration_tests
