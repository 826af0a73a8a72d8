// numerics/algebra/dense.hpp: dense linear algebra with matrices of any size as plain functions, compiled once.
//
// Where Eigen's decompositions are used directly, each source compiles them again: seconds apiece.
#pragma once
#include <Eigen/Core>

namespace drover::numerics {

/// x with a x = b, by LU with partial pivoting; a must be regular.
Eigen::MatrixXcd solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a);

/// The same with full pivoting, for rows of very different size.
Eigen::MatrixXcd pivoted_inverse(const Eigen::MatrixXcd& a);
bool is_invertible(const Eigen::MatrixXcd& a);

/// The shortest x of all that make |a x - b| least.  Singular values below `threshold` times the largest count as 0;
/// 0: Eigen's own threshold, the rounding of the decomposition.
Eigen::MatrixXd shortest_solution(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold = 0.0);
Eigen::MatrixXcd shortest_solution(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// An orthogonal matrix whose first columns span those of a; the others, what is normal to them.
Eigen::MatrixXd orthogonal_factor(const Eigen::MatrixXd& a);

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

}  // namespace drover::numerics
