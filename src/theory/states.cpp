// theory/states.cpp: uniform stationary states by Newton's method, with deflation.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/bracket.hpp"
#include "numerics/algebra/dense.hpp"
#include "theory/point_theory.hpp"
#include "theory/state_names.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
using Vector = UniformEquations::Vector;
using Matrix = UniformEquations::Matrix;
constexpr double accepted_residual = 1e-12;
/// Of the rates, in a search: two seconds.  Models with some tens of states need fewer, but where fields have states
/// independently of each other there are as many as combinations of them, or continua of relative directions.
constexpr std::int64_t max_evaluations = 3'000'000;
bool has_time(const UniformEquations& equations) { return equations.evaluations() < max_evaluations; }

/// A root, or how far the iteration came.
struct Attempt {
    Vector z;
    double residual = infinite;
    Eigen::Index row = 0;  ///< of the largest residual
    bool is_kink = false;  ///< stationary, and a rate has no derivative there
    bool is_root() const { return residual <= accepted_residual; }
};

/// The size of each field, repeated for its components with a rate.
Vector field_sizes(const UniformEquations& equations, const Vector& z) {
    model::UniformState all = equations.state_of(z), sizes(all.size());
    for (std::size_t k = 0; k < all.size(); ++k) {
        const auto& [field, first] = equations.places()[k];
        sizes[k] = field.spin > 0 ? std::hypot(all[first], all[first + 1]) : std::abs(all[first]);
    }
    return equations.of_state(sizes);
}

/// One over the size of each row.  Both rows of a vector have one size: that of a free direction is rounding.
Vector row_scales(const UniformEquations& equations, const Matrix& jacobian) {
    Vector sizes = jacobian.cwiseAbs().rowwise().maxCoeff();
    sizes.head(equations.count()) = field_sizes(equations, sizes.head(equations.count()));
    for (double& size : sizes) size = size > 0.0 && std::isfinite(size) ? 1.0 / size : 1.0;
    return sizes;
}

/// The Newton step of rows of equal size; the shortest one where the Jacobian is singular, as along a turn.
Vector newton_step(const UniformEquations& equations, const Matrix& jacobian, const Vector& values) {
    const Vector scale = row_scales(equations, jacobian);
    return -numerics::shortest_solution(scale.asDiagonal() * jacobian, scale.asDiagonal() * values, 1e-12);
}

Attempt newton(const UniformEquations& equations, Vector z) {
    Vector f = equations.values(z);
    for (int step = 0; step < 60 && f.allFinite() && f.norm() > 0.0; ++step) {
        const Matrix j = equations.jacobian(z);
        Vector change = newton_step(equations, j, f);
        if (!change.allFinite()) break;
        // Relative to the sizes of the terms: rates of different fields have different units.
        // A rate whose terms are all 0 is as exact as the others.
        const Vector there = equations.sizes(z, j), sizes = there.cwiseMax(1e-14 * there.maxCoeff());
        const double before = UniformEquations::relative(f, sizes).norm();
        f = equations.values(z + change);
        for (int half = 0; half < 12 && !(UniformEquations::relative(f, sizes).norm() <= before); ++half) {
            change *= 0.5;
            f = equations.values(z + change);
        }
        z += change;
        if ((change.array().abs() <= 1e-15 * field_sizes(equations, z).array()).all()) break;
    }
    Attempt attempt{.z = z};
    if (!z.allFinite() || !f.allFinite()) return attempt;
    const Matrix slopes = equations.jacobian(z);
    if (!slopes.allFinite()) {  // a kink, or beyond the domain of a function, whatever the rates are there
        attempt.is_kink =
            f.norm() <= accepted_residual * equations.equations().uniform_rate_sizes(equations.state_of(z)).norm();
        return attempt;
    }
    attempt.residual = equations.relative(z, slopes).maxCoeff(&attempt.row);
    return attempt;
}

