// model/linearised_at.cpp: the coefficients of the powers of the wavevector.
#include "drover/model/linearised_at.hpp"

#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"
#include "model/compiled.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::model {

using numerics::Wavevector;

namespace {
using Powers = std::map<Order, Eigen::MatrixXd>;

std::vector<LinearisedAt::Power> listed(const Powers& powers) {
    return mapped(powers, [](const auto& one) { return LinearisedAt::Power{one.first.x, one.first.y, one.second}; });
}

Symbol sum_of(const std::vector<LinearisedAt::Power>& powers, int components, const Wavevector& q) {
    Symbol m = Symbol::Zero(components, components);
    for (const LinearisedAt::Power& power : powers) {
        const std::complex<double> factor = factor_of({power.x, power.y}, q);
        if ((power.x + power.y) % 2 == 0) m.real() += factor.real() * power.factors;
        else m.imag() += factor.imag() * power.factors;
    }
    return m;
}

std::vector<LinearisedAt::Power> powers_of_terms(const CompiledEquations& c, const std::vector<Term>& terms,
                                                 const UniformState& about, const std::vector<double>& scales = {}) {
    const std::vector<double> slots = c.slots_at(about);
    Powers powers;
    for (std::size_t n = 0; n < terms.size(); ++n)
        c.visit_slopes(terms[n], slots, [&](int row, const Derivative& derivative, double coefficient) {
            Eigen::MatrixXd& factors = powers[derivative.order];
            if (factors.size() == 0) factors = Eigen::MatrixXd::Zero(c.components, c.components);
            factors(row, derivative.component) += scales.empty() ? coefficient : scales[n] * coefficient;
        });
    return listed(powers);
}

void check_sizes(const LeftSides& left, Eigen::Index count) {
    const auto rows = left.slopes.rows(), columns = left.slopes.cols();
    const bool has_noise = left.noise.size() > 0 || left.flux_noise.size() > 0;
    require(
        left.mass_density.size() == count &&
            (!has_noise || (left.noise.size() == count && left.flux_noise.size() == count)) &&
            (left.slopes.size() == 0 || (rows == count && columns == count)),
        {},
        "left sides of {} masses, {} and {} noises and {} by {} slopes; expected {} of each, or no noises or slopes",
        left.mass_density.size(), left.noise.size(), left.flux_noise.size(), rows, columns, count);
}
}  // namespace

std::vector<int> turning_components(const Model& model) {
    const std::vector<int> firsts = first_components(model);
    std::vector<int> result;
    for (const std::size_t n : drawn_fields(model))
        if (model.fields[n].spin > 0) result.push_back(firsts[n]);
    return result;
}

double direction_of(const Model& model, const UniformState& state) {
    const std::vector<int> firsts = first_components(model);
    check_state(state, components(model));
    for (const std::size_t n : drawn_fields(model)) {
        const auto at = static_cast<std::size_t>(firsts[n]);
        if (const int spin = model.fields[n].spin; spin > 0 && (state[at] != 0.0 || state[at + 1] != 0.0))
            return std::atan2(state[at + 1], state[at]) / spin;
    }
    return 0.0;
}

LinearisedAt::LinearisedAt(const Equations& equations, const UniformState& about)
    : equations_(equations), about_(equations.completed(about)), state_(equations.state_components()) {
    const CompiledEquations& c = *equations.compiled_;
    powers_ = powers_of_terms(c, c.terms, about_);
    substitutes_ = powers_of_terms(c, c.substitutes, about_);
    rates_ = powers_;
    held_ = c.held;
    set_parts(c.free);
    for (int k = 0; k < c.components; ++k)
        if (c.array_of[static_cast<std::size_t>(k)] >= 0 || c.in_balance(k)) members_.push_back(k);
    left_.mass_density = Eigen::VectorXd::Zero(c.components);
    left_.mass_density(state_).setOnes();
    left_.direction = direction_of(c.model, about_);
}

