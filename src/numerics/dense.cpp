// numerics/dense.cpp: by Eigen's decompositions.
#include "numerics/dense.hpp"

#include <Eigen/LU>
#include <Eigen/QR>

namespace drover::numerics {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;

MatrixXcd solution(const MatrixXcd& a, const MatrixXcd& b) { return a.partialPivLu().solve(b); }
MatrixXd inverse(const MatrixXd& a) { return a.partialPivLu().inverse(); }
MatrixXcd inverse(const MatrixXcd& a) { return a.partialPivLu().inverse(); }

MatrixXd shortest_solution(const MatrixXd& a, const MatrixXd& b, double threshold) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> solver;
    if (threshold > 0.0) solver.setThreshold(threshold);
    return solver.compute(a).solve(b);
}

MatrixXcd shortest_solution(const MatrixXcd& a, const MatrixXcd& b) {
    return a.completeOrthogonalDecomposition().solve(b);
}

MatrixXd orthogonal_factor(const MatrixXd& a) { return Eigen::HouseholderQR<MatrixXd>(a).householderQ(); }

}  // namespace drover::numerics
