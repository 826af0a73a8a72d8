// model/lowering.cpp: the rules of ranks and parities, and what each operation does to components.
#include "model/lowering.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>

#include "base/mapped.hpp"

namespace drover::model {

namespace {
using Kind = Formula::Kind;
constexpr int max_depth = 600;  // the stack

bool is_scalar(const Value& a) { return a.rank == scalar; }
std::string text_of(const Value& a) { return rank_text(a.rank, a.parity); }

std::vector<std::string> with_components(const std::string& name, int spin) {
    switch (spin) {
        case 0: return {name};
        case 1: return {name + "_x", name + "_y"};
        case 2: return {name + "_xx", name + "_xy"};
        default: return {name + "_1", name + "_2"};
    }
}
}  // namespace

const Notation& equation_notation() {
    static const Notation notation{.arguments_of =
                                       [](const std::string& name) {
                                           return name == "outer"         ? 2
                                                  : name == explicit_name ? 1
                                                                          : function_arguments(name);
                                       },
                                   .is_operator =
                                       [](const std::string& name) {
                                           constexpr std::array operators{"grad", "div", "lap", "curl",
                                                                          "perp", "sym", "d_x", "d_y"};
                                           return std::ranges::find(operators, name) != operators.end();
                                       }};
    return notation;
}

Notation notation_with(const std::map<std::string, GivenFunction>& functions) {
    Notation notation = equation_notation();
    notation.arguments_of = [&functions](const std::string& name) {
        const auto found = functions.find(name);
        return found == functions.end() ? equation_notation().arguments_of(name) : found->second.arguments;
    };
    return notation;
}

Lowering::Lowering(const Model& model, const Names& names, Algebra& algebra)
    : model_(model), names_(names), algebra_(algebra) {}

Formula Lowering::parsed(const FormulaText& text) const {
    if (scope_ == nullptr) return parse_formula(text, notation_with(model_.functions));
    Notation notation = notation_with(scope_->functions);
    notation.is_operator = [](const std::string& name) {  // components of grad div
        return equation_notation().is_operator(name) || name == "grad_div_x" || name == "grad_div_y";
    };
    return parse_formula(text, notation);
}

Value Lowering::value_of(const Text& text, const Rank& rank, Parity parity) {
    const FormulaText source(text.text, text.where);
    const Formula formula = parsed(source);
    Value value = value_of(source, formula);
    check(source, formula, value, rank, parity);
    return value;
}

void Lowering::check(const FormulaText& text, const Formula& formula, const Value& found, const Rank& rank,
                     Parity parity) const {
    if (found.is_complex())
        text.fail_with(formula.at, "this is complex; expected a real value: re(...), im(...) or |...|");
    if (is_scalar(found) && algebra_.constant_of(found.components[0]) == 0.0) return;  // 0 has any rank
    if (found.rank != rank)
        text.fail_with(formula.at, "this is {}; expected {}", text_of(found), rank_text(rank, parity));
    if (!model_.chiral && found.parity != Parity::none && parity != Parity::none && found.parity != parity)
        text.fail_with(formula.at,
                       "this is {}; expected {}, or chiral = true in the model, which allows terms that distinguish "
                       "left and right",
                       text_of(found), rank_text(rank, parity));
}

Parity Lowering::common_parity(const FormulaText& text, const Formula& at, const Value& a, const Value& b) const {
    if (a.parity == b.parity) return a.parity;
    if (a.parity == Parity::none || b.parity == Parity::none || model_.chiral) return Parity::none;
    text.fail_with(at.at,
                   "{} is added to {}; expected equal parities, or chiral = true in the model, which allows terms that "
                   "distinguish left and right",
                   text_of(b), text_of(a));
}

Value Lowering::value_of(const FormulaText& text, const Formula& f) {
    if (depth_ >= max_depth)
        text.fail_with(
            f.at,
            "this is nested deeper than {} levels, with definitions and chains of dots; expected a simpler formula",
            max_depth);
    ++depth_;
    Value value = value_of_kind(text, f);
    --depth_;
    return value;
}

Value Lowering::value_of_kind(const FormulaText& text, const Formula& f) {
    algebra_.graph.where = text.location(f.at);
    switch (f.kind) {
        case Kind::number: return {.components = {algebra_.constant(f.value)}};
        case Kind::name: return named(text, f);
        case Kind::sum: return added(text, f);
        case Kind::product: return multiplied(text, f);
        case Kind::negative: {
            Value value = value_of(text, f.arguments[0]);
            for (std::vector<Component>* parts : {&value.components, &value.imaginary})
                for (Component& component : *parts) component = algebra_.scaled(component, -1.0);
            return value;
        }
        case Kind::power: return power(text, f);
        case Kind::dot: return dot(text, f);
        case Kind::double_dot: return double_dot(text, f);
        case Kind::norm: return norm(text, f);
        case Kind::call: return call(text, f);
        case Kind::operation: return operation(text, f);
    }
    return {};
}

Value Lowering::value_of(const WrittenTerm& term) {
    scope_ = term.scope.get();
    Value value;
    if (term.texts.size() == 1) {
        const FormulaText source(term.texts[0].text, term.texts[0].where);
        const Formula formula = parsed(source);
        value = value_of(source, formula);
        if (term.is_flux) check(source, formula, value, vector, Parity::none);
    } else {
        value = {vector, Parity::none, {}};
        for (const Text& text : term.texts)
            value.components.push_back(value_of(text, scalar, Parity::none).components[0]);
    }
    scope_ = nullptr;
    if (!term.is_flux) return value;
    Component sum;
    for (const std::size_t k : {0u, 1u})
        sum = algebra_.sum(sum, algebra_.derivative(value.components[k], {k == 0, k == 1}), -1.0);
    return {.parity = value.parity, .components = {sum}};
}

/// Names of the scope stand for formulas of the model.
Value Lowering::named_in_scope(const FormulaText& text, const Formula& f) {
    const Scope* const scope = scope_;
    if (const auto found = scope->parameters.find(f.name); found != scope->parameters.end())
        return {.components = {algebra_.constant(found->second)}};
    const auto found = scope->names.find(f.name);
    const bool is_position = f.name == "x" || f.name == "y" || f.name == "t";
    if (found == scope->names.end() && !is_position && f.name != "pi" && f.name != "e_x" && f.name != "e_y") {
        std::vector<std::string> known{"x", "y", "t"};
        for (const auto& [name, number] : scope->parameters) known.push_back(name);
        for (const auto& [name, formula] : scope->names) known.push_back(name);
        text.fail(f.at, expected_name(f.name, known));
    }
    scope_ = nullptr;
    const std::string formula = found == scope->names.end() ? f.name : found->second;
    const SourceLocation nowhere;
    const FormulaText source(formula, nowhere);
    const Value value = value_of(source, parsed(source));
    scope_ = scope;
    return value;
}

Value Lowering::named(const FormulaText& text, const Formula& f) {
    if (scope_ != nullptr) return named_in_scope(text, f);
    const Names::Meaning* meaning = names_.find(f.name);
    if (meaning == nullptr) {
        if (f.name == "pi") return {.components = {algebra_.constant(std::numbers::pi)}};
        if (f.name == "i" && model_.functions.contains("conj"))
            return {.components = {{}}, .imaginary = {algebra_.constant(1.0)}};
        if (f.name == "e_x" || f.name == "e_y")  // unit vectors along the axes
            return {vector, Parity::none, {algebra_.constant(f.name == "e_x"), algebra_.constant(f.name == "e_y")}};
        text.fail(f.at, names_.expected(f.name));
    }
    const auto component = [](int number) { return Component{.linear = {{{number, no_derivative}, 1.0}}}; };
    if (const auto found = substitutes_.find(meaning->index);
        found != substitutes_.end() &&
        (meaning->kind == Names::Kind::field || meaning->kind == Names::Kind::component)) {
        if (meaning->kind == Names::Kind::field) return found->second;
        const auto part = static_cast<std::size_t>(meaning->component - names_.first_component(meaning->index));
        return {.parity = Parity::none, .components = {found->second.components[part]}};
    }
    switch (meaning->kind) {
        case Names::Kind::component: return {.parity = Parity::none, .components = {component(meaning->component)}};
        case Names::Kind::coefficient: return {.components = {algebra_.constant(model_.coefficients.at(f.name))}};
        case Names::Kind::position:
            return {.parity = meaning->index == slot_t ? Parity::even : Parity::none,
                    .components = {algebra_.of_node(algebra_.graph.slot(static_cast<int>(meaning->index)))}};
        case Names::Kind::field: {
            const Field& field = model_.fields[meaning->index];
            Value value{.rank = {0, field.spin}, .parity = field.odd ? Parity::odd : Parity::even};
            for (int c = 0; c < components(field); ++c) value.components.push_back(component(meaning->component + c));
            return value;
        }
        case Names::Kind::definition: break;
    }
    const std::size_t index = meaning->index;
    if (model_.definitions[index].is_table && text.text().substr(f.at + f.name.size()).starts_with('('))
        text.fail_with(f.at,
                       "{} is the value of a table, and \"(\" would begin a factor; expected {} without arguments, or "
                       "{} * (...) for a product",
                       f.name, f.name, f.name);
    if (std::ranges::find(open_definitions_, index) != open_definitions_.end())
        text.fail_with(f.at, "{} is defined by itself; expected a definition by other names", f.name);
    const Value value = value_of_definition(index);
    algebra_.graph.where = text.location(f.at);
    return value;
}

Value Lowering::value_of_definition(std::size_t index) {
    if (const auto found = definitions_.find(index); found != definitions_.end()) return found->second;
    open_definitions_.push_back(index);
    const Text& written = model_.definitions[index].value;
    const FormulaText source(written.text, written.where);
    const Value value = value_of(source, parsed(source));
    open_definitions_.pop_back();
    definitions_.emplace(index, value);
    return value;
}

Value Lowering::added(const FormulaText& text, const Formula& f) {
    Value sum = value_of(text, f.arguments[0]);
    for (std::size_t i = 1; i < f.arguments.size(); ++i) {
        const Formula& part = f.arguments[i];
        const Value next = value_of(text, part);
        if (next.rank != sum.rank)
            text.fail_with(part.sign_at, "{} and {} are added; expected equal ranks", text_of(sum), text_of(next));
        sum.parity = common_parity(text, part, sum, next);
        const double sign = part.sign == '-' ? -1.0 : 1.0;
        if (next.is_complex()) sum.imaginary.resize(sum.components.size());
        for (std::size_t c = 0; c < sum.components.size(); ++c)
            sum.components[c] = algebra_.sum(sum.components[c], next.components[c], sign);
        for (std::size_t c = 0; c < next.imaginary.size(); ++c)
            sum.imaginary[c] = algebra_.sum(sum.imaginary[c], next.imaginary[c], sign);
    }
    return sum;
}

void Lowering::need_scalar(const FormulaText& text, const Formula& f, const Value& found, const char* what) const {
    if (!is_scalar(found)) text.fail_with(f.at, "{} is {}; expected a scalar", what, text_of(found));
    if (found.is_complex())
        text.fail_with(f.at, "{} is complex; expected a real scalar: re(...), im(...) or |...|", what);
}

Value Lowering::multiplied(const FormulaText& text, const Formula& f) {
    Value result = value_of(text, f.arguments[0]);
    for (std::size_t i = 1; i < f.arguments.size(); ++i) {
        const Formula& part = f.arguments[i];
        const Value next = value_of(text, part);
        algebra_.graph.where = text.location(part.sign_at);
        if (part.sign == '/') {
            if (!is_scalar(next)) text.fail_with(part.at, "the divisor is {}; expected a scalar", text_of(next));
            result = divided(text, part, result, next);
        } else {
            result = times(text, part, result, next);
        }
    }
    return result;
}

/// Whether a node is written as a sum of squares, such as p.p.
static bool is_sum_of_squares(const GraphBuilder& graph, int node) {
    const Node& n = graph[node];
    if (n.operation == Operation::add) return is_sum_of_squares(graph, n.left) && is_sum_of_squares(graph, n.right);
    if (n.operation != Operation::multiply) return false;
    return n.left == n.right ||
           (graph.is_number(n.left) && graph[n.left].value >= 0.0 && is_sum_of_squares(graph, n.right));
}

Value Lowering::power(const FormulaText& text, const Formula& f) {
    const Value base = value_of(text, f.arguments[0]), exponent = value_of(text, f.arguments[1]);
    if (!is_scalar(base))
        text.fail_with(f.at, "a power of {}; expected a scalar: write (p.p)^2 or |p|^3", text_of(base));
    need_scalar(text, f.arguments[1], exponent, "the exponent");
    const std::optional<double> n = algebra_.constant_of(exponent.components[0]);
    if (n == 1.0) return base;
    if (base.is_complex()) return complex_power(text, f, base, n.value_or(std::nan("")));
    int argument = algebra_.at_points(base.components[0]), power = algebra_.at_points(exponent.components[0]);
    const Node root = algebra_.graph[argument];
    const bool is_norm = root.operation == Operation::sqrt && is_sum_of_squares(algebra_.graph, root.left);
    if (is_norm && n && std::fmod(*n, 2.0) == 0.0) {  // |p|^2 is p.p
        argument = root.left;
        power = algebra_.graph.number(*n / 2.0);
    }
    const int node = algebra_.graph.make(Operation::power, argument, power);
    const bool is_even = n && std::fmod(*n, 2.0) == 0.0, is_odd = n && std::abs(std::fmod(*n, 2.0)) == 1.0;
    if (exponent.parity == Parity::odd && !model_.chiral)
        text.fail_with(f.arguments[1].at,
                       "the exponent is a pseudoscalar; expected a scalar, or chiral = true in the model");
    Parity parity = exponent.parity == Parity::even ? base.parity : Parity::none;
    if (parity == Parity::odd && is_even) parity = Parity::even;
    else if (parity == Parity::odd && !is_odd)
        text.fail_with(f.at, "a power of a pseudoscalar that is not whole; expected a whole exponent");
    return {.parity = parity, .components = {algebra_.of_node(node)}};
}

Component Lowering::scalar_function(const FormulaText& text, const Formula& f, Operation operation,
                                    const std::vector<Value>& arguments) {
    std::vector<int> nodes;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        need_scalar(text, f.arguments[i], arguments[i], "the argument");
        nodes.push_back(algebra_.at_points(arguments[i].components[0]));
    }
    algebra_.graph.where = text.location(f.at);
    return algebra_.of_node(algebra_.graph.make(operation, nodes[0], nodes.size() > 1 ? nodes[1] : -1));
}

