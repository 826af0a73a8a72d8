// model/equations.cpp: the linearisation of equations about uniform states.
#include "drover/model/equations.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/compiled.hpp"
#include "model/lowering.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::model {

using numerics::Wavevector;

const Model& Equations::model() const { return compiled_->model; }
int Equations::components() const { return compiled_->components; }
const std::vector<int>& Equations::state_components() const { return compiled_->state; }
const std::vector<TermSummary>& Equations::terms() const { return compiled_->summaries; }
int Equations::degree() const { return compiled_->degree; }
bool Equations::has_explicit_part() const {
    return !compiled_->outputs.empty() || !compiled_->forces.empty() || !compiled_->is_isotropic ||
           has_product_noise() || compiled_->free.size() > compiled_->state.size();
}
bool Equations::has_finite_degree() const { return compiled_->has_finite_degree; }
TransformCount Equations::transforms() const { return transforms_of(*compiled_); }

UniformState Equations::reference() const { return compiled_->reference(); }

bool Equations::has_nonlinear_part() const {
    const std::vector<double>& constants = compiled_->constants;
    return has_explicit_part() || std::ranges::any_of(constants, [](double constant) { return constant != 0.0; });
}

namespace {
void check_term(const CompiledEquations& c, std::size_t n) {
    require(n < c.terms.size(), {}, "term {}; expected less than {}, the number of terms", n, c.terms.size());
}

void check_field(const CompiledEquations& c, std::size_t n) {
    require(n < c.model.fields.size(), {}, "field {}; expected less than {}, the number of fields", n,
            c.model.fields.size());
}

using numerics::IsotropicBlocks;

numerics::Layout layout_of(const CompiledEquations& c) {
    numerics::Layout layout{.chiral = c.model.chiral};
    for (const int k : c.state)
        if (c.part_of(k) == 0)
            layout.fields.push_back({c.spin_of(k), c.model.fields[c.field(k)].odd, c.is_solenoidal(k)});
    return layout;
}

/// The blocks of a symbol at q along x.
IsotropicBlocks blocks_of(const CompiledEquations& c, const Symbol& m, const numerics::BlockParts& parts,
                          bool at_zero) {
    return numerics::blocks_of(parts, [&](const numerics::Part& row, const numerics::Part& column) {
        const std::complex<double> entry =
            m(c.state[static_cast<std::size_t>(row.component)], c.state[static_cast<std::size_t>(column.component)]);
        return (numerics::power_of_i(at_zero ? 0 : row.spin - column.spin) * entry).real();
    });
}
}  // namespace

Equations Equations::about(const UniformState& state) const {
    check_state(state, static_cast<std::size_t>(components()));
    auto split = std::make_shared<CompiledEquations>(*compiled_);
    split->split(state);
    return Equations(std::move(split));
}

Equations Equations::only(std::size_t term) const {
    check_term(*compiled_, term);
    auto part = std::make_shared<CompiledEquations>(*compiled_);
    part->terms.clear();
    part->summaries.clear();
    for (std::size_t n = 0; n < compiled_->terms.size(); ++n) {
        const Term& one = compiled_->terms[n];
        if (n != term && compiled_->model.fields[one.summary.field].left != LeftSide::balance) continue;
        part->terms.push_back(one);
        part->summaries.push_back(one.summary);
    }
    part->evaluated = part->terms;
    part->products.clear();
    part->noise_terms.clear();
    part->noise_rows.assign(part->noise_rows.size(), LinearForm{});
    for (Field& field : part->model.fields) field.noise = 0.0;
    part->split(compiled_->about);
    return Equations(std::move(part));
}

bool Equations::has_derivative(std::size_t n, const UniformState& at) const {
    const CompiledEquations& c = *compiled_;
    check_term(c, n);
    return c.has_slopes(c.terms[n], c.slots_at(c.balanced(at)));
}

bool Equations::is_isotropic(std::size_t n) const {
    const CompiledEquations& c = *compiled_;
    check_term(c, n);
    std::vector<LinearForm> rows(static_cast<std::size_t>(c.components));
    if (c.terms[n].summary.is_placed || !has_derivative(n, c.reference())) return false;
    c.visit_slopes(c.terms[n], c.slots_at(c.balanced(c.reference())),
                   [&](int row, const Derivative& derivative, double coefficient) {
                       rows[static_cast<std::size_t>(row)][derivative] += coefficient;
                   });
    return c.commutes_with_turns(rows);
}

UniformState CompiledEquations::reference() const {
    UniformState values;
    for (const Field& field : model.fields)
        for (int k = 0; k < model::components(field); ++k)
            values.push_back(field.spin == 0 && !field.odd ? field.reference : 0.0);
    return values;
}