/// At the threshold of order any order below the root of rounding is stationary: where twice as much is too, it is 0.
Attempt without_rounding(const UniformEquations& equations, const Attempt& root) {
    Attempt none = root, twice = root;
    double size = 0.0;
    for (Eigen::Index k = 0; k < root.z.size(); ++k) {
        const int component = equations.equations().state_components()[static_cast<std::size_t>(k)];
        if (equations.places()[static_cast<std::size_t>(component)].field.spin == 0) continue;
        size = std::max(size, std::abs(root.z(k)));
        none.z(k) = 0.0;
        twice.z(k) *= 2.0;
    }
    if (!root.is_root() || size == 0.0 || size > 1e-4) return root;
    for (Attempt* const one : {&none, &twice})
        one->residual = equations.relative(one->z, equations.jacobian(one->z)).maxCoeff(&one->row);
    return none.is_root() && twice.is_root() ? none : root;
}

/// Values that are rounding errors of 0 become 0.  A field that is small in its own unit is none: twice as much of it
/// is no root.
Attempt cleaned(const UniformEquations& equations, const Attempt& root) {
    const Vector sizes = field_sizes(equations, root.z);
    Attempt clean = root, twice = root;
    for (Eigen::Index k = 0; k < clean.z.size(); ++k) {
        const bool is_small = sizes(k) <= 1e-9 * std::max(sizes.maxCoeff(), 1e-3);
        if (is_small) twice.z(k) *= 2.0;
        if (is_small || std::abs(clean.z(k)) <= 1e-15 * sizes(k)) clean.z(k) = 0.0;
    }
    for (Attempt* const one : {&clean, &twice})
        one->residual = equations.relative(one->z, equations.jacobian(one->z)).maxCoeff(&one->row);
    const bool is_rounding = clean.is_root() && (twice.is_root() || !root.is_root());
    return without_rounding(equations, is_rounding ? clean : root);
}

/// Whether a state has small rates only beside large terms, such as s = 10^12 of 1 - s + sqrt(s^2 + 1): its equations
/// do not place it, and where what they do not place is made smaller, the rates stay, and the terms do not.
bool is_far_away(const UniformEquations& equations, const Attempt& root) {
    const Matrix j = equations.jacobian(root.z);
    constexpr double epsilon = std::numeric_limits<double>::epsilon(), near = 0.01, not_small = 1e-9;
    const Vector scale = row_scales(equations, j), sizes = equations.sizes(root.z, j);
    const auto [left, values, right] = numerics::dense_svd(Matrix(scale.asDiagonal() * j));
    const Vector rounding = left.leftCols(values.size()).cwiseAbs().transpose() * scale.cwiseProduct(epsilon * sizes),
                 shift = right.leftCols(values.size()).cwiseAbs() * rounding.cwiseQuotient(values);  // NaN: anywhere
    const auto scaled = [&](double factor) {
        Vector z = root.z;
        for (Eigen::Index k = 0; k < z.size(); ++k)
            if (!(shift(k) <= 1e-6 * std::abs(z(k)))) z(k) *= factor;
        return z;
    };
    const auto largest_rate = [&](const Vector& z) { return equations.relative(z, equations.jacobian(z)).maxCoeff(); };
    const double located = 10.0 * std::max(root.residual, epsilon);
    if (largest_rate(scaled(1.0 + near)) > located && largest_rate(scaled(1.0 - near)) > located) return false;
    for (double factor = 0.1; factor > 1e-18; factor *= 0.1)
        if (const Vector z = scaled(factor); largest_rate(z) > not_small)
            return (equations.values(z).array().abs() <= 10.0 * accepted_residual * sizes.array()).all();
    return false;
}

bool equal_states(const UniformEquations& equations, const Vector& a, const Vector& b) {
    const Vector sizes = field_sizes(equations, a).cwiseMax(field_sizes(equations, b));
    return ((a - b).cwiseAbs().array() <= 1e-6 * sizes.array() + 1e-12).all();
}

/// The state with its direction along x.
Vector turned_along_x(const UniformEquations& equations, const Vector& z) {
    Vector result = equations.turned(z, -model::direction_of(equations.model(), equations.state_of(z)));
    const Vector sizes = field_sizes(equations, result);
    for (Eigen::Index k = 0; k < result.size(); ++k)
        if (std::abs(result(k)) <= 4e-16 * sizes(k)) result(k) = 0.0;  // rounding of the turn
    return result;
}

