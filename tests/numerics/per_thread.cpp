// tests/numerics/per_thread.cpp: an object of each thread.
#include "numerics/fields/per_thread.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace drover::numerics::per_thread_tests {
namespace {

std::atomic<int> alive = 0;
struct Counted {
    Counted() { ++alive; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    ~Counted() { --alive; }
    int value = 0;
};

TEST(PerThread, EachThreadHasItsOwnObjectWhichEndsWithIt) {
    static PerThread<Counted> objects;
    objects.get().value = 1;
    std::thread([&] {
        EXPECT_EQ(objects.get().value, 0);
        objects.get().value = 2;
        EXPECT_EQ(objects.get().value, 2);
        EXPECT_EQ(alive, 2);
    }).join();
    EXPECT_EQ(alive, 1);
    EXPECT_EQ(objects.get().value, 1);
}

}  // namespace
}  // namespace drover::numerics::per_thread_tests
