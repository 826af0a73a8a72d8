// numerics/algebra/dense.hpp: dense linear algebra with matrices of any size as plain functions, compiled once.
//
// Where Eigen's decompositions are used directly, each source compiles them again: seconds apiece.
#pragma once
#include <Eigen/Core>
#include <complex>

namespace drover::numerics {

/// Square matrices of at most 6 rows, which need no memory from the heap.
inline constexpr int max_small_rows = 6;
template <class Scalar>
using SmallSquare = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, max_small_rows, max_small_rows>;

/// x with a x = b, by LU with partial pivoting; a must be regular.
Eigen::MatrixXcd solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a);

/// exp(a), for a whose exponential is not far smaller than its norm once balanced: Taylor's series of a part, squared.
Eigen::MatrixXcd exponential(const Eigen::MatrixXcd& a);

/// Powers of 2 by which rows and columns are multiplied so that the elements of a matrix are near 1: rounding is judged
/// in them where rows and columns have units of their own.  1 for a row or column of zeros.
struct Scales {
    Eigen::VectorXd rows, columns;
};
Scales even_scales(const Eigen::MatrixXcd& a);

/// An inverse with full pivoting, for rows and columns of very different size.
Eigen::MatrixXd pivoted_inverse(const Eigen::MatrixXd& a);
bool is_invertible(const Eigen::MatrixXd& a);
bool is_invertible(const Eigen::MatrixXcd& a);

/// The shortest x of all that make |a x - b| least.  Singular values below `threshold` times the largest count as 0; 0:
/// those that are rounding of the decomposition, which is that of a in its even_scales(), as are both lengths.
Eigen::MatrixXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold = 0.0);
Eigen::MatrixXcd shortest_solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// An orthogonal matrix whose first columns span those of a; the others, what is normal to them.
Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a);

/// Powers of 2, d, with which the rows of diag(1/d) a diag(d) are as large as its columns, off the diagonal: units that
/// differ much make no rounding errors there.  A row or column without such elements gets those of the other no larger
/// than the diagonal.
/// Source: Parlett & Reinsch, Numer. Math. 13, 293 (1969).
Eigen::VectorXd balance(const Eigen::MatrixXcd& a);
/// diag(1/d) a diag(d) with these d.
Eigen::MatrixXd balanced(const Eigen::MatrixXd& a);
Eigen::MatrixXcd balanced(const Eigen::MatrixXcd& a);

/// a vectors = vectors diag(values); columns of norm 1.
struct DenseEigen {
    Eigen::VectorXcd values;
    Eigen::MatrixXcd vectors;
    bool has_converged = true;
};
DenseEigen dense_eigen(const Eigen::MatrixXcd& a);
Eigen::VectorXcd dense_eigenvalues(const Eigen::MatrixXcd& a);
Eigen::VectorXcd dense_eigenvalues(const Eigen::MatrixXd& a);

/// a = left diag(values) right^H, values descending; left and right square and unitary.
template <class Matrix>
struct DenseSvd {
    Matrix left;
    Eigen::VectorXd values;
    Matrix right;
};
DenseSvd<Eigen::MatrixXd> dense_svd(const Eigen::MatrixXd& a);
DenseSvd<Eigen::MatrixXcd> dense_svd(const Eigen::MatrixXcd& a);

/// Largest number of rows of solve_lyapunov().
inline constexpr int max_lyapunov = 48;

/// Solves m s + s m^H + q = 0; q Hermitian, and so is s.  Returns the largest real part of the eigenvalues of m: `s` is
/// written only where it is negative.  Defective m are allowed.
/// Source: Bartels & Stewart, Comm. ACM 15, 820 (1972), in the complex Schur form.
double solve_lyapunov(const Eigen::MatrixXcd& m, const Eigen::MatrixXcd& q, Eigen::MatrixXcd& s);
/// The same in extended precision, for modes that are far slower than the fastest, and of any size.
double solve_lyapunov_precisely(const Eigen::MatrixXcd& m, const Eigen::MatrixXcd& q, Eigen::MatrixXcd& s);

/// The same in either precision, of m = u t u^H with a triangular t and a unitary u.  Matrix: square, complex.
template <class Matrix>
typename Matrix::RealScalar solve_lyapunov_of_schur(const Matrix& t, const Matrix& u, const Matrix& q, Matrix& s) {
    using Complex = typename Matrix::Scalar;
    using Real = typename Matrix::RealScalar;
    const Eigen::Index n = t.rows();
    Real largest = t(0, 0).real();
    for (Eigen::Index i = 1; i < n; ++i)
        if (!(t(i, i).real() <= largest)) largest = t(i, i).real();
    if (!(largest < Real(0))) return largest;
    Matrix y = u.adjoint() * q * u;
    for (Eigen::Index j = n; j-- > 0;)
        for (Eigen::Index i = n; i-- > 0;) {
            Complex sum = y(i, j);
            for (Eigen::Index k = i + 1; k < n; ++k) sum += t(i, k) * y(k, j);
            for (Eigen::Index k = j + 1; k < n; ++k) sum += y(i, k) * std::conj(t(j, k));
            y(i, j) = -sum / (t(i, i) + std::conj(t(j, j)));
        }
    const Matrix product = u * y * u.adjoint();
    s = Real(0.5) * (product + product.adjoint());
    return largest;
}

/// The eigenvalues and eigenvectors of m, by the shifted QR algorithm in 113-bit arithmetic; some 0.3 ms for six rows.
/// Source: Golub & Van Loan, "Matrix Computations", 4th ed. (2013), secs. 7.4, 7.5 and 7.6.
DenseEigen precise_eigen(const Eigen::MatrixXcd& m);

/// In double precision where that gives six digits of the real part of each eigenvalue, else in 113 bits: the rates of
/// modes that are far slower than the fastest would be rounding errors of either sign.
DenseEigen reliable_eigen(const Eigen::MatrixXcd& m);
Eigen::VectorXcd reliable_eigenvalues(const Eigen::MatrixXcd& m);

}  // namespace drover::numerics