const GivenFunction* Lowering::given_function(const std::string& name) const {
    const std::map<std::string, GivenFunction>& functions = scope_ == nullptr ? model_.functions : scope_->functions;
    const auto found = functions.find(name);
    return found == functions.end() ? nullptr : &found->second;
}

/// A function of numbers is a number.
Value Lowering::given_call(const FormulaText& text, const Formula& f, const GivenFunction& function) {
    if (!function.values || !function.slopes || function.arguments < 1 || function.results < 1 || function.results > 2)
        text.fail_with(f.at,
                       "the function {} of {} arguments with {} results, {} values and {} slopes; expected 1 or more "
                       "arguments, 1 or 2 results, and both functions",
                       f.name, function.arguments, function.results, function.values ? "with" : "without",
                       function.slopes ? "with" : "without");
    std::vector<int> nodes;
    Parity parity = function.results == 1 ? Parity::even : Parity::none;
    for (const Formula& argument : f.arguments) {
        const Value value = value_of(text, argument);
        need_scalar(text, argument, value, "the argument");
        if (value.parity != Parity::even) parity = Parity::none;
        nodes.push_back(algebra_.at_points(value.components[0]));
    }
    algebra_.graph.where = text.location(f.at);
    Value result{function.results == 1 ? scalar : vector, parity, {}};
    if (std::ranges::all_of(nodes, [&](int node) { return algebra_.graph.is_number(node); })) {
        std::vector<PointArgument> numbers;
        for (const int node : nodes) numbers.push_back({.number = algebra_.graph[node].value});
        std::array<double, 2> values{};
        const std::array<double*, 2> out{&values[0], &values[1]};
        function.values(1, numbers, std::span(out).first(static_cast<std::size_t>(function.results)));
        for (int k = 0; k < function.results; ++k)
            result.components.push_back(algebra_.constant(values[static_cast<std::size_t>(k)]));
        return result;
    }
    std::shared_ptr<const GivenFunction>& shared = functions_[&function];
    if (shared == nullptr) shared = std::make_shared<const GivenFunction>(function);
    for (const int node : algebra_.call(shared, nodes)) result.components.push_back(algebra_.of_node(node));
    return result;
}

