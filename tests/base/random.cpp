// tests/base/random.cpp: random numbers: known answers, independence of the request size, distribution.
#include "drover/base/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::random_tests {
namespace {

constexpr RandomKey key{.seed = 11, .stream = Stream::test, .step = 3, .substep = 1};

TEST(Random, numbers_are_the_published_philox4x64_10_of_counter_and_key) {
    // Known answer of Random123's kat_vectors for counter and key of zeros: the first word is 16554d9eca36314c.
    // Our key contains the stream, which is never zero, so the words are compared with a second implementation below.
    const auto high = [](std::uint64_t a, std::uint64_t b) {
        __extension__ typedef unsigned __int128 Wide;
        return static_cast<std::uint64_t>((static_cast<Wide>(a) * b) >> 64);
    };
    const auto philox = [&](std::array<std::uint64_t, 4> c, std::array<std::uint64_t, 2> k) {
        for (int round = 0; round < 10; ++round) {
            c = {high(0xCA5A826395121157u, c[2]) ^ c[1] ^ k[0], 0xCA5A826395121157u * c[2],
                 high(0xD2E7470EE14C6C93u, c[0]) ^ c[3] ^ k[1], 0xD2E7470EE14C6C93u * c[0]};
            k = {k[0] + 0x9E3779B97F4A7C15u, k[1] + 0xBB67AE8584CAA73Bu};
        }
        return c;
    };
    EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0})[0], 0x16554d9eca36314cu);
    std::vector<double> out(5);
    fill_uniform(key, 42, 5, out);
    for (std::size_t j = 0; j < 5; ++j) {
        const auto words =
            philox({42, key.step, key.substep, j / 4}, {key.seed, static_cast<std::uint64_t>(key.stream)});
        EXPECT_EQ(out[j], (static_cast<double>(words[j % 4] >> 11) + 0.5) / 9007199254740992.0);
    }
}

TEST(Random, numbers_do_not_depend_on_how_many_are_requested_at_once) {
    std::vector<double> whole(7 * 10), part(7 * 3);
    fill_normal(key, 100, 7, whole);
    fill_normal(key, 104, 7, part);
    for (std::size_t i = 0; i < part.size(); ++i) EXPECT_EQ(part[i], whole[4 * 7 + i]);
    std::vector<double> fewer(2);
    fill_normal(key, 104, 2, fewer);
    EXPECT_EQ(fewer[1], part[1]);
}

TEST(Random, numbers_differ_with_every_part_of_the_key) {
    const auto first = [](RandomKey changed, std::uint64_t index) {
        double out = 0.0;
        fill_normal(changed, index, 1, {&out, 1});
        return out;
    };
    const double here = first(key, 5);
    RandomKey other = key;
    other.seed = 12;
    EXPECT_NE(first(other, 5), here);
    other = key;
    other.stream = Stream::noise;
    EXPECT_NE(first(other, 5), here);
    other = key;
    other.step = 4;
    EXPECT_NE(first(other, 5), here);
    other = key;
    other.substep = 2;
    EXPECT_NE(first(other, 5), here);
    EXPECT_NE(first(key, 6), here);
}

TEST(Random, normal_numbers_have_normal_moments_and_uncorrelated_neighbours) {
    constexpr std::size_t count = 1000000;
    std::vector<double> x(count);
    fill_normal(key, 0, 4, x);
    double m1 = 0, m2 = 0, m3 = 0, m4 = 0, neighbour = 0;
    for (std::size_t i = 0; i < count; ++i) {
        m1 += x[i];
        m2 += x[i] * x[i];
        m3 += x[i] * x[i] * x[i];
        m4 += x[i] * x[i] * x[i] * x[i];
        neighbour += x[i] * x[(i + 1) % count];
    }
    // Five standard deviations: for x^n sqrt((<x^2n> - <x^n>^2) / count), with <x^2, 4, 6, 8> = 1, 3, 15, 105.
    const double n = count, root = std::sqrt(n);
    EXPECT_NEAR(m1 / n, 0.0, 5.0 / root);
    EXPECT_NEAR(m2 / n, 1.0, 5.0 * std::sqrt(2.0) / root);
    EXPECT_NEAR(m3 / n, 0.0, 5.0 * std::sqrt(15.0) / root);
    EXPECT_NEAR(m4 / n, 3.0, 5.0 * std::sqrt(96.0) / root);
    EXPECT_NEAR(neighbour / n, 0.0, 5.0 / root);
}

TEST(Random, a_length_that_is_not_a_multiple_of_per_index_is_rejected) {
    std::vector<double> out(5);
    EXPECT_THROW(fill_normal(key, 0, 2, out), Error);
}

}  // namespace
}  // namespace drover::random_tests
