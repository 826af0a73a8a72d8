// model/theory_long_waves.cpp: elimination of the fast modes about q = 0.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/model/theory.hpp"
#include "numerics/dense.hpp"
#include "sorted_modes.hpp"

namespace drover::model {

namespace {
using Complex = std::complex<double>;

/// rates = sum_n |q|^n m[n] deviations at one angle, where d/dt is multiplied by `moved`: 1 for components with a rate,
/// 0 for those in balance.
struct Expansion {
    std::array<Symbol, 3> m;
    Eigen::VectorXd moved;
    std::vector<int> members;  ///< components
};

Expansion expansion(const LinearisedAt& at, double angle) {
    Expansion result;
    const std::vector<int>&state = at.equations().state_components(), &held = at.held_components();
    result.members = state;
    result.members.insert(result.members.end(), held.begin(), held.end());
    const auto count = static_cast<Eigen::Index>(result.members.size());
    for (Symbol& m : result.m) m = Symbol::Zero(count, count);
    result.moved = Eigen::VectorXd::Zero(count);
    result.moved.head(static_cast<Eigen::Index>(state.size())).setOnes();
    const double c = std::cos(at.direction() + angle), s = std::sin(at.direction() + angle);
    for (const LinearisedAt::Power& power : at.powers()) {
        const int degree = power.x + power.y;
        if (degree > 2) continue;
        const Complex factor = std::array<Complex, 3>{1.0, Complex(0.0, 1.0), -1.0}[static_cast<std::size_t>(degree)] *
                               std::pow(c, power.x) * std::pow(s, power.y);
        result.m[static_cast<std::size_t>(degree)] += factor * power.factors(result.members, result.members);
    }
    return result;
}

/// Modes at q = 0 that neither grow nor decay, with left moved right = 1, and what the fast modes answer to a force.
struct Slow {
    Symbol right, left, fast;
    std::string why_none;
};

Slow slow_at_zero(const Expansion& e) {
    const Symbol& m = e.m[0];
    const Eigen::Index n = m.rows();
    // Rows and columns of size 1, so that units do not decide what is singular.
    Eigen::VectorXd rows = Eigen::VectorXd::Ones(n), columns = rows;
    for (Eigen::Index k = 0; k < n; ++k)
        if (const double size = m.row(k).cwiseAbs().maxCoeff(); size > 0.0) rows(k) = 1.0 / size;
    for (Eigen::Index k = 0; k < n; ++k)
        if (const double size = (rows.asDiagonal() * m.col(k)).cwiseAbs().maxCoeff(); size > 0.0)
            columns(k) = 1.0 / size;
    const numerics::DenseSvd<Symbol> svd = numerics::dense_svd(Symbol(rows.asDiagonal() * m * columns.asDiagonal()));
    Eigen::Index rank = 0;
    while (rank < n && svd.values(rank) > 1e-10 * svd.values(0)) ++rank;
    const Eigen::Index slow = n - rank;
    Slow result{.right = columns.asDiagonal() * svd.right.rightCols(slow),
                .left = svd.left.rightCols(slow).adjoint() * rows.asDiagonal(),
                .fast = {},
                .why_none = {}};
    for (Eigen::Index k = 0; k < slow; ++k) result.right.col(k).normalize(), result.left.row(k).normalize();
    const Symbol overlap = result.left * e.moved.asDiagonal() * result.right;
    if (slow > 0 && numerics::dense_svd(overlap).values.minCoeff() < 1e-9)
        return {.right = {},
                .left = {},
                .fast = {},
                .why_none = "at q = 0 a slow mode drives another one without limit, and s is no power series in q"};
    if (slow > 0) result.left = numerics::solution(overlap, result.left);
    Symbol bordered = Symbol::Zero(n + slow, n + slow);
    bordered.topLeftCorner(n, n) = m;
    bordered.topRightCorner(n, slow) = e.moved.asDiagonal() * result.right;
    bordered.bottomLeftCorner(slow, n) = result.left * e.moved.asDiagonal();
    result.fast = numerics::pivoted_inverse(bordered).topLeftCorner(n, n);
    return result;
}

/// The largest difference between s and its expansion over q^2, at the q where it is smallest: at large q the next term
/// of the series limits it, at small q rounding.
double error_of(const LinearisedAt& at, double angle, const std::vector<SlowMode>& slow) {
    double smallest = std::numeric_limits<double>::infinity();
    for (double q = 1.0; q > 1e-6; q *= 0.2) {
        const Modes exact = modes(at, at.wavevector(q, angle));
        double largest = 0.0;
        for (const SlowMode& mode : slow) {
            const Complex series = Complex(0.0, -q) * mode.speed - q * q * mode.damping;
            largest = std::max(largest, (exact.rates.array() - series).abs().minCoeff() / (q * q));
        }
        smallest = std::min(smallest, largest);
    }
    return smallest;
}
}  // namespace

SlowModes slow_modes(const LinearisedAt& at, double angle) {
    SlowModes result;
    const Expansion e = expansion(at, angle);
    const Slow slow = slow_at_zero(e);
    result.why_none = slow.why_none;
    if (!result.why_none.empty() || slow.right.cols() == 0) return result;
    Symbol first = slow.left * e.m[1] * slow.right;
    const double rounding = 1e-13 * slow.left.norm() * e.m[1].norm() * slow.right.norm();
    if (first.norm() <= rounding) first.setZero();
    const Symbol second = slow.left * (e.m[2] - e.m[1] * slow.fast * e.m[1]) * slow.right;
    const Modes waves = sorted_modes(first);
    const double size = std::max({first.norm(), rounding, std::numeric_limits<double>::min()});
    const Eigen::Index n = waves.rates.size();
    const bool defective = !(waves.duals.norm() < 1e6);
    std::vector<bool> done(static_cast<std::size_t>(n), false);
    const Symbol all = at.all_components({});
    for (Eigen::Index k = 0; k < n; ++k) {
        if (done[static_cast<std::size_t>(k)]) continue;
        std::vector<int> equal;  // modes of the same speed
        for (Eigen::Index j = k; j < n; ++j)
            if (!done[static_cast<std::size_t>(j)] && std::abs(waves.rates(j) - waves.rates(k)) <= 1e-9 * size) {
                equal.push_back(static_cast<int>(j));
                done[static_cast<std::size_t>(j)] = true;
            }
        const Symbol right = waves.shapes(Eigen::all, equal), left = waves.duals(equal, Eigen::all);
        const Modes damped = sorted_modes(defective ? Symbol(0.0 * left * right) : Symbol(left * second * right));
        for (Eigen::Index j = 0; j < damped.rates.size(); ++j) {
            const Symbol amplitudes = slow.right * right * damped.shapes.col(j);
            SlowMode mode{.speed = Complex(0.0, 1.0) * waves.rates(equal[static_cast<std::size_t>(j)]),
                          .damping = -damped.rates(j),
                          .shape = all * amplitudes.topRows(all.cols())};
            if (std::abs(mode.speed) <= 1e-13 * size) mode.speed = 0.0;
            if (defective) mode.damping = std::numeric_limits<double>::quiet_NaN();
            mode.shape.normalize();
            result.modes.push_back(std::move(mode));
        }
    }
    std::sort(result.modes.begin(), result.modes.end(), [size](const SlowMode& a, const SlowMode& b) {
        if (std::abs(a.speed.real() - b.speed.real()) > 1e-9 * size) return a.speed.real() < b.speed.real();
        return a.damping.real() < b.damping.real();
    });
    result.error = defective ? std::numeric_limits<double>::quiet_NaN() : error_of(at, angle, result.modes);
    return result;
}

}  // namespace drover::model