Value Lowering::call(const FormulaText& text, const Formula& f) {
    if (const GivenFunction* function = given_function(f.name)) {
        const bool is_part = !function->values && (f.name == "re" || f.name == "im" || f.name == "conj");
        return is_part ? part_of_complex(text, f) : given_call(text, f, *function);
    }
    if (f.name == "outer") return outer(text, f);
    if (f.name == explicit_name)
        text.fail_with(f.at, "explicit(...) is part of a formula; expected it as a whole summand of an equation");
    std::vector<Value> arguments;
    Parity parity = Parity::even;
    for (const Formula& argument : f.arguments) {
        arguments.push_back(value_of(text, argument));
        if (arguments.back().parity == Parity::none) parity = Parity::none;
    }
    const Operation operation = find_function(f.name)->operation;
    const Component result = scalar_function(text, f, operation, arguments);
    constexpr std::array odd_functions{Operation::atan, Operation::sign, Operation::sin,
                                       Operation::sinh, Operation::tan,  Operation::tanh};
    const bool is_odd = std::ranges::find(odd_functions, operation) != odd_functions.end();
    const bool is_even = operation == Operation::abs || operation == Operation::cos || operation == Operation::cosh;
    for (const Value& argument : arguments)
        if (argument.parity == Parity::odd && !is_even) {
            if (!is_odd && !model_.chiral)
                text.fail_with(f.at,
                               "{} of a pseudoscalar is neither even nor odd under reflections; expected a scalar, or "
                               "chiral = true in the model",
                               f.name);
            if (parity != Parity::none) parity = is_odd ? Parity::odd : Parity::none;
        }
    return {.parity = parity, .components = {result}};
}