void CompiledEquations::add_form(const LinearForm& form, const Order& order, std::complex<double> factor,
                                 const Wavevector& q, int row, Symbol& m) const {
    for (const auto& [derivative, coefficient] : form)
        m(row, derivative.component) += factor * coefficient * factor_of(derivative.order + order, q);
}

Symbol CompiledEquations::form_symbol(const std::vector<LinearForm>& rows, const Wavevector& q, int columns) const {
    Symbol m = Symbol::Zero(components, std::max(columns, components));
    for (int row = 0; row < components; ++row) add_form(rows[static_cast<std::size_t>(row)], {}, 1.0, q, row, m);
    return m;
}

Eigen::MatrixXd CompiledEquations::sizes_of(const std::vector<LinearForm>& rows) const {
    Eigen::MatrixXd sizes = Eigen::MatrixXd::Zero(components, components + noise_components);
    for (int row = 0; row < components; ++row)
        for (const auto& [derivative, coefficient] : rows[static_cast<std::size_t>(row)])
            sizes(row, derivative.component) += std::abs(coefficient);
    return sizes;
}

Eigen::VectorXd Equations::uniform_rates(const UniformState& given, const std::vector<double>& factors) const {
    require(factors.empty() || factors.size() == compiled_->terms.size(), {},
            "{} factors of {} terms; expected one of each, or none", factors.size(), compiled_->terms.size());
    return compiled_->uniform_rates(given, factors);
}

UniformState Equations::completed(const UniformState& at) const { return compiled_->completed(at); }

Eigen::VectorXd Equations::uniform_rate_sizes(const UniformState& at) const {
    Eigen::VectorXd sizes;
    static_cast<void>(compiled_->uniform_rates(at, {}, &sizes));
    return sizes;
}

Eigen::VectorXd CompiledEquations::uniform_rates(const UniformState& given, const std::vector<double>& factors,
                                                 Eigen::VectorXd* sizes) const {
    const UniformState at = balanced(given);
    Eigen::VectorXd rates = Eigen::VectorXd::Zero(components);
    if (sizes != nullptr) *sizes = rates;
    const std::vector<double> slots = slots_at(at, false);
    for (std::size_t n = 0; n < terms.size(); ++n)
        for (std::size_t k = 0; k < terms[n].rows.size(); ++k) {
            const Term& term = terms[n];
            const int row = first_component[term.summary.field] + static_cast<int>(k);
            const auto add = [&](double part) {
                rates(row) += factors.empty() ? part : factors[n] * part;
                if (sizes != nullptr) (*sizes)(row) += std::abs(part);
            };
            for (const auto& [derivative, coefficient] : term.rows[k].linear)
                if (derivative.order == Order{}) add(coefficient * at[static_cast<std::size_t>(derivative.component)]);
            for (const PointFunction& function : term.rows[k].functions)
                if (function.order == Order{}) add(evaluate(function.value, slots));
        }
    return rates;
}

UniformState CompiledEquations::completed(const UniformState& at) const {
    UniformState all = balanced(at);
    const std::vector<double> slots = slots_at(all, false);
    for (const Term& term : substitutes)
        for (std::size_t k = 0; k < term.rows.size(); ++k) {
            double value = 0.0;
            for (const auto& [derivative, coefficient] : term.rows[k].linear)
                if (derivative.order == Order{})
                    value += coefficient * all[static_cast<std::size_t>(derivative.component)];
            for (const PointFunction& function : term.rows[k].functions)
                if (function.order == Order{}) value += evaluate(function.value, slots);
            all[static_cast<std::size_t>(first_component[term.summary.field]) + k] = value;
        }
    return all;
}

double Equations::varying_mass(std::size_t field, const UniformState& at) const {
    const CompiledEquations& c = *compiled_;
    check_field(c, field);
    for (const Mass& mass : c.masses)
        if (mass.field == field) return evaluate(c.calls[mass.call].values[0], c.slots_at(c.balanced(at), false));
    return 1.0;
}

const TermSummary* Equations::placed_term() const {
    for (const std::vector<Term>* terms : {&compiled_->terms, &compiled_->substitutes})
        for (const Term& term : *terms)
            if (term.summary.is_placed) return &term.summary;
    return nullptr;
}

const TermSummary* Equations::placed_noise() const {
    const auto found = std::ranges::find_if(noise_terms(), [](const TermSummary& one) { return one.is_placed; });
    return found == noise_terms().end() ? nullptr : &*found;
}

