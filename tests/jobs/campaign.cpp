// tests/jobs/campaign.cpp: units that processes share: each is done, whoever is killed, and its result is the same.
#include "jobs/campaign/campaign.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <random>
#include <thread>
#include <utility>

#include "drover/base/error.hpp"
#include "files/support.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "jobs/stop_rule.hpp"
#include "run/loop/provenance.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs::campaign_tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::Folder;

CampaignOutcome run_campaign(UnitPlan plan, CampaignOptions options) {
    return Campaign(std::move(plan), std::move(options)).run();
}

const files::RecordIdentity identity{5, "[run]\nseed = 1\n"};

std::string key_of(std::size_t unit) { return text("unit-{:04}", unit); }

/// Units that leave a mark when they run, and give a text.
class Units {
public:
    Units(const Folder& folder, std::size_t count, std::chrono::microseconds each)
        : folder_(folder), done_(count, false), each_(each) {}

    UnitPlan plan(const std::function<void(std::size_t)>& before = {}) {
        return {.wanted =
                    [this](const Offer& offer) {
                        for (std::size_t u = 0; u < done_.size(); ++u)
                            if (!done_[u] && !offer(key_of(u))) return;
                    },
                .run = [this, before](const std::string& key) -> std::optional<UnitResult> {
                    const std::size_t unit = std::stoul(key.substr(5));
                    if (before) before(unit);
                    std::this_thread::sleep_for(each_);
                    std::ofstream((folder_ / text("ran-{}-{}", key, ::getpid())).string());
                    return UnitResult{.content = "result of " + key, .shared = "common"};
                },
                .take =
                    [this](const UnitRecord& record) {
                        if (record.state == UnitState::done) done_[std::stoul(record.key.substr(5))] = true;
                    }};
    }

private:
    const Folder& folder_;
    std::vector<bool> done_;
    std::chrono::microseconds each_;
};

CampaignOptions options(const Folder& folder, Share share = {}, int workers = 1) {
    return {.job = {.folder = folder / "campaign", .share = share, .workers = workers, .quiet = true},
            .identity = identity,
            .times = {.renewal = std::chrono::milliseconds(50), .death = std::chrono::milliseconds(2000)}};
}

void expect_complete(const Folder& folder, std::size_t count) {
    const std::vector<UnitRecord> records = campaign_records(folder / "campaign", identity);
    ASSERT_EQ(records.size(), count);
    for (std::size_t u = 0; u < count; ++u) {
        EXPECT_EQ(records[u].key, key_of(u));
        EXPECT_EQ(records[u].state, UnitState::done);
        EXPECT_EQ(records[u].result.content, "result of " + key_of(u));
        EXPECT_EQ(records[u].result.shared, "common");
    }
}

std::size_t runs_in(const Folder& folder) { return folder.count() - 1; }

TEST(Campaign, goes_on_to_other_units_where_another_process_has_done_those_that_it_claimed) {
    const Folder folder;
    Units units(folder, 3, {});
    UnitStore other(folder / "campaign", identity, Share{.number = 2, .count = 2});
    UnitPlan plan = units.plan();
    bool is_done = false;  // the first unit, by the other process, just after it was claimed here
    plan.wanted = [&, wanted = plan.wanted](const Offer& offer) {
        wanted([&](const std::string& key) {
            const bool goes_on = offer(key);
            if (!std::exchange(is_done, true))
                other.append({.key = key,
                              .state = UnitState::done,
                              .result = {.content = "result of " + key, .shared = "common"},
                              .reason = {},
                              .program = "the same"}),
                    other.sync();
            return goes_on;
        });
    };
    const CampaignOutcome outcome = run_campaign(plan, options(folder));
    EXPECT_EQ(outcome.ran, 2u);
    expect_complete(folder, 3);
}

