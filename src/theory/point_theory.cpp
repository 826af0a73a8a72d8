// theory/point_theory.cpp: the isotropic state and the state of the largest order, by one unknown.
#include "theory/point_theory.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "numerics/algebra/dense.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

PointTheory::PointTheory(const model::Equations& right_sides, std::vector<double> factors,
                         std::function<model::LeftSides(const model::UniformState&)> left,
                         std::function<model::Equations()> solver)
    : equations_(right_sides),
      unknowns_(right_sides.state_components()),
      factors_(std::move(factors)),
      left_(std::move(left)),
      solver_(std::move(solver)) {}

PointTheory PointTheory::scaled(const std::vector<double>& more, std::function<model::Equations()> solver) const {
    PointTheory result = *this;
    if (result.factors_.empty()) result.factors_.assign(more.size(), 1.0);
    for (std::size_t n = 0; n < more.size(); ++n) result.factors_[n] *= more[n];
    result.solver_ = std::move(solver);
    return result;
}

Eigen::VectorXd PointTheory::rates(const model::UniformState& at) const {
    return equations_.uniform_rates(at, factors_)(unknowns_);
}

model::LinearisedAt PointTheory::linearised(const model::UniformState& about) const {
    if (!left_) return {equations_, about};
    model::LeftSides left = left_(about);
    left.factors = factors_;
    left.direction = model::direction_of(equations_.model(), about);
    return {equations_, about, std::move(left)};
}

Eigen::MatrixXd PointTheory::slopes(const model::LinearisedAt& at) const {
    return left_ ? at.factors(0, 0) : Eigen::MatrixXd(at.symbol({}).real());
}

int order_component(const model::Equations& equations) {
    const std::vector<int>& state = equations.state_components();
    for (const int component : model::turning_components(equations.model()))
        if (std::ranges::find(state, component) != state.end()) return component;
    return -1;
}

namespace {
/// Whether the order is found, or why it is not.
enum class Outcome { found, none, unsure };

/// States whose order is P along an axis, with all other fields that do not keep a mean in balance.  Without a field
/// that turns: those of the other fields.
class AlongAxis {
public:
    struct Point {
        Outcome outcome = Outcome::unsure;
        model::UniformState state = {};
        double rate = nan;  ///< of P
        double left = 0.0;  ///< the largest other rate that is left
        double size = 0.0;  ///< of the parts of the rates
    };

    AlongAxis(const PointTheory& theory, const model::UniformState& means, int order)
        : theory_(theory), rest_{.state = means}, order_(order), first_(-2) {
        const std::vector<int>& unknowns = theory.unknowns();
        if (order >= 0) first_ = std::ranges::find(unknowns, order) - unknowns.begin();
        if (first_ == static_cast<Eigen::Index>(unknowns.size())) return;
        if (!theory.rates(means).allFinite()) {
            rest_.outcome = Outcome::none;
            return;
        }
        if (!set_slopes(means)) return;
        rest_ = at(0.0);
        if (rest_.outcome != Outcome::found || order_ < 0) return;
        push_ = theory.rates(rest_.state).segment<2>(first_);
        if (push_.norm() <= 1e-15 * rest_.size) push_.setZero();
        if (rest_.left > 1e-9 * std::max(rest_.size, push_.norm())) rest_.outcome = Outcome::unsure;
    }

    const Point& rest() const { return rest_; }
    /// About the state at rest.
    const model::LinearisedAt& linear() const { return *linear_; }
    const Eigen::Vector2d& push() const { return push_; }  ///< the rate of the order there
    /// The slope of the rate of P there, where all others follow.
    double slope() const { return axis_.dot(of_order_ * axis_); }
    void set_axis(const Eigen::Vector2d& axis) { axis_ = axis; }

    Point at(double order) const {
        Point point{.state = rest_.state};
        for (const int part : {0, 1})
            if (order_ >= 0) point.state[place(order_ + part)] = order * axis_(part);
        if (order != 0.0) move_others(point.state, order * (response_ * axis_));
        for (int step = 0; step < 60; ++step) {
            const auto is_finite = [](double value) { return std::isfinite(value); };
            if (!std::ranges::all_of(point.state, is_finite)) return point;  // Newton's steps have left it
            const Eigen::VectorXd rates = theory_.rates(point.state);
            if (!rates.allFinite()) return point;
            if (are_balanced(rates, point.state)) return with_rates(std::move(point), rates);
            Eigen::MatrixXd inverse = inverse_of_others_;
            if (step > 8) {  // the slopes have changed
                const Eigen::MatrixXd slopes = theory_.slopes(theory_.linearised(point.state));
                inverse = numerics::pivoted_inverse(Eigen::MatrixXd(slopes(others_, others_)));
            }
            move_others(point.state, -inverse * Eigen::VectorXd(rates(others_)));
        }
        return point;
    }

private:
    static std::size_t place(int component) { return static_cast<std::size_t>(component); }
    int component(Eigen::Index unknown) const { return theory_.unknowns()[static_cast<std::size_t>(unknown)]; }
    bool is_order(Eigen::Index k) const { return k == first_ || k == first_ + 1; }
    void move_others(model::UniformState& state, const Eigen::VectorXd& change) const {
        for (std::size_t k = 0; k < others_.size(); ++k)
            state[place(component(others_[k]))] += change(static_cast<Eigen::Index>(k));
    }

