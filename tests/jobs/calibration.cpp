// tests/jobs/calibration.cpp: folders of trials of another version of drover.
#include "jobs/calibration/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "files/input_file.hpp"
#include "files/record_folder.hpp"
#include "files/support.hpp"
#include "io/scene_text.hpp"
#include "jobs/campaign/campaign_records.hpp"

namespace drover::jobs::calibration_tests {
namespace {

/// Without the line that begins with a key.
std::string without(std::string content, const std::string& key) {
    const std::size_t begin = content.find("\n" + key + " = ");
    EXPECT_NE(begin, std::string::npos) << key;
    return content.erase(begin, content.find('\n', begin + 1) - begin);
}

TEST(Calibration, resumes_in_a_folder_whose_version_lacked_keys_that_have_their_defaults) {
    const testing_support::Folder folder;
    const io::Scene scene = io::parse_scene(R"(
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
    CalibrationOptions options;
    options.folder = folder / "trials";
    options.workers = 1;
    options.quiet = true;
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

}  // namespace
}  // namespace drover::jobs::calibration_tests
