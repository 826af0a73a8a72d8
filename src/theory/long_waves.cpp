// theory/long_waves.cpp: elimination of the fast modes about q = 0.
#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

/// The powers of q in the equations: the factors of (i q_x)^x (i q_y)^y, and what multiplies d/dt.
struct Expansion {
    std::function<MatrixXd(int x, int y)> factors;
    Eigen::VectorXd mass_density;
    std::vector<int> fields;  ///< of the rows: the components of one have one unit
};

/// The size of an entry of the rates at q = 0 before its terms cancel.
double size_of_terms(const model::LinearisedAt& at, int row, int column) {
    double size = 0.0;
    for (std::size_t n = 0; n < at.equations().terms().size(); ++n)
        size += std::abs(at.term_symbol(n, {})(row, column));
    return size;
}

/// Without the rounding errors of a turn: of the rates between the components of one field, those that vanish but for
/// the last digits of the largest or, near the onset of order, of the terms that cancel.
MatrixXd factors_of(const model::LinearisedAt& at, int x, int y) {
    MatrixXd result = at.factors(x, y);
    if (x > 0 || y > 0) return result;
    constexpr double rounding = 1e-13, suspicious = 1e-6;
    const std::vector<int>& members = at.members();
    for (const auto& [field, first] : model::placed_fields(at.equations().model())) {
        const auto component = static_cast<int>(first);
        const auto begin = std::ranges::find(members, component);
        if (field.spin == 0 || begin == members.end()) continue;
        auto block = result.block<2, 2>(begin - members.begin(), begin - members.begin());
        const double largest = block.cwiseAbs().maxCoeff();
        for (int i = 0; i < 2; ++i)
            for (int k = 0; k < 2; ++k) {
                const double size = std::abs(block(i, k));
                if (size < rounding * largest || (size > 0.0 && size < suspicious * largest &&
                                                  size < rounding * size_of_terms(at, component + i, component + k)))
                    block(i, k) = 0.0;
            }
    }
    return result;
}

Expansion expansion_of(const model::LinearisedAt& at) {
    return {.factors = [&at](int x, int y) { return factors_of(at, x, y); },
            .mass_density = at.mass_density()(at.members()),
            .fields = fields_of(at.equations(), at.members())};
}

/// Powers of 2 for the rows and columns with which the factors are as near as possible to 1, in units of length and of
/// time that make them so: by least squares of the logarithms of the largest factor between two fields.
/// Source: Curtis & Reid, J. Inst. Maths Applics 10, 118 (1972).
numerics::Scales unit_scales(const Expansion& at) {
    const int count = at.fields.empty() ? 0 : std::ranges::max(at.fields) + 1, unknowns = 2 * count + 2;
    std::vector<std::vector<double>> equations;  // the coefficients of the unknowns, then the right side
    const auto add = [&](int row, int column, int order, int rate, double size) {
        if (!(size > 0.0) || !std::isfinite(size)) return;
        std::vector<double>& equation = equations.emplace_back(static_cast<std::size_t>(unknowns + 1), 0.0);
        equation[static_cast<std::size_t>(row)] = equation[static_cast<std::size_t>(count + column)] = 1.0;
        equation[static_cast<std::size_t>(2 * count)] = order;
        equation[static_cast<std::size_t>(2 * count + 1)] = rate;
        equation.back() = -std::log2(size);
    };
    const auto rows = static_cast<Eigen::Index>(at.fields.size());
    const auto field = [&](Eigen::Index row) { return at.fields[static_cast<std::size_t>(row)]; };
    for (int order = 0; order <= 2; ++order) {
        MatrixXd size = MatrixXd::Zero(count, count);
        for (int x = 0; x <= order; ++x) {
            const MatrixXd factors = at.factors(x, order - x);
            for (Eigen::Index i = 0; i < rows; ++i)
                for (Eigen::Index k = 0; k < rows; ++k) {
                    double& largest = size(field(i), field(k));
                    largest = std::max(largest, std::abs(factors(i, k)));
                }
        }
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < count; ++k) add(i, k, order, 1, size(i, k));
    }
    for (Eigen::Index i = 0; i < rows; ++i) add(field(i), field(i), 0, 0, std::abs(at.mass_density(i)));
    MatrixXd left = MatrixXd::Zero(static_cast<Eigen::Index>(equations.size()), unknowns);
    VectorXd right(left.rows());
    for (Eigen::Index n = 0; n < left.rows(); ++n) {
        const std::vector<double>& equation = equations[static_cast<std::size_t>(n)];
        for (int k = 0; k < unknowns; ++k) left(n, k) = equation[static_cast<std::size_t>(k)];
        right(n) = equation.back();
    }
    const VectorXd found =
        left.rows() > 0 ? VectorXd(numerics::shortest_solution(left, right)) : VectorXd::Zero(unknowns);
    numerics::Scales result{.rows = VectorXd(rows), .columns = VectorXd(rows)};
    for (Eigen::Index i = 0; i < rows; ++i) {
        result.rows(i) = std::exp2(std::round(found(field(i))));
        result.columns(i) = std::exp2(std::round(found(count + field(i))));
    }
    return result;
}

