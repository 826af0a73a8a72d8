// numerics/lyapunov.cpp: the Lyapunov equation in double precision.
#include "numerics/lyapunov.hpp"

#include <algorithm>

#include "drover/base/error.hpp"
#include "lyapunov_solver.hpp"
#include "numerics/dense.hpp"

namespace drover::numerics {

double solve_lyapunov(int rows, std::span<const std::complex<double>> m, std::span<const std::complex<double>> q,
                      std::span<std::complex<double>> s) {
    const auto size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(rows);
    require(rows >= 1 && rows <= max_lyapunov && m.size() == size && q.size() == size && s.size() == size, {},
            "a Lyapunov equation has {} rows; expected 1 to {}", rows, max_lyapunov);
    Eigen::MatrixXcd solution;
    const DenseSchur schur = dense_schur(Eigen::Map<const Eigen::MatrixXcd>(m.data(), rows, rows));
    const double largest =
        solve_lyapunov<Eigen::MatrixXcd>(schur.triangular, schur.unitary,
                                         Eigen::Map<const Eigen::MatrixXcd>(q.data(), rows, rows), solution);
    if (largest < 0.0) std::copy_n(solution.data(), size, s.begin());
    return largest;
}

}  // namespace drover::numerics
