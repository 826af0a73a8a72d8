// numerics/precise_eigenvalues.hpp: eigenvalues to 33 digits, of matrices whose slow modes double precision loses.
#pragma once
#include "numerics/small_matrices.hpp"

namespace drover::numerics {

/// Whether double precision leaves fewer than six digits of the real part of some eigenvalue of m: modes far slower than
/// the fastest, whose rates are then rounding errors of either sign.
bool loses_slow_modes(const SmallMatrix& m, const SmallVector& values);

/// The eigenvalues and eigenvectors of m, by the shifted QR algorithm in 113-bit arithmetic; some 0.3 ms for six rows.
/// Source: Golub & Van Loan, "Matrix Computations", 4th ed. (2013), secs. 7.4, 7.5 and 7.6.
EigenDecomposition precise_eigen_decomposition(const SmallMatrix& m);

}  // namespace drover::numerics
