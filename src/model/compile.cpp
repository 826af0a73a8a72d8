// model/compile.cpp: from the texts of a model to linear forms and functions at points.
#include <algorithm>
#include <optional>
#include <set>

#include "base/constants.hpp"
#include "drover/model/equations.hpp"
#include "model/compiled.hpp"
#include "model/noise_drift.hpp"
#include "model/summands.hpp"

namespace drover::model {

namespace {
/// The noises of the summands that multiply noise, by field and number of the summand.
using Products = std::map<std::pair<std::size_t, std::size_t>, std::set<std::size_t>>;

class Compiler {
public:
    /// Of the equations with a rate, those summands that are taken.
    Compiler(const Model& model, std::function<bool(std::size_t field, std::size_t summand)> takes)
        : with_noises_(with_noises_as_fields(model)),
          names_(with_noises_),
          lowering_(with_noises_, names_, algebra_),
          reader_(with_noises_, lowering_, algebra_),
          takes_(std::move(takes)) {
        c_.model = model;
        check_fields(model);
        number_components();
        c_.is_substituted.assign(model.fields.size(), false);
        solve_balances();
    }

    /// The summands whose noise depends on fields, position or time, and those that have the same noise.
    Products products_of_noise() {
        std::vector<Summand> noisy;
        for (std::size_t i = 0; i < c_.model.fields.size(); ++i) {
            if (c_.model.fields[i].left != LeftSide::rate) continue;
            const std::optional<Formula> mass = mass_of(i);
            const bool varies = mass && !is_constant_mass(i, *mass);
            for (Summand& one : read(i, mass)) {
                one.multiplies_noise = one.has_noise() && (one.multiplies_noise || (varies && !one.is_acceleration));
                if (one.has_noise()) noisy.push_back(std::move(one));
            }
        }
        check_definitions();
        std::set<std::size_t> multiplied;
        const auto is_product = [&](const Summand& one) {
            return one.multiplies_noise ||
                   std::ranges::any_of(one.noises, [&](std::size_t noise) { return multiplied.contains(noise); });
        };
        Products result;
        for (std::size_t before = 1; before != result.size();) {
            before = result.size();
            for (const Summand& one : noisy)
                if (is_product(one)) {
                    require_noise_alone(one);
                    multiplied.insert(one.noises.begin(), one.noises.end());
                    result.emplace(std::pair{one.summary.field, one.number}, one.noises);
                }
        }
        return result;
    }

    void require_noise_alone(const Summand& one) const {
        // Of products of noise the reader has checked it: their noise is in their value.
        require(
            one.noise.empty() || algebra_.are_zero(one.value.components), one.summary.where,
            "the term \"{}\" mixes noise that multiplies fields with terms without noise; expected noise as a summand "
            "of its own",
            one.summary.text);
    }

    /// drifting: the products of noise in the sense of Stratonovich.
    void compile(const Products& drifting = {}) {
        read_drift(drifting);
        for (std::size_t i = 0; i < c_.model.fields.size(); ++i) {
            compile_field(i);
            add_drift(i);
        }
        const auto is_of_fields = [this](const auto& entry) { return entry.first.component < c_.components; };
        for (int slot = first_atom; slot < algebra_.slots(); ++slot) {
            const LinearForm& form = algebra_.form_of(slot);
            const bool is_read = c_.model.noises.empty() || std::ranges::all_of(form, is_of_fields);
            c_.atoms.push_back(is_read ? form : LinearForm{});
        }
        for (const FunctionCall& call : algebra_.calls()) {
            c_.calls.push_back({call, {}});
            for (const int argument : call.arguments)
                c_.calls.back().values.push_back(algebra_.graph.expression(argument));
        }
    }

    /// Those that no equation uses are checked as well.
    void check_definitions() {
        for (std::size_t i = 0; i < c_.model.definitions.size(); ++i)
            static_cast<void>(lowering_.value_of_definition(i));
    }

