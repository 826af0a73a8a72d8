// numerics/algebra/lyapunov.cpp: the Lyapunov equation in double precision.
#include "numerics/algebra/lyapunov.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "drover/base/error.hpp"
#include "numerics/algebra/lyapunov_solver.hpp"
#include "numerics/algebra/small_square.hpp"

namespace drover::numerics {

namespace {
template <class Matrix>
double solve(int rows, const std::complex<double>* m, const std::complex<double>* q, std::complex<double>* s) {
    const Eigen::ComplexSchur<Matrix> schur(Eigen::Map<const Matrix>(m, rows, rows));
    Matrix solution;
    const double largest =
        solve_lyapunov<Matrix>(schur.matrixT(), schur.matrixU(), Eigen::Map<const Matrix>(q, rows, rows), solution);
    if (largest < 0.0) std::copy_n(solution.data(), solution.size(), s);
    return largest;
}
}  // namespace

double solve_lyapunov(int rows, std::span<const std::complex<double>> m, std::span<const std::complex<double>> q,
                      std::span<std::complex<double>> s) {
    const auto size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(rows);
    require(rows >= 1 && rows <= max_lyapunov && m.size() == size && q.size() == size && s.size() == size, {},
            "a Lyapunov equation has {} rows; expected 1 to {}", rows, max_lyapunov);
    return rows <= max_small_rows ? solve<SmallSquare<std::complex<double>>>(rows, m.data(), q.data(), s.data())
                                  : solve<Eigen::MatrixXcd>(rows, m.data(), q.data(), s.data());
}

}  // namespace drover::numerics
