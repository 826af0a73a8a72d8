// tests/jobs/trials.cpp: failures of the scene are recorded, those of the disk stop the trials and are not.
#include "jobs/campaign/trials.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <utility>

#include "drover/base/error.hpp"
#include "files/bytes.hpp"
#include "files/support.hpp"
#include "io/scene.hpp"
#include "jobs/stop_rule.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs::trials_tests {
namespace {
using testing_support::Folder;

/// A flock that a large step makes diverge.
TrialRun trial(double dt = 0.1) {
    const std::string scene = text(
        "[relaxation]\nrate = -1.0\nsaturation = 1.0\n[elasticity]\nstiffness = 1.0\n[grid]\nnx = 8\nny = 8\n"
        "lx = 8.0\nly = 8.0\n[time]\ndt = {0}\nend = {1}\nstepper = \"etdrk4-krogstad\"\n[output]\n"
        "frame_every = {1}\nsample_every = {0}\n[initial]\nkind = \"formula\"\npolar_order_x = \"{2}\"\n",
        dt, 40.0 * dt, dt > 1.0 ? "1e200" : "0.5");
    return {.scene = io::parse_scene(scene, "trial.toml", {}, {})};
}

/// While it lives, no file grows beyond this size.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes) {
        run::ignore_file_size_signal();
        ::getrlimit(RLIMIT_FSIZE, &before_);
        const struct rlimit limit { bytes, before_.rlim_max };
        ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    struct rlimit before_ {};
};

TEST(Trials, a_full_disk_stops_them_is_not_recorded_and_the_next_command_runs_the_trial) {
    const Folder folder;
    {
        Trials trials("", {.folder = folder / "."});
        const FileSizeLimit limit(10000);
        try {
            trials.run({trial()});
            FAIL() << "expected an Error";
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::environment);
            EXPECT_THAT(error.what(), ::testing::HasSubstr("the largest file size allowed (ulimit -f) is reached"));
        }
        EXPECT_EQ(trials.find(trial()), nullptr);
    }
    Trials trials("", {.folder = folder / "."});
    EXPECT_EQ(trials.find(trial()), nullptr);
    EXPECT_TRUE(trials.run({trial()}));
    ASSERT_NE(trials.find(trial()), nullptr);
    EXPECT_FALSE(trials.find(trial())->failure);
}

/// Why the trial failed, as a new process finds it in the folder.
std::string recorded_failure(const std::filesystem::path& folder, const TrialRun& trial) {
    const Trials trials("", {.folder = folder});
    const TrialResult* result = trials.find(trial);
    return result == nullptr ? "no result" : result->failure.value_or("no failure");
}

TEST(Trials, a_failure_of_the_scene_is_recorded_and_read_as_earlier_versions_recorded_it) {
    const Folder folder;
    EXPECT_TRUE(Trials("", {.folder = folder / "."}).run({trial(2.0)}));
    const std::string failure = recorded_failure(folder / ".", trial(2.0));
    EXPECT_THAT(failure, ::testing::HasSubstr("NaN or infinite"));

    const files::RecordIdentity identity = files::identity_of("trials", "");
    UnitRecord record = campaign_records(folder / ".", identity).at(0);
    EXPECT_EQ(record.state, UnitState::failed);
    EXPECT_EQ(record.reason, failure);
    files::ByteWriter message;
    message(std::exchange(record.reason, ""), false);
    std::string& content = record.result.content;
    content.resize(content.size() - sizeof(std::uint64_t) - 1);  // no message, and no flag of the machine
    content += files::text_of(message.bytes);
    record.state = UnitState::done;
    std::filesystem::remove_all(folder / "records");
    UnitStore store(folder / ".", identity, {});
    store.append(record);
    store.sync();
    EXPECT_EQ(recorded_failure(folder / ".", trial(2.0)), failure);
}

TEST(Trials, for_which_three_machines_were_too_small_have_failed_in_a_share) {
    const Folder folder;
    Trials("", {.folder = folder / "."}).run({trial(2.0)});
    const files::RecordIdentity identity = files::identity_of("trials", "");
    UnitRecord record = campaign_records(folder / ".", identity).at(0);
    record.state = UnitState::lost;
    record.reason = "needs 349 MB";
    std::filesystem::remove_all(folder / "records");
    UnitStore store(folder / ".", identity, {});
    for (int machine = 0; machine < 3; ++machine) store.append(record);
    store.sync();
    Trials share("", {.folder = folder / ".", .share = {.number = 4, .count = 5}});
    EXPECT_EQ(share.find(trial(2.0)), nullptr);
    EXPECT_TRUE(share.run({trial(2.0)}));
    ASSERT_NE(share.find(trial(2.0)), nullptr);
    EXPECT_EQ(share.find(trial(2.0))->failure, "needs 349 MB");
}

