// numerics/algebra/block.cpp: functions of small matrices, computed in extended precision and rounded once.
#include "drover/numerics/block.hpp"

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "drover/base/error.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/algebra/extended_matrix.hpp"

namespace drover::numerics {

namespace {
using Real = ExtendedReal;
template <int N>
using Matrix = ExtendedMatrix<N>;
template <int N>
using Vector = ExtendedVector<N>;

/// body<N>() for the size of a block.
template <class Body>
auto for_size(const Block& block, Body body) {
    require(block.size >= 0 && block.size <= max_block, {}, "a block has {} rows; expected 0 to {}", block.size,
            max_block);
    switch (block.size) {
        case 1: return body.template operator()<1>();
        case 2: return body.template operator()<2>();
        case 3: return body.template operator()<3>();
        case 4: return body.template operator()<4>();
        default: return body.template operator()<any_size>();
    }
}
static_assert(Block::max_inside == 4);

template <int N>
Matrix<N> extended(const Block& block, const Block& partner) {
    require(block.size == partner.size, {}, "a block has {} rows; expected {}, as its partner", block.size,
            partner.size);
    Matrix<N> result(block.size);
    const std::span<const double> values = block.values();
    std::ranges::copy(values, result.values.begin());
    return result;
}

template <int N>
Block rounded(const Matrix<N>& matrix) {
    Block result(matrix.rows());
    std::transform(matrix.values.begin(), matrix.values.end(), result.values().begin(),
                   [](Real value) { return static_cast<double>(value); });
    return result;
}

/// Halvings that bring the row-sum norm of m dt to 1/2 or less, after which 24 terms of a Taylor series are exact to
/// rounding.
template <int N>
int halvings(const Matrix<N>& m, Real dt) {
    Real norm = 0.0L;
    for (int i = 0; i < m.rows(); ++i) {
        Real sum = 0.0L;
        for (int j = 0; j < m.rows(); ++j) sum += std::abs(m(i, j));
        if (!(sum <= norm)) norm = sum;  // a NaN stays
    }
    norm *= dt;
    if (!std::isfinite(norm)) fail_run("a linear operator has entries that are not finite; check the coefficients");
    return norm <= 0.5L ? 0 : static_cast<int>(std::ceil(std::log2(norm))) + 1;
}
constexpr int taylor_terms = 24;

template <int N>
void refuse_overflow(const Matrix<N>& result, double dt) {
    const Real max_real = std::numeric_limits<double>::max();
    if (std::ranges::all_of(result.values, [&](Real value) { return std::abs(value) < max_real; })) return;
    fail_run("a linear mode grows beyond the range of numbers in one step of dt = {}; choose a smaller dt", dt);
}

template <int N>
struct Exponential {
    Matrix<N> propagator;                    // exp(z)
    Matrix<N> growth;                        // exp(z) - 1, which keeps the digits of slow modes beside fast ones
    std::array<Matrix<N>, max_phi + 1> phi;  // from phi_1 to phi_highest
    int highest = 3;
};

constexpr std::array<Real, max_phi + 1> factorials = [] {
    std::array<Real, max_phi + 1> result{1.0L};
    for (std::size_t n = 1; n < result.size(); ++n) result[n] = static_cast<Real>(n) * result[n - 1];
    return result;
}();

/// phi functions of z, |z| <= 1/2: the series of the highest, the others by phi_k = z phi_{k+1} + 1/k!.
template <int N>
Exponential<N> short_exponential(const Matrix<N>& z, int highest = 3) {
    const Matrix<N> one = identity<N>(z.rows());
    Exponential<N> e{.highest = highest};
    const auto order = static_cast<std::size_t>(highest);
    e.phi[order] = one;
    for (int n = taylor_terms; n >= 1; --n) e.phi[order] = z * e.phi[order] / static_cast<Real>(n + highest) + one;
    e.phi[order] = e.phi[order] / factorials[order];
    for (std::size_t k = order - 1; k >= 1; --k) e.phi[k] = z * e.phi[k + 1] + one / factorials[k];
    e.growth = z * e.phi[1];
    e.propagator = one + e.growth;
    return e;
}

/// exp(2z) - 1 = 2 growth + growth^2; once every mode has decayed, exp(z) is small and its square is the better way.
template <int N>
void double_propagator(Exponential<N>& e) {
    if (max_abs(e.propagator) < 0.5L) {
        e.propagator = e.propagator * e.propagator;
        e.growth = e.propagator - identity<N>(e.growth.rows());
    } else {
        e.growth = 2.0L * e.growth + e.growth * e.growth;
        e.propagator = identity<N>(e.growth.rows()) + e.growth;
    }
}

template <int N>
void double_interval(Exponential<N>& e) {
    for (auto n = static_cast<std::size_t>(e.highest); n >= 2; --n) {
        const std::size_t lower = n / 2, upper = n - lower;
        Matrix<N> sum = e.phi[lower] * e.phi[upper];
        if (upper > lower) sum += e.phi[upper] / factorials[lower];
        for (std::size_t j = upper + 1; j <= n; ++j) sum += 2.0L / factorials[n - j] * e.phi[j];
        e.phi[n] = std::ldexp(1.0L, -static_cast<int>(n)) * sum;
    }
    e.phi[1] = e.phi[1] + e.growth * e.phi[1] / 2.0L;
    double_propagator(e);
}

template <int N>
PhiFunctions rounded(const Exponential<N>& e, double dt) {
    refuse_overflow(e.propagator, dt);
    PhiFunctions result{rounded(e.propagator)};
    for (int k = 1; k <= e.highest; ++k) result.push_back(rounded(e.phi[static_cast<std::size_t>(k)]));
    return result;
}

template <int N>
struct NoisyInterval {
    Matrix<N> covariance;
    Exponential<N> e;
};

/// |rates| interval <= 1/2.
template <int N>
NoisyInterval<N> short_noisy_interval(const Matrix<N>& rates, const Matrix<N>& q, double dt) {
    const Real interval = dt;
    // sum of interval^(n+1)/(n+1)! applied n times: c -> m c + c m^T, on q, which keeps c symmetric.
    Matrix<N> term = interval * q;
    Matrix<N> covariance = term;
    for (int n = 1; n <= taylor_terms; ++n) {
        const Matrix<N> half = rates * term;
        term = (interval / Real(n + 1)) * (half + transposed(half));
        covariance += term;
    }
    return {covariance, short_exponential<N>(interval * rates)};
}

/// Calls found(k, covariance, propagator) for intervals of dt/2^k, k < count, from the shortest to dt.
template <int N, class Found>
void for_noisy_intervals(const Block& m, const Block& q, double dt, int count, Found found) {
    const Matrix<N> rates = extended<N>(m, m), noise = extended<N>(q, m);
    const int doublings = halvings(rates, dt);
    const auto report = [&](int k, const NoisyInterval<N>& interval) {
        if (k >= count) return;
        refuse_overflow(interval.covariance, std::ldexp(dt, -k));
        found(k, interval.covariance, interval.e.propagator);
    };
    for (int k = count - 1; k > doublings; --k) report(k, short_noisy_interval(rates, noise, std::ldexp(dt, -k)));
    NoisyInterval<N> now = short_noisy_interval(rates, noise, std::ldexp(dt, -doublings));
    for (int k = doublings;; --k) {
        report(k, now);
        if (k == 0) return;
        now.covariance += now.e.propagator * now.covariance * transposed(now.e.propagator);
        now.covariance = symmetric_part(now.covariance);
        double_propagator(now.e);
    }
}

/// Less than this, relative to the variances, is rounding of their entries, not variance.
Real rounding_of(int size) { return 16.0L * static_cast<Real>(size) * std::numeric_limits<double>::epsilon(); }

/// Square roots of the diagonal.
template <int N>
Vector<N> deviations(const Matrix<N>& covariance) {
    Vector<N> result(static_cast<std::size_t>(covariance.rows()));
    for (int i = 0; i < covariance.rows(); ++i) {
        const Real variance = covariance(i, i);
        if (!(variance >= 0.0L) || !std::isfinite(variance))
            fail_run("a noise covariance has the variance {}; expected a finite number >= 0",
                     static_cast<double>(variance));
        result[static_cast<std::size_t>(i)] = std::sqrt(variance);
    }
    return result;
}

/// Row i divided by rows(i), column k by columns(k); zero where one of them is.
template <int N>
Matrix<N> scaled(const Matrix<N>& matrix, const Vector<N>& rows, const Vector<N>& columns) {
    Matrix<N> result(matrix.rows());
    for (int i = 0; i < matrix.rows(); ++i)
        for (int k = 0; k < matrix.rows(); ++k) {
            const Real scale = rows[static_cast<std::size_t>(i)] * columns[static_cast<std::size_t>(k)];
            result(i, k) = scale > 0.0L ? matrix(i, k) / scale : 0.0L;
        }
    return result;
}

/// The largest variance, or 0.
template <int N>
Real max_diagonal(const Matrix<N>& matrix) {
    Real largest = 0.0L;
    for (int i = 0; i < matrix.rows(); ++i) largest = std::max(largest, matrix(i, i));
    return largest;
}

/// The least variance, or 0.
template <int N>
Real min_diagonal(const Matrix<N>& matrix) {
    Real min_entry = 0.0L;
    for (int i = 0; i < matrix.rows(); ++i) min_entry = std::min(min_entry, matrix(i, i));
    return min_entry;
}

/// f of f f^T = `rest`, in the order of elimination; leaves in `rest` what is below rounding.
template <int N>
struct Elimination {
    Matrix<N> factor;
    std::array<int, max_block> pivots{};
    int rank = 0;
};
template <int N>
Elimination<N> eliminate(Matrix<N>& rest) {
    const int rows = rest.rows();
    Elimination<N> result{.factor = Matrix<N>(rows)};
    for (int column = 0; column < rows; ++column) {
        const Real largest = max_diagonal(rest);
        if (largest <= rounding_of(rows)) break;
        // The first of those that are as large: which of two equal ones is larger is a matter of rounding.
        int pivot = 0;
        while (rest(pivot, pivot) < 0.999L * largest) ++pivot;
        result.pivots[static_cast<std::size_t>(result.rank++)] = pivot;
        const Real deviation = std::sqrt(rest(pivot, pivot));
        for (int i = 0; i < rows; ++i) result.factor(i, column) = rest(i, pivot) / deviation;
        for (int i = 0; i < rows; ++i)
            for (int k = 0; k < rows; ++k) rest(i, k) -= result.factor(i, column) * result.factor(k, column);
        for (int i = 0; i < rows; ++i) rest(pivot, i) = rest(i, pivot) = 0.0L;
    }
    return result;
}

template <int N>
bool is_rounding(const Matrix<N>& rest) {
    return min_diagonal(rest) >= -1e-12L && max_abs(rest) <= 1e-11L;
}

/// f f^T = covariance, to rounding relative to the variances themselves or, where they are differences of much larger
/// ones with the deviations `of_terms`, relative to those.
template <int N>
Matrix<N> factor_of(const Matrix<N>& covariance, const Vector<N>& of_terms) {
    Vector<N> deviation = deviations(covariance);
    Matrix<N> rest = scaled(covariance, deviation, deviation);
    Matrix<N> f = eliminate(rest).factor;
    if (!is_rounding(rest)) {
        deviation = of_terms;
        rest = scaled(covariance, deviation, deviation);
        f = eliminate(rest).factor;
    }
    if (!is_rounding(rest))
        fail_run("a noise covariance is not positive: a direction has the relative variance {:.3g}; expected >= 0",
                 static_cast<double>(min_diagonal(rest)));
    for (int i = 0; i < f.rows(); ++i)
        for (int k = 0; k < f.rows(); ++k) f(i, k) *= deviation[static_cast<std::size_t>(i)];
    return f;
}

/// The r for which r c has the least distance from `cross`, the covariance of something with a variable of covariance
/// c.  Directions of c without variance get none.
template <int N>
Matrix<N> regression_on(const Matrix<N>& c, const Matrix<N>& cross, const Vector<N>& deviation_of_it) {
    const int rows = c.rows();
    const Vector<N> deviation = deviations(c);
    Matrix<N> rest = scaled(c, deviation, deviation);
    const Elimination<N> known = eliminate(rest);
    // In the normalised variables of the elimination, then back: row pivots[k] of the factor ends at column k.
    Matrix<N> result(rows), on_normal(rows), unscaled(rows);
    const Matrix<N> scaled_cross = scaled(cross, deviation_of_it, deviation);
    const auto pivot_of = [&](int k) { return known.pivots[static_cast<std::size_t>(k)]; };
    for (int k = 0; k < known.rank; ++k)
        for (int i = 0; i < rows; ++i) {
            Real left = scaled_cross(i, pivot_of(k));
            for (int j = 0; j < k; ++j) left -= on_normal(i, j) * known.factor(pivot_of(k), j);
            on_normal(i, k) = left / known.factor(pivot_of(k), k);
        }
    for (int k = known.rank - 1; k >= 0; --k)
        for (int i = 0; i < rows; ++i) {
            Real left = on_normal(i, k);
            for (int j = k + 1; j < known.rank; ++j) left -= result(i, pivot_of(j)) * known.factor(pivot_of(j), k);
            result(i, pivot_of(k)) = left / known.factor(pivot_of(k), k);
        }
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < rows; ++k) {
            const Real of_it = deviation_of_it[static_cast<std::size_t>(i)],
                       of_c = deviation[static_cast<std::size_t>(k)];
            unscaled(i, k) = of_c > 0.0L ? of_it * result(i, k) / of_c : 0.0L;
        }
    return unscaled;
}

template <int N>
NoiseHalves halves_of(const Matrix<N>& half, const Matrix<N>& propagator, double dt) {
    const int rows = half.rows();
    const Matrix<N> with_whole = half * transposed(propagator);  // of the first half with the whole
    const Matrix<N> whole = propagator * with_whole + half;
    refuse_overflow(whole, 2.0 * dt);
    const Vector<N> deviation = deviations(half);
    const Matrix<N> regression = regression_on(symmetric_part(whole), with_whole, deviation);
    Matrix<N> spread = symmetric_part(half - regression * transposed(with_whole));
    // What is left of a variable that the whole determines is rounding, of either sign.
    for (int i = 0; i < rows; ++i)
        if (spread(i, i) <= rounding_of(rows) * half(i, i))
            for (int k = 0; k < rows; ++k) spread(i, k) = spread(k, i) = 0.0L;
    return {rounded(regression), rounded(factor_of(spread, deviation)), rounded(propagator)};
}

template <class Scalar>
using DynamicMatrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar>
DynamicMatrix<Scalar> matrix_of(const Block& block) {
    DynamicMatrix<Scalar> result(block.size, block.size);
    for (int i = 0; i < block.size; ++i)
        for (int j = 0; j < block.size; ++j) result(i, j) = block(i, j);
    return result;
}
}  // namespace