    CompiledEquations result(std::vector<NoiseProducts> products = {}) {
        for (std::vector<Term>* terms : {&c_.terms, &c_.substitutes, &c_.evaluated})
            for (Term& term : *terms) c_.summarise(term);
        for (const Term& term : c_.terms) c_.summaries.push_back(term.summary);
        c_.products = std::move(products);
        for (const NoiseProducts& one : c_.products)
            c_.noise_terms.insert(c_.noise_terms.end(), one.equations->summaries.begin(),
                                  one.equations->summaries.end());
        c_.check_noise();
        c_.split(c_.reference());
        return std::move(c_);
    }

private:
    void number_components() {
        c_.first_component = first_components(c_.model);
        for (std::size_t i = 0; i < c_.model.fields.size(); ++i)
            c_.field_of.insert(c_.field_of.end(), components(c_.model.fields[i]), static_cast<int>(i));
        c_.components = static_cast<int>(c_.field_of.size());
        c_.noise_rows.resize(static_cast<std::size_t>(c_.components));
        for (const WhiteNoise& noise : c_.model.noises) c_.noise_components += model::components(noise);
        c_.array_of.assign(static_cast<std::size_t>(c_.components), -1);
        for (int k = 0; k < c_.components; ++k) {
            if (c_.model.fields[c_.field(k)].left == LeftSide::balance) continue;
            c_.free.push_back(k);
            if (c_.is_given(k)) continue;
            c_.array_of[static_cast<std::size_t>(k)] = static_cast<int>(c_.state.size());
            c_.state.push_back(k);
        }
        require(!c_.state.empty(), c_.model.fields.empty() ? SourceLocation{} : c_.model.fields[0].where,
                "the model has no field with a rate; expected at least one");
    }

    std::vector<Summand> read(std::size_t index, const std::optional<Formula>& mass = {}) {
        const bool is_balance = c_.model.fields[index].left == LeftSide::balance;
        return reader_.read(index, mass, [&](std::size_t number) { return is_balance || takes_(index, number); });
    }

    std::optional<Formula> mass_of(std::size_t index) const {
        const Text& mass = c_.model.fields[index].mass;
        if (mass.text.empty()) return {};
        return parse_formula(FormulaText(mass.text, mass.where), notation_with(c_.model.functions));
    }

    std::optional<double> constant_mass(std::size_t index) {
        return algebra_.constant_of(lowering_.value_of(c_.model.fields[index].mass, {}, Parity::even).components[0]);
    }

    bool is_constant_mass(std::size_t index, const Formula& mass) {
        const Field& field = c_.model.fields[index];
        const Value value = lowering_.value_of(FormulaText(field.mass.text, field.mass.where), mass);
        reader_.check_mass(field, value);
        return algebra_.constant_of(value.components.at(0)).has_value();
    }

    // ---- balances

    std::vector<Component> total_of(std::size_t index) {
        std::vector<Component> total(static_cast<std::size_t>(components(c_.model.fields[index])));
        for (const Summand& part : read(index))
            for (std::size_t k = 0; k < total.size(); ++k) total[k] = algebra_.sum(total[k], part.value.components[k]);
        return total;
    }

    /// Whether a balance is solved at every point: it has products, or terms that are written apart and linear, and
    /// distinguish directions.
    bool is_of_points(std::size_t index, const std::vector<Component>& total) const {
        if (is_of_waves(index, total)) return false;
        if (has_products(algebra_, total)) return true;
        if (c_.model.fields[index].further.empty()) return false;
        std::vector<LinearForm> rows(static_cast<std::size_t>(c_.components));
        const int first = c_.first_component[index];
        for (std::size_t k = 0; k < total.size(); ++k) rows[static_cast<std::size_t>(first) + k] = total[k].linear;
        if (c_.commutes_with_turns(rows)) return false;
        for (std::size_t k = 0; k < total.size(); ++k)
            for (const auto& [derivative, coefficient] : total[k].linear)
                if (c_.field(derivative.component) == index &&
                    derivative != Derivative{first + static_cast<int>(k), {}})
                    return false;  // no solution at points
        return true;
    }