TEST(Trials, that_fail_count_for_the_rules_that_stop_a_job) {
    const Folder folder;
    const ScopedStopRule stop("failures=1");
    Trials trials("", {.folder = folder / ".", .workers = 1});
    EXPECT_FALSE(trials.run({trial(2.0), trial(3.0)}));
    EXPECT_NE(trials.find(trial(2.0)), nullptr);
    EXPECT_EQ(trials.find(trial(3.0)), nullptr);
}

TEST(Trials, the_archive_of_another_run_of_a_trial_is_not_continued) {
    const Folder one, two;
    Trials trials("", {.folder = one / "."}), others("", {.folder = two / "."});
    trials.run({trial()});
    others.run({trial()});
    const std::filesystem::path archive = trials.find(trial())->archive;
    for (const char* end : {"", ".checkpoint-a", ".checkpoint-b"})
        std::filesystem::copy_file(others.find(trial())->archive.string() + end, archive.string() + end,
                                   std::filesystem::copy_options::overwrite_existing);
    TrialRun longer = trial();
    longer.scene.time.end *= 2.0;
    try {
        trials.run({longer});
        FAIL() << "expected an Error";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), ::testing::HasSubstr("the archive is of another run of this trial: run_id = "));
    }
    EXPECT_EQ(trials.find(longer), nullptr);
}

TEST(Trials, beside_the_checkpoints_of_another_run_stop_and_are_not_recorded) {
    const Folder one, two;
    Trials trials("", {.folder = one / "."}), others("", {.folder = two / "."});
    trials.run({trial()});
    others.run({trial()});
    for (const char* end : {".checkpoint-a", ".checkpoint-b"})
        std::filesystem::copy_file(others.find(trial())->archive.string() + end,
                                   trials.find(trial())->archive.string() + end,
                                   std::filesystem::copy_options::overwrite_existing);
    TrialRun longer = trial();
    longer.scene.time.end *= 2.0;
    EXPECT_THROW(trials.run({longer}), Error);
    EXPECT_EQ(Trials("", {.folder = one / "."}).find(longer), nullptr);
}

TEST(Trials, with_damaged_checkpoints_are_repeated_and_their_archive_is_kept) {
    const Folder folder;
    Trials trials("", {.folder = folder / "."});
    trials.run({trial()});
    const std::string archive = trials.find(trial())->archive.string();
    for (const char* end : {".checkpoint-a", ".checkpoint-b"}) std::ofstream(archive + end) << "damaged";
    TrialRun longer = trial();
    longer.scene.time.end *= 2.0;
    EXPECT_TRUE(trials.run({longer}));
    ASSERT_NE(trials.find(longer), nullptr);
    EXPECT_FALSE(trials.find(longer)->failure);
    EXPECT_TRUE(std::filesystem::exists(archive + ".damaged"));
}

TEST(Trials, tell_which_part_of_a_run_their_times_are_of) {
    const Folder folder;
    TrialRun longer = trial();
    longer.scene.time.end *= 2.0;
    {
        Trials trials("", {.folder = folder / "."});
        trials.run({trial()});
        EXPECT_NEAR(trials.find(trial())->timed, trial().scene.time.end, 1e-9);  // rounding
        trials.run({longer});
        EXPECT_NEAR(trials.find(longer)->timed, longer.scene.time.end, 1e-9);
        EXPECT_EQ(trials.find(trial()), trials.find(longer));
    }
    std::filesystem::remove_all(folder / "records");  // as a kill leaves it just before the record
    Trials trials("", {.folder = folder / "."});
    EXPECT_EQ(trials.find(longer), nullptr);
    EXPECT_TRUE(trials.run({longer}));
    ASSERT_NE(trials.find(longer), nullptr);
    EXPECT_EQ(trials.find(longer)->timed, 0.0);  // all steps had been made before
    EXPECT_FALSE(trials.find(longer)->failure);
}

TEST(Trials, that_are_only_collected_run_nothing) {
    const Folder folder;
    Trials("", {.folder = folder / "."}).run({trial()});
    Trials trials("", {.folder = folder / ".", .collect = true});
    EXPECT_TRUE(trials.run({trial(), trial(0.05)}));
    EXPECT_NE(trials.find(trial()), nullptr);
    EXPECT_EQ(trials.find(trial(0.05)), nullptr);
}

}  // namespace
}  // namespace drover::jobs::trials_tests
