// tests/numerics/large_blocks.cpp: functions of blocks of a size known at run time alone, in 113-bit arithmetic.
#include <gtest/gtest.h>

#include <cmath>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"
#include "drover/numerics/block.hpp"
#include "numerics/extended.hpp"
#include "numerics/rod_bead_operator.hpp"

namespace drover::numerics::large_blocks_tests {
namespace {

using test::identity;
using test::QuadMatrix;
using test::scaled;

/// Every mode decays at 1 to 5 per second or so, with oscillations.
Block decaying_block(int size, std::uint64_t seed) {
    Block m(size);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, m.values());
    for (double& value : m.values()) value /= std::sqrt(size);
    for (int i = 0; i < size; ++i) m(i, i) -= 3.0;
    return m;
}

/// Noise of that rank.
Block noise_block(int size, int rank) {
    Block a(size), q(size);
    fill_normal({.seed = 5, .stream = Stream::test}, 0, 1, a.values());
    for (int i = 0; i < size; ++i)
        for (int j = 0; j < size; ++j)
            for (int k = 0; k < rank; ++k) q(i, j) += a(i, k) * a(j, k);
    return q;
}

double largest(const QuadMatrix& m) {
    double result = 0.0;
    for (const test::Quad value : m.a) result = std::max(result, std::abs(static_cast<double>(value)));
    return result;
}
double distance(const QuadMatrix& a, const QuadMatrix& b) { return largest(sum(a, scaled(b, -1))); }

TEST(LargeBlocks, phi_functions_are_those_of_the_exponential_up_to_the_largest_size) {
    for (const int size : {5, 9, max_block})
        for (const double dt : {0.01, 0.4, 30.0}) {
            const Block m = decaying_block(size, 2);
            const QuadMatrix z = scaled(QuadMatrix(m), dt);
            const PhiFunctions phi = phi_functions(m, dt, 5);
            EXPECT_LT(distance(QuadMatrix(phi[0]), exponential(QuadMatrix(m), dt)), 2e-16) << size << " " << dt;
            // phi_k = z phi_{k+1} + 1/k!; each is rounded once, at most at 1e-16.
            test::Quad factorial = 1;
            for (std::size_t k = 0; k < 5; ++k) {
                const QuadMatrix right = sum(product(z, QuadMatrix(phi[k + 1])), scaled(identity(size), 1 / factorial));
                EXPECT_LT(distance(QuadMatrix(phi[k]), right), 2e-16 * (1.0 + size * largest(z))) << size << " " << k;
                factorial *= static_cast<double>(k + 1);
            }
        }
}

TEST(LargeBlocks, of_two_copies_of_a_small_block_have_its_bits) {
    const Block m = test::rod_bead_operator({}, 0.7).even, q = noise_block(4, 4);
    const auto twice = [](const Block& block) {
        Block result(8);
        for (int i = 0; i < 4; ++i)
            for (int k = 0; k < 4; ++k) result(i, k) = result(i + 4, k + 4) = block(i, k);
        return result;
    };
    for (const double dt : {1e-3, 0.1, 20.0}) {
        const PhiFunctions small = phi_functions(m, dt), large = phi_functions(twice(m), dt);
        for (std::size_t k = 0; k < small.size(); ++k) EXPECT_EQ(large[k], twice(small[k])) << dt << " phi " << k;
        EXPECT_EQ(noise_tree(twice(m), twice(q), dt, 0).covariance, twice(noise_tree(m, q, dt, 0).covariance)) << dt;
    }
}

TEST(LargeBlocks, noise_has_the_covariance_of_an_independent_quadrature) {
    constexpr int size = 6;
    const Block m = decaying_block(size, 2);
    for (const int rank : {6, 3})
        for (const double dt : {1e-3, 0.1}) {
            const Block q = noise_block(size, rank);
            const NoiseTree tree = noise_tree(m, q, dt, 2);
            const QuadMatrix exact = covariance_by_quadrature(QuadMatrix(m), QuadMatrix(q), dt),
                             f(factor(tree.covariance));
            const double scale = largest(exact);
            EXPECT_LT(distance(QuadMatrix(tree.covariance), exact), 2e-16 * scale) << rank << " " << dt;
            // The elimination leaves out directions of less than 1e-11 of the variance.
            EXPECT_LT(distance(product(f, transposed(f)), exact), 1e-11 * scale) << rank << " " << dt;
            double half = dt / 2.0;
            QuadMatrix whole = exact;
            for (const NoiseHalves& found : tree.halves) {
                const QuadMatrix of_half = covariance_by_quadrature(QuadMatrix(m), QuadMatrix(q), half);
                const QuadMatrix k(found.regression), s(found.spread), e(found.propagator),
                    with_whole = product(k, whole),
                    first = sum(product(with_whole, transposed(k)), product(s, transposed(s))),
                    expected_with_whole = product(of_half, transposed(e));
                // As for small blocks: directions without variance beyond rounding are left out, here of 1e-14.
                EXPECT_LT(distance(first, of_half), 1e-8 * scale) << rank << " " << half;
                EXPECT_LT(distance(with_whole, expected_with_whole), 1e-6 * scale) << rank << " " << half;
                EXPECT_LT(distance(e, exponential(QuadMatrix(m), half)), 2e-16) << rank << " " << half;
                whole = of_half;
                half /= 2.0;
            }
        }
}

TEST(LargeBlocks, the_stationary_covariance_solves_its_equation) {
    for (const int size : {5, max_block}) {
        const Block m = decaying_block(size, 2), q = noise_block(size, size);
        const QuadMatrix s(stationary_covariance(m, q)), flow = product(QuadMatrix(m), s);
        // s is rounded at 1e-16 of itself; m has rows of a norm below 10.
        EXPECT_LT(distance(sum(flow, transposed(flow)), scaled(QuadMatrix(q), -1)), 20e-16 * 10.0 * largest(s)) << size;
        double trace = 0.0, sum = 0.0;
        for (const std::complex<double>& rate : eigenvalues(m)) sum += rate.real();
        for (int i = 0; i < size; ++i) trace += m(i, i);
        EXPECT_EQ(eigenvalues(m).size(), static_cast<std::size_t>(size));
        EXPECT_NEAR(sum, trace, 1e-13 * std::abs(trace));  // rounding
    }
    EXPECT_THROW(stationary_covariance(Block(7), noise_block(7, 7)), Error);
}

TEST(LargeBlocks, without_rows_are_allowed_and_beyond_the_largest_size_rejected) {
    const Block none(0);
    EXPECT_EQ(phi_functions(none, 1.0).size(), 4u);
    EXPECT_EQ(noise_tree(none, none, 1.0, 2).halves.size(), 2u);
    EXPECT_EQ(factor(stationary_covariance(none, none)).size, 0);
    EXPECT_TRUE(eigenvalues(none).empty());
    const Block beyond(max_block + 1);
    EXPECT_THROW(phi_functions(beyond, 1.0), Error);
    EXPECT_THROW(factor(beyond), Error);
    EXPECT_THROW(noise_tree(Block(6), Block(5), 1.0, 0).covariance, Error);
}

}  // namespace
}  // namespace drover::numerics::large_blocks_tests
