// tests/jobs/shared_compute.cpp: a calculation of many loops by several processes is that of one, whoever is killed.
#include "jobs/shared_compute.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <numbers>
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
    SharedCompute first(options(folder));
    expect_circle(circle(first.compute()));
    EXPECT_GT(first.computed(), 10u);
    SharedCompute second(options(folder));
    expect_circle(circle(second.compute()));
    EXPECT_EQ(second.computed(), 0u);
    SharedCompute collecting(options(folder, {}, true));
    expect_circle(circle(collecting.compute()));
}

TEST(SharedCompute, collecting_what_is_not_complete_says_so) {
    const Folder folder;
    {
        Campaign({.wanted = [](const Offer&) {}, .run = {}, .take = {}}, options(folder));
    }
    SharedCompute collecting(options(folder, {}, true));
    EXPECT_THROW(circle(collecting.compute()), Interrupted);
}

TEST(SharedCompute, three_processes_one_of_which_is_killed_divide_the_loops) {
    const Folder folder;
    std::vector<pid_t> children;
    for (int share = 1; share <= 3; ++share) {
        const pid_t child = ::fork();
        if (child == 0) {
            SharedCompute shared(options(folder, {.number = share, .count = 3}));
            const numerics::Contour found = circle(shared.compute(), std::chrono::microseconds(300));
            ::_exit(found.lines.size() == 1 && shared.computed() > 0 ? 0 : 1);
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
    SharedCompute after(options(folder));
    expect_circle(circle(after.compute()));
    EXPECT_EQ(after.computed(), 0u);
}

TEST(SharedCompute, numbers_that_fail_end_the_calculation_with_their_reason) {
    const Folder folder;
    SharedCompute shared(options(folder));
    const auto compute = shared.compute();
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
