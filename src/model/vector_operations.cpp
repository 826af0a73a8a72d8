// model/vector_operations.cpp: products of vectors and tensors, and differential operators, in components.
#include <cmath>

#include "model/lowering.hpp"

namespace drover::model {

namespace {
std::size_t size_of(const Rank& rank) { return (std::size_t{1} << rank.indices) * (rank.spin == 0 ? 1u : 2u); }
/// A vector is a spin of 1, never an index alone.
Rank normal(const Rank& rank) { return rank.spin == 0 && rank.indices > 0 ? Rank{rank.indices - 1, 1} : rank; }
/// The same with an index in the place of a spin of 1.
Rank with_index(const Rank& rank) { return rank.spin == 1 ? Rank{rank.indices + 1, 0} : rank; }
}  // namespace

/// Writes a nematic with its indices, so that its last or first index can be contracted.
static Value with_indices(Algebra& algebra, const Value& a) {
    if (a.rank.spin == 1) return {with_index(a.rank), a.parity, a.components};
    if (a.rank.spin != 2) return a;
    Value result{{a.rank.indices + 2, 0}, a.parity, {}};
    for (std::size_t i = 0; i < a.components.size(); i += 2) {
        const Component &xx = a.components[i], &xy = a.components[i + 1];
        result.components.insert(result.components.end(), {xx, xy, xy, algebra.scaled(xx, -1.0)});
    }
    return result;
}

/// v.grad v = grad(v.v)/2 - v x curl v: needs the curl instead of four derivatives.
Value Lowering::self_advection(const Value& v) {
    const Component half_square = algebra_.scaled(algebra_.sum(algebra_.product(v.components[0], v.components[0]),
                                                               algebra_.product(v.components[1], v.components[1])),
                                                  0.5);
    const Component curl =
        algebra_.sum(algebra_.derivative(v.components[1], d_dx), algebra_.derivative(v.components[0], d_dy), -1.0);
    Value result{vector, product_parity(v.parity, v.parity), {}};
    result.components.push_back(
        algebra_.sum(algebra_.derivative(half_square, d_dx), algebra_.product(v.components[1], curl), -1.0));
    result.components.push_back(
        algebra_.sum(algebra_.derivative(half_square, d_dy), algebra_.product(v.components[0], curl)));
    return result;
}

template <class Product>
Value Lowering::by_parts(const Value& a, const Value& b, Product product) {
    if (!a.is_complex() && !b.is_complex()) return product(a, b);
    const auto imaginary = [](const Value& v) { return Value{v.rank, v.parity, v.imaginary}; };
    const auto real = [](const Value& v) { return Value{v.rank, v.parity, v.components}; };
    Value result = product(real(a), real(b));
    result.imaginary.resize(result.components.size());
    const auto add = [&](std::vector<Component>& to, const Value& part, double sign) {
        for (std::size_t k = 0; k < to.size(); ++k) to[k] = algebra_.sum(to[k], part.components[k], sign);
    };
    if (a.is_complex() && b.is_complex()) add(result.components, product(imaginary(a), imaginary(b)), -1.0);
    if (a.is_complex()) add(result.imaginary, product(imaginary(a), real(b)), 1.0);
    if (b.is_complex()) add(result.imaginary, product(real(a), imaginary(b)), 1.0);
    return result;
}

Value Lowering::dot(const FormulaText& text, const Formula& f) {
    const Value left = value_of(text, f.arguments[0]);
    const Formula& second = f.arguments[1];
    Value right;
    if (second.kind == Formula::Kind::operation && second.name == "grad" && left.rank == vector && !left.is_complex()) {
        const Value inner = value_of(text, second.arguments[0]);
        const auto is_linear = [](const Component& c) { return c.rest.empty(); };
        if (inner.rank == vector && is_linear(left.components[0]) && is_linear(left.components[1]) &&
            left.components[0].linear == inner.components[0].linear &&
            left.components[1].linear == inner.components[1].linear && is_linear(inner.components[0]) &&
            is_linear(inner.components[1]) && left.parity == Parity::even && inner.parity == Parity::even)
            return self_advection(left);
        right = applied(text, second, inner);
    } else {
        right = value_of(text, second);
    }
    return by_parts(left, right, [&](const Value& a, const Value& b) { return dot(text, f, a, b); });
}

Value Lowering::dot(const FormulaText& text, const Formula& f, const Value& left, const Value& right) {
    algebra_.graph.where = text.location(f.at);
    const Value a = with_indices(algebra_, left), b = right.rank.indices > 0 ? right : with_indices(algebra_, right);
    if (a.rank.spin != 0 || a.rank.indices == 0 || b.rank.indices == 0)
        text.fail_with(f.at,
                       "the dot product of {} and {}; expected vectors or tensors; an operator acts on the whole "
                       "product after it: write (grad h).(grad h) or |grad h|^2",
                       rank_text(left.rank, left.parity), rank_text(right.rank, right.parity));
    const Rank payload{b.rank.indices - 1, b.rank.spin};
    const std::size_t lead = a.components.size() / 2, width = size_of(payload);
    Value result{normal({a.rank.indices - 1 + payload.indices, payload.spin}), product_parity(a.parity, b.parity), {}};
    for (std::size_t i = 0; i < lead; ++i)
        for (std::size_t j = 0; j < width; ++j)
            result.components.push_back(
                algebra_.sum(algebra_.product(a.components[2 * i], b.components[j]),
                             algebra_.product(a.components[2 * i + 1], b.components[width + j])));
    if (result.rank.indices + result.rank.spin > 3)
        text.fail_with(f.at, "the dot product is a tensor of a rank above 3; expected a lower rank");
    return result;
}

Value Lowering::double_dot(const FormulaText& text, const Formula& f) {
    return by_parts(value_of(text, f.arguments[0]), value_of(text, f.arguments[1]),
                    [&](const Value& a, const Value& b) { return double_dot(text, f, a, b); });
}

Value Lowering::double_dot(const FormulaText& text, const Formula& f, const Value& left, const Value& right) {
    algebra_.graph.where = text.location(f.at);
    Value result{scalar, product_parity(left.parity, right.parity), {}};
    Component sum;
    const auto add_products = [&](const Value& a, const Value& b, double factor) {
        for (std::size_t i = 0; i < a.components.size(); ++i)
            sum = algebra_.sum(sum, algebra_.product(a.components[i], b.components[i]), factor);
    };
    if (left.rank == right.rank && left.rank.indices == 0 && left.rank.spin >= 2) {
        add_products(left, right, static_cast<double>(1 << (left.rank.spin - 1)));  // all indices contracted
    } else {
        const Value a = with_indices(algebra_, left), b = with_indices(algebra_, right);
        if (a.rank != b.rank || a.rank != Rank{2, 0})
            text.fail_with(
                f.at,
                "the double dot product of {} and {}; expected two tensors of rank 2, or two fields of the same spin",
                rank_text(left.rank, left.parity), rank_text(right.rank, right.parity));
        add_products(a, b, 1.0);
    }
    result.components.push_back(sum);
    return result;
}

Value Lowering::outer(const FormulaText& text, const Formula& f) {
    return by_parts(value_of(text, f.arguments[0]), value_of(text, f.arguments[1]),
                    [&](const Value& a, const Value& b) { return outer(text, f, a, b); });
}

Value Lowering::outer(const FormulaText& text, const Formula& f, const Value& a, const Value& b) {
    algebra_.graph.where = text.location(f.at);
    if (a.rank != vector || b.rank.indices > 0 || b.rank.spin == 0)
        text.fail_with(f.at, "the outer product of {} and {}; expected a vector and a vector or a field of a spin",
                       rank_text(a.rank, a.parity), rank_text(b.rank, b.parity));
    Value result{{1, b.rank.spin}, product_parity(a.parity, b.parity), {}};
    for (const Component& first : a.components)
        for (const Component& second : b.components) result.components.push_back(algebra_.product(first, second));
    return result;
}

/// A product with a scalar.
Value Lowering::times(const FormulaText& text, const Formula& f, const Value& left, const Value& right) {
    return by_parts(left, right, [&](const Value& a, const Value& b) {
        if (a.rank != scalar && b.rank != scalar)
            text.fail_with(f.at,
                           "{} is multiplied by {}; expected a scalar factor: write a.b for the dot product, or "
                           "outer(a, b) for the outer product",
                           rank_text(a.rank, a.parity), rank_text(b.rank, b.parity));
        Value result = b.rank == scalar ? a : b;
        const Component& factor = b.rank == scalar ? b.components[0] : a.components[0];
        for (Component& c : result.components) c = algebra_.product(c, factor);
        result.parity = product_parity(a.parity, b.parity);
        return result;
    });
}

Value Lowering::divided(const FormulaText& text, const Formula& f, const Value& above, const Value& below) {
    if (below.is_complex()) {  // a conj(b) / |b|^2
        Value conjugate = below, square{.parity = Parity::even, .components = {{}}};
        conjugate.imaginary[0] = algebra_.scaled(conjugate.imaginary[0], -1.0);
        for (const Component* part : {&below.components[0], &below.imaginary[0]})
            square.components[0] = algebra_.sum(square.components[0], algebra_.product(*part, *part));
        return divided(text, f, times(text, f, above, conjugate), square);
    }
    const std::optional<double> number = algebra_.constant_of(below.components[0]);
    if (number == 0.0) text.fail_with(f.sign_at, "this divides by zero; expected another divisor");
    Value result = above;
    for (std::vector<Component>* parts : {&result.components, &result.imaginary})
        for (Component& c : *parts) {
            if (number) c = algebra_.scaled(c, 1.0 / *number);
            else if (!algebra_.is_zero(c))
                c = algebra_.of_node(algebra_.graph.make(Operation::divide, algebra_.at_points(c),
                                                         algebra_.at_points(below.components[0])));
        }
    result.parity = product_parity(above.parity, below.parity);
    return result;
}

Value Lowering::complex_power(const FormulaText& text, const Formula& f, const Value& base, double n) {
    constexpr double max_power = 16.0;
    if (!(std::abs(n) <= max_power) || n != std::round(n))
        text.fail_with(f.at,
                       "a power of a complex value; expected a whole number of at most {}: of other powers write |A|^n",
                       max_power);
    Value result{.components = {algebra_.constant(1.0)}};
    for (int k = 0; k < std::abs(static_cast<int>(n)); ++k) result = times(text, f, result, base);
    if (n < 0.0) result = divided(text, f, {.components = {algebra_.constant(1.0)}}, result);
    return result;
}

/// re, im and conj.
Value Lowering::part_of_complex(const FormulaText& text, const Formula& f) {
    Value value = value_of(text, f.arguments[0]);
    if (f.name == "conj") {
        for (Component& c : value.imaginary) c = algebra_.scaled(c, -1.0);
        return value;
    }
    if (f.name == "im") {
        if (value.is_complex()) value.components = value.imaginary;
        else
            for (Component& c : value.components) c = {};
    }
    value.imaginary.clear();
    return value;
}

Value Lowering::gradient(const Value& a) {
    Value result{normal({a.rank.indices + 1, a.rank.spin}), a.parity, {}};
    for (const Order& order : {d_dx, d_dy})
        for (const Component& component : a.components)
            result.components.push_back(algebra_.derivative(component, order));
    return result;
}

/// Contracts the derivative with the first index.  Of a spin m: d* F = (d_x - i d_y)(F_1 + i F_2), of spin m - 1.
Value Lowering::divergence(const Value& a) {
    const auto d = [&](std::size_t component, const Order& order) {
        return algebra_.derivative(a.components[component], order);
    };
    Value result{normal({a.rank.indices - 1, a.rank.spin}), a.parity, {}};
    if (a.rank.indices > 0) {
        const std::size_t width = a.components.size() / 2;
        for (std::size_t j = 0; j < width; ++j)
            result.components.push_back(algebra_.sum(d(j, d_dx), d(width + j, d_dy)));
        return result;
    }
    result.rank = {0, a.rank.spin - 1};
    result.components.push_back(algebra_.sum(d(0, d_dx), d(1, d_dy)));
    if (a.rank.spin > 1) result.components.push_back(algebra_.sum(d(1, d_dx), d(0, d_dy), -1.0));
    return result;
}

/// The symmetric traceless part of a tensor with one index and a spin m, of spin m + 1: (T_x + i T_y)/2, T_k complex.
Value Lowering::symmetric(const Value& a) {
    const std::vector<Component>& c = a.components;
    Value result{{0, a.rank.spin + 1}, a.parity, {}};
    result.components.push_back(algebra_.scaled(algebra_.sum(c[0], c[3], -1.0), 0.5));
    result.components.push_back(algebra_.scaled(algebra_.sum(c[1], c[2]), 0.5));
    return result;
}

Value Lowering::operation(const FormulaText& text, const Formula& f) {
    const Formula& argument = f.arguments[0];
    if (scope_ != nullptr && (argument.kind != Formula::Kind::name || scope_->names.count(argument.name) == 0))
        text.fail(argument.at, drover::text("the name of a field after {}", f.name));
    const bool is_number = argument.kind == Formula::Kind::number ||
                           (argument.kind == Formula::Kind::name && model_.coefficients.count(argument.name) > 0);
    if (is_number && scope_ == nullptr && f.name != "perp")
        text.fail_with(f.at, "{} of a number is 0; expected the number before it, or {}(...) of the whole product",
                       f.name, f.name);
    return applied(text, f, value_of(text, f.arguments[0]));
}

Value Lowering::applied(const FormulaText& text, const Formula& f, Value a) {
    if (!a.is_complex()) return applied_to_real(text, f, std::move(a));
    Value result = applied_to_real(text, f, {a.rank, a.parity, a.components});
    result.imaginary = applied_to_real(text, f, {a.rank, a.parity, a.imaginary}).components;
    return result;
}

Value Lowering::applied_to_real(const FormulaText& text, const Formula& f, Value a) {
    algebra_.graph.where = text.location(f.at);
    const auto reject = [&](const char* expected) {
        text.fail_with(f.at, "{} of {}; expected {}", f.name, rank_text(a.rank, a.parity), expected);
    };
    const std::string& name = f.name;
    if (name == "lap") {
        for (Component& c : a.components)
            c = algebra_.sum(algebra_.derivative(c, {2, 0}), algebra_.derivative(c, {0, 2}));
        return a;
    }
    if (name == "grad_div_x" || name == "grad_div_y") {
        if (a.rank != vector) reject("a vector");
        a = divergence(a);
    }
    if (name.ends_with("_x") || name.ends_with("_y")) {
        for (Component& c : a.components) c = algebra_.derivative(c, name.ends_with("_x") ? d_dx : d_dy);
        a.parity = Parity::none;
        return a;
    }
    if (name == "grad") {
        if (a.rank.indices > 1) reject("a scalar, a vector, a field of a spin, or the gradient of one");
        return gradient(a);
    }
    if (name == "div") {
        if (a.rank == scalar) reject("a vector, a tensor or a field of a spin");
        return divergence(a);
    }
    if (name == "sym") {
        if (a.rank.indices != 1) reject("a gradient or outer product: sym(grad v)");
        return symmetric(a);
    }
    if (name == "curl") {
        if (a.rank != vector) reject("a vector");
        return {scalar,
                product_parity(a.parity, Parity::odd),
                {algebra_.sum(algebra_.derivative(a.components[1], d_dx), algebra_.derivative(a.components[0], d_dy),
                              -1.0)}};
    }
    if (a.rank.indices > 0 || a.rank.spin == 0) reject("a vector or a field of a spin");
    return {a.rank, product_parity(a.parity, Parity::odd), {algebra_.scaled(a.components[1], -1.0), a.components[0]}};
}

}  // namespace drover::model