/// Modes at q = 0 that neither grow nor decay, of LinearisedAt::members(): left moved right is the identity.
struct SlowSpace {
    MatrixXd right, left;       ///< columns, rows
    MatrixXd fast;              ///< the answer of the fast modes to a force on them, 0 for one on the slow modes
    std::string why_none = {};  ///< as LongWaves
};

/// By the singular values of the equations at q = 0.
SlowSpace slow_space(const Expansion& at) {
    const MatrixXd m = at.factors(0, 0);
    const Eigen::VectorXd& mass_density = at.mass_density;
    const Eigen::Index n = m.rows();
    // Rows and columns of size 1, so that units do not decide what is singular.
    Eigen::VectorXd rows = Eigen::VectorXd::Ones(n), columns = rows;
    for (Eigen::Index k = 0; k < n; ++k)
        if (const double size = m.row(k).cwiseAbs().maxCoeff(); size > 0.0) rows(k) = 1.0 / size;
    for (Eigen::Index k = 0; k < n; ++k)
        if (const double size = (rows.asDiagonal() * m.col(k)).cwiseAbs().maxCoeff(); size > 0.0)
            columns(k) = 1.0 / size;
    const numerics::DenseSvd<MatrixXd> svd =
        numerics::dense_svd(MatrixXd(rows.asDiagonal() * m * columns.asDiagonal()));
    Eigen::Index rank = 0;
    while (rank < n && svd.values(rank) > 1e-10 * svd.values(0)) ++rank;
    const Eigen::Index slow = n - rank;
    SlowSpace result{.right = columns.asDiagonal() * svd.right.rightCols(slow),
                     .left = svd.left.rightCols(slow).transpose() * rows.asDiagonal()};
    for (Eigen::Index k = 0; k < slow; ++k) result.right.col(k).normalize(), result.left.row(k).normalize();
    const MatrixXd overlap = result.left * mass_density.asDiagonal() * result.right;
    for (Eigen::Index k = 0; k < n; ++k)  // such as a stream function
        if (mass_density(k) == 0.0 && m.row(k).isZero(0.0) && m.col(k).isZero(0.0))
            return {.why_none =
                        "a balance leaves its field free at q = 0, where long waves are expanded; expected a drag in "
                        "that balance, such as -c v, or of a stream function its velocity as a divergence-free field"};
    if (slow > 0 && numerics::dense_svd(overlap).values.minCoeff() < 1e-9)
        return {.why_none = "at q = 0 a slow mode drives another one without limit, and s is no power series in q"};
    if (slow > 0) result.left = numerics::inverse(overlap) * result.left;
    // In the same units: rates near a threshold are small beside slopes in a density.
    MatrixXd bordered = MatrixXd::Zero(n + slow, n + slow);
    bordered.topLeftCorner(n, n) = rows.asDiagonal() * m * columns.asDiagonal();
    bordered.topRightCorner(n, slow) = rows.asDiagonal() * (mass_density.asDiagonal() * result.right);
    bordered.bottomLeftCorner(slow, n) = result.left * mass_density.asDiagonal() * columns.asDiagonal();
    for (Eigen::Index k = n; k < n + slow; ++k) bordered.col(k).normalize(), bordered.row(k).normalize();
    const MatrixXd inverse = numerics::pivoted_inverse(bordered);
    result.fast = columns.asDiagonal() * inverse.topLeftCorner(n, n) * rows.asDiagonal();
    return result;
}

