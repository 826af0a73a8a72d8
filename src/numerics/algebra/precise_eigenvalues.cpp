// numerics/algebra/precise_eigenvalues.cpp: the complex QR algorithm in quadruple precision.
#include "numerics/algebra/dense.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
__extension__ typedef __float128 Quad;
constexpr double unit_roundoff = 0x1p-112;

/// One Newton step from the root in extended precision doubles its 64 bits.
Quad root(Quad x) {
    if (!(x > 0)) return 0;
    const Quad first = std::sqrt(static_cast<long double>(x));
    return (first + x / first) / 2;
}

// The operators of std::complex are for built-in types only.
struct Number {
    Quad re = 0, im = 0;
};
Number operator+(Number a, Number b) { return {a.re + b.re, a.im + b.im}; }
Number operator-(Number a, Number b) { return {a.re - b.re, a.im - b.im}; }
Number operator*(Number a, Number b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
Number operator*(Quad a, Number b) { return {a * b.re, a * b.im}; }
Number conj(Number a) { return {a.re, -a.im}; }
Quad norm(Number a) { return a.re * a.re + a.im * a.im; }
Quad size(Number a) { return root(norm(a)); }
Number operator/(Number a, Number b) { return (1 / norm(b)) * (a * conj(b)); }

/// The square root with a real part that is not negative.
Number root(Number a) {
    const Quad length = size(a), re = root((length + a.re) / 2), im = root((length - a.re) / 2);
    return {re, a.im < 0 ? -im : im};
}

struct Matrix {
    int rows;
    std::vector<Number> values;
    Number& operator()(int i, int j) { return values[static_cast<std::size_t>(i * rows + j)]; }
};

Matrix identity(int rows) {
    Matrix result{rows, std::vector<Number>(static_cast<std::size_t>(rows * rows))};
    for (int i = 0; i < rows; ++i) result(i, i) = {1, 0};
    return result;
}

/// The unitary matrix that turns (x, y) into (r, 0), and its inverse.
struct Rotation {
    Number c, s;
    Rotation(Number x, Number y) {
        const Quad length = root(norm(x) + norm(y));
        if (length > 0) c = (1 / length) * x, s = (1 / length) * y;
        else c = {1, 0};
    }
    /// Rows i and i + 1, from a column on: they are zero before it.
    void turn_rows(Matrix& t, int i, int first) const {
        for (int j = first; j < t.rows; ++j) {
            const Number a = t(i, j), b = t(i + 1, j);
            t(i, j) = conj(c) * a + conj(s) * b;
            t(i + 1, j) = c * b - s * a;
        }
    }
    /// Columns i and i + 1, up to a row: they are zero below it.
    void turn_columns(Matrix& t, int i, int last) const {
        for (int k = 0; k <= last; ++k) {
            const Number a = t(k, i), b = t(k, i + 1);
            t(k, i) = c * a + s * b;
            t(k, i + 1) = conj(c) * b - conj(s) * a;
        }
    }
};

/// t becomes upper Hessenberg; u t u^H stays as it is, for a u that has rows.
void reduce_to_hessenberg(Matrix& t, Matrix& u) {
    for (int column = 0; column + 2 < t.rows; ++column)
        for (int row = t.rows - 2; row > column; --row) {
            const Rotation turn(t(row, column), t(row + 1, column));
            turn.turn_rows(t, row, column);
            t(row + 1, column) = {};  // exactly: rounding errors below would stop tiny blocks from converging
            turn.turn_columns(t, row, t.rows - 1);
            turn.turn_columns(u, row, u.rows - 1);
        }
}

/// The eigenvalue of the last two rows down to `last` that is nearer to the last diagonal element.
Number wilkinson_shift(Matrix& t, int last) {
    const Number a = t(last - 1, last - 1), d = t(last, last), half = Quad(0.5) * (a - d);
    const Number product = t(last - 1, last) * t(last, last - 1);
    const Number discriminant = root(half * half + product);
    const Number plus = half + discriminant, minus = half - discriminant;
    const Number larger = norm(plus) > norm(minus) ? plus : minus;
    if (norm(larger) == 0) return d;
    return d - product / larger;
}

/// t becomes upper triangular; u t u^H stays as it is, for a u that has rows.
void triangularise(Matrix& t, Matrix& u) {
    constexpr int max_iterations = 60;
    for (int last = t.rows - 1, iterations = 0; last > 0;) {
        int first = last;
        while (first > 0) {
            const Quad beside = size(t(first, first)) + size(t(first - 1, first - 1));
            if (size(t(first, first - 1)) <= Quad(unit_roundoff) * beside) break;
            --first;
        }
        if (first > 0) t(first, first - 1) = {};
        if (first == last) {
            --last;
            iterations = 0;
            continue;
        }
        if (++iterations > max_iterations)
            fail_run("the eigenvalues of a linear mode do not converge; choose less extreme coefficients");
        const Number shift =
            iterations % 11 == 10 ? Number{size(t(last, last - 1)), 0} + t(last, last) : wilkinson_shift(t, last);
        Number x = t(first, first) - shift, y = t(first + 1, first);
        for (int i = first; i < last; ++i) {
            const Rotation turn(x, y);
            turn.turn_rows(t, i, std::max(i - 1, first));
            if (i > first) t(i + 1, i - 1) = {};
            turn.turn_columns(t, i, std::min(i + 2, last));
            turn.turn_columns(u, i, u.rows - 1);
            if (i + 2 <= last) x = t(i + 1, i), y = t(i + 2, i);
        }
    }
}

/// Eigenvector k of the triangular matrix, by back substitution.
std::vector<Number> triangular_vector(Matrix& t, int k, Quad smallest) {
    std::vector<Number> x(static_cast<std::size_t>(t.rows));
    x[static_cast<std::size_t>(k)] = {1, 0};
    for (int i = k - 1; i >= 0; --i) {
        Number sum;
        for (int j = i + 1; j <= k; ++j) sum = sum + t(i, j) * x[static_cast<std::size_t>(j)];
        Number gap = t(k, k) - t(i, i);
        if (size(gap) < smallest) gap = {smallest, 0};  // a defective matrix: the vectors are parallel to rounding
        x[static_cast<std::size_t>(i)] = sum / gap;
    }
    return x;
}

bool loses_slow_modes(const Eigen::MatrixXcd& m, const Eigen::VectorXcd& values) {
    constexpr double digits = 1e6;
    const double rounding = std::numeric_limits<double>::epsilon() * m.norm();
    return std::ranges::any_of(values, [&](const std::complex<double>& value) {
        return std::abs(value.real()) < digits * rounding;
    });
}

/// The triangular matrix; u: identity(m.rows()), or of no rows where the vectors are not wanted.
Matrix schur_form(const Eigen::MatrixXcd& m, Matrix& u) {
    Matrix t{static_cast<int>(m.rows()), {}};
    for (int i = 0; i < t.rows; ++i)
        for (int j = 0; j < t.rows; ++j) t.values.push_back({m(i, j).real(), m(i, j).imag()});
    reduce_to_hessenberg(t, u);
    triangularise(t, u);
    return t;
}

std::complex<double> rounded(Number a) { return {static_cast<double>(a.re), static_cast<double>(a.im)}; }
}  // namespace

