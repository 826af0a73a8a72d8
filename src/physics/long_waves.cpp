// physics/long_waves.cpp: elimination of the fast modes about q = 0.
#include "drover/physics/long_waves.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "expansion.hpp"
#include "numerics/small_matrices.hpp"

namespace drover::physics {

namespace {
using Small = LongWaves::Small;
/// The expansion of the fields that the form has.
struct Compact {
    Expansion q;
    Matrix6 moved = Matrix6::Zero();  ///< what multiplies d/dt
    std::vector<int> present;         ///< rows and columns of these fields
};

Compact compact(const Equations& e, const UniformPoint& about) {
    Compact r{.q = expansion(e, about), .present = {}};
    const Form& form = e.form;
    const auto add = [&](int field, double weight) {
        r.present.push_back(field);
        r.moved(field, field) = weight;
    };
    if (form.bead_density >= 0) add(FieldIndex::bead_density, 1.0);
    if (form.rod_density >= 0) add(FieldIndex::rod_density, 1.0);
    if (form.velocity != Velocity::absent) {
        const double mass = form.velocity == Velocity::dynamic ? e.model.inertia.bead_mass * about.bead_density : 0.0;
        add(FieldIndex::bead_velocity_x, mass);
        add(FieldIndex::bead_velocity_y, mass);
    }
    add(FieldIndex::polar_order_x, 1.0);
    add(FieldIndex::polar_order_y, 1.0);
    return r;
}

Small chosen(const Matrix6& whole, const std::vector<int>& present) { return whole(present, present); }

/// Ratio of the smallest pivot to the largest: 0 for a singular matrix.
template <class Matrix>
double least_pivot(const Eigen::FullPivLU<Matrix>& lu) {
    return lu.matrixLU().diagonal().cwiseAbs().minCoeff() / lu.maxPivot();
}

/// Modes at q = 0 that neither grow nor decay: moved right and left moved are dual, left moved right = 1.
struct Slow {
    Small right, left;  ///< columns, rows
    Small fast;         ///< the fast answer to a push on fast modes: constant fast y = y, left moved fast y = 0
    std::string undefined;
};

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

Slow slow_at_rest(const Equations& e, const StationaryState& about, const Compact& f) {
    const Small constant = chosen(f.q.constant, f.present), moved = chosen(f.moved, f.present);
    const auto n = constant.rows(), densities = n - (e.form.velocity == Velocity::absent ? 2 : 4), rest = n - densities;
    const Small block = constant.bottomRightCorner(rest, rest), mass = moved.bottomRightCorner(rest, rest);
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
    if (!rows.allFinite() || !columns.allFinite()) return {.undefined = at_threshold};
    const Small even = rows.asDiagonal() * whole * columns.asDiagonal();
    const Eigen::FullPivLU<Small> by_even(even);
    if (!(least_pivot(by_even) > 1e-13)) return {.undefined = at_threshold};
    const Small inverse = columns.asDiagonal() * by_even.inverse() * rows.asDiagonal();

    Slow result{.right = Small::Zero(n, slow), .left = Small::Zero(slow, n)};
    const Small left = g.transpose() * inverse;
    result.left.bottomRightCorner(changes.cols(), rest) = left;
    result.right.bottomRightCorner(rest, changes.cols()) = changes;
    for (Eigen::Index d = 0; d < densities; ++d) {
        const Eigen::VectorXd push = constant.block(densities, d, rest, 1);
        if ((left * push).cwiseAbs().sum() > 1e-9 * (left.cwiseAbs() * push.cwiseAbs()).sum())
            return {.undefined =
                        "a change of density accelerates all beads without limit, and s is not a power series in q"};
        Eigen::VectorXd answer = -inverse * push;
        answer -= changes * (left * mass * answer);
        result.right(d, d) = result.left(d, d) = 1.0;
        result.right.block(densities, d, rest, 1) = answer;
    }
    result.fast = Small::Zero(n, n);
    result.fast.bottomRightCorner(rest, rest) = inverse - changes * (left * mass * inverse);
    return result;
}
}  // namespace

LongWaves long_waves(const Equations& equations, const StationaryState& about) {
    LongWaves result;
    const Compact f = compact(equations, about.point);
    const Slow slow = slow_at_rest(equations, about, f);
    result.undefined = slow.undefined;
    if (!slow.undefined.empty() || slow.right.cols() == 0) return result;
    const Small &right = slow.right, &left = slow.left;
    const Small moved = chosen(f.moved, f.present);
    const auto n = moved.rows();
    const Small project = Small::Identity(n, n) - moved * right * left;
    const auto through = [&](const Matrix6& a, const Matrix6& b) -> Small {
        return left * chosen(a, f.present) * (slow.fast * (project * chosen(b, f.present) * right));
    };
    const auto between = [&](const Matrix6& m) -> Small { return left * chosen(m, f.present) * right; };
    result.speed_x = -between(f.q.first_x);
    result.speed_y = -between(f.q.first_y);
    result.damping_xx = -between(f.q.second_xx) - through(f.q.first_x, f.q.first_x);
    result.damping_yy = -between(f.q.second_yy) - through(f.q.first_y, f.q.first_y);
    result.damping_xy = -between(f.q.second_xy) - through(f.q.first_x, f.q.first_y) - through(f.q.first_y, f.q.first_x);
    result.right = Small::Zero(FieldIndex::count, right.cols());
    result.left = Small::Zero(left.rows(), FieldIndex::count);
    for (Eigen::Index i = 0; i < n; ++i) {
        result.right.row(f.present[static_cast<std::size_t>(i)]) = right.row(i);
        result.left.col(f.present[static_cast<std::size_t>(i)]) = left.col(i);
    }
    return result;
}

namespace {
using Complex = std::complex<double>;
using ComplexSmall = Eigen::Matrix<Complex, Eigen::Dynamic, Eigen::Dynamic, 0, FieldIndex::count, FieldIndex::count>;
using ComplexColumn = Eigen::Matrix<Complex, Eigen::Dynamic, 1, 0, FieldIndex::count, 1>;
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Speeds that differ by less than this part of the largest are one: rounding splits a double root by its square root.
constexpr double same = 3e-7;

struct AtAngle {
    Small speed, damping;
};
AtAngle at_angle(const LongWaves& w, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {.speed = w.speed_x * c + w.speed_y * s,
            .damping = w.damping_xx * (c * c) + w.damping_yy * (s * s) + w.damping_xy * (c * s)};
}

ComplexColumn speeds_of(const Small& u) {
    ComplexColumn speeds;
    if (u.rows() == 1) speeds = ComplexColumn::Constant(1, u(0, 0));
    else speeds = numerics::eigenvalues(u);
    // A size that no choice of units changes: of the speeds, and of the loops that could make one.
    double size = speeds.cwiseAbs().maxCoeff();
    for (int i = 0; i < u.rows(); ++i)
        for (int k = 0; k < u.rows(); ++k) size = std::max(size, std::sqrt(std::abs(u(i, k) * u(k, i))));
    for (Complex& speed : speeds) {
        if (std::abs(speed.imag()) < same * size) speed = speed.real();
        if (std::abs(speed) < 1e-13 * size) speed = 0.0;  // rounding
    }
    std::sort(speeds.begin(), speeds.end(),
              [](Complex a, Complex b) { return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag(); });
    for (int i = 1; i < speeds.size(); ++i)  // one cluster, one speed
        if (std::abs(speeds(i) - speeds(i - 1)) < same * size) speeds(i) = speeds(i - 1);
    return speeds;
}

/// The matrix of cofactors, transposed, of at most 3 rows: right times left eigenvector where it is singular once.
ComplexSmall adjugate(const ComplexSmall& m) {
    ComplexSmall r(m.rows(), m.rows());
    if (m.rows() == 1) r << 1.0;
    else if (m.rows() == 2) r << m(1, 1), -m(0, 1), -m(1, 0), m(0, 0);
    else
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) {
                const int a = (k + 1) % 3, b = (k + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
                r(i, k) = m(a, c) * m(b, d) - m(a, d) * m(b, c);
            }
    return r;
}

struct Group {
    ComplexColumn damping;
    ComplexSmall shape;  ///< a column each
};

/// The `count` modes of one speed; their dampings are NaN if it has fewer eigenvectors.
Group group_of(const AtAngle& at, Complex speed, int count) {
    const auto k = at.speed.rows();
    const ComplexSmall rest = at.speed.cast<Complex>() - speed * ComplexSmall::Identity(k, k);
    if (count == 1 && k <= 3) {
        const ComplexSmall both = adjugate(rest);
        const Complex overlap = both.trace();
        Eigen::Index column = 0;
        both.colwise().squaredNorm().maxCoeff(&column);
        return {.damping = ComplexColumn::Constant(1, (both * at.damping.cast<Complex>()).trace() / overlap),
                .shape = both.col(column)};
    }
    const numerics::SingularValueDecomposition svd = numerics::singular_value_decomposition(rest);
    const ComplexSmall right = svd.right.rightCols(count), left = svd.left.rightCols(count).adjoint();
    const ComplexSmall overlap = left * right;
    const Eigen::FullPivLU<ComplexSmall> by_overlap(overlap);
    const auto& singular = svd.values;
    const double most = std::max(singular(0), at.speed.cwiseAbs().maxCoeff());
    if (!(least_pivot(by_overlap) > 1e-6) || singular(k - count) > 1e-5 * most)
        return {.damping = ComplexColumn::Constant(count, not_a_number), .shape = right};
    const ComplexSmall reduced = by_overlap.solve(left * at.damping.cast<Complex>() * right);
    const numerics::EigenDecomposition solved = numerics::eigen_decomposition(reduced);
    return {.damping = solved.values, .shape = right * solved.vectors};
}

/// see(speed, Group) for the modes of each speed.
template <class See>
void for_groups(const AtAngle& at, See see) {
    const ComplexColumn speeds = speeds_of(at.speed);
    for (int first = 0, next = 0; first < speeds.size(); first = next) {
        for (next = first + 1; next < speeds.size() && speeds(next) == speeds(first);) ++next;
        see(speeds(first), group_of(at, speeds(first), next - first));
    }
}
}  // namespace

std::vector<SlowMode> slow_modes(const LongWaves& waves, double angle) {
    std::vector<SlowMode> modes;
    if (waves.right.cols() == 0) return modes;
    for_groups(at_angle(waves, angle), [&](Complex speed, const Group& group) {
        for (int i = 0; i < group.damping.size(); ++i) {
            modes.push_back({.speed = speed, .damping = group.damping(i), .shape = waves.right * group.shape.col(i)});
            modes.back().shape.normalize();
        }
    });
    return modes;
}

SlowGrowth slow_growth(const LongWaves& waves, double angle) {
    SlowGrowth growth{.first = 0.0, .second = -std::numeric_limits<double>::infinity()};
    if (waves.right.cols() == 0) return growth;
    for_groups(at_angle(waves, angle), [&](Complex speed, const Group& group) {
        growth.first = std::max(growth.first, speed.imag());
        // A defective speed splits as sqrt(q), one half of it growing.
        for (const Complex damping : group.damping)
            growth.second = std::max(growth.second, std::isnan(damping.real()) ? std::numeric_limits<double>::infinity()
                                                                               : -damping.real());
    });
    if (growth.first > 0.0) growth.second = 0.0;
    return growth;
}

}  // namespace drover::physics