/// Whether one state is a turned copy of another; both are along x, which a field of spin m leaves m ways.
bool turned_copies(const UniformEquations& equations, const Vector& a, const Vector& b) {
    if (!equations.turns_freely()) return equal_states(equations, a, b);
    for (const model::Field& field : equations.model().fields)
        for (int n = 0; n < field.spin; ++n)
            if (equal_states(equations, a, equations.turned(b, 2.0 * std::numbers::pi * n / field.spin))) return true;
    return equal_states(equations, a, b);
}

/// Changes of a state that, to first order, leave it stationary, without turns where all directions are equivalent:
/// orthonormal columns.
Matrix neutral_changes(const UniformEquations& equations, const Vector& z) {
    Matrix j = equations.jacobian(z);
    if (!j.allFinite()) return Matrix::Zero(z.size(), 0);
    j = row_scales(equations, j).asDiagonal() * j;
    const Vector turn = equations.turn_of(z);
    if (equations.turns_freely() && turn.norm() > 0.0) {  // held fixed
        j.conservativeResize(j.rows() + 1, Eigen::NoChange);
        j.bottomRows(1) = turn.normalized().transpose();
    }
    const auto [left, values, right] = numerics::dense_svd(j);
    Eigen::Index rank = 0;
    while (rank < values.size() && values(rank) > 1e-8 * values(0)) ++rank;
    return right.rightCols(j.cols() - rank);
}

/// The stationary state near a point beside another one, if it is a member of a family as well.
std::optional<Vector> member_near(const UniformEquations& equations, const Vector& from, const Vector& step) {
    const Attempt next = cleaned(equations, newton(equations, from + step));
    if (!next.is_root() || (next.z - from - step).norm() > 0.5 * step.norm()) return {};
    return next.z;
}

bool is_of_family(const UniformEquations& equations, const Vector& z) {
    const Matrix neutral = neutral_changes(equations, z);
    const double length = z.norm() > 0.0 ? 0.02 * z.norm() : 0.02;
    for (Eigen::Index k = 0; k < neutral.cols(); ++k)
        if (const std::optional<Vector> member = member_near(equations, z, length * neutral.col(k)))
            if (neutral_changes(equations, *member).cols() > 0) return true;
    return false;
}

/// Whether stationary states connect two of them: a walk towards the other one.
bool are_connected(const UniformEquations& equations, const Vector& from, const Vector& to) {
    const double longest = 0.2 * (to - from).norm();
    Vector here = from;
    for (int n = 0; n < 100 && has_time(equations); ++n) {
        const Matrix neutral = neutral_changes(equations, here);
        if (neutral.cols() == 0) return false;
        const Vector way = to - here;
        constexpr double arrived = 1e-4;  // nearer, Newton's method moves along the family by more than the step
        if (way.norm() <= arrived * to.norm()) return true;
        Vector step = neutral * (neutral.transpose() * way);
        if (step.norm() < 0.05 * way.norm()) {  // opposite members of a ring: sideways
            if (n > 0) return false;
            step = neutral.col(0) * longest;
        }
        if (step.norm() > longest) step *= longest / step.norm();
        const std::optional<Vector> next = member_near(equations, here, step);
        if (!next) return false;
        here = equations.turns_freely() ? turned_along_x(equations, *next) : *next;
    }
    return false;
}

/// Roots that are no copies of each other.
class Roots {
public:
    explicit Roots(const UniformEquations& equations) : equations_(equations) {}

