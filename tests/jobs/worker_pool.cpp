// tests/jobs/worker_pool.cpp: jobs that become available while others run, their results, and how they end.
#include "jobs/campaign/worker_pool.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <map>
#include <new>
#include <stdexcept>
#include <vector>

#include "drover/base/error.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs::worker_pool_tests {
namespace {

TEST(WorkerPool, jobs_that_become_available_while_others_run_are_run_and_return_results) {
    std::size_t known = 0, ended = 0, turns = 0;
    std::map<std::size_t, std::vector<std::string>> messages;
    const Jobs jobs{
        .next = [&]() -> std::optional<std::size_t> {
            if (known == 6 || known >= ended + 2) return std::nullopt;  // two at first, then one for each that ends
            return known++;
        },
        .work =
            [](std::size_t job, const Send& send) {
                send("");
                send(std::string(100000 * job,
                                 static_cast<char>('a' + job)));  // more than the capacity of a pipe
                return 0;
            },
        .received = [&](std::size_t job, const std::string& message) { messages[job].push_back(message); },
        .ended =
            [&](std::size_t job, int status) {
                ++ended;
                EXPECT_EQ(status, 0);
                EXPECT_EQ(messages[job],
                          (std::vector<std::string>{"", std::string(100000 * job, static_cast<char>('a' + job))}));
            },
        .idle = [&] { ++turns; }};
    EXPECT_FALSE(run_jobs(jobs, {.workers = 3}));
    EXPECT_EQ(ended, 6u);
    EXPECT_EQ(messages.size(), 6u);
    EXPECT_GT(turns, 0u);
}

TEST(WorkerPool, the_messages_before_a_kill_arrive_whole) {
    std::vector<std::string> messages;
    const Jobs jobs{.next = [n = 0]() mutable -> std::optional<std::size_t> {
                        return n++ == 0 ? std::optional<std::size_t>(0) : std::nullopt;
                    },
                    .work = [](std::size_t, const Send& send) -> int {
                        send("one");
                        send("two");
                        return ::kill(::getpid(), SIGKILL);
                    },
                    .received = [&](std::size_t, const std::string& message) { messages.push_back(message); },
                    .ended = [](std::size_t, int status) { EXPECT_EQ(status, 128 + SIGKILL); }};
    run_jobs(jobs, {.workers = 1});
    EXPECT_EQ(messages, (std::vector<std::string>{"one", "two"}));
}

TEST(WorkerPool, the_exit_status_of_a_worker_is_reported) {
    std::map<std::size_t, int> statuses;
    const Jobs jobs{.next = [n = std::size_t{0}]() mutable -> std::optional<std::size_t> {
                        return n < 4 ? std::optional(n++) : std::nullopt;
                    },
                    .work =
                        [](std::size_t job, const Send&) {
                            if (job == 2) ::kill(::getpid(), SIGKILL);
                            return job == 3 ? 7 : job == 1 ? 2 : 0;
                        },
                    .received = [](std::size_t, const std::string&) {},
                    .ended = [&](std::size_t job, int status) { statuses[job] = status; }};
    EXPECT_FALSE(run_jobs(jobs, {.workers = 2}));
    EXPECT_EQ(statuses, (std::map<std::size_t, int>{{0, 0}, {1, 2}, {2, 128 + SIGKILL}, {3, 7}}));
}

TEST(WorkerPool, a_worker_that_a_signal_alone_stopped_does_not_stop_the_others) {
    std::map<std::size_t, int> statuses;
    const Jobs jobs{.next = [n = std::size_t{0}]() mutable -> std::optional<std::size_t> {
                        return n < 2 ? std::optional(n++) : std::nullopt;
                    },
                    .work =
                        [](std::size_t job, const Send&) {
                            if (job == 0) ::raise(SIGTERM);
                            return run::stop_signal() != 0 ? run::exit_stopped : run::exit_done;
                        },
                    .received = [](std::size_t, const std::string&) {},
                    .ended = [&](std::size_t job, int status) { statuses[job] = status; }};
    EXPECT_FALSE(run_jobs(jobs, {.workers = 1}));
    EXPECT_EQ(statuses, (std::map<std::size_t, int>{{0, run::exit_stopped}, {1, run::exit_done}}));
}

TEST(WorkerPool, no_worker_survives_an_exception_of_the_caller) {
    const Jobs jobs{.next = [n = std::size_t{0}]() mutable -> std::optional<std::size_t> { return n++; },
                    .work =
                        [](std::size_t job, const Send&) {
                            if (job > 0) ::sleep(60);
                            return 0;
                        },
                    .received = [](std::size_t, const std::string&) {},
                    .ended = [](std::size_t, int) { fail_run("the disk is full"); }};
    EXPECT_THROW(run_jobs(jobs, {.workers = 3}), Error);
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
    EXPECT_EQ(errno, ECHILD);
}

void expect_end_by(Fault fault) {
    std::size_t started = 0, ended = 0;
    const Jobs jobs{.next = [&]() -> std::optional<std::size_t> { return started++; },
                    .work =
                        [&](std::size_t job, const Send&) {
                            if (job == 0) throw Error(fault, {"a.h5"}, "the disk is full");
                            for (;;) ::pause();  // until it is asked to stop
                            return 0;
                        },
                    .received = [](std::size_t, const std::string&) {},
                    .ended = [&](std::size_t, int) { ++ended; }};
    try {
        run_jobs(jobs, {.workers = 2, .grace_period = 0.0});
        FAIL() << "expected an Error";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), fault);
        EXPECT_STREQ(error.what(), "a.h5: the disk is full");
    }
    EXPECT_LE(started, 3u);  // at most one more while the first ended
    EXPECT_EQ(ended, 0u);
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
}

TEST(WorkerPool, an_error_ends_all_jobs_and_is_thrown_with_its_kind_and_its_sentence) {
    for (const Fault fault : {Fault::environment, Fault::input}) expect_end_by(fault);
}

TEST(WorkerPool, exceptions_of_memory_are_of_the_environment_and_unknown_ones_are_defects) {
    for (const bool is_memory : {true, false}) {
        const Jobs jobs{.next = [n = std::size_t{0}]() mutable -> std::optional<std::size_t> {
                            return n++ == 0 ? std::optional(n) : std::nullopt;
                        },
                        .work = [&](std::size_t, const Send&) -> int {
                            if (is_memory) throw std::bad_alloc();
                            throw std::logic_error("wrong");
                        },
                        .received = [](std::size_t, const std::string&) {},
                        .ended = [](std::size_t, int) {}};
        try {
            run_jobs(jobs, {.workers = 1});
            FAIL() << "expected an Error";
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), is_memory ? Fault::environment : Fault::defect) << error.what();
        }
    }
}

}  // namespace
}  // namespace drover::jobs::worker_pool_tests