/// All but what is in balance, free at q = 0 and coupled to nothing up to the second order: the flow of a fluid without
/// drag about a uniform state, which has no part in long waves.
std::vector<Eigen::Index> coupled_parts(const Expansion& at) {
    const Eigen::Index n = at.mass_density.size();
    MatrixXd size = MatrixXd::Zero(n, n);
    for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}) size += at.factors(x, y).cwiseAbs();
    size.diagonal().setZero();
    size += at.factors(0, 0).cwiseAbs();
    std::vector<Eigen::Index> coupled;
    for (Eigen::Index k = 0; k < n; ++k)
        if (at.mass_density(k) != 0.0 || !size.row(k).isZero(0.0) || !size.col(k).isZero(0.0)) coupled.push_back(k);
    return coupled;
}

LongWaves waves_of(const Expansion& at);

/// The same of some of its parts; the others have no part in any mode.
LongWaves waves_of_parts(const Expansion& at, const std::vector<Eigen::Index>& parts) {
    std::vector<int> fields;
    for (const Eigen::Index part : parts) fields.push_back(at.fields[static_cast<std::size_t>(part)]);
    LongWaves result = waves_of({.factors = [&](int x, int y) -> MatrixXd { return at.factors(x, y)(parts, parts); },
                                 .mass_density = at.mass_density(parts),
                                 .fields = fields});
    const Eigen::Index n = at.mass_density.size(), slow = result.right.cols();
    const MatrixXd right = std::exchange(result.right, MatrixXd::Zero(n, slow)),
                   left = std::exchange(result.left, MatrixXd::Zero(slow, n));
    result.right(parts, Eigen::all) = right;
    result.left(Eigen::all, parts) = left;
    return result;
}

LongWaves even_waves_of(const Expansion& at);

/// By the equations in even units.
LongWaves waves_of(const Expansion& at) {
    const std::vector<Eigen::Index> parts = coupled_parts(at);
    if (static_cast<Eigen::Index>(parts.size()) < at.mass_density.size()) return waves_of_parts(at, parts);
    const numerics::Scales by = unit_scales(at);
    const auto even = [&](int x, int y) -> MatrixXd {
        return by.rows.asDiagonal() * at.factors(x, y) * by.columns.asDiagonal();
    };
    LongWaves result = even_waves_of({.factors = even,
                                      .mass_density = by.rows.cwiseProduct(at.mass_density).cwiseProduct(by.columns),
                                      .fields = at.fields});
    result.right = by.columns.asDiagonal() * result.right;
    result.left = result.left * by.rows.asDiagonal();
    return result;
}

LongWaves even_waves_of(const Expansion& at) {
    const SlowSpace space = slow_space(at);
    LongWaves result{.left = space.left, .right = space.right, .why_none = space.why_none};
    if (!space.why_none.empty() || space.right.cols() == 0) return result;
    const MatrixXd first_x = at.factors(1, 0), first_y = at.factors(0, 1);
    const MatrixXd by_x = space.fast * (first_x * space.right), by_y = space.fast * (first_y * space.right);
    const auto second = [&](int x, int y) -> MatrixXd { return space.left * at.factors(x, y) * space.right; };
    result.speed_x = -(space.left * first_x * space.right);
    result.speed_y = -(space.left * first_y * space.right);
    result.damping_xx = second(2, 0) - space.left * first_x * by_x;
    result.damping_yy = second(0, 2) - space.left * first_y * by_y;
    result.damping_xy = second(1, 1) - space.left * first_x * by_y - space.left * first_y * by_x;
    for (auto [speed, first] : {std::pair{&result.speed_x, &first_x}, std::pair{&result.speed_y, &first_y}})
        if (speed->norm() <= 1e-13 * space.left.norm() * first->norm() * space.right.norm())
            speed->setZero();  // rounding of the singular vectors
    return result;
}

