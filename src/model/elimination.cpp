// model/elimination.cpp: fields in balance: what they are of the others, mode by mode and in uniform states.
#include <cmath>

#include "base/constants.hpp"
#include "model/compiled.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::model {

namespace {
/// Whether a balance of one vector, the usual case, is far from singular.
template <class Matrix>
bool is_regular_pair(const Matrix& m) {
    return m.rows() == 2 && m.cols() == 2 &&
           std::abs(m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0)) > 1e-10 * m.cwiseAbs2().sum();
}

/// Of a mean that the balance leaves free, as of a pressure, the value 0: the shortest solution.
template <class Matrix, class Right>
Right solve_balance(const Matrix& of_held, const Right& right) {
    if (!is_regular_pair(of_held)) return numerics::shortest_solution(of_held, right);
    Matrix adjugate(2, 2);
    adjugate << of_held(1, 1), -of_held(0, 1), -of_held(1, 0), of_held(0, 0);
    return (adjugate / (of_held(0, 0) * of_held(1, 1) - of_held(0, 1) * of_held(1, 0))).lazyProduct(right);
}
}  // namespace

void check_state(const UniformState& state, std::size_t components) {
    require(state.size() == components, {}, "a uniform state of {} values; expected {}, one for each component",
            state.size(), components);
    for (const double value : state)
        require(std::isfinite(value), {}, "a uniform state with the value {}; expected finite values", value);
}

UniformState CompiledEquations::balanced(const UniformState& at) const {
    check_state(at, static_cast<std::size_t>(components));
    if (held.empty()) return at;
    const Eigen::MatrixXd& m = uniform_linear;
    Eigen::VectorXd total(static_cast<Eigen::Index>(held.size()));
    for (std::size_t i = 0; i < held.size(); ++i) {
        double& force = total(static_cast<Eigen::Index>(i));
        force = constants[static_cast<std::size_t>(held[i])];
        for (int k = 0; k < components; ++k)
            if (!in_balance(k)) force += m(held[i], k) * at[static_cast<std::size_t>(k)];
    }
    if (!forces.empty()) total += uniform_products(at)(held);
    const Eigen::MatrixXd of_held = m(held, held);
    const Eigen::VectorXd values = -solve_balance(of_held, total);
    UniformState result = at;
    for (std::size_t i = 0; i < held.size(); ++i)
        result[static_cast<std::size_t>(held[i])] = values(static_cast<Eigen::Index>(i));
    return result;
}

Eigen::VectorXd CompiledEquations::uniform_products(const UniformState& at) const {
    const std::vector<double> slots = slots_at(at, false);
    Eigen::VectorXd result = Eigen::VectorXd::Zero(components);
    for (const RateFunction& force : forces)
        for (const RateFunction::Use& use : force.uses)
            if (use.order == Order{}) result(use.component) += use.factor * evaluate(force.value, slots);
    return result;
}

std::vector<double> CompiledEquations::sources(std::vector<double>* of_held) const {
    if (!has_balance()) return constants;
    const Eigen::Map<const Eigen::VectorXd> given(constants.data(), components);
    const Symbol m = averaged(linear, 0.0);  // the explicit part has the rest
    const Eigen::VectorXcd shift =
        -solve_balance(m(held, held).eval(), given(held).cast<std::complex<double>>().eval());
    std::vector<double> result = constants;
    if (of_held != nullptr) of_held->assign(static_cast<std::size_t>(components), 0.0);
    for (std::size_t i = 0; i < held.size(); ++i) {
        const double value = shift(static_cast<Eigen::Index>(i)).real();
        if (of_held != nullptr) (*of_held)[static_cast<std::size_t>(held[i])] = value;
        for (const int k : state) result[static_cast<std::size_t>(k)] += m(k, held[i]).real() * value;
    }
    return result;
}

Symbol CompiledEquations::eliminated(const Symbol& m, Symbol* balance) const {
    return eliminated(m, held, state, free, balance);
}

