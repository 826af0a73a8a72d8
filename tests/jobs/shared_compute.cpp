// tests/jobs/shared_compute.cpp: a calculation of many loops by several processes is that of one, whoever is killed.
#include "jobs/campaign/campaign.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <numbers>
#include <set>
#include <thread>

#include "drover/base/error.hpp"
#include "files/support.hpp"
#include "numerics/algebra/contour.hpp"

namespace drover::jobs::shared_compute_tests {
namespace {
using testing_support::Folder;

CampaignOptions options(const Folder& folder, Share share = {}, bool collect = false) {
    return {.job = {.folder = folder / "shared", .share = share, .workers = 1, .collect = collect, .quiet = true},
            .identity = {9, "a circle\n"},
            .times = {.renewal = std::chrono::milliseconds(50), .death = std::chrono::milliseconds(2000)}};
}

/// The processes that computed anything: each has a file of its own, "share-00002-...".
std::set<std::string> record_files(const Folder& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "shared/records"))
        names.insert(entry.path().filename().string());
    return names;
}

/// A calculation whose later loops depend on the numbers of earlier ones: the circle of radius .3 as a contour.
numerics::Contour circle(const ComputeAll& compute, std::chrono::microseconds each = {}) {
    const auto f = [each](const numerics::PlanePoint& at) {
        std::this_thread::sleep_for(each);
        return std::hypot(at.x - 0.51, at.y - 0.48) - 0.3;
    };
    return numerics::trace_zero(f, {}, {.cells = 8, .chord = 1e-3}, compute);
}

void expect_circle(const numerics::Contour& found) {
    Threads alone;
    const numerics::Contour expected = circle(on_threads(alone));
    ASSERT_EQ(found.lines.size(), 1u);
    ASSERT_EQ(found.lines.front().points.size(), expected.lines.front().points.size());
    for (std::size_t i = 0; i < expected.lines.front().points.size(); ++i) {
        EXPECT_EQ(found.lines.front().points[i].x, expected.lines.front().points[i].x);
        EXPECT_EQ(found.lines.front().points[i].y, expected.lines.front().points[i].y);
    }
    EXPECT_EQ(found.evaluations, expected.evaluations);
}

TEST(SharedCompute, one_process_goes_through_all_loops_and_another_finds_their_numbers) {
    const Folder folder;
    expect_circle(circle(shared_compute(options(folder))));
    EXPECT_GT(campaign_records(options(folder).job.folder, options(folder).identity).size(), 10u);
    const std::set<std::string> first = record_files(folder);
    EXPECT_EQ(first.size(), 1u);
    expect_circle(circle(shared_compute(options(folder))));
    EXPECT_EQ(record_files(folder), first);
    expect_circle(circle(shared_compute(options(folder, {}, true))));
}

TEST(SharedCompute, collecting_what_is_not_complete_says_so) {
    const Folder folder;
    {
        Campaign({.wanted = [](const Offer&) {}, .run = {}, .take = {}}, options(folder));
    }
    EXPECT_THROW(circle(shared_compute(options(folder, {}, true))), Interrupted);
}

TEST(SharedCompute, three_processes_one_of_which_is_killed_divide_the_loops) {
    const Folder folder;
    std::vector<pid_t> children;
    for (int share = 1; share <= 3; ++share) {
        const pid_t child = ::fork();
        if (child == 0) {
            const ComputeAll compute = shared_compute(options(folder, {.number = share, .count = 3}));
            ::_exit(circle(compute, std::chrono::microseconds(300)).lines.size() == 1 ? 0 : 1);
        }
        children.push_back(child);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(150));  // any moment will do
    ::kill(children.front(), SIGKILL);
    for (const pid_t child : children) {
        int status = 0;
        ::waitpid(child, &status, 0);
        EXPECT_TRUE(child == children.front() || status == 0) << status;
    }
    const std::set<std::string> shares = record_files(folder);
    for (const char* share : {"share-00002", "share-00003"})
        EXPECT_TRUE(std::ranges::any_of(shares, [&](const auto& name) { return name.starts_with(share); })) << share;
    expect_circle(circle(shared_compute(options(folder))));
    EXPECT_EQ(record_files(folder), shares);
}

TEST(SharedCompute, numbers_that_fail_end_the_calculation_with_their_reason) {
    const Folder folder;
    const ComputeAll compute = shared_compute(options(folder));
    try {
        compute(20, 1, [](std::size_t item, std::span<double> number) {
            if (item == 17) fail_input({}, "no state at 17");
            number[0] = 1.0;
        });
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("no state at 17"), std::string::npos);
    }
}
}  // namespace
}  // namespace drover::jobs::shared_compute_tests