/// Speeds that differ by less than this part of the largest are one: rounding splits a double root by its square root.
constexpr double same = 3e-7;

struct AtAngle {
    MatrixXd speed, damping;
};
AtAngle at_angle(const LongWaves& w, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {.speed = w.speed_x * c + w.speed_y * s,
            .damping = w.damping_xx * (c * c) + w.damping_yy * (s * s) + w.damping_xy * (c * s)};
}

VectorXcd speeds_of(const MatrixXd& u) {
    VectorXcd speeds;
    if (u.rows() == 1) speeds = VectorXcd::Constant(1, u(0, 0));
    else speeds = numerics::dense_eigenvalues(u);
    // A size that no choice of units changes: of the speeds, and of the loops that could make one.
    double size = speeds.cwiseAbs().maxCoeff();
    for (int i = 0; i < u.rows(); ++i)
        for (int k = 0; k < u.rows(); ++k) size = std::max(size, std::sqrt(std::abs(u(i, k) * u(k, i))));
    for (Complex& speed : speeds) {
        if (std::abs(speed.imag()) < same * size) speed = speed.real();
        if (std::abs(speed) < 1e-13 * size) speed = 0.0;  // rounding
    }
    std::ranges::sort(speeds, [](Complex a, Complex b) {
        return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag();
    });
    for (int i = 1; i < speeds.size(); ++i)  // one cluster, one speed
        if (std::abs(speeds(i) - speeds(i - 1)) < same * size) speeds(i) = speeds(i - 1);
    return speeds;
}

/// The matrix of cofactors, transposed, of at most 3 rows: right times left eigenvector where it is singular once.
MatrixXcd adjugate(const MatrixXcd& m) {
    MatrixXcd r(m.rows(), m.rows());
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
    VectorXcd damping;
    MatrixXcd shape;  ///< a column each
};

/// The `count` modes of one speed; their dampings are NaN if it has fewer eigenvectors.
Group group_of(const AtAngle& at, Complex speed, int count) {
    const auto k = at.speed.rows();
    MatrixXcd rest = at.speed.cast<Complex>();
    rest.diagonal().array() -= speed;
    if (count == 1 && k <= 3) {
        const MatrixXcd both = adjugate(rest);
        Eigen::Index column = 0;
        both.colwise().squaredNorm().maxCoeff(&column);
        return {.damping = VectorXcd::Constant(1, (both * at.damping.cast<Complex>()).trace() / both.trace()),
                .shape = both.col(column)};
    }
    const numerics::DenseSvd<MatrixXcd> svd = numerics::dense_svd(rest);
    const MatrixXcd right = svd.right.rightCols(count), left = svd.left.rightCols(count).adjoint();
    const MatrixXcd overlap = left * right;
    const double max_speed = std::max(svd.values(0), at.speed.cwiseAbs().maxCoeff());
    const VectorXd sizes = numerics::dense_svd(overlap).values;
    if (!(sizes(count - 1) > 1e-6 * sizes(0)) || svd.values(k - count) > 1e-5 * max_speed)
        return {.damping = VectorXcd::Constant(count, nan), .shape = right};
    const MatrixXcd reduced = numerics::solution(overlap, left * at.damping.cast<Complex>() * right);
    const numerics::DenseEigen solved = numerics::dense_eigen(reduced);
    return {.damping = solved.values, .shape = right * solved.vectors};
}