    /// Those at rest; false if the other fields do not determine themselves.
    bool set_slopes(const model::UniformState& rest) {
        linear_.emplace(theory_.linearised(rest));
        slopes_ = theory_.slopes(*linear_);
        for (Eigen::Index k = 0; k < slopes_.rows();
             ++k)  // a uniform rate that is 0 whatever the state: a conserved mean
            if (!is_order(k) && slopes_.row(k).cwiseAbs().maxCoeff() > 0.0) others_.push_back(k);
        const std::vector<Eigen::Index> order =
            order_ < 0 ? std::vector<Eigen::Index>() : std::vector<Eigen::Index>{first_, first_ + 1};
        response_ = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(others_.size()), 2);
        if (order_ >= 0) of_order_ = slopes_(order, order);
        if (others_.empty()) return true;
        const Eigen::MatrixXd of_others = slopes_(others_, others_);
        if (!numerics::is_invertible(of_others)) return false;
        inverse_of_others_ = numerics::pivoted_inverse(of_others);
        if (order_ < 0) return true;
        response_ = -inverse_of_others_ * Eigen::MatrixXd(slopes_(others_, order));
        of_order_ += Eigen::MatrixXd(slopes_(order, others_)) * response_;
        return true;
    }

    Eigen::VectorXd sizes_of(const model::UniformState& state) const {
        Eigen::VectorXd sizes(static_cast<Eigen::Index>(theory_.unknowns().size()));
        for (Eigen::Index k = 0; k < sizes.size(); ++k) sizes(k) = std::abs(state[place(component(k))]);
        return slopes_.cwiseAbs() * sizes;
    }

    bool are_balanced(const Eigen::VectorXd& rates, const model::UniformState& state) const {
        if (others_.empty()) return true;
        const Eigen::VectorXd sizes = sizes_of(state);
        return std::ranges::all_of(others_, [&](Eigen::Index k) { return std::abs(rates(k)) <= 1e-13 * sizes(k); });
    }

    Point with_rates(Point point, const Eigen::VectorXd& rates) const {
        point.outcome = Outcome::found;
        point.size = sizes_of(point.state).maxCoeff();
        for (Eigen::Index k = 0; k < rates.size(); ++k)  // of conserved means, and of others that follow
            if (!is_order(k)) point.left = std::max(point.left, std::abs(rates(k)));
        if (order_ < 0) return point;
        const Eigen::Vector2d rate = rates.segment<2>(first_), turned(-axis_.y(), axis_.x());
        point.rate = axis_.dot(rate);
        point.left = std::max(point.left, std::abs(turned.dot(rate)));
        return point;
    }

    const PointTheory& theory_;
    Point rest_;
    int order_;
    Eigen::Index first_;
    Eigen::Vector2d axis_{1.0, 0.0}, push_{0.0, 0.0};
    std::optional<model::LinearisedAt> linear_;
    Eigen::MatrixXd slopes_, response_;  ///< at rest; what the others are of the order
    std::vector<Eigen::Index> others_;
    Eigen::MatrixXd inverse_of_others_;
    Eigen::Matrix2d of_order_ = Eigen::Matrix2d::Zero();
};

/// The largest root of the rate H + P h(P^2) of the order, where H is that of its source.
class LargestOrder {
public:
    explicit LargestOrder(AlongAxis& along) : along_(along) {
        source_ = along.push().norm();
        if (source_ > 0.0) along.set_axis(along.push() / source_);
        set_unit();
    }

    AlongAxis::Point find() const {
        const std::optional<double> slope = cubic_slope();
        return slope ? of_cubic(*slope) : by_steps();
    }