std::vector<PhiFunctions> phi_functions_of_halves(const Block& m, double dt, int count, int highest) {
    require(highest >= 3 && highest <= max_phi, {}, "phi functions up to {}; expected 3 to {}", highest, max_phi);
    std::vector<PhiFunctions> result(static_cast<std::size_t>(count));
    for_size(m, [&]<int N>() {
        const Matrix<N> rates = extended<N>(m, m);
        const int doublings = halvings(rates, dt);
        const auto short_interval = [&](int k) {
            return short_exponential<N>(std::ldexp(Real(dt), -k) * rates, highest);
        };
        const auto keep = [&](int k, const Exponential<N>& e) {
            if (k < count) result[static_cast<std::size_t>(k)] = rounded(e, std::ldexp(dt, -k));
        };
        for (int k = doublings + 1; k < count; ++k) keep(k, short_interval(k));
        Exponential<N> e = short_interval(doublings);
        keep(doublings, e);
        for (int k = doublings - 1; k >= 0; --k) {
            double_interval(e);
            keep(k, e);
        }
    });
    return result;
}

PhiFunctions phi_functions(const Block& m, double dt, int highest) {
    return std::move(phi_functions_of_halves(m, dt, 1, highest).front());
}

NoiseTree noise_tree(const Block& m, const Block& q, double whole, int count) {
    NoiseTree result{.covariance = {}, .halves = std::vector<NoiseHalves>(static_cast<std::size_t>(count))};
    for_size(m, [&]<int N>() {
        const auto keep = [&](int k, const Matrix<N>& covariance, const Matrix<N>& propagator) {
            if (k == 0) result.covariance = rounded(covariance);
            else
                result.halves[static_cast<std::size_t>(k - 1)] =
                    halves_of(covariance, propagator, std::ldexp(whole, -k));
        };
        for_noisy_intervals<N>(m, q, whole, count + 1, keep);
    });
    return result;
}

