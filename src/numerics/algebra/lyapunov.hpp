// numerics/algebra/lyapunov.hpp: the Lyapunov equation of small complex matrices.
#pragma once
#include <complex>
#include <span>

namespace drover::numerics {

/// Largest number of rows.
inline constexpr int max_lyapunov = 48;

/// Solves m s + s m^H + q = 0 for `rows` by `rows` matrices stored column by column; q Hermitian, and so is s.  Returns
/// the largest real part of the eigenvalues of m: `s` is written only where it is negative.  Defective m are allowed.
/// Source: Bartels & Stewart, Comm. ACM 15, 820 (1972), in the complex Schur form.
double solve_lyapunov(int rows, std::span<const std::complex<double>> m, std::span<const std::complex<double>> q,
                      std::span<std::complex<double>> s);

}  // namespace drover::numerics
