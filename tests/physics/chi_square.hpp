// tests/physics/chi_square.hpp: whether the modes of independent realisations have a given law: sums of squares and
// their tails.
#pragma once
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "drover/numerics/grid.hpp"

namespace drover::physics {

inline constexpr std::uint64_t seed = 20141021;  // fixed before the first run

/// Regularised upper incomplete gamma function: probability that a chi-square of 2 a degrees exceeds 2 x.  Series
/// below a + 1, continued fraction above (Abramowitz & Stegun 6.5.29, 6.5.31).
inline double upper_gamma(double a, double x) {
    if (x <= 0.0) return 1.0;
    const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
    if (x < a + 1.0) {
        double term = 1.0 / a, sum = term;
        for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) sum += term *= x / n;
        return 1.0 - front * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for (int n = 1; n < 100000; ++n) {
        const double an = -n * (n - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        const double factor = d * c;
        h *= factor;
        if (std::abs(factor - 1.0) < 1e-16) break;
    }
    return front * h;
}

/// Two-sided probability of a sum of squares of `degrees` standard normal numbers.
inline double two_sided(double squares, double degrees) {
    const double above = upper_gamma(0.5 * degrees, 0.5 * squares);
    return 2.0 * std::min(above, 1.0 - above);
}

/// Modes kept for products of a degree that stand for themselves and their conjugates: the half plane, with the half
/// column kx = 0, ky > 0.
inline std::vector<std::size_t> independent_modes(const numerics::Grid& grid, int degree) {
    std::vector<std::size_t> result;
    for (std::size_t m = 1; m < numerics::modes(grid); ++m) {
        const std::size_t column = m % numerics::columns(grid), row = m / numerics::columns(grid);
        if (numerics::is_kept(grid, degree, column, row) && (column > 0 || 2 * row < static_cast<std::size_t>(grid.ny)))
            result.push_back(m);
    }
    return result;
}

/// Sums of squares over realisations, of every mode and every pair of its variables: independent complex normal
/// numbers of unit variance, if the law is right.
struct Tally {
    std::vector<std::vector<double>>
        of_mode;  ///< |zi|^2, then |zi + zj|^2/2 and |zi + i zj|^2/2 of the pairs, all twice
    double whole = 0.0;
    std::size_t variables = 0;
    int realisations = 0;

    Tally(std::size_t modes, std::size_t the_variables)
        : of_mode(modes, std::vector<double>(the_variables * the_variables)), variables(the_variables) {}

    void add(std::size_t mode, std::span<const std::complex<double>> z) {
        const std::complex<double> i(0.0, 1.0);
        auto sum = of_mode[mode].begin();
        for (const std::complex<double> value : z) {
            // Real and imaginary part have half of the variance each: twice the square is a chi-square of two degrees.
            *sum++ += 2.0 * std::norm(value);
            whole += 2.0 * std::norm(value);
        }
        for (std::size_t a = 0; a < z.size(); ++a)
            for (std::size_t b = a + 1; b < z.size(); ++b) {
                *sum++ += std::norm(z[a] + z[b]);
                *sum++ += std::norm(z[a] + i * z[b]);
            }
    }
};

struct Verdict {
    double min = 1.0;    ///< least probability of all modes and pairs, times their number (Bonferroni)
    double whole = 1.0;  ///< probability of the complete set
};

inline Verdict diagnosis(const Tally& tally) {
    Verdict result;
    const double degrees = 2.0 * tally.realisations, count = static_cast<double>(tally.of_mode.size()),
                 variables = static_cast<double>(tally.variables);
    for (const auto& mode : tally.of_mode)
        for (const double squares : mode)
            result.min = std::min(result.min, two_sided(squares, degrees) * variables * variables * count);
    result.whole = two_sided(tally.whole, degrees * variables * count);
    return result;
}

}  // namespace drover::physics