Value Lowering::norm(const FormulaText& text, const Formula& f) {
    const Value a = value_of(text, f.arguments[0]);
    algebra_.graph.where = text.location(f.at);
    const Parity parity = a.parity == Parity::none ? Parity::none : Parity::even;
    if (is_scalar(a) && !a.is_complex())
        return {.parity = parity,
                .components = {
                    algebra_.of_node(algebra_.graph.make(Operation::abs, algebra_.at_points(a.components[0])))}};
    if (a.rank.indices > 0)
        text.fail_with(f.at, "the norm of {}; expected a scalar, a vector or a field of a spin", text_of(a));
    Component square;
    for (const std::vector<Component>* parts : {&a.components, &a.imaginary})
        for (const Component& c : *parts) square = algebra_.sum(square, algebra_.product(c, c));
    return {.parity = parity,
            .components = {algebra_.of_node(algebra_.graph.make(Operation::sqrt, algebra_.at_points(square)))}};
}

// ---- names

std::vector<std::string> component_names(const Field& field) { return with_components(field.symbol, field.spin); }

std::vector<std::size_t> drawn_fields(const Model& model) {
    std::vector<std::size_t> fields(model.fields.size());
    std::iota(fields.begin(), fields.end(), 0);
    std::ranges::stable_sort(fields, {}, [&](std::size_t n) { return model.fields[n].observed.drawn; });
    return fields;
}