/// see(speed, Group) for the modes of each speed.
template <class See>
void for_groups(const AtAngle& at, See see) {
    const VectorXcd speeds = speeds_of(at.speed);
    for (int first = 0, next = 0; first < speeds.size(); first = next) {
        for (next = first + 1; next < speeds.size() && speeds(next) == speeds(first);) ++next;
        see(speeds(first), group_of(at, speeds(first), next - first));
    }
}

/// Waves of one direction as if along x, without the parts along q of divergence-free fields; `parts` has the others
/// as columns, by members.
Expansion along_one_direction(const model::LinearisedAt& at, double angle, const MatrixXd& parts) {
    const double c = std::cos(angle), s = std::sin(angle);
    const std::vector<int> of_members = fields_of(at.equations(), at.members());
    std::vector<int> fields;
    for (Eigen::Index k = 0; k < parts.cols(); ++k) {
        Eigen::Index member = 0;
        parts.col(k).cwiseAbs().maxCoeff(&member);
        fields.push_back(of_members[static_cast<std::size_t>(member)]);
    }
    return {.factors = [&at, parts, c, s](int x, int y) -> MatrixXd {
                MatrixXd sum = MatrixXd::Zero(parts.rows(), parts.rows()), sizes = sum;
                for (int n = 0; n <= x && y == 0; ++n) {
                    const MatrixXd summand = std::pow(c, n) * std::pow(s, x - n) * factors_of(at, n, x - n);
                    sum += summand;
                    sizes += summand.cwiseAbs();
                }
                constexpr double rounding = 1e-14;  // of parts along q that cancel
                const MatrixXd result = parts.transpose() * sum * parts,
                               size = parts.transpose().cwiseAbs() * sizes * parts.cwiseAbs();
                return (result.array().abs() <= rounding * size.array()).select(0.0, result);
            },
            .mass_density = parts.transpose().cwiseAbs2() * at.mass_density()(at.members()),
            .fields = fields};
}
}  // namespace

LongWaves long_waves(const model::LinearisedAt& at) { return waves_of(expansion_of(at)); }

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

void SlowGrowth::add(std::complex<double> speed, std::complex<double> damping) {
    first = std::max(first, speed.imag());
    // A defective speed splits as sqrt(q), one half of it growing.
    second = std::max(second, std::isnan(damping.real()) ? infinite : -damping.real());
}

SlowGrowth slow_growth(const LongWaves& waves, double angle) {
    SlowGrowth growth;
    if (waves.right.cols() == 0) return growth;
    for_groups(at_angle(waves, angle), [&](Complex speed, const Group& group) {
        for (const Complex damping : group.damping) growth.add(speed, damping);
    });
    if (growth.first > 0.0) growth.second = 0.0;
    return growth;
}

SlowModes slow_modes(const model::LinearisedAt& at, double angle) {
    const double direction = at.direction() + angle;
    const MatrixXd parts = at.parts_across(direction);
    const bool has_all = parts.cols() == parts.rows();
    const LongWaves waves = has_all ? long_waves(at) : waves_of(along_one_direction(at, direction, parts));
    SlowModes result{.modes = slow_modes(waves, has_all ? direction : 0.0), .why_none = waves.why_none};
    if (result.modes.empty()) return result;
    double fastest = 0.0;
    for (SlowMode& mode : result.modes) {
        Eigen::VectorXcd whole = Eigen::VectorXcd::Zero(at.equations().components());
        whole(at.members()) = parts * mode.shape;
        mode.shape =
            (has_all ? Eigen::VectorXcd(at.all_components({}) * whole(at.state_components())) : whole).normalized();
        if (std::abs(mode.speed) <= 1e-13 * (waves.speed_x.norm() + waves.speed_y.norm())) mode.speed = 0.0;
        fastest = std::max(fastest, std::abs(mode.speed));
    }
    std::ranges::sort(result.modes, [fastest](const SlowMode& a, const SlowMode& b) {
        if (std::abs(a.speed.real() - b.speed.real()) > 1e-9 * fastest) return a.speed.real() < b.speed.real();
        return a.damping.real() < b.damping.real();
    });
    return result;
}

}  // namespace drover::theory