TEST(Campaign, stops_when_a_rule_is_met_and_the_next_call_goes_on) {
    struct Case {
        const char* rule;
        std::size_t least, most;  ///< jobs that run
    };
    // Every other one fails at once, the others take 30 ms and more: a tenth of a second is over after at most 7.
    for (const auto& [rule, least, most] : {Case{"failures=3", 6, 6}, {"jobs=5", 5, 5}, {"core-time=0.1s", 1, 7}}) {
        const Folder folder;
        {
            const ScopedStopRule stop(rule);
            Units units(folder, 20, std::chrono::milliseconds(30));
            UnitPlan plan = units.plan([](std::size_t unit) {
                if (unit % 2 == 1) fail_run("no such unit");
            });
            CampaignOptions one_by_one = options(folder);
            one_by_one.max_group = 1;
            const CampaignOutcome outcome = run_campaign(plan, one_by_one);
            EXPECT_TRUE(outcome.stopped);
            EXPECT_GE(outcome.ran, least) << rule;
            EXPECT_LE(outcome.ran, most) << rule;
            EXPECT_EQ(run::stop_reason(run::stop_signal()), text("--stop-when {}", rule));
        }
        Units units(folder, 20, {});
        EXPECT_FALSE(run_campaign(units.plan(), options(folder)).stopped);
        expect_complete(folder, 20);
    }
}

TEST(Campaign, that_is_complete_was_not_stopped_by_a_rule_that_its_last_unit_meets) {
    const Folder folder;
    const ScopedStopRule stop("jobs=4");
    Units units(folder, 4, {});
    EXPECT_FALSE(run_campaign(units.plan(), options(folder)).stopped);
    EXPECT_EQ(run::stop_signal(), 0);
    expect_complete(folder, 4);
}

TEST(StopRules, that_are_none_are_refused_with_those_that_there_are) {
    for (const char* wrong : {"failures", "failures=", "failures=0", "failures=1.5", "=3", "seconds=3", "core-time=x"})
        EXPECT_THROW(set_stop_rules({wrong}), Error) << wrong;
    try {
        set_stop_rules({"failure=3"});
        FAIL();
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("expected NAME=LIMIT with one of jobs, failures, core-time"));
    }
    EXPECT_TRUE(stop_rules().empty());
}

TEST(Campaign, every_unit_runs_once_and_none_when_it_is_repeated) {
    const Folder folder;
    for (int repeat = 0; repeat < 2; ++repeat) {
        Units units(folder, 20, {});
        const CampaignOutcome outcome = run_campaign(units.plan(), options(folder, {}, 3));
        EXPECT_EQ(outcome.ran, repeat == 0 ? 20u : 0u);
        expect_complete(folder, 20);
        EXPECT_EQ(runs_in(folder), 20u);
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder / "campaign" / "claims"));
}

TEST(Campaign, goes_on_when_more_is_wanted) {
    const Folder folder;
    Units units(folder, 5, {});
    UnitPlan plan = units.plan();
    std::size_t wanted = 2;
    plan.wanted = [&, all = plan.wanted](const Offer& offer) {
        all([&](const std::string& key) { return key >= key_of(wanted) || offer(key); });
    };
    Campaign campaign(plan, options(folder));
    EXPECT_EQ(campaign.run().ran, 2u);
    wanted = 5;
    EXPECT_EQ(campaign.run().ran, 3u);
    expect_complete(folder, 5);
    const auto records = std::filesystem::directory_iterator(folder / "campaign" / "records");
    EXPECT_EQ(std::distance(begin(records), end(records)), 1);  // one file for a process
}

TEST(Campaign, processes_share_the_units_and_none_runs_twice) {
    const Folder folder;
    constexpr int shares = 4;
    constexpr std::size_t count = 24;
    constexpr auto each = std::chrono::milliseconds(200);  // so that a look at the records is cheap beside a unit
    std::vector<pid_t> children;
    for (int i = 1; i <= shares; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            Units units(folder, count, each);
            run_campaign(units.plan(), options(folder, {.number = i, .count = shares}));
            ::_exit(0);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = 1;
        ::waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
    }
    expect_complete(folder, count);
    EXPECT_EQ(runs_in(folder), count);
}

