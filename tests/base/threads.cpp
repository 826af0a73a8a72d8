// tests/base/threads.cpp: loops over chunks visit each index once and propagate exceptions.
#include "drover/base/threads.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

namespace drover::threads_tests {
namespace {

TEST(Threads, a_loop_visits_every_index_exactly_once) {
    for (const int team : {1, 2, 5}) {
        Threads threads(team);
        EXPECT_EQ(threads.count(), team);
        for (const std::size_t length : {0u, 1u, 7u, 1000u})
            for (const std::size_t chunk : {1u, 3u, 2000u}) {
                std::vector<std::atomic<int>> visits(length);
                threads.for_chunks(length, chunk, [&](std::size_t begin, std::size_t end) {
                    EXPECT_EQ(begin % chunk, 0u) << "chunks depend on the length alone";
                    for (std::size_t i = begin; i < end; ++i) ++visits[i];
                });
                for (const auto& count : visits) EXPECT_EQ(count, 1);
            }
    }
}

TEST(Threads, an_exception_propagates_and_the_team_stays_usable) {
    Threads threads(3);
    EXPECT_THROW(threads.for_chunks(100, 1,
                                    [](std::size_t begin, std::size_t) {
                                        if (begin == 37) throw std::runtime_error("chunk 37");
                                    }),
                 std::runtime_error);
    std::atomic<int> sum = 0;
    threads.for_chunks(10, 1, [&](std::size_t begin, std::size_t) { sum += static_cast<int>(begin); });
    EXPECT_EQ(sum, 45);
}

/// The exit status of a child that does this; one that hangs is ended by a signal.
int status_of_child(const std::function<bool()>& holds) {
    const pid_t child = ::fork();
    if (child == 0) {
        ::alarm(20);
        ::_exit(holds() ? 0 : 1);
    }
    int status = -1;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return status;
}

TEST(Threads, the_child_of_a_fork_has_a_team_of_its_own_and_can_drop_that_of_its_parent) {
    auto threads = std::make_unique<Threads>(3);
    const auto sum_of_loop = [&threads] {
        std::atomic<int> sum = 0;
        threads->for_chunks(10, 1, [&](std::size_t begin, std::size_t) { sum += static_cast<int>(begin); });
        return sum.load();
    };
    EXPECT_EQ(sum_of_loop(), 45);
    EXPECT_EQ(status_of_child([&] {
                  threads.reset();
                  return true;
              }),
              0);
    EXPECT_EQ(status_of_child([&] {
                  const bool is_right = sum_of_loop() == 45 && sum_of_loop() == 45 && threads->count() == 3;
                  threads.reset();
                  return is_right;
              }),
              0);
    EXPECT_EQ(sum_of_loop(), 45);
}

TEST(Threads, a_fork_waits_for_a_mutex_so_that_the_child_finds_it_unlocked) {
    std::mutex& mutex = new_mutex_over_forks();
    std::atomic<bool> is_locked = false, is_over = false;
    std::thread other([&] {
        while (!is_over) {
            const std::lock_guard lock(mutex);
            is_locked = true;
        }
    });
    while (!is_locked) std::this_thread::yield();
    const std::uint64_t forks = fork_count();
    for (int k = 0; k < 20; ++k)
        EXPECT_EQ(status_of_child([&] {
                      const std::lock_guard lock(mutex);
                      return fork_count() == forks + 1;
                  }),
                  0);
    is_over = true;
    other.join();
    EXPECT_EQ(fork_count(), forks);
}

TEST(Threads, a_team_needs_at_least_one_thread) {
    EXPECT_ANY_THROW(Threads(0));
    EXPECT_GE(usable_cores(), 1);
}

}  // namespace
}  // namespace drover::threads_tests
