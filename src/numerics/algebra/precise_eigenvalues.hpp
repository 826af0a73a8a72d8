// numerics/algebra/precise_eigenvalues.hpp: eigenvalues in 113 bits, of matrices whose slow modes double precision
// loses.
#pragma once
#include "numerics/algebra/dense.hpp"

namespace drover::numerics {

/// The eigenvalues and eigenvectors of m, by the shifted QR algorithm in 113-bit arithmetic; some 0.3 ms for six rows.
/// Source: Golub & Van Loan, "Matrix Computations", 4th ed. (2013), secs. 7.4, 7.5 and 7.6.
DenseEigen precise_eigen(const Eigen::MatrixXcd& m);

/// In double precision where that gives six digits of the real part of each eigenvalue, else in 113 bits: the rates of
/// modes that are far slower than the fastest would be rounding errors of either sign.
DenseEigen reliable_eigen(const Eigen::MatrixXcd& m);
Eigen::VectorXcd reliable_eigenvalues(const Eigen::MatrixXcd& m);

}  // namespace drover::numerics