    void try_from(const Vector& start, bool deflates) {
        if (!has_time(equations_)) return;
        ++starts_;
        add(newton(equations_, start));
        if (!deflates) return;
        if (const std::optional<Vector> other = deflated(start)) add(newton(equations_, *other));
    }
    struct Root {
        Attempt at;
        bool is_of_family = false;
    };
    const std::vector<Root>& found() const { return roots_; }
    const std::optional<Vector>& kink() const { return kink_; }
    const Attempt& nearest() const { return nearest_; }  ///< the smallest residual of all attempts
    int starts() const { return starts_; }

private:
    void add(const Attempt& attempt) {
        if (attempt.is_kink && !kink_) kink_ = attempt.z;
        if (!std::isfinite(attempt.residual)) return;
        Attempt root = cleaned(equations_, attempt);  // a field that decays is 0 but for rounding: relative to itself 1
        if (root.is_root() && !equations_.jacobian(root.z).allFinite()) {
            if (!kink_) kink_ = root.z;
            return;
        }
        if (root.residual < nearest_.residual) nearest_ = root;
        if (!root.is_root()) return;
        if (equations_.turns_freely()) root.z = turned_along_x(equations_, root.z);
        for (const Root& other : roots_) {
            if (turned_copies(equations_, root.z, other.at.z)) return;
            if (other.is_of_family && are_connected(equations_, root.z, other.at.z)) return;
        }
        if (is_far_away(equations_, root)) return;
        roots_.push_back({.at = root, .is_of_family = is_of_family(equations_, root.z)});
    }

    /// Newton's method for the equations times prod (1 + l^2/|z - root|^2), which has none of the roots.  l: the
    /// distance at the start.
    std::optional<Vector> deflated(Vector z) const {
        if (roots_.empty()) return {};
        std::vector<double> squares;
        for (const Root& root : roots_) squares.push_back((z - root.at.z).squaredNorm());
        for (int step = 0; step < 60; ++step) {
            const Vector f = equations_.values(z);
            if (!f.allFinite()) return {};
            Vector change = newton_step(equations_, equations_.jacobian(z), f);
            double slope = 0.0;  // of the logarithm of the factor along the change
            for (std::size_t r = 0; r < roots_.size(); ++r) {
                const Vector away = z - roots_[r].at.z;
                const double square = away.squaredNorm();
                if (square == 0.0) return {};
                slope -= 2.0 * squares[r] * away.dot(change) / (square * (squares[r] + square));
            }
            change /= 1.0 - slope;
            if (!change.allFinite()) return {};
            const double longest = 2.0 * (1.0 + z.norm());
            if (change.norm() > longest) change *= longest / change.norm();
            z += change;
            if (change.norm() <= 1e-8 * z.norm()) return z;
        }
        return {};
    }

    const UniformEquations& equations_;
    std::vector<Root> roots_;
    std::optional<Vector> kink_;
    Attempt nearest_;
    int starts_ = 0;
};

/// Starting points: one field away from its reference, then mixtures of all fields.
std::vector<Vector> starting_points(const UniformEquations& equations) {
    const model::UniformState& reference = equations.means();
    std::vector<Vector> starts{equations.reference()};
    const auto add = [&](const model::UniformState& state) { starts.push_back(equations.of_state(state)); };
    const Vector rates = equations.values(equations.reference());
    const model::UniformState pushes = equations.state_of(rates.head(equations.count()));
    for (const auto& [field, k] : model::placed_fields(equations.model())) {
        if (field.left == model::LeftSide::balance) continue;
        const double unit = reference[k] != 0.0 ? std::abs(reference[k]) : 1.0;
        std::vector<double> directions{0.0};
        for (int n = 1; n < 16 && field.spin > 0 && !equations.turns_freely(); ++n)
            directions.push_back(std::numbers::pi / 8.0 * n);
        if (directions.size() > 1)  // states along a direction that the equations name may repel all others
            for (const double side : {1.0, -1.0})
                directions.push_back(std::atan2(side * pushes[k + 1], side * pushes[k]));
        for (const double size : {1e-3, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0, 1e3}) {
            model::UniformState state = reference;
            if (field.spin == 0)
                for (const double sign : {1.0, -1.0}) state[k] = reference[k] + sign * size * unit, add(state);
            else
                for (const double angle : directions) {
                    state[k] = size * std::cos(angle), state[k + 1] = size * std::sin(angle);
                    add(state);
                }
        }
    }
    Numbers numbers;
    for (int n = 0; n < 48; ++n) {
        model::UniformState state = reference;
        for (double& value : state)
            value = value == 0.0 ? numbers.between(-1.0, 1.0) * std::pow(10.0, numbers.between(-2.0, 1.5))
                                 : value * std::pow(10.0, numbers.between(-1.0, 1.0));
        add(state);
    }
    return starts;
}

