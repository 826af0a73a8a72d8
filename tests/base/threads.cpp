// tests/base/threads.cpp: loops over chunks visit each index once and propagate exceptions.
#include "drover/base/threads.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace drover {
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

TEST(Threads, a_team_needs_at_least_one_thread) {
    EXPECT_ANY_THROW(Threads(0));
    EXPECT_GE(usable_cores(), 1);
}

}  // namespace
}  // namespace drover