void CompiledEquations::visit_slopes(
    const Term& term, const std::vector<double>& slots,
    const std::function<void(int row, const Derivative& derivative, double coefficient)>& visit) const {
    require(
        !term.summary.is_placed, term.summary.where,
        "the term \"{}\" depends on position or time, so no uniform state satisfies it; expected a term of the fields "
        "alone",
        term.summary.text);
    for (std::size_t k = 0; k < term.rows.size(); ++k) {
        const int row = first_component[term.summary.field] + static_cast<int>(k);
        for (const auto& [derivative, coefficient] : term.rows[k].linear) visit(row, derivative, coefficient);
        for (const PointFunction& function : term.rows[k].functions) {
            const auto require_slope = [&](bool holds) {
                require(holds, term.summary.where,
                        "the term \"{}\" has no finite derivative in this uniform state; expected another state{}",
                        term.summary.text, calls.empty() ? "" : ", within the nodes of all tables");
            };
            require_slope(is_continuous_at(function, slots));
            for (const PointFunction::Slope& slope : function.slopes) {
                const double value = slope_at(slope.value, slots);
                require_slope(std::isfinite(value));
                for (const auto& [derivative, coefficient] : form_of(slope.slot))
                    visit(row, {derivative.component, derivative.order + function.order}, value * coefficient);
            }
        }
    }
}

Symbol Equations::term_symbol(std::size_t n, const UniformState& about, const Wavevector& q) const {
    const CompiledEquations& c = *compiled_;
    check_term(c, n);
    const Term& term = c.terms[n];
    Symbol m = Symbol::Zero(c.components, c.components);
    c.visit_slopes(term, c.slots_at(c.balanced(about)), [&](int row, const Derivative& derivative, double coefficient) {
        m(row, derivative.component) += coefficient * factor_of(derivative.order, q);
    });
    return m;
}

Symbol Equations::symbol(const UniformState& about, const Wavevector& q) const {
    const CompiledEquations& c = *compiled_;
    const std::vector<double> slots = c.slots_at(c.completed(about));
    Symbol m = Symbol::Zero(c.components, c.components);
    for (const Term& term : c.terms)
        c.visit_slopes(term, slots, [&](int row, const Derivative& derivative, double coefficient) {
            m(row, derivative.component) += coefficient * factor_of(derivative.order, q);
        });
    c.add_pressure(m, q);
    return c.eliminated(m);
}

std::string Equations::latex(std::size_t index) const {
    check_field(*compiled_, index);
    const Field& field = model().fields[index];
    const auto name = [this](const std::string& word) {
        const auto typeset = [](const std::string& symbol, int spin) {
            const std::string bare = latex_of_name(symbol);
            return spin == 0 ? bare : (spin == 1 ? "\\boldsymbol{" : "\\mathsf{") + bare + "}";
        };
        for (const Field& other : model().fields)
            if (word == other.symbol || word == other.name) return typeset(other.symbol, other.spin);
        for (const WhiteNoise& noise : model().noises)
            if (word == noise.symbol) return typeset(noise.symbol, noise.spin);
        return latex_of_name(word);
    };
    const auto typeset = [&](const Text& text) {
        return latex_of(parse_formula(FormulaText(text.text, text.where), notation_with(model().functions)), name);
    };
    const std::string left = field.part == Part::whole ? field.symbol : field.symbol.substr(0, field.symbol.size() - 3);
    std::string right = field.equation.text.empty() ? "0" : typeset(field.equation);
    if (field.solenoidal) right += text(" - \\nabla P_{{{0}}}, \\quad \\nabla \\cdot {0} = 0", name(field.symbol));
    if (field.left == LeftSide::balance) return "0 = " + right;
    const std::string mass = field.mass.text.empty() ? "" : typeset(field.mass) + "\\, ";
    return mass + "\\partial_t " + name(left) + " = " + right;
}

// ---- L, N and Q

Symbol CompiledEquations::in_frame(const Symbol& m, double cosine, double sine, bool back) const {
    Symbol turn = Symbol::Identity(components, components);
    for (int k = 0; k < components; ++k) {
        const int spin = spin_of(k);
        if (spin == 0 || part_of(k) != 0) continue;
        const std::complex<double> angle = std::pow(std::complex<double>(cosine, sine), spin);
        turn(k, k) = turn(k + 1, k + 1) = angle.real();
        turn(k, k + 1) = angle.imag();
        turn(k + 1, k) = -angle.imag();
    }
    if (back) return turn.transpose() * m * turn;
    return turn * m * turn.transpose();
}

Symbol CompiledEquations::averaged(const std::vector<LinearForm>& rows, double q) const {
    constexpr int directions = 16;  // exact for polynomials in q of degree and spins up to 15 together
    Symbol sum = is_isotropic ? form_symbol(rows, {q, 0.0}) : Symbol(Symbol::Zero(components, components));
    for (int n = 0; n < (is_isotropic ? 0 : directions); ++n) {
        const double angle = 2.0 * std::numbers::pi * n / directions, cosine = std::cos(angle), sine = std::sin(angle);
        sum += in_frame(form_symbol(rows, {q * cosine, q * sine}), cosine, sine) / directions;
    }
    for (int i = 0; i < components && !is_isotropic; ++i)
        for (int j = 0; j < components; ++j)
            if (is_odd(i) != is_odd(j) && !model.chiral) sum(i, j) = 0.0;
    add_pressure(sum, {q, 0.0});
    return sum;
}