LinearisedAt::LinearisedAt(const Equations& equations, const UniformState& about, LeftSides left)
    : equations_(equations), about_(about), left_(std::move(left)) {
    const CompiledEquations& c = *equations.compiled_;
    check_state(about_, static_cast<std::size_t>(c.components));
    check_sizes(left_, c.components);
    require(left_.factors.empty() || left_.factors.size() == c.terms.size(), {},
            "{} factors of {} terms; expected one of each, or none", left_.factors.size(), c.terms.size());
    powers_ = powers_of_terms(c, c.terms, about_, left_.factors);
    for (int k = 0; k < c.components; ++k) {
        if (c.is_given(k)) continue;
        members_.push_back(k);
        (left_.mass_density(k) != 0.0 ? state_ : held_).push_back(k);
    }
    set_parts(state_);
    rates_ = powers_;
    for (Power& power : rates_)
        for (const int k : state_) power.factors.row(k) /= left_.mass_density(k);
    if (left_.slopes.size() == 0) return;
    const Eigen::VectorXd rates = equations.uniform_rates(about_, left_.factors);
    rates_.push_back({0, 0, Eigen::MatrixXd::Zero(c.components, c.components)});
    for (const int k : state_)
        rates_.back().factors.row(k) =
            -rates(k) / (left_.mass_density(k) * left_.mass_density(k)) * left_.slopes.row(k);
}

Symbol LinearisedAt::whole(const Wavevector& q) const { return sum_of(powers_, equations_.components(), q); }

Eigen::MatrixXd LinearisedAt::factors(int x, int y) const {
    for (const Power& power : powers_)
        if (power.x == x && power.y == y) return power.factors(members_, members_);
    const auto count = static_cast<Eigen::Index>(members_.size());
    return Eigen::MatrixXd::Zero(count, count);
}

Symbol LinearisedAt::eliminated(const Wavevector& q, Symbol* balance) const {
    const Symbol m = sum_of(rates_, equations_.components(), q);
    const Parts& parts = parts_at(q);
    return CompiledEquations::eliminated(resolved(m, q), parts.held, parts.state, parts.free, balance);
}

Symbol LinearisedAt::symbol(const Wavevector& q) const {
    if (const std::vector<int>& state = parts_at(q).state; !held_.empty() || has_solenoidal_)
        return eliminated(q)(state, state);
    Symbol m = sum_of(rates_, equations_.components(), q);
    if (state_.size() < static_cast<std::size_t>(m.rows())) m = Symbol(m(state_, state_));
    return m;
}

Symbol LinearisedAt::all_components(const Wavevector& q) const {
    Symbol balance;
    eliminated(q, &balance);
    const std::vector<int>& state = parts_at(q).state;
    for (const int k : state) balance(k, k) = 1.0;
    if (has_solenoidal_) balance = turn_of(q).transpose() * balance;
    const Symbol all = balance + sum_of(substitutes_, equations_.components(), q) * balance;
    return all(Eigen::all, state);
}

Symbol LinearisedAt::noise(const Wavevector& q) const {
    const std::vector<int>& state = parts_at(q).state;
    if (left_.noise.size() == 0) return resolved(equations_.noise(about_, q), q)(state, state);
    const Eigen::VectorXd strengths = left_.noise + (q.x * q.x + q.y * q.y) * left_.flux_noise;
    return Symbol(strengths.cast<std::complex<double>>().asDiagonal())(state, state);
}

void LinearisedAt::set_parts(std::vector<int> free) {
    const CompiledEquations& c = *equations_.compiled_;
    uniform_ = waves_ = {.state = state_, .held = held_, .free = std::move(free)};
    has_solenoidal_ = c.has_solenoidal();
    for (std::vector<int>* list : {&waves_.state, &waves_.held, &waves_.free})
        std::erase_if(*list, [&c](int k) { return c.is_solenoidal(k) && c.part_of(k) == 0; });
}

Eigen::MatrixXd LinearisedAt::turn_of(const Wavevector& q) const {
    const CompiledEquations& c = *equations_.compiled_;
    Eigen::MatrixXd turn = Eigen::MatrixXd::Identity(c.components, c.components);
    const double size = std::hypot(q.x, q.y);
    for (int k = 0; k < c.components && size > 0.0; ++k)
        if (c.is_solenoidal(k) && c.part_of(k) == 0)
            turn.block<2, 2>(k, k) << q.x / size, q.y / size, -q.y / size, q.x / size;
    return turn;
}

Eigen::MatrixXd LinearisedAt::parts_across(double angle) const {
    const CompiledEquations& c = *equations_.compiled_;
    std::vector<int> kept = members_;
    std::erase_if(kept, [&c](int k) { return c.is_solenoidal(k) && c.part_of(k) == 0; });
    return turn_of({std::cos(angle), std::sin(angle)}).transpose()(members_, kept);
}

Symbol LinearisedAt::resolved(const Symbol& m, const Wavevector& q) const {
    if (!has_solenoidal_) return m;
    const Eigen::MatrixXd turn = turn_of(q);
    return turn * m * turn.transpose();
}

