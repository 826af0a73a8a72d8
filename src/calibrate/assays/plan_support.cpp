// calibrate/assays/plan_support.cpp: least squares with few unknowns.
#include "calibrate/assays/plan_support.hpp"
#include "base/constants.hpp"

#include <Eigen/Dense>

namespace drover::calibrate {

std::vector<double> least_squares(const std::vector<std::vector<double>>& columns, const std::vector<double>& y) {
    const auto rows = static_cast<Eigen::Index>(y.size()), unknowns = static_cast<Eigen::Index>(columns.size());
    Eigen::MatrixXd matrix(rows, unknowns);
    for (Eigen::Index k = 0; k < unknowns; ++k)
        matrix.col(k) = Eigen::Map<const Eigen::VectorXd>(columns[static_cast<std::size_t>(k)].data(), rows);
    const auto solver = matrix.colPivHouseholderQr();
    std::vector<double> factors(columns.size(), nan);
    if (solver.rank() < unknowns) return factors;
    Eigen::Map<Eigen::VectorXd>(factors.data(), unknowns) =
        solver.solve(Eigen::Map<const Eigen::VectorXd>(y.data(), rows));
    return factors;
}

}  // namespace drover::calibrate
