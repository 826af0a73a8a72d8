// numerics/dense.hpp: solutions of dense linear systems of any size as plain functions, compiled once.
//
// Where Eigen's decompositions are used directly, each source compiles them again: seconds apiece.
#pragma once
#include <Eigen/Core>

namespace drover::numerics {

/// x with a x = b, by LU with partial pivoting; a must be regular.
Eigen::MatrixXcd solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a);

/// The shortest x of all that make |a x - b| least.  Singular values below `threshold` times the largest count as 0;
/// 0: Eigen's own threshold, the rounding of the decomposition.
Eigen::MatrixXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold = 0.0);
Eigen::MatrixXcd shortest_solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// An orthogonal matrix whose first columns span those of a; the others, what is normal to them.
Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a);

}  // namespace drover::numerics
