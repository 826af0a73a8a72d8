// tests/numerics/extended.hpp: an independent reference in 113-bit arithmetic: matrices, exponential, covariance of
// noise.
#pragma once
#include <cmath>
#include <vector>

#include "drover/numerics/block.hpp"

namespace drover::test {

__extension__ typedef __float128 Quad;

inline Quad size(Quad a) { return a < 0 ? -a : a; }

struct QuadMatrix {
    int n = 0;
    std::vector<Quad> a;
    explicit QuadMatrix(int rows) : n(rows), a(static_cast<std::size_t>(rows * rows), Quad(0)) {}
    explicit QuadMatrix(const numerics::Block& block) : QuadMatrix(block.size) {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) (*this)(i, j) = block(i, j);
    }
    Quad& operator()(int i, int j) { return a[static_cast<std::size_t>(i * n + j)]; }
    Quad operator()(int i, int j) const { return a[static_cast<std::size_t>(i * n + j)]; }
};

inline QuadMatrix identity(int n) {
    QuadMatrix result(n);
    for (int i = 0; i < n; ++i) result(i, i) = 1;
    return result;
}

inline QuadMatrix product(const QuadMatrix& x, const QuadMatrix& y) {
    QuadMatrix result(x.n);
    for (int i = 0; i < x.n; ++i)
        for (int k = 0; k < x.n; ++k)
            for (int j = 0; j < x.n; ++j) result(i, j) += x(i, k) * y(k, j);
    return result;
}

inline QuadMatrix transposed(const QuadMatrix& x) {
    QuadMatrix result(x.n);
    for (int i = 0; i < x.n; ++i)
        for (int j = 0; j < x.n; ++j) result(i, j) = x(j, i);
    return result;
}

inline QuadMatrix scaled(const QuadMatrix& x, Quad factor) {
    QuadMatrix result = x;
    for (Quad& value : result.a) value *= factor;
    return result;
}

inline QuadMatrix sum(const QuadMatrix& x, const QuadMatrix& y) {
    QuadMatrix result = x;
    for (std::size_t k = 0; k < result.a.size(); ++k) result.a[k] += y.a[k];
    return result;
}

/// exp(m dt) by 60 terms of the series on dt / 2^k and k squarings.
inline QuadMatrix exponential(const QuadMatrix& m, Quad dt) {
    Quad norm = 0;
    for (const Quad value : m.a) norm = norm > size(value) ? norm : size(value);
    int squarings = 0;
    for (Quad z = norm * dt * m.n; z > 0.25; z /= 2) ++squarings;
    Quad interval = dt;
    for (int k = 0; k < squarings; ++k) interval /= 2;
    QuadMatrix term = identity(m.n), result = identity(m.n);
    for (int k = 1; k <= 60; ++k) {
        term = scaled(product(term, m), interval / k);
        result = sum(result, term);
    }
    for (int k = 0; k < squarings; ++k) result = product(result, result);
    return result;
}

/// x with a x = b, by elimination with full pivoting.
inline std::vector<Quad> solved(std::vector<std::vector<Quad>> a, std::vector<Quad> b) {
    const std::size_t n = b.size();
    std::vector<std::size_t> order(n);
    for (std::size_t k = 0; k < n; ++k) order[k] = k;
    for (std::size_t k = 0; k < n; ++k) {
        std::size_t row = k, column = k;
        for (std::size_t i = k; i < n; ++i)
            for (std::size_t j = k; j < n; ++j)
                if (size(a[i][j]) > size(a[row][column])) {
                    row = i;
                    column = j;
                }
        std::swap(a[k], a[row]);
        std::swap(b[k], b[row]);
        std::swap(order[k], order[column]);
        for (auto& line : a) std::swap(line[k], line[column]);
        for (std::size_t i = k + 1; i < n; ++i) {
            const Quad factor = a[i][k] / a[k][k];
            for (std::size_t j = k; j < n; ++j) a[i][j] -= factor * a[k][j];
            b[i] -= factor * b[k];
        }
    }
    std::vector<Quad> x(n);
    for (std::size_t k = n; k-- > 0;) {
        Quad value = b[k];
        for (std::size_t j = k + 1; j < n; ++j) value -= a[k][j] * x[order[j]];
        x[order[k]] = value / a[k][k];
    }
    return x;
}

/// s with m s + s m^T + q = 0: also where modes grow, as long as no two rates add to zero.
inline QuadMatrix lyapunov(const QuadMatrix& m, const QuadMatrix& q) {
    const auto place = [&](int i, int j) { return static_cast<std::size_t>(i * m.n + j); };
    const auto entries = static_cast<std::size_t>(m.n * m.n);
    std::vector<std::vector<Quad>> a(entries, std::vector<Quad>(entries, Quad(0)));
    std::vector<Quad> b(entries);
    for (int i = 0; i < m.n; ++i)
        for (int j = 0; j < m.n; ++j) {
            b[place(i, j)] = -q(i, j);
            for (int k = 0; k < m.n; ++k) {
                a[place(i, j)][place(k, j)] += m(i, k);
                a[place(i, j)][place(i, k)] += m(j, k);
            }
        }
    QuadMatrix s(m.n);
    s.a = solved(std::move(a), std::move(b));
    return s;
}

/// Covariance of the noise over dt by s - e s e^T: exact, and free of cancellation where the exponents are not small.
inline QuadMatrix covariance_by_difference(const QuadMatrix& m, const QuadMatrix& q, Quad dt) {
    const QuadMatrix s = lyapunov(m, q), e = exponential(m, dt);
    return sum(s, scaled(product(product(e, s), transposed(e)), -1));
}

/// The same by Gauss-Legendre quadrature of e^(m s) q e^(m s)^T with 40 points: where the exponents are at most about
/// 1.
inline QuadMatrix covariance_by_quadrature(const QuadMatrix& m, const QuadMatrix& q, Quad dt) {
    constexpr int points = 40;
    QuadMatrix result(m.n);
    for (int k = 0; k < points; ++k) {
        Quad x = std::cos(3.14159265358979323846 * (k + 0.75) / (points + 0.5)), slope = 0;
        for (int iteration = 0; iteration < 8; ++iteration) {  // Newton on the Legendre polynomial
            Quad before = 1, value = x;
            for (int j = 2; j <= points; ++j) {
                const Quad next = ((2 * j - 1) * x * value - (j - 1) * before) / j;
                before = value;
                value = next;
            }
            slope = points * (x * value - before) / (x * x - 1);
            x -= value / slope;
        }
        const Quad weight = 2 / ((1 - x * x) * slope * slope);
        const QuadMatrix e = exponential(m, dt * (x + 1) / 2);
        result = sum(result, scaled(product(product(e, q), transposed(e)), weight * dt / 2));
    }
    return result;
}

}  // namespace drover::test