std::vector<int> first_components(const Model& model) {
    return mapped(placed_fields(model), [](const PlacedField& one) { return static_cast<int>(one.first); });
}

std::vector<std::string> dataset_names(const Field& field) { return with_components(field.name, field.spin); }

Names::Names(const Model& model) : first_components_(first_components(model)) {
    for (const auto& [name, function] : model.functions) reserved_.insert(name);
    if (reserved_.contains("conj")) reserved_.insert("i");
    add("x", {Kind::position, slot_x, 0}, {});
    add("y", {Kind::position, slot_y, 0}, {});
    add("t", {Kind::position, slot_t, 0}, {});
    for (std::size_t i = 0; i < model.fields.size(); ++i) {
        const Field& field = model.fields[i];
        const int component = first_components_[i];
        require(field.spin >= 0 && field.spin <= 6, field.where, "the field {} has spin {}; expected 0 to 6",
                field.name, field.spin);
        add(field.symbol, {Kind::field, i, component}, field.where);
        if (field.name != field.symbol) add(field.name, {Kind::field, i, component}, field.where);
        const std::vector<std::string> names = component_names(field);
        for (std::size_t c = 0; c < names.size(); ++c) {
            if (field.spin > 0) add(names[c], {Kind::component, i, component + static_cast<int>(c)}, field.where);
        }
    }
    for (std::size_t i = 0; i < model.definitions.size(); ++i)
        add(model.definitions[i].name, {Kind::definition, i, 0}, model.definitions[i].value.where);
    for (const auto& [name, value] : model.coefficients) add(name, {Kind::coefficient, 0, 0}, {});
}