    /// Whether a balance can only be solved wave by wave, and can be: derivatives of its field act on it, or it has no
    /// divergence, and its products are those of other fields.
    bool is_of_waves(std::size_t index, const std::vector<Component>& total) const {
        const int first = c_.first_component[index];
        const auto is_own = [&](const Derivative& derivative) { return c_.field(derivative.component) == index; };
        bool couples_points = c_.model.fields[index].solenoidal;
        for (std::size_t k = 0; k < total.size(); ++k) {
            for (const auto& [derivative, coefficient] : total[k].linear)
                couples_points =
                    couples_points || (is_own(derivative) && derivative != Derivative{first + static_cast<int>(k), {}});
            for (const auto& [order, node] : total[k].rest)
                for (const int slot : algebra_.slots_read(node))
                    if (std::ranges::any_of(algebra_.form_of(slot), [&](const auto& e) { return is_own(e.first); }))
                        return false;
        }
        return couples_points;
    }

    /// Solves the balances with products at every point, in the order of their dependence: their fields then stand for
    /// expressions of the others.  Those that are linear in their field with constant coefficients, and have
    /// derivatives of it, are left to the solution wave by wave.
    void solve_balances() {
        std::vector<std::size_t> waiting;
        for (std::size_t i = 0; i < c_.model.fields.size(); ++i) {
            const Field& field = c_.model.fields[i];
            if (field.left != LeftSide::balance) continue;
            require(!field.equation.text.empty() || !field.further.empty(), field.where,
                    "{} is in balance and has no equation; expected one", field.symbol);
            waiting.push_back(i);
        }
        for (bool goes_on = true; goes_on;) {
            goes_on = false;
            std::map<std::size_t, std::vector<Component>> with_products;
            for (const std::size_t i : waiting)
                if (std::vector<Component> total = total_of(i); is_of_points(i, total))
                    with_products.emplace(i, std::move(total));
            for (const auto& [i, total] : with_products) {
                const std::set<int> read = components_of(algebra_, total);
                const bool waits = std::ranges::any_of(read, [&](int component) {
                    return c_.field(component) != i && with_products.count(c_.field(component)) > 0;
                });
                if (waits) continue;
                const Field& field = c_.model.fields[i];
                const Value value = solved_balance(algebra_, field, c_.first_component[i], total);
                lowering_.substitute(i, value);
                c_.substitutes.push_back(
                    term_of({.field = i, .text = field.equation.text, .where = field.equation.where},
                            value.components));
                c_.is_substituted[i] = true;
                std::erase(waiting, i);
                goes_on = true;
                break;
            }
            if (!goes_on && !with_products.empty()) c_.reject_cycle(with_products.begin()->first);
        }
    }
    void compile_field(std::size_t index) {
        const Field& field = c_.model.fields[index];
        if (field.equation.text.empty() && field.further.empty()) {
            if (field.mass.text.empty()) return;
            if (const auto number = constant_mass(index)) c_.constant_masses[index] = *number;
            return;
        }
        const std::optional<Formula> mass = mass_of(index);
        const FormulaText mass_text(field.mass.text, field.mass.where);
        std::vector<Summand> parts = read(index, mass);
        if (c_.is_substituted[index]) {
            for (const Summand& part : parts) add_term(part.summary, {}, false);
            return;
        }
        if (mass) divide_by_mass(index, mass_text, *mass, parts);
        else
            for (const Summand& part : parts) add_part(part, part.value.components, true);
        if (field.conserved) check_conserved(algebra_, field, parts, solenoidal());
        const auto is_in_balance = [this](int component) { return c_.in_balance(component); };
        if (field.left == LeftSide::balance)
            check_free_mean(algebra_, field, total_of(index), is_in_balance, solenoidal());
    }

    /// The first components of divergence-free fields.
    std::vector<int> solenoidal() const {
        std::vector<int> result;
        for (std::size_t i = 0; i < c_.model.fields.size(); ++i)
            if (c_.model.fields[i].solenoidal) result.push_back(c_.first_component[i]);
        return result;
    }