// Kills at random moments, of the process and so of its workers, and a process that does the rest.
TEST(Campaign, whoever_is_killed_every_unit_is_done_in_the_end) {
    std::mt19937 random(3);
    for (int round = 0; round < 5; ++round) {
        const Folder folder;
        constexpr std::size_t count = 40;
        for (int kill = 0; kill < 4; ++kill) {
            const pid_t child = ::fork();
            if (child == 0) {
                Units units(folder, count, std::chrono::milliseconds(4));
                run_campaign(units.plan(), options(folder, {}, 2));
                ::_exit(0);
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(5 + random() % 60));
            ::kill(child, SIGKILL);
            ::waitpid(child, nullptr, 0);
        }
        Units units(folder, count, {});
        run_campaign(units.plan(), options(folder, {}, 2));
        expect_complete(folder, count);
    }
}

TEST(Campaign, a_share_that_finds_all_work_held_by_one_that_lives_ends_without_an_error) {
    const Folder folder;
    const pid_t holder = ::fork();
    if (holder == 0) {
        Units units(folder, 1, std::chrono::seconds(60));
        run_campaign(units.plan(), options(folder));
        ::_exit(0);
    }
    while (!std::filesystem::exists(folder / "campaign/claims/unit-0000.0"))
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Units units(folder, 1, {});
    const CampaignOutcome outcome = run_campaign(units.plan(), options(folder, {.number = 1, .count = 2}));
    EXPECT_EQ(outcome.held, 1u);
    EXPECT_EQ(outcome.ran, 0u);
    EXPECT_THAT(campaign_status(folder / "campaign", {}, {key_of(0)}), HasSubstr("0 of 1 done, 0 failed, 1 running"));
    ::kill(holder, SIGKILL);  // a plain call now takes the work of the dead
    ::waitpid(holder, nullptr, 0);
    EXPECT_EQ(run_campaign(units.plan(), options(folder)).ran, 1u);
    expect_complete(folder, 1);
}

TEST(Campaign, failures_are_kept_and_a_plain_call_tries_them_again) {
    const Folder folder;
    const auto fail = [](std::size_t unit) {
        if (unit == 1) fail_run("it diverged");
    };
    Units units(folder, 3, {});
    EXPECT_EQ(run_campaign(units.plan(fail), options(folder)).ran, 3u);
    std::vector<UnitRecord> records = campaign_records(folder / "campaign", identity);
    ASSERT_EQ(records.size(), 3u);
    EXPECT_EQ(records[1].state, UnitState::failed);
    EXPECT_EQ(records[1].reason, "it diverged");
    Units share(folder, 3, {});
    EXPECT_EQ(run_campaign(share.plan(fail), options(folder, {.number = 2, .count = 2})).ran, 0u);
    Units again(folder, 3, {});
    EXPECT_EQ(run_campaign(again.plan(), options(folder)).ran, 1u);
    expect_complete(folder, 3);
}

TEST(Campaign, a_unit_that_kills_its_worker_is_given_up_and_the_others_of_its_group_run) {
    const Folder folder;
    const auto crash = [](std::size_t unit) {
        if (unit == 4) ::raise(SIGKILL);
    };
    for (int tries = 1; tries <= 4; ++tries) {  // a share tries it three times in all
        Units units(folder, 9, {});
        EXPECT_EQ(run_campaign(units.plan(crash), options(folder, {.number = 1, .count = 2})).ran, tries == 1   ? 9u
                                                                                                   : tries <= 3 ? 1u
                                                                                                                : 0u);
    }
    const std::vector<UnitRecord> records = campaign_records(folder / "campaign", identity);
    ASSERT_EQ(records.size(), 9u);
    EXPECT_EQ(records[4].state, UnitState::lost);
    EXPECT_THAT(records[4].reason, HasSubstr("status 137"));
    for (const UnitRecord& record : records) EXPECT_EQ(record.state == UnitState::done, record.key != key_of(4));
}