    /// Where saturation is cubic, h(s) is a straight line: three points tell.  Its slope; nothing where it is not.
    std::optional<double> cubic_slope() const {
        const double h_1 = growth(unit_), h_4 = growth(4.0 * unit_), h_9 = growth(9.0 * unit_),
                     slope = (h_9 - h_4) / 5.0;
        const double h_0 = h_4 - 4.0 * slope, size = std::abs(h_0) + 9.0 * std::abs(slope);
        if (!(std::abs(h_0 + slope - h_1) <= 1e-12 * size && std::abs(h_0 - along_.slope()) <= 1e-9 * size)) return {};
        return std::abs(slope) > 1e-14 * std::abs(h_0) ? slope / unit_ : 0.0;
    }

private:
    /// A unit of s in which products are not lost beside what is linear.
    void set_unit() {
        constexpr double max_unit = 0x1p400, lost = 1e-6;
        for (double unit = 1.0; unit <= max_unit; unit *= 0x1p20) {
            const double h = growth(9.0 * unit);
            if (!std::isfinite(h)) return;  // beyond what the equations allow
            unit_ = unit;
            if (std::abs(h - along_.slope()) > lost * std::abs(along_.slope())) return;
        }
        unit_ = 1.0;  // all is linear
    }

    /// h at s: at which order grows.
    double growth(double s) const {
        const double order = std::sqrt(s);
        const AlongAxis::Point point = along_.at(order);
        return point.outcome == Outcome::found ? (point.rate - source_) / order : nan;
    }

    AlongAxis::Point of_cubic(double slope) const {
        const double h_0 = along_.slope();
        if (source_ == 0.0) {
            if (!(h_0 * slope < 0.0)) return {.outcome = Outcome::none};
            return polished(std::sqrt(-h_0 / slope), slope);
        }
        if (!(slope < 0.0)) return {};
        // From the side of large order, where the rate falls ever faster.
        double order = std::sqrt(std::max(0.0, -h_0 / slope)) + std::cbrt(-source_ / slope);
        for (int step = 0; step < 100; ++step) {
            const double rate = source_ + order * (h_0 + order * order * slope);
            const double next = order - rate / (h_0 + 3.0 * order * order * slope);
            if (std::abs(next - order) <= 1e-15 * order) break;
            order = next;
        }
        return polished(order, slope);
    }

    /// With the rate itself in place of the line through its points.
    AlongAxis::Point polished(double order, double slope) const {
        AlongAxis::Point point = along_.at(order);
        const double by_order = along_.slope() + 3.0 * order * order * slope;
        for (int step = 0; step < 3 && point.outcome == Outcome::found && by_order != 0.0; ++step) {
            const double next = order - point.rate / by_order;
            if (std::abs(next - order) <= 1e-15 * order || !(next > 0.0)) break;
            point = along_.at(order = next);
        }
        return point;
    }

    /// The largest change of sign among powers of 2, halved.
    AlongAxis::Point by_steps() const {
        const auto rate_at = [&](double s) { return growth(s) + source_ / std::sqrt(s); };
        double high = 0.0, low = 0.0;
        for (int k = 40; k >= -80 && low == 0.0; --k) {
            const double s = unit_ * std::exp2(k), rate = rate_at(s);
            if (rate < 0.0) high = s;
            if (rate >= 0.0) low = s;
        }
        if (low == 0.0 || high == 0.0) return {.outcome = Outcome::none};
        for (int step = 0; step < 200; ++step) {
            const double middle = 0.5 * (low + high);
            if (!(middle > low && middle < high)) break;
            (rate_at(middle) >= 0.0 ? low : high) = middle;
        }
        return along_.at(std::sqrt(low));
    }

    AlongAxis& along_;
    double source_ = 0.0, unit_ = 1.0;
};

AlongAxis along_axis(const PointTheory& theory, const model::UniformState& means) {
    return {theory, means, order_component(theory.equations())};
}

/// By the whole search.
std::optional<PointState> searched_state(const PointTheory& theory, const model::UniformState& means, bool ordered) {
    const model::Equations equations = theory.solver();
    const int order = order_component(equations);
    const auto order_of = [&](const model::UniformState& state) {
        if (order < 0) return 0.0;
        const auto first = static_cast<std::size_t>(order);
        return std::hypot(state[first], state[first + 1]);
    };
    const auto away = [&](const StationaryState& state) { return squared_distance(state.values, means); };
    const StationaryStates found = stationary_states(equations, means);
    const StationaryState* best = nullptr;
    for (const StationaryState& state : found.states) {
        if ((order_of(state.values) > 0.0) != ordered) continue;
        if (best == nullptr || (ordered ? order_of(state.values) > order_of(best->values) : away(state) < away(*best)))
            best = &state;
    }
    if (best == nullptr) return {};
    return PointState{.values = best->values, .linear = theory.linearised(best->values)};
}
}  // namespace

