// physics/long_waves.cpp: the slow modes of rods and beads at q = 0.
#include "drover/physics/long_waves.hpp"

#include <Eigen/LU>

#include "numerics/small_matrices.hpp"

namespace drover::physics {

namespace {
using Small = numerics::SmallRealMatrix;

constexpr const char* at_threshold = "at the threshold a fast mode becomes slow, and s is not a power series in q";

/// Turns of the whole state and, where nothing holds beads back, pushes of all of them: uniform changes of v and p
/// that stay.  Rows of the block of v and p: as many as it has.
Small uniform_changes(const Equations& e, const StationaryState& about, const Small& block) {
    const auto n = block.rows();
    // Undamped beads: no drag, and no driving that depends on the flow.
    const bool free_beads = e.form.velocity == Velocity::dynamic && block.topLeftCorner<2, 2>().isZero(0.0) &&
                            (block.topRightCorner<2, 2>().isZero(0.0) || block.bottomLeftCorner<2, 2>().isZero(0.0));
    Small changes = Small::Zero(n, (about.free_direction ? 1 : 0) + (free_beads ? 2 : 0));
    if (about.free_direction) {
        const auto turned = [](const Eigen::Vector2d& v) { return Eigen::Vector2d(-v.y(), v.x()); };
        changes.col(0).tail<2>() = turned(about.point.order);
        if (n == 4) changes.col(0).head<2>() = turned(about.point.velocity);
    }
    if (free_beads) {
        const Eigen::Matrix2d order = block.bottomRightCorner<2, 2>(), turning = block.bottomLeftCorner<2, 2>();
        changes.topRightCorner<2, 2>().setIdentity();
        changes.bottomRightCorner<2, 2>() = -order.fullPivLu().solve(turning);
    }
    return changes;
}
}  // namespace

LongWaves long_waves(const Equations& e, const StationaryState& about) {
    const auto at = e.linearised(about.point);
    const Small constant = at->factors(0, 0);
    const Eigen::VectorXd moved = at->moved()(at->members());
    const auto n = constant.rows(), rest = Eigen::Index{e.form.velocity == Velocity::absent ? 2 : 4},
               densities = n - rest;
    const Small block = constant.bottomRightCorner(rest, rest), mass = moved.tail(rest).asDiagonal().toDenseMatrix();
    const Small changes = uniform_changes(e, about, block);
    const auto slow = densities + changes.cols();
    // block + moved changes g^T is not singular, and g^T times its inverse is the left null vectors, dual to the
    // changes.
    const double rate = block.cwiseAbs().maxCoeff();
    const Small g = rate * changes;
    const Small whole = block + mass * changes * g.transpose();
    Eigen::VectorXd rows(rest), columns(rest);  // to size 1, so that units do not decide what is singular
    for (Eigen::Index i = 0; i < rest; ++i) rows(i) = 1.0 / whole.row(i).cwiseAbs().maxCoeff();
    for (Eigen::Index k = 0; k < rest; ++k) columns(k) = 1.0 / (rows.asDiagonal() * whole).col(k).cwiseAbs().maxCoeff();
    if (!rows.allFinite() || !columns.allFinite()) return {.why_none = at_threshold};
    const Small even = rows.asDiagonal() * whole * columns.asDiagonal();
    const Eigen::FullPivLU<Small> by_even(even);
    const double least_pivot = by_even.matrixLU().diagonal().cwiseAbs().minCoeff();
    if (!(least_pivot > 1e-13 * by_even.maxPivot())) return {.why_none = at_threshold};
    const Small inverse = columns.asDiagonal() * by_even.inverse() * rows.asDiagonal();

    Small right = Small::Zero(n, slow), left = Small::Zero(slow, n), fast = Small::Zero(n, n);
    const Small duals = g.transpose() * inverse;
    left.bottomRightCorner(changes.cols(), rest) = duals;
    right.bottomRightCorner(rest, changes.cols()) = changes;
    for (Eigen::Index d = 0; d < densities; ++d) {
        const Eigen::VectorXd push = constant.block(densities, d, rest, 1);
        if ((duals * push).cwiseAbs().sum() > 1e-9 * (duals.cwiseAbs() * push.cwiseAbs()).sum())
            return {.why_none =
                        "a change of density accelerates all beads without limit, and s is not a power series in q"};
        Eigen::VectorXd answer = -inverse * push;
        answer -= changes * (duals * mass * answer);
        right(d, d) = left(d, d) = 1.0;
        right.block(densities, d, rest, 1) = answer;
    }
    fast.bottomRightCorner(rest, rest) = inverse - changes * (duals * mass * inverse);
    const Small project = Small::Identity(n, n) - moved.asDiagonal() * right * left;
    return model::long_waves(*at, {.right = right, .left = left, .fast = fast * project});
}

}  // namespace drover::physics