DenseEigen precise_eigen(const Eigen::MatrixXcd& m) {
    const int rows = static_cast<int>(m.rows());
    Matrix u = identity(rows), t = schur_form(m, u);
    DenseEigen result{.values = Eigen::VectorXcd(rows), .vectors = Eigen::MatrixXcd(rows, rows)};
    const Quad smallest = Quad(unit_roundoff) * Quad(m.norm()) + Quad(std::numeric_limits<double>::min());
    for (int k = 0; k < rows; ++k) {
        result.values(k) = rounded(t(k, k));
        const std::vector<Number> inner = triangular_vector(t, k, smallest);
        std::vector<Number> vector(static_cast<std::size_t>(rows));
        Quad length = 0;
        for (int i = 0; i < rows; ++i) {
            for (int j = 0; j <= k; ++j)
                vector[static_cast<std::size_t>(i)] =
                    vector[static_cast<std::size_t>(i)] + u(i, j) * inner[static_cast<std::size_t>(j)];
            length += norm(vector[static_cast<std::size_t>(i)]);
        }
        for (int i = 0; i < rows; ++i)
            result.vectors(i, k) = rounded((1 / root(length)) * vector[static_cast<std::size_t>(i)]);
    }
    return result;
}

DenseEigen reliable_eigen(const Eigen::MatrixXcd& m) {
    DenseEigen result = dense_eigen(m);
    return loses_slow_modes(m, result.values) ? precise_eigen(m) : result;
}

Eigen::VectorXcd reliable_eigenvalues(const Eigen::MatrixXcd& m) {
    Eigen::VectorXcd values = dense_eigenvalues(m);
    if (!loses_slow_modes(m, values)) return values;
    Matrix none{0, {}}, t = schur_form(m, none);
    for (int k = 0; k < t.rows; ++k) values(k) = rounded(t(k, k));
    return values;
}

}  // namespace drover::numerics