    /// Forces divided by the mass at every point: all forces have one linear form, so that it is transformed once.
    void divide_by_mass(std::size_t index, const FormulaText& mass_text, const Formula& mass,
                        std::vector<Summand>& parts) {
        const Field& field = c_.model.fields[index];
        const Value value = lowering_.value_of(mass_text, mass);
        lowering_.check(mass_text, mass, value, {}, Parity::even);
        const std::optional<double> number = algebra_.constant_of(value.components[0]);
        const bool is_constant = number.has_value();
        if (is_constant && !(*number > 0.0))
            mass_text.fail_with(mass.at, "the mass is {}; expected a number above 0", *number);
        require(is_constant || !field.conserved, field.mass.where,
                "{} is conserved, and its mass is not constant; expected a number", field.symbol);
        require(is_constant || !field.solenoidal, field.mass.where,
                "{} is solenoidal, and its mass is not constant; expected a number: a pressure divided by a mass that "
                "varies is not available",
                field.symbol);
        const int inverse = is_constant ? -1 : inverse_of(index, mass_text.location(mass.at), value.components[0]);
        const auto divided = [&](const Component& force) {
            if (number) return algebra_.scaled(force, 1.0 / *number);
            if (algebra_.is_zero(force)) return force;
            return algebra_.of_node(algebra_.graph.make(Operation::multiply, algebra_.at_points(force), inverse));
        };
        const auto width = static_cast<std::size_t>(components(field));
        std::vector<Component> straight(width), placed(width), whole(width);
        for (const Summand& part : parts) {
            std::vector<Component> rates = part.value.components;
            const bool is_uniform =
                std::ranges::all_of(rates, [&](const Component& c) { return algebra_.constant_of(c).has_value(); });
            std::vector<Component>& total = part.summary.is_explicit                     ? whole
                                            : is_uniform || !positions_in(rates).empty() ? placed
                                                                                         : straight;
            for (std::size_t k = 0; k < width; ++k)
                if (!part.is_acceleration) {
                    total[k] = algebra_.sum(total[k], rates[k]);
                    rates[k] = divided(rates[k]);
                }
            require(
                is_constant || part.is_acceleration || !part.has_noise(), part.summary.where,
                "the noise of the term \"{}\" is divided by a mass that varies; expected the mass as its first factor",
                part.summary.text);
            add_part(part, rates, is_constant || part.is_acceleration,
                     number && !part.is_acceleration ? 1.0 / *number : 1.0);
        }
        if (number) {
            c_.constant_masses[index] = *number;
            return;
        }
        for (std::vector<Component>* total : {&straight, &placed, &whole}) {
            for (Component& c : *total) c = divided(c);
            if (!parts.empty())
                c_.evaluated.push_back(term_of(
                    {.field = parts[0].summary.field, .where = field.equation.where, .is_explicit = total == &whole},
                    *total));
        }
    }

    /// The inverse of a mass, which the solver bounds, is the result of a call.
    int inverse_of(std::size_t index, const SourceLocation& where, const Component& mass) {
        const int node = algebra_.at_points(mass);
        const auto inverse = std::make_shared<const GivenFunction>(GivenFunction{
            .has_finite_degree = false,
            .values =
                [](std::size_t size, std::span<const PointArgument> masses, std::span<double* const> out) {
                    for (std::size_t i = 0; i < size; ++i)
                        out[0][i] = 1.0 / (masses[0].values ? masses[0].values[i] : masses[0].number);
                },
            .slopes =
                [](std::span<const double> masses) { return std::vector<double>{-1.0 / (masses[0] * masses[0])}; }});
        c_.masses.push_back({index, algebra_.calls().size(), where});
        return algebra_.call(inverse, {node})[0];
    }

    /// The slots of x, y and t that rates read.
    std::set<int> positions_in(const std::vector<Component>& rates) const {
        std::set<int> found;
        for (const Component& c : rates)
            for (const auto& [order, node] : c.rest) found.merge(algebra_.slots_read(node));
        found.erase(found.lower_bound(first_atom), found.end());
        return found;
    }

    // ---- terms

    /// A part with its noise; of noise alone no term is left.
    void add_part(const Summand& part, const std::vector<Component>& rates, bool evaluated, double noise_factor = 1.0) {
        const int first = c_.first_component[part.summary.field];
        for (std::size_t k = 0; k < part.noise.size(); ++k)
            for (const auto& [derivative, coefficient] : part.noise[k])
                c_.noise_rows[static_cast<std::size_t>(first) + k][derivative] += noise_factor * coefficient;
        if (part.has_noise() && algebra_.are_zero(rates)) c_.noise_terms.push_back(part.summary);
        else add_term(part.summary, rates, evaluated);
    }

