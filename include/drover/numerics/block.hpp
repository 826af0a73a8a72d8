// numerics/block.hpp: functions of small real matrices: exponential, phi functions, covariance of noise, its factor.
#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace drover::numerics {

inline constexpr int max_block = 24;

/// A square matrix of at most max_block rows, row by row.
struct Block {
    Block() = default;
    explicit Block(int rows) : size(rows), outside(rows > max_inside ? entries() : 0) {}
    double& operator()(int i, int j) { return values()[static_cast<std::size_t>(i * size + j)]; }
    double operator()(int i, int j) const { return values()[static_cast<std::size_t>(i * size + j)]; }
    std::span<double> values() { return {size > max_inside ? outside.data() : inside.data(), entries()}; }
    std::span<const double> values() const { return {size > max_inside ? outside.data() : inside.data(), entries()}; }
    std::size_t entries() const { return static_cast<std::size_t>(size) * static_cast<std::size_t>(size); }
    bool operator==(const Block&) const = default;

    /// Blocks of so many rows need no memory of their own.
    static constexpr int max_inside = 4;
    int size = 0;
    std::array<double, max_inside * max_inside> inside{};
    std::vector<double> outside;
};

/// phi_0 = exp, phi_k(z) = sum_n z^n / (n + k)!, of the matrix z = m * dt: [k] is phi_k.
using PhiFunctions = std::vector<Block>;
inline constexpr int max_phi = 8;

/// phi_0 to phi_highest, 3 <= highest <= max_phi.  Every entry to rounding, however stiff m is: Taylor series on
/// a short interval in extended precision, then the doubling formulas for exp(z) - 1 in place of exp(z), so that slow
/// modes beside fast ones keep all their digits.  Throws a run Error when a mode overflows in one step.
/// Source: Hochbruck & Ostermann, Acta Numerica 19, 209 (2010), eq. (2.10); doubling: Skaflestad & Wright, Appl. Numer.
/// Math. 59, 783 (2009).
PhiFunctions phi_functions(const Block& m, double dt, int highest = 3);

/// The same numbers for the steps dt, dt/2, ..., dt/2^(count - 1), at hardly more than the cost of the longest.
std::vector<PhiFunctions> phi_functions_of_halves(const Block& m, double dt, int count, int highest = 3);

/// The increments of da = m a dt + noise of covariance q dt over the two halves of an interval, for a given increment
/// `whole` over all of it:
/// first = regression * whole + spread * (standard normal numbers), second = whole - propagator * first.
struct NoiseHalves {
    Block regression, spread, propagator;
};

/// The covariance of the increment over an interval, and what its halves need, and their halves.
struct NoiseTree {
    Block covariance;
    std::vector<NoiseHalves> halves;
};
/// The covariance over `whole`: the integral of exp(m s) q exp(m s)^T over 0 < s < whole; and for halves of the lengths
/// whole/2, ..., whole/2^count.  q symmetric, semi-definite.  Any whole >= 0; throws as phi_functions.
NoiseTree noise_tree(const Block& m, const Block& q, double whole, int count);

/// The rates of the modes of da/dt = m a, in no order.
std::vector<std::complex<double>> eigenvalues(const Block& m);

/// Stationary covariance s of the same process: m s + s m^T + q = 0.  Throws an input Error for matrices of different
/// sizes, and a run Error unless every mode decays.
Block stationary_covariance(const Block& m, const Block& q);

/// f with f f^T = c, for a covariance c that may be only semi-definite: each variable is scaled by its own deviation,
/// the largest remaining variance is eliminated first, and elimination stops at rounding errors.
/// Throws a run Error if c has a negative variance or a negative direction beyond rounding.
Block factor(const Block& c);

}  // namespace drover::numerics