void Names::add(const std::string& name, const Meaning& meaning, const SourceLocation& where) {
    const auto is_letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
    require(!name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) && std::ranges::all_of(name, is_letter),
            where, "the name \"{}\" of a field, noise, definition or coefficient; expected letters, digits and _",
            name);
    require(equation_notation().arguments_of(name) == 0 && !equation_notation().is_operator(name) && name != "pi" &&
                name != "e_x" && name != "e_y" && !reserved_.contains(name),
            where, "the name {} is that of a function, an operator or a constant; expected another name", name);
    const auto [place, is_new] = meanings_.emplace(name, meaning);
    const bool has_place = !where.file.empty();  // a coefficient has none
    const std::string first = location_text(places_[name]);
    require(place->second.kind != Kind::position || meaning.kind == Kind::position, where,
            "the name {} is that of {}; expected another name", name, name == "t" ? "the time" : "the position");
    require(is_new, has_place ? where : places_[name], "the name {} is used twice{}; expected another name", name,
            meaning.kind == Kind::coefficient ? ": it is a coefficient as well"
            : first.empty()                   ? ""
                                              : ", first at " + first);
    places_[name] = where;
}

const Names::Meaning* Names::find(const std::string& name) const {
    const auto found = meanings_.find(name);
    return found == meanings_.end() ? nullptr : &found->second;
}

std::string Names::expected(const std::string& name) const {
    return expected_name(name, mapped(meanings_, [](const auto& one) { return one.first; }));
}

std::string expected_name(const std::string& name, const std::vector<std::string>& known) {
    const bool is_short = name.size() < 3;  // any letter is near another
    return text("{}one of {}, pi, e_x, e_y, an operator such as grad or lap, a function, or a coefficient with a value",
                is_short ? "" : suggestion(name, known, "", "{} (did you mean that?), "), joined(known));
}

}  // namespace drover::model