    Row row_of(const Component& component, const SourceLocation& where) {
        Row row{component.linear, {}};
        for (const auto& [order, node] : component.rest) {
            PointFunction function{order, algebra_.graph.expression(node), {}};
            for (const int slot : algebra_.slots_read(node)) {
                if (slot < first_atom) continue;
                Expression slope = slope_of(node, function.value, slot, where);
                if (!drover::is_zero(slope)) function.slopes.push_back({slot, std::move(slope)});
            }
            row.functions.push_back(std::move(function));
        }
        return row;
    }

    Expression slope_of(int node, const Expression& value, int slot, const SourceLocation& where) {
        if (algebra_.calls().empty()) return derivative(value, slot, where);
        algebra_.graph.where = where;
        return algebra_.graph.expression(algebra_.slope_by(node, slot));
    }

    Term term_of(const TermSummary& summary, const std::vector<Component>& rates) {
        Term term{summary, {}};
        const std::set<int> positions = positions_in(rates);
        term.summary.is_placed = !positions.empty();
        term.summary.is_timed = positions.contains(slot_t);
        for (const Component& rate : rates) term.rows.push_back(row_of(rate, summary.where));
        return term;
    }

    /// For the symbol and, `evaluated`, for the solver.
    void add_term(const TermSummary& summary, const std::vector<Component>& rates, bool evaluated) {
        c_.terms.push_back(term_of(summary, rates));
        if (evaluated) c_.evaluated.push_back(c_.terms.back());
    }

    // ---- noise in the sense of Stratonovich

    void read_drift(const Products& products) {
        for (const auto& [place, noises] : products) {
            const std::size_t index = place.first;
            const std::optional<Formula> mass = mass_of(index);
            const double divisor = mass ? constant_mass(index).value_or(nan) : 1.0;
            for (const Summand& one :
                 reader_.read(index, mass, [n = place.second](std::size_t number) { return number == n; }))
                drift_.add(one, divisor);
        }
    }

    void add_drift(std::size_t index) {
        const std::vector<Component> rates = drift_.of(index);
        if (algebra_.are_zero(rates)) return;
        add_term({.field = index, .text = drift_.text(index), .where = c_.model.fields[index].equation.where}, rates,
                 true);
    }

    Model with_noises_;
    Names names_;
    Algebra algebra_;
    Lowering lowering_;
    SummandReader reader_;
    std::function<bool(std::size_t, std::size_t)> takes_;
    CompiledEquations c_;
    NoiseDrift drift_{algebra_, c_};
};

CompiledEquations compiled(const Model& model) {
    if (model.noises.empty()) {
        Compiler compiler(model, [](std::size_t, std::size_t) { return true; });
        compiler.compile();
        compiler.check_definitions();
        return compiler.result();
    }
    const Products products = Compiler(model, [](std::size_t, std::size_t) { return true; }).products_of_noise();
    std::map<std::size_t, std::set<std::size_t>> noises_of;  // fields
    for (const auto& [place, noises] : products) noises_of[place.first].insert(noises.begin(), noises.end());
    std::vector<NoiseProducts> driven;
    for (const auto& [field, noises] : noises_of) {
        Compiler compiler(driven_model(model, field, noises), [&](std::size_t i, std::size_t summand) {
            return products.contains({i, summand});
        });
        compiler.compile();
        driven.push_back(
            {field, {noises.begin(), noises.end()}, std::make_shared<const CompiledEquations>(compiler.result())});
    }
    Compiler compiler(model, [&](std::size_t i, std::size_t summand) { return !products.contains({i, summand}); });
    compiler.compile(model.noise_moment ? products : Products{});
    return compiler.result(std::move(driven));
}
}  // namespace

Equations::Equations(const Model& model) : compiled_(std::make_shared<const CompiledEquations>(compiled(model))) {}

}  // namespace drover::model