Symbol CompiledEquations::eliminated(const Symbol& m, const std::vector<int>& held, const std::vector<int>& state,
                                     const std::vector<int>& free, Symbol* balance) {
    if (held.empty()) {
        if (balance != nullptr) *balance = Symbol::Zero(m.rows(), m.cols());
        return m;
    }
    Symbol held_by(held.size(), free.size());
    // Asked for at every wavenumber: without memory from the heap where the balance is that of one vector.
    if (held.size() == 2 && is_regular_pair(m(held, held))) {
        const std::complex<double> a = m(held[0], held[0]), b = m(held[0], held[1]), c = m(held[1], held[0]),
                                   d = m(held[1], held[1]), determinant = a * d - b * c;
        for (std::size_t j = 0; j < free.size(); ++j) {
            const std::complex<double> x = m(held[0], free[j]), y = m(held[1], free[j]);
            held_by(0, static_cast<Eigen::Index>(j)) = (b * y - d * x) / determinant;
            held_by(1, static_cast<Eigen::Index>(j)) = (c * x - a * y) / determinant;
        }
    } else held_by = -solve_balance(Symbol(m(held, held)), Symbol(m(held, free)));
    Symbol result = Symbol::Zero(m.rows(), m.cols());
    for (std::size_t j = 0; j < free.size(); ++j)
        for (const int i : state) {
            std::complex<double>& entry = result(i, free[j]);
            entry = m(i, free[j]);
            for (std::size_t k = 0; k < held.size(); ++k)
                entry += m(i, held[k]) * held_by(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(j));
        }
    if (balance != nullptr) {
        *balance = Symbol::Zero(m.rows(), m.cols());
        (*balance)(held, free) = held_by;
    }
    return result;
}

Symbol CompiledEquations::inverse_of_balance(const Symbol& m, double q) const {
    const auto count = static_cast<Eigen::Index>(held.size());
    Symbol result = solve_balance(Symbol(m(held, held)), Symbol(Symbol::Identity(count, count)));
    for (Eigen::Index k = 0; k < count && q > 0.0; ++k) {
        const int component = held[static_cast<std::size_t>(k)];
        if (!is_solenoidal(component) || part_of(component) != 0) continue;
        result.row(k).setZero();
        result.col(k).setZero();
    }
    return result;
}

/// Whether a linear force that names a direction, as a weight "n e_y" does, is that of a field whose mean changes.
bool CompiledEquations::reads_changing_mean() const {
    for (const RateFunction& force : forces)
        for (const int slot : slots_read(force.value)) {
            if (slot < first_atom || !constant_value(slope(force.value, slot))) continue;
            for (const RateFunction::Use& use : force.uses)
                for (const auto& [derivative, coefficient] : form_of(slot))
                    if (use.order == Order{} && derivative.order == Order{} &&
                        !model.fields[field(derivative.component)].conserved)
                        return true;
        }
    return false;
}

void CompiledEquations::check_balance_at(double q) const {
    if (held.empty()) return;
    Symbol m = form_symbol(linear, {q, 0.0});
    add_pressure(m, {q, 0.0});
    const Symbol of_held = m(held, held), of_others = m(held, free);
    if (is_regular_pair(of_held)) return;
    bool is_determined = numerics::is_invertible(of_held);
    if (!is_determined && q == 0.0) {
        // Fields whose means no balance reads: their equations must hold for any value of the other means; for means
        // that do not change, at the references.
        std::vector<Eigen::Index> of_free, of_rest;
        for (Eigen::Index i = 0; i < of_held.rows(); ++i)
            (of_held.row(i).isZero(0.0) && of_held.col(i).isZero(0.0) ? of_free : of_rest).push_back(i);
        const UniformState at = reference();
        const Eigen::VectorXd products = uniform_products(at);
        double force = 0.0;
        for (const Eigen::Index i : of_free) {
            const int component = held[static_cast<std::size_t>(i)];
            double total = constants[static_cast<std::size_t>(component)], size = std::abs(total);
            for (std::size_t j = 0; j < free.size(); ++j) {
                const double slope = of_others(i, static_cast<Eigen::Index>(j)).real();
                const double part = slope * at[static_cast<std::size_t>(free[j])];
                total += part;
                size += std::abs(part);
                if (!model.fields[field(free[j])].conserved) force = std::max(force, std::abs(slope));
            }
            total += products(component);
            size += std::abs(products(component));
            if (std::abs(total) > 1e-12 * size) force = std::max(force, std::abs(total));
        }
        if (reads_changing_mean()) force = infinite;
        is_determined = force == 0.0 && (of_rest.empty() || numerics::is_invertible(Symbol(of_held(of_rest, of_rest))));
    }
    const Field& first = model.fields[field(held[0])];
    require(is_determined, first.equation.text.empty() ? first.where : first.equation.where,
            "the balance of {} does not determine it at wavenumber {}; expected a term such as -c {}{}", first.symbol,
            q, first.symbol,
            q == 0.0 ? ", or conserved = true of the fields in it, where their means do not change" : "");
}

}  // namespace drover::model