Eigen::RowVectorXcd LinearisedAt::of_forces(const Eigen::RowVectorXcd& of_rates, const Wavevector& q) const {
    const Parts& parts = parts_at(q);
    require(of_rates.size() == static_cast<Eigen::Index>(parts.state.size()), {},
            "{} weights of rates; expected {}, one for each row of the symbol", of_rates.size(), parts.state.size());
    Eigen::RowVectorXcd result = Eigen::RowVectorXcd::Zero(equations_.components());
    const Eigen::RowVectorXcd of_state = of_rates.cwiseQuotient(left_.mass_density(parts.state).transpose());
    result(parts.state) = of_state;
    if (!parts.held.empty()) {
        const Symbol m = resolved(whole(q), q);
        const Symbol of_held = m(parts.held, parts.held), by_held = m(parts.state, parts.held);
        result(parts.held) = -of_state * by_held * numerics::inverse(of_held);
    }
    return has_solenoidal_ ? Eigen::RowVectorXcd(result * turn_of(q)) : result;
}

Symbol LinearisedAt::term_symbol(std::size_t term, const Wavevector& q) const {
    const Symbol whole = equations_.term_symbol(term, about_, q);  // rejects a term that is not there
    return (left_.factors.empty() ? 1.0 : left_.factors[term]) * whole;
}

Wavevector LinearisedAt::wavevector(double q, double angle) const {
    return {.x = q * std::cos(left_.direction + angle), .y = q * std::sin(left_.direction + angle)};
}

Symbol LinearisedAt::along_and_across(const Symbol& of_components, const Wavevector& q) const {
    const int count = equations_.components();
    require(of_components.rows() == count && of_components.cols() == count, {},
            "a matrix of {} by {}; expected {} by {}", of_components.rows(), of_components.cols(), count, count);
    const double size = std::hypot(q.x, q.y);
    if (size == 0.0) return of_components;
    return equations_.compiled_->in_frame(of_components, q.x / size, q.y / size);
}

std::map<int, Eigen::MatrixXd> LinearisedAt::factors_by_order(double angle) const {
    std::map<int, Eigen::MatrixXd> result;
    for (const auto& [x, y, factors] : powers_)
        result.try_emplace(x + y, Eigen::MatrixXd::Zero(factors.rows(), factors.cols())).first->second +=
            std::pow(std::cos(angle), x) * std::pow(std::sin(angle), y) * factors;
    return result;
}

std::map<int, Eigen::MatrixXd> LinearisedAt::sizes_by_order() const {
    std::map<int, Eigen::MatrixXd> result;
    for (const auto& [x, y, factors] : powers_)
        result.try_emplace(x + y, Eigen::MatrixXd::Zero(factors.rows(), factors.cols())).first->second +=
            equations_.compiled_->over_fields(factors.cwiseAbs());
    return result;
}

bool LinearisedAt::is_isotropic() const {
    const auto sizes = sizes_by_order();
    return std::ranges::all_of(sizes, [this](const auto& one) {
        const auto factors = [&](const Wavevector& q) {
            return Symbol(factors_by_order(std::atan2(q.y, q.x)).at(one.first).template cast<std::complex<double>>());
        };
        return equations_.compiled_->is_same_in_all_directions(factors, one.second);
    });
}

bool LinearisedAt::is_mirrored() const {
    const CompiledEquations& c = *equations_.compiled_;
    Eigen::VectorXd parity = Eigen::VectorXd::Ones(c.components);  // in the frame of the direction
    for (int k = 0; k < c.components; ++k) parity(k) = c.is_odd(k) ? -1.0 : 1.0;
    const double cosine = std::cos(direction()), sine = std::sin(direction());
    const auto sizes = sizes_by_order();
    return std::ranges::all_of(some_angles, [&](double angle) {
        const auto ahead = factors_by_order(direction() + angle), mirrored = factors_by_order(direction() - angle);
        return std::ranges::all_of(sizes, [&](const auto& one) {
            const auto in_frame = [&](const std::map<int, Eigen::MatrixXd>& factors) {
                return c.in_frame(factors.at(one.first).template cast<std::complex<double>>(), cosine, sine);
            };
            const Symbol difference = in_frame(ahead) - parity.asDiagonal() * in_frame(mirrored) * parity.asDiagonal();
            return (difference.cwiseAbs().array() <= 1e-12 * one.second.array()).all();
        });
    });
}

}  // namespace drover::model