/// Values of a component, from which lines of states are made: all sizes, and those from one to another root.
std::vector<double> values_on_line(const std::vector<Roots::Root>& roots, Eigen::Index k) {
    std::vector<double> values{0.0};
    for (int n = -72; n <= 240; n += n < 72 ? 1 : 8)  // 1e-9 to 1e30, above 1e9 by decades
        for (const double sign : {1.0, -1.0}) values.push_back(sign * std::pow(10.0, n / 8.0));
    double low = 0.0, high = 0.0;
    for (const Roots::Root& root : roots) low = std::min(low, root.at.z(k)), high = std::max(high, root.at.z(k));
    constexpr int steps = 64;
    for (int n = 0; n <= 2 * steps; ++n) values.push_back(low + (high - low) * n / steps);
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
}

/// Where the rate of one component changes its sign along its own values, through the reference and through each root:
/// of one field, all its states that differ by more than the distance of the values.
std::vector<Vector> changes_of_sign(const UniformEquations& equations, const std::vector<Roots::Root>& roots) {
    std::vector<Vector> lines{equations.reference()}, starts;
    if (equations.count() > 1)
        for (const Roots::Root& root : roots) lines.push_back(root.at.z);
    for (Eigen::Index k = 0; k < equations.count(); ++k) {
        const std::vector<double> values = values_on_line(roots, k);
        for (Vector z : lines) {
            if (!has_time(equations)) return starts;
            const auto rate_at = [&](double value) {
                z(k) = value;
                return equations.values(z)(k);
            };
            double before = 0.0, rate_before = nan;
            for (const double value : values) {
                const double rate = rate_at(value);
                if (rate == 0.0 && rate_before != 0.0) starts.push_back(z);
                else if (rate * rate_before < 0.0) {
                    z(k) = numerics::crossing(before, value, 1e-6, rate_at);
                    starts.push_back(z);
                }
                before = value, rate_before = rate;
            }
        }
    }
    return starts;
}

/// From guesses alone, from points in all directions too, or beside what these lead to as well.
enum class Depth { guesses, points, whole };