std::vector<std::complex<double>> eigenvalues(const Block& m) {
    if (m.size == 0) return {};
    const Eigen::VectorXcd rates = dense_eigenvalues(balanced(matrix_of<double>(m)));
    return {rates.begin(), rates.end()};
}

double solve_lyapunov_precisely(const Eigen::MatrixXcd& m, const Eigen::MatrixXcd& q, Eigen::MatrixXcd& s) {
    using ComplexMatrix = DynamicMatrix<std::complex<Real>>;
    if (m.rows() == 0) {
        s = q;
        return -std::numeric_limits<double>::infinity();
    }
    const ComplexMatrix noise = q.cast<std::complex<Real>>();
    ComplexMatrix covariance;
    const Eigen::ComplexSchur<ComplexMatrix> schur(m.cast<std::complex<Real>>());
    const Real largest = solve_lyapunov_of_schur<ComplexMatrix>(schur.matrixT(), schur.matrixU(), noise, covariance);
    if (largest < 0.0L) s = covariance.cast<std::complex<double>>();
    return static_cast<double>(largest);
}

Block stationary_covariance(const Block& m, const Block& q) {
    require(m.size == q.size, {}, "a noise of {} rows of an operator of {}; expected as many", q.size, m.size);
    Block result(m.size);
    if (m.size == 0) return result;
    Eigen::MatrixXcd covariance;
    const double largest =
        solve_lyapunov_precisely(matrix_of<std::complex<double>>(m), matrix_of<std::complex<double>>(q), covariance);
    if (!(largest < 0.0))
        fail_run("no stationary state: a linear mode grows at {:.4g} /s; expected every mode to decay", largest);
    for (int i = 0; i < m.size; ++i)
        for (int j = 0; j < m.size; ++j) result(i, j) = covariance(i, j).real();
    return result;
}

Block factor(const Block& c) {
    return for_size(c, [&]<int N>() {
        const Matrix<N> covariance = extended<N>(c, c);
        return rounded(factor_of(covariance, deviations(covariance)));
    });
}

}  // namespace drover::numerics
