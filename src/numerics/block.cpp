// numerics/block.cpp: functions of small matrices, computed in extended precision and rounded once.
#include "drover/numerics/block.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "drover/base/error.hpp"
#include "lyapunov_solver.hpp"

namespace drover::numerics {

namespace {
using Real = long double;  // 64 bits of mantissa on x86-64
// Sizes are known at run time alone, room for the largest is on the stack: unrolled code for each size takes minutes to
// compile.
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic, 0, max_block, max_block>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1, 0, max_block, 1>;

Matrix extended(const Block& block) {
    require(block.size >= 1 && block.size <= max_block, {}, "a block has {} rows; expected 1 to {}", block.size,
            max_block);
    Matrix result(block.size, block.size);
    for (int i = 0; i < block.size; ++i)
        for (int j = 0; j < block.size; ++j) result(i, j) = block(i, j);
    return result;
}

Block rounded(const Matrix& matrix) {
    Block result(static_cast<int>(matrix.rows()));
    for (int i = 0; i < result.size; ++i)
        for (int j = 0; j < result.size; ++j) result(i, j) = static_cast<double>(matrix(i, j));
    return result;
}

/// Halvings that bring the row-sum norm of m dt to 1/2 or less, after which 24 terms of a Taylor series are exact to
/// rounding.
int halvings(const Matrix& m, Real dt) {
    const Real norm = m.cwiseAbs().rowwise().sum().maxCoeff() * dt;
    if (!std::isfinite(norm)) fail_run("a linear operator has entries that are not finite; check the coefficients");
    return norm <= 0.5L ? 0 : static_cast<int>(std::ceil(std::log2(norm))) + 1;
}
constexpr int taylor_terms = 24;

void refuse_overflow(const Matrix& result, double dt) {
    const Real most = std::numeric_limits<double>::max();
    if (result.allFinite() && result.cwiseAbs().maxCoeff() < most) return;
    fail_run("a linear mode grows beyond the range of numbers in one step of dt = {}; choose a smaller dt", dt);
}

struct Exponential {
    Matrix propagator;        // exp(z)
    Matrix growth;            // exp(z) - 1, which keeps the digits of slow modes beside fast ones
    std::vector<Matrix> phi;  // from phi_1 on; [0] is not used
};

constexpr std::array<Real, max_phi + 1> factorials = [] {
    std::array<Real, max_phi + 1> result{1.0L};
    for (std::size_t n = 1; n < result.size(); ++n) result[n] = static_cast<Real>(n) * result[n - 1];
    return result;
}();

Matrix identity_like(const Matrix& m) { return Matrix::Identity(m.rows(), m.cols()); }

/// phi functions of z, |z| <= 1/2: the series of the highest, the others by phi_k = z phi_{k+1} + 1/k!.
Exponential short_exponential(const Matrix& z, std::size_t highest = 3) {
    const Matrix identity = identity_like(z);
    Exponential e{.propagator = {}, .growth = {}, .phi = std::vector<Matrix>(highest + 1)};
    e.phi[highest] = identity;
    for (int n = taylor_terms; n >= 1; --n)
        e.phi[highest] =
            (z * e.phi[highest] / static_cast<Real>(static_cast<std::size_t>(n) + highest) + identity).eval();
    e.phi[highest] /= factorials[highest];
    for (std::size_t k = highest - 1; k >= 1; --k) e.phi[k] = z * e.phi[k + 1] + identity / factorials[k];
    e.growth = z * e.phi[1];
    e.propagator = identity + e.growth;
    return e;
}

/// exp(2z) - 1 = 2 growth + growth^2; once every mode has decayed, exp(z) is small and its square is the better way.
void double_propagator(Exponential& e) {
    if (e.propagator.cwiseAbs().maxCoeff() < 0.5L) {
        e.propagator = (e.propagator * e.propagator).eval();
        e.growth = e.propagator - identity_like(e.propagator);
    } else {
        e.growth = (2.0L * e.growth + e.growth * e.growth).eval();
        e.propagator = identity_like(e.growth) + e.growth;
    }
}

void double_interval(Exponential& e) {
    for (std::size_t n = e.phi.size() - 1; n >= 2; --n) {
        const std::size_t lower = n / 2, upper = n - lower;
        Matrix sum = e.phi[lower] * e.phi[upper];
        if (upper > lower) sum += e.phi[upper] / factorials[lower];
        for (std::size_t j = upper + 1; j <= n; ++j) sum += 2.0L / factorials[n - j] * e.phi[j];
        e.phi[n] = std::ldexp(1.0L, -static_cast<int>(n)) * sum;
    }
    e.phi[1] = (e.phi[1] + e.growth * e.phi[1] / 2.0L).eval();
    double_propagator(e);
}
}  // namespace

PhiFunctions phi_functions(const Block& m, double dt, int highest) {
    require(highest >= 3 && highest <= max_phi, {}, "phi functions up to {}; expected 3 to {}", highest, max_phi);
    const Matrix rates = extended(m);
    const int doublings = halvings(rates, dt);
    Exponential e = short_exponential(rates * std::ldexp(Real(dt), -doublings), static_cast<std::size_t>(highest));
    for (int i = 0; i < doublings; ++i) double_interval(e);
    refuse_overflow(e.propagator, dt);
    PhiFunctions result{rounded(e.propagator)};
    for (std::size_t k = 1; k < e.phi.size(); ++k) result.push_back(rounded(e.phi[k]));
    return result;
}

namespace {
struct NoisyInterval {
    Matrix covariance, propagator;
};

struct ShortNoisyInterval {
    NoisyInterval interval;
    Exponential e;
};

/// |rates| interval <= 1/2.
ShortNoisyInterval short_noisy_interval(const Matrix& rates, const Block& q, double dt) {
    const Real interval = dt;
    // sum of interval^(n+1)/(n+1)! applied n times: c -> m c + c m^T, on q.
    Matrix term = extended(q) * interval;
    Matrix covariance = term;
    for (int n = 1; n <= taylor_terms; ++n) {
        term = ((rates * term + term * rates.transpose()) * (interval / Real(n + 1))).eval();
        covariance += term;
    }
    Exponential e = short_exponential(rates * interval);
    return {{covariance, e.propagator}, e};
}

/// Calls found(k, interval) for intervals of dt/2^k, k < count, from the shortest to dt.
template <class Found>
void for_noisy_intervals(const Block& m, const Block& q, double dt, int count, Found found) {
    const Matrix rates = extended(m);
    const int doublings = halvings(rates, dt);
    for (int k = count - 1; k > doublings; --k) found(k, short_noisy_interval(rates, q, std::ldexp(dt, -k)).interval);
    auto [now, e] = short_noisy_interval(rates, q, std::ldexp(dt, -doublings));
    for (int k = doublings;; --k) {
        if (k < count) {
            refuse_overflow(now.covariance, std::ldexp(dt, -k));
            found(k, now);
        }
        if (k == 0) return;
        now.covariance += (e.propagator * now.covariance * e.propagator.transpose()).eval();
        now.covariance = ((now.covariance + now.covariance.transpose()) / 2.0L).eval();
        double_propagator(e);
        now.propagator = e.propagator;
    }
}

/// Less than this, relative to the variances, is rounding of their entries, not variance.
Real rounding_of(Eigen::Index size) { return 16.0L * static_cast<Real>(size) * std::numeric_limits<double>::epsilon(); }

/// Square roots of the diagonal.
Vector deviations(const Matrix& covariance) {
    Vector result(covariance.rows());
    for (Eigen::Index i = 0; i < covariance.rows(); ++i) {
        const Real variance = covariance(i, i);
        if (!(variance >= 0.0L) || !std::isfinite(variance))
            fail_run("a noise covariance has the variance {}; expected a finite number >= 0",
                     static_cast<double>(variance));
        result(i) = std::sqrt(variance);
    }
    return result;
}

/// Row i divided by rows(i), column k by columns(k); zero where one of them is.
Matrix scaled(const Matrix& matrix, const Vector& rows, const Vector& columns) {
    Matrix result(matrix.rows(), matrix.cols());
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
        for (Eigen::Index k = 0; k < matrix.cols(); ++k) {
            const Real scale = rows(i) * columns(k);
            result(i, k) = scale > 0.0L ? matrix(i, k) / scale : 0.0L;
        }
    return result;
}

/// f of f f^T = `rest`, in the order of elimination; leaves in `rest` what is below rounding.
struct Elimination {
    Matrix factor;
    std::vector<int> pivots;
};
Elimination eliminate(Matrix& rest) {
    const auto n = static_cast<int>(rest.rows());
    Elimination result{.factor = Matrix::Zero(n, n), .pivots = {}};
    for (int column = 0; column < n; ++column) {
        const Real largest = rest.diagonal().maxCoeff();
        if (largest <= rounding_of(n)) break;
        // The first of those that are as large: which of two equal ones is larger is a matter of rounding.
        int pivot = 0;
        while (rest(pivot, pivot) < 0.999L * largest) ++pivot;
        result.pivots.push_back(pivot);
        result.factor.col(column) = rest.col(pivot) / std::sqrt(rest(pivot, pivot));
        rest -= (result.factor.col(column) * result.factor.col(column).transpose()).eval();
        rest.row(pivot).setZero();
        rest.col(pivot).setZero();
    }
    return result;
}

bool is_rounding(const Matrix& rest) {
    return rest.diagonal().minCoeff() >= -1e-12L && rest.cwiseAbs().maxCoeff() <= 1e-11L;
}

/// f f^T = covariance, to rounding relative to the variances themselves or, where they are differences of much larger
/// ones with the deviations `of_terms`, relative to those.
Matrix factor_of(const Matrix& covariance, const Vector& of_terms) {
    Vector deviation = deviations(covariance);
    Matrix rest = scaled(covariance, deviation, deviation);
    Matrix f = eliminate(rest).factor;
    if (!is_rounding(rest)) {
        deviation = of_terms;
        rest = scaled(covariance, deviation, deviation);
        f = eliminate(rest).factor;
    }
    if (!is_rounding(rest))
        fail_run("a noise covariance is not positive: a direction has the relative variance {:.3g}; expected >= 0",
                 static_cast<double>(rest.diagonal().minCoeff()));
    return deviation.asDiagonal() * f;
}

/// The r for which r c has the least distance from `cross`, the covariance of something with a variable of covariance
/// c.  Directions of c without variance get none.
Matrix regression_on(const Matrix& c, const Matrix& cross, const Vector& deviation_of_it) {
    const Vector deviation = deviations(c);
    Matrix rest = scaled(c, deviation, deviation);
    const Elimination known = eliminate(rest);
    const auto rank = static_cast<int>(known.pivots.size());
    // In the normalised variables of the elimination, then back: row pivots[k] of the factor ends at column k.
    Matrix result = Matrix::Zero(cross.rows(), c.rows());
    Matrix on_normal = Matrix::Zero(cross.rows(), c.rows());
    const Matrix scaled_cross = scaled(cross, deviation_of_it, deviation);
    const auto diagonal = [&](int k) { return known.factor(known.pivots[static_cast<std::size_t>(k)], k); };
    for (int k = 0; k < rank; ++k) {
        const int pivot = known.pivots[static_cast<std::size_t>(k)];
        Vector rest_of_cross = scaled_cross.col(pivot);
        for (int j = 0; j < k; ++j) rest_of_cross -= on_normal.col(j) * known.factor(pivot, j);
        on_normal.col(k) = rest_of_cross / diagonal(k);
    }
    for (int k = rank - 1; k >= 0; --k) {
        const int pivot = known.pivots[static_cast<std::size_t>(k)];
        Vector left = on_normal.col(k);
        for (int j = k + 1; j < rank; ++j) {
            const int later = known.pivots[static_cast<std::size_t>(j)];
            left -= result.col(later) * known.factor(later, k);
        }
        result.col(pivot) = left / diagonal(k);
    }
    Matrix unscaled(result.rows(), result.cols());
    for (Eigen::Index i = 0; i < result.rows(); ++i)
        for (Eigen::Index k = 0; k < result.cols(); ++k)
            unscaled(i, k) = deviation(k) > 0.0L ? deviation_of_it(i) * result(i, k) / deviation(k) : 0.0L;
    return unscaled;
}
}  // namespace

Block noise_covariance(const Block& m, const Block& q, double dt) {
    Block result;
    for_noisy_intervals(m, q, dt, 1, [&](int, const NoisyInterval& found) { result = rounded(found.covariance); });
    return result;
}

namespace {
NoiseHalves halves_of(const NoisyInterval& half, double dt) {
    const Matrix with_whole = half.covariance * half.propagator.transpose();  // of the first half with the whole
    const Matrix whole = half.propagator * with_whole + half.covariance;
    refuse_overflow(whole, 2.0 * dt);
    const Matrix regression =
        regression_on((whole + whole.transpose()) / 2.0L, with_whole, deviations(half.covariance));
    Matrix spread = half.covariance - regression * with_whole.transpose();
    spread = ((spread + spread.transpose()) / 2.0L).eval();
    // What is left of a variable that the whole determines is rounding, of either sign.
    for (Eigen::Index i = 0; i < spread.rows(); ++i)
        if (spread(i, i) <= rounding_of(spread.rows()) * half.covariance(i, i)) {
            spread.row(i).setZero();
            spread.col(i).setZero();
        }
    return {rounded(regression), rounded(factor_of(spread, deviations(half.covariance))), rounded(half.propagator)};
}
}  // namespace

std::vector<NoiseHalves> noise_halves(const Block& m, const Block& q, double dt, int count) {
    std::vector<NoiseHalves> result(static_cast<std::size_t>(count));
    for_noisy_intervals(m, q, dt, count, [&](int k, const NoisyInterval& half) {
        result[static_cast<std::size_t>(k)] = halves_of(half, std::ldexp(dt, -k));
    });
    return result;
}

NoiseTree noise_tree(const Block& m, const Block& q, double whole, int count) {
    NoiseTree result{.covariance = {}, .halves = std::vector<NoiseHalves>(static_cast<std::size_t>(count))};
    for_noisy_intervals(m, q, whole, count + 1, [&](int k, const NoisyInterval& found) {
        if (k == 0) result.covariance = rounded(found.covariance);
        else result.halves[static_cast<std::size_t>(k - 1)] = halves_of(found, std::ldexp(whole, -k));
    });
    return result;
}

std::vector<std::complex<double>> eigenvalues(const Block& m) {
    const Eigen::MatrixXd in_double = extended(m).cast<double>();
    const Eigen::VectorXcd rates = in_double.eigenvalues();
    return {rates.begin(), rates.end()};
}

Block stationary_covariance(const Block& m, const Block& q) {
    using ComplexMatrix = Eigen::Matrix<std::complex<Real>, Eigen::Dynamic, Eigen::Dynamic, 0, max_block, max_block>;
    const ComplexMatrix rates = extended(m).cast<std::complex<Real>>(), noise = extended(q).cast<std::complex<Real>>();
    ComplexMatrix covariance;
    const Real largest = solve_lyapunov(rates, noise, covariance);
    if (!(largest < 0.0L))
        fail_run("no stationary state: a linear mode grows at {:.4g} /s; expected every mode to decay",
                 static_cast<double>(largest));
    return rounded(covariance.real());
}

Block factor(const Block& c) {
    const Matrix covariance = extended(c);
    return rounded(factor_of(covariance, deviations(covariance)));
}

}  // namespace drover::numerics