StationaryStates found_states(const model::Equations& equations, const model::UniformState& means, Depth depth,
                              const std::vector<model::UniformState>& guesses = {}) {
    StationaryStates result;
    if (const model::TermSummary* placed = equations.placed_term()) {
        result.why_none = text("the term \"{}\" of {} depends on position or time, so no uniform state satisfies it",
                               placed->text, equations.model().fields[placed->field].symbol);
        return result;
    }
    const UniformEquations uniform(equations, means);
    for (const model::UniformState& guess : guesses) model::check_state(guess, means.size());
    Roots roots(uniform);
    if (depth == Depth::guesses) roots.try_from(uniform.reference(), false);
    for (const model::UniformState& guess : guesses) roots.try_from(uniform.of_state(guess), false);
    if (depth != Depth::guesses) {
        for (const Vector& start : starting_points(uniform)) roots.try_from(start, depth == Depth::whole);
        for (std::size_t before = 0, rounds = 0; rounds < 4 && roots.found().size() > before; ++rounds) {
            before = roots.found().size();
            for (const Vector& start : changes_of_sign(uniform, roots.found())) roots.try_from(start, false);
        }
        if (!has_time(uniform))
            result.why_incomplete = text(
                "the search for uniform states ended at its limit, {:.0e} evaluations of the rates, with {} states: "
                "there may be others",
                static_cast<double>(max_evaluations), roots.found().size());
    }
    const model::Model& model = equations.model();
    for (const Roots::Root& root : roots.found()) {
        StationaryState state{.values = equations.completed(uniform.state_of(root.at.z)),
                              .residual = root.at.residual,
                              .is_of_family = root.is_of_family};
        state.is_isotropic = !has_order(model, uniform.state_of(root.at.z));
        state.has_free_direction = uniform.turns_freely() && !state.is_isotropic;
        result.states.push_back(std::move(state));
    }
    const auto key = [&](const StationaryState& state) {
        return std::tuple(!state.is_isotropic, std::sqrt(squared_order(model, state.values)));
    };
    std::ranges::sort(result.states, [&](const StationaryState& a, const StationaryState& b) {
        const auto [a_kind, a_order] = key(a);
        const auto [b_kind, b_order] = key(b);
        if (a_kind != b_kind) return a_kind < b_kind;
        if (std::abs(a_order - b_order) > 1e-9 * (a_order + b_order)) return a_order < b_order;
        return a.values < b.values;
    });
    const bool is_ordered = !result.states.empty() && !result.states.back().is_isotropic;
    name_states(uniform, result.states);
    if (roots.kink())
        result.kink = text("the state with {} is stationary, but a term has no derivative there",
                           state_text(model, uniform.state_of(*roots.kink())));
    if (result.states.empty() && roots.kink()) result.why_none = result.kink;
    else if (result.states.empty())
        result.why_none =
            text("Newton's method found no uniform stationary state from {} starting points; {}", roots.starts(),
                 std::isfinite(roots.nearest().residual)
                     ? text("the smallest rate that remained is {:.3g} of its terms", roots.nearest().residual)
                     : "no rates are finite where it ends, or they have no derivative there");
    if (order_component(equations) >= 0 && !is_ordered)  // what is in balance has no order of its own
        result.why_no_order =
            text("Newton's method found no ordered uniform state from {} starting points", roots.starts());
    return result;
}

}  // namespace

StationaryStates stationary_states(const model::Equations& equations) {
    return found_states(equations, equations.reference(), Depth::whole);
}

StationaryStates stationary_states(const model::Equations& equations, const model::UniformState& means) {
    return found_states(equations, means, Depth::whole);
}

StationaryStates stationary_states_near(const model::Equations& equations, const model::UniformState& means,
                                        const std::vector<model::UniformState>& guesses, bool elsewhere) {
    return found_states(equations, means, elsewhere ? Depth::points : Depth::guesses, guesses);
}

const StationaryState* nearest_state(const StationaryStates& found, const model::Model& model,
                                     const std::vector<model::UniformState>& samples) {
    const auto count = static_cast<std::size_t>(model::components(model));
    for (const auto& means : samples) require(means.size() == count, {}, "{} values; expected {}", means.size(), count);
    // Fields have units of their own: each counts in parts of its largest size.
    std::vector<double> sizes;
    for (const auto& [field, at] : model::placed_fields(model)) {
        double& size = sizes.emplace_back(0.0);
        for (const StationaryState& state : found.states)
            size = std::max(size, std::hypot(state.values[at], field.spin > 0 ? state.values[at + 1] : 0.0));
    }
    const auto square = [&](const StationaryState& state, const model::UniformState& means) {
        const model::UniformState& values = state.values;
        double sum = 0.0;
        std::size_t n = 0;
        for (const auto& [field, at] : model::placed_fields(model)) {
            const bool has_two = field.spin > 0;
            const double apart = means[at] - values[at], other = has_two ? means[at + 1] - values[at + 1] : 0.0;
            const bool by_size = has_two && (state.has_free_direction || state.is_isotropic);
            const double size = by_size ? std::hypot(means[at], means[at + 1]) - std::hypot(values[at], values[at + 1])
                                        : std::hypot(apart, other);
            const double unit = sizes[n++];
            if (field.left == model::LeftSide::rate && unit > 0.0) sum += std::pow(size / unit, 2);
        }
        return sum;
    };
    const StationaryState* result = nullptr;
    double nearest = 0.0;
    for (const StationaryState& state : found.states) {
        double sum = 0.0;
        for (const model::UniformState& means : samples) sum += square(state, means);
        if (result == nullptr || sum < nearest) result = &state, nearest = sum;
    }
    return result;
}

}  // namespace drover::theory