TEST(Campaign, a_unit_whose_process_a_signal_stops_each_time_is_given_up_after_three) {
    const Folder folder;
    Units units(folder, 2, {});
    UnitPlan plan = units.plan();
    const auto run = plan.run;
    plan.run = [run](const std::string& key) { return key == key_of(0) ? std::nullopt : run(key); };
    EXPECT_FALSE(run_campaign(plan, options(folder)).stopped);
    const std::vector<UnitRecord> records = campaign_records(folder / "campaign", identity);
    ASSERT_EQ(records.size(), 2u);
    EXPECT_EQ(records[0].state, UnitState::lost);
    EXPECT_THAT(records[0].reason, HasSubstr("a signal stopped its process, 3 times"));
    EXPECT_EQ(records[1].state, UnitState::done);
}

TEST(Campaign, a_failure_of_the_disk_ends_it_keeps_what_has_ended_and_releases_the_rest) {
    const Folder folder;
    const auto fail = [](std::size_t unit) {
        if (unit == 3) fail_environment("the disk is full");
    };
    Units units(folder, 6, {});
    EXPECT_THROW(run_campaign(units.plan(fail), options(folder)), Error);
    EXPECT_EQ(campaign_records(folder / "campaign", identity).size(), 3u);
    EXPECT_TRUE(std::filesystem::is_empty(folder / "campaign" / "claims"));
    run_campaign(units.plan(), options(folder));
    expect_complete(folder, 6);
}

TEST(Campaign, mixed_files_end_it_and_nothing_is_recorded) {
    const Folder folder;
    const auto fail = [](std::size_t unit) {
        if (unit == 1) throw run::MixedFiles("unit.h5", "is of another run");
    };
    Units units(folder, 3, {});
    try {
        run_campaign(units.plan(fail), options(folder, {.number = 1, .count = 2}));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        EXPECT_STREQ(error.what(), "unit.h5: is of another run");
    }
    EXPECT_EQ(campaign_records(folder / "campaign", identity).size(), 1u);
    run_campaign(units.plan(), options(folder));
    expect_complete(folder, 3);
}

TEST(RunRecord, results_of_a_run_come_back_as_they_were) {
    const measure::Axis shell{"shell", "mm-1", "wavenumber", {0.5, 1.0, 1.5}};
    const RunResults given{
        .rows =
            {{"polar_order",
              "1",
              "time mean",
              {},
              {{.mean = 0.5, .error = 0.01, .autocorrelation_time = 3.0, .warm_up = 2.0, .samples = 90, .blocks = 9}}},
             {"binder", "1", "", {}, {{.mean = NAN, .why_no_error = "no error estimate: too short"}}},
             {"spectrum", "mm2", "S(q)", {shell}, {{.mean = 1.0, .error = 0.0}, {.mean = 2.0}, {.mean = 3.0}}}},
        .warnings = {"one", "two"}};
    const UnitResult bytes = encode(given);
    const RunResults back = decode(bytes);
    EXPECT_EQ(encode(back), bytes);
    EXPECT_THAT(back.warnings, ElementsAre("one", "two"));
    ASSERT_EQ(back.rows.size(), 3u);
    EXPECT_EQ(back.rows[0].estimates[0].error, 0.01);
    EXPECT_EQ(back.rows[0].estimates[0].blocks, 9u);
    EXPECT_EQ(back.rows[0].estimates[0].autocorrelation_time, 3.0);
    EXPECT_EQ(back.rows[1].estimates[0].why_no_error, "no error estimate: too short");
    EXPECT_EQ(back.rows[2].axes[0].values, shell.values);
    EXPECT_EQ(back.rows[2].estimates[2].mean, 3.0);
    for (std::size_t cut = 1; cut < bytes.content.size(); ++cut)
        EXPECT_THROW(decode({.content = bytes.content.substr(0, cut), .shared = bytes.shared}), Error) << cut;
}

}  // namespace
}  // namespace drover::jobs::campaign_tests