bool CompiledEquations::has_solenoidal() const {
    return std::ranges::any_of(model.fields, [](const Field& one) { return one.solenoidal; });
}

void CompiledEquations::leave_out_divergence(Symbol& m, const Wavevector& q) const { leave_out_along(m, q, false); }

void CompiledEquations::add_pressure(Symbol& m, const Wavevector& q) const { leave_out_along(m, q, true); }

void CompiledEquations::leave_out_along(Symbol& m, const Wavevector& q, bool holds_balances) const {
    const double length = std::hypot(q.x, q.y);
    if (length == 0.0 || !has_solenoidal()) return;
    m = in_frame(m, q.x / length, q.y / length);
    for (int k = 0; k < components; ++k) {
        if (!is_solenoidal(k) || part_of(k) != 0) continue;
        m.row(k).setZero();
        m.col(k).setZero();
        const double size = std::abs(m(k + 1, k + 1));  // so that the balance of both parts is as regular as of one
        if (holds_balances && in_balance(k)) m(k, k) = size > 0.0 ? size : 1.0;
    }
    m = in_frame(m, q.x / length, q.y / length, true);
}

std::map<int, std::vector<LinearForm>> by_order(const std::vector<LinearForm>& rows) {
    std::map<int, std::vector<LinearForm>> parts;
    for (std::size_t row = 0; row < rows.size(); ++row)
        for (const auto& [derivative, coefficient] : rows[row])
            parts.try_emplace(derivative.order.x + derivative.order.y, rows.size()).first->second[row][derivative] =
                coefficient;
    return parts;
}

Eigen::MatrixXd CompiledEquations::over_fields(const Eigen::MatrixXd& of_components) const {
    const auto count = static_cast<Eigen::Index>(model.fields.size());
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index i = 0; i < components; ++i)
        for (Eigen::Index j = 0; j < components; ++j)
            sums(field_of[static_cast<std::size_t>(i)], field_of[static_cast<std::size_t>(j)]) += of_components(i, j);
    return sums(field_of, field_of);
}

bool CompiledEquations::is_same_in_all_directions(const std::function<Symbol(const Wavevector& direction)>& matrix,
                                                  const Eigen::MatrixXd& sizes, bool unmixed) const {
    const Symbol along_x = matrix({1.0, 0.0});
    const Eigen::MatrixXd rounding = 1e-12 * sizes;
    for (int i = 0; i < components && unmixed; ++i)
        for (int j = 0; j < components; ++j)
            if (is_odd(i) != is_odd(j) && !(std::abs(along_x(i, j)) <= rounding(i, j))) return false;
    return std::ranges::all_of(some_angles, [&](double angle) {
        const double cosine = std::cos(angle), sine = std::sin(angle);
        const Symbol turned = in_frame(matrix({cosine, sine}), cosine, sine);
        return ((turned - along_x).cwiseAbs().array() <= rounding.array()).all();
    });
}

bool CompiledEquations::commutes_with_turns(const std::vector<LinearForm>& rows) const {
    const auto parts = by_order(rows);
    return std::ranges::all_of(parts, [this](const auto& one) {
        const std::vector<LinearForm>& part = one.second;
        return is_same_in_all_directions([&](const Wavevector& q) { return form_symbol(part, q); },
                                         over_fields(sizes_of(part)), !model.chiral);
    });
}

numerics::System Equations::linear_system(const numerics::Grid& grid, int kept_degree) const {
    const std::shared_ptr<const CompiledEquations> c = compiled_;
    numerics::System system{.grid = grid, .layout = layout_of(*c)};
    const numerics::BlockParts parts = numerics::block_parts(system.layout);
    system.linear = [c, parts](double q) {
        return blocks_of(*c, c->eliminated(c->averaged(c->linear, q)), parts, q == 0.0);
    };
    if (c->has_sums())
        system.noise = [c, parts](double q) { return blocks_of(*c, c->sum_noise({q, 0.0}), parts, q == 0.0); };
    if (has_product_noise()) system.product_noise = std::make_shared<const numerics::ProductNoise>(product_noise(c));
    system.degree = kept_degree > 0 ? kept_degree : c->degree;
    if (c->has_balance())
        for (const double q : numerics::distinct_wavenumbers(grid, system.degree).q)
            if (q > 0.0) c->check_balance_at(q);
    return system;
}

}  // namespace drover::model