std::optional<StationaryStates> states_of_cubic_order(const PointTheory& theory, const model::UniformState& means) {
    if (order_component(theory.equations()) < 0) return {};
    AlongAxis along = along_axis(theory, means);
    if (along.rest().outcome != Outcome::found || along.push().norm() > 0.0) return {};
    const LargestOrder order(along);
    const std::optional<double> slope = order.cubic_slope();
    if (!slope || (*slope == 0.0 && along.slope() == 0.0)) return {};
    const auto residual = [](const AlongAxis::Point& at) {
        const double rate = std::max(at.left, std::abs(at.rate));
        return rate == 0.0 ? 0.0 : rate / at.size;
    };
    StationaryStates result;
    result.states.push_back({.name = "isotropic", .values = along.rest().state, .is_isotropic = true});
    const AlongAxis::Point found = order.find();
    if (found.outcome == Outcome::none) {
        result.why_no_order = "the uniform equations have no ordered solution";
        return result;
    }
    constexpr double max_residual = 1e-12;  // as in a search
    if (found.outcome != Outcome::found || residual(found) > max_residual) return {};
    result.states.push_back(
        {.name = "ordered", .values = found.state, .residual = residual(found), .has_free_direction = true});
    return result;
}

OrderSearch order_search(const model::Equations& equations) {
    if (order_component(equations) < 0) return {};
    if (turns_freely(equations)) return {.turns_freely = true};
    const PointTheory theory(equations);
    const AlongAxis along = along_axis(theory, equations.reference());
    return {.is_whole = along.rest().outcome != Outcome::found || along.push().norm() == 0.0};
}

std::optional<PointState> isotropic_state(const PointTheory& theory, const model::UniformState& means) {
    const AlongAxis along = along_axis(theory, means);
    if (along.rest().outcome == Outcome::unsure) return searched_state(theory, means, false);
    if (along.rest().outcome == Outcome::none || along.push().norm() > 0.0) return {};
    const model::UniformState& state = along.rest().state;
    return PointState{.values = state, .linear = state == means ? along.linear() : theory.linearised(state)};
}

std::optional<PointState> ordered_state(const PointTheory& theory, const model::UniformState& means,
                                        const OrderSearch& search) {
    if (order_component(theory.equations()) < 0) return {};
    if (search.is_whole && theory.rates(means).allFinite()) return searched_state(theory, means, true);
    AlongAxis along = along_axis(theory, means);
    if (along.rest().outcome == Outcome::none) return {};
    if (along.rest().outcome != Outcome::found) return searched_state(theory, means, true);
    const AlongAxis::Point found = LargestOrder(along).find();
    const bool is_driven = along.push().norm() > 0.0;
    if (found.outcome == Outcome::none && !is_driven) return {};
    if (found.outcome != Outcome::found || std::max(found.left, std::abs(found.rate)) > 1e-9 * found.size)
        return searched_state(theory, means, true);
    return PointState{.values = found.state, .linear = theory.linearised(found.state)};
}

double relaxation_of_order(const PointTheory& theory, const PointState& isotropic) {
    const std::vector<int> turning = model::turning_components(theory.equations().model());
    const std::vector<int>& unknowns = theory.unknowns();
    const auto place_of = [&](int component) { return std::ranges::find(unknowns, component) - unknowns.begin(); };
    const auto count = static_cast<Eigen::Index>(unknowns.size());
    const int first = order_component(theory.equations());
    if (first < 0) return nan;
    const std::vector<Eigen::Index> order{place_of(first), place_of(first + 1)};
    std::vector<Eigen::Index> others;
    for (const int component : turning)
        if (const Eigen::Index place = place_of(component); place < count && place != order.front())
            others.insert(others.end(), {place, place + 1});
    const Eigen::MatrixXd slopes = theory.slopes(isotropic.linear);
    Eigen::Matrix2d rates = slopes(order, order);
    const Eigen::MatrixXd by_others = slopes(order, others), of_order = slopes(others, order);
    if (!by_others.isZero(0.0) && !of_order.isZero(0.0)) {
        const Eigen::MatrixXd alone = slopes(others, others);
        if (!numerics::is_invertible(alone)) return nan;
        rates -= by_others * numerics::pivoted_inverse(alone) * of_order;
    }
    // The larger real part of the eigenvalues.
    const double mean = 0.5 * rates.trace(),
                 square = 0.25 * std::pow(rates(0, 0) - rates(1, 1), 2) + rates(0, 1) * rates(1, 0);
    return -(mean + (square > 0.0 ? std::sqrt(square) : 0.0));
}

}  // namespace drover::theory
