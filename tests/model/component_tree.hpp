// tests/model/component_tree.hpp: formulas as trees of Cartesian tensors, evaluated without the library.
#pragma once
#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

namespace drover::model {

/// One operation of a formula, with its text.
struct Tree {
    enum class Kind {
        number,
        field,      ///< all components of a field
        component,  ///< one of them, as a scalar
        unit,       ///< e_x or e_y: `index`
        sum,
        negative,
        product,
        quotient,
        power,  ///< to `value`
        dot,
        double_dot,
        norm,
        function,  ///< `name`
        outer,
        grad,
        div,
        lap,
        curl,
        perp,
        sym,
        along_axis  ///< d_x or d_y: `index`
    };
    /// How tightly the text binds.
    enum class Binding { sum, product, power, operation_on_chain, chain, operation, atom };

    Kind kind = Kind::number;
    int indices = 0, spin = 0;  ///< Cartesian indices, then a spin
    double value = 0.0;
    int index = 0;  ///< the first component of a field, or an axis
    std::string name = {};
    std::vector<Tree> parts = {};

    std::string text = {};
    Binding binding = Binding::atom;
    int parity = 1, degree = 0, derivatives = 0;
    bool is_polynomial = true, is_anisotropic = false;

    int rank() const { return indices + spin; }
};

/// A Cartesian tensor: 2^rank components, the first index slowest.
template <class Number>
struct Tensor {
    int rank = 0;
    std::vector<Number> at;
};

/// The tensor of a field F_1 + i F_2 of a spin: Re((F_1 - i F_2) e_i e_j ...) with e = (1, i).
template <class Number>
Tensor<Number> tensor_of_spin(int spin, const Number& first, const Number& second) {
    Tensor<Number> result{spin, {}};
    for (unsigned n = 0; n < (1u << static_cast<unsigned>(spin)); ++n) {
        const int turns = std::popcount(n);
        result.at.push_back(turns % 2 == 0 ? first : second);
        if (turns > 1) result.at.back() = -1.0 * result.at.back();
    }
    return result;
}

/// Evaluates trees in a world of numbers: World has constant(value), component(index), slope(number, axis) and
/// mapped(number, function, its derivative).
template <class Number, class World>
class Evaluation {
public:
    explicit Evaluation(const World& the_world) : world(the_world) {}

    Tensor<Number> of(const Tree& t) const {
        using Kind = Tree::Kind;
        switch (t.kind) {
            case Kind::number: return {0, {world.constant(t.value)}};
            case Kind::component: return {0, {world.component(t.index)}};
            case Kind::unit: return {1, {world.constant(t.index == 0), world.constant(t.index == 1)}};
            case Kind::field:
                return tensor_of_spin<Number>(t.spin, world.component(t.index),
                                              world.component(t.index + (t.spin > 0 ? 1 : 0)));
            default: break;
        }
        std::vector<Tensor<Number>> parts;
        for (const Tree& part : t.parts) parts.push_back(of(part));
        return t.parts.size() == 1 ? of_one(t, parts[0]) : of_two(t, parts[0], parts[1]);
    }

private:
    Tensor<Number> of_one(const Tree& t, const Tensor<Number>& a) const {
        using Kind = Tree::Kind;
        switch (t.kind) {
            case Kind::grad: return gradient(a);
            case Kind::div: return contracted(gradient(a));
            case Kind::curl: return {0, {Number(world.slope(a.at[1], 0) - world.slope(a.at[0], 1))}};
            case Kind::perp: return tensor_of_spin<Number>(a.rank, -1.0 * a.at[1], a.at[0]);
            case Kind::sym: return symmetric(a);
            case Kind::lap:
                return each(a, [&](const Number& x) -> Number {
                    return world.slope(world.slope(x, 0), 0) + world.slope(world.slope(x, 1), 1);
                });
            case Kind::along_axis: return each(a, [&](const Number& x) { return world.slope(x, t.index); });
            case Kind::negative: return each(a, [](const Number& x) -> Number { return -1.0 * x; });
            case Kind::power: return {0, {power(a.at[0], t.value)}};
            case Kind::norm: return {0, {norm(a)}};
            default: return {0, {function(t.name, a.at[0])}};
        }
    }
    Tensor<Number> of_two(const Tree& t, const Tensor<Number>& a, const Tensor<Number>& b) const {
        using Kind = Tree::Kind;
        switch (t.kind) {
            case Kind::product:
                if (a.rank > 0) return each(a, [&](const Number& x) -> Number { return x * b.at[0]; });
                return each(b, [&](const Number& x) -> Number { return a.at[0] * x; });
            case Kind::quotient: return each(a, [&](const Number& x) -> Number { return x / b.at[0]; });
            case Kind::outer: return outer(a, b);
            case Kind::dot: {  // the last index of a with the first one of b
                Tensor<Number> result{a.rank + b.rank - 2, {}};
                const std::size_t width = b.at.size() / 2;
                for (std::size_t i = 0; i < a.at.size(); i += 2)
                    for (std::size_t j = 0; j < width; ++j)
                        result.at.push_back(a.at[i] * b.at[j] + a.at[i + 1] * b.at[width + j]);
                return result;
            }
            case Kind::double_dot: {
                Number sum = world.constant(0.0);
                for (std::size_t i = 0; i < a.at.size(); ++i) sum = sum + a.at[i] * b.at[i];
                return {0, {sum}};
            }
            default: {
                Tensor<Number> result = a;
                for (std::size_t i = 0; i < a.at.size(); ++i) result.at[i] = a.at[i] + b.at[i];
                return result;
            }
        }
    }

    template <class Body>
    static Tensor<Number> each(const Tensor<Number>& a, Body body) {
        Tensor<Number> result{a.rank, {}};
        for (const Number& x : a.at) result.at.push_back(body(x));
        return result;
    }
    static Tensor<Number> outer(const Tensor<Number>& a, const Tensor<Number>& b) {
        Tensor<Number> result{a.rank + b.rank, {}};
        for (const Number& x : a.at)
            for (const Number& y : b.at) result.at.push_back(x * y);
        return result;
    }
    Tensor<Number> gradient(const Tensor<Number>& a) const {
        Tensor<Number> result{a.rank + 1, {}};
        for (const int axis : {0, 1})
            for (const Number& x : a.at) result.at.push_back(world.slope(x, axis));
        return result;
    }
    /// The trace over the first two indices.
    static Tensor<Number> contracted(const Tensor<Number>& a) {
        Tensor<Number> result{a.rank - 2, {}};
        const std::size_t quarter = a.at.size() / 4;
        for (std::size_t i = 0; i < quarter; ++i) result.at.push_back(a.at[i] + a.at[3 * quarter + i]);
        return result;
    }
    /// The symmetric traceless part: F = 2^(1 - n) sum T_ij... e_i e_j ..., e = (1, i).
    Tensor<Number> symmetric(const Tensor<Number>& a) const {
        Number first = world.constant(0.0), second = world.constant(0.0);
        const double scale = std::pow(2.0, 1 - a.rank);
        for (unsigned n = 0; n < a.at.size(); ++n) {
            const int turns = std::popcount(n) % 4;
            Number& part = turns % 2 == 0 ? first : second;
            part = part + (turns < 2 ? scale : -scale) * a.at[n];
        }
        return tensor_of_spin<Number>(a.rank, first, second);
    }
    Number power(const Number& x, double n) const {
        return world.mapped(
            x, [n](double v) { return std::pow(v, n); }, [n](double v) { return n * std::pow(v, n - 1.0); });
    }
    Number norm(const Tensor<Number>& a) const {
        if (a.rank == 0)
            return world.mapped(
                a.at[0], [](double v) { return std::abs(v); }, [](double v) { return v > 0.0 ? 1.0 : -1.0; });
        return power(a.at[0] * a.at[0] + a.at[1] * a.at[1], 0.5);
    }
    Number function(const std::string& name, const Number& x) const {
        if (name == "sin")
            return world.mapped(
                x, [](double v) { return std::sin(v); }, [](double v) { return std::cos(v); });
        if (name == "cos")
            return world.mapped(
                x, [](double v) { return std::cos(v); }, [](double v) { return -std::sin(v); });
        return world.mapped(
            x, [](double v) { return std::tanh(v); }, [](double v) { return 1.0 / std::pow(std::cosh(v), 2); });
    }

    const World& world;
};

/// Values on a fine grid.  Derivatives are exact for every mode that the grid has.
struct GridWorld {
    using Number = Eigen::ArrayXXd;  // (x, y)
    static constexpr int size = 27;

    double lx = 1.0, ly = 1.0;
    std::vector<Number> components = {};

    Number constant(double value) const { return Number::Constant(size, size, value); }
    Number component(int index) const { return components[static_cast<std::size_t>(index)]; }
    Number slope(const Number& a, int axis) const {
        if (axis == 0) return (differentiation() * a.matrix() * (1.0 / lx)).array();
        return (a.matrix() * differentiation().transpose() * (1.0 / ly)).array();
    }
    template <class Function, class Slope>
    Number mapped(const Number& a, Function function, Slope) const {
        return a.unaryExpr(function);
    }
    /// The coefficient of exp(i q.r) at the mode numbers of q.
    static std::complex<double> mode(const Number& a, int kx, int ky) {
        static const std::vector<std::complex<double>> phases = [] {
            std::vector<std::complex<double>> turns;
            for (int i = 0; i < size; ++i) turns.push_back(std::polar(1.0, -2.0 * std::numbers::pi * i / size));
            return turns;
        }();
        std::complex<double> sum = 0.0;
        for (int j = 0; j < size; ++j)
            for (int i = 0; i < size; ++i)
                sum += a(i, j) * phases[static_cast<std::size_t>((((kx * i + ky * j) % size) + size) % size)];
        return sum / static_cast<double>(size * size);
    }

private:
    /// d/ds on the points of a period 1: each mode times 2 pi i k.
    static const Eigen::MatrixXd& differentiation() {
        static const Eigen::MatrixXd matrix = [] {
            Eigen::MatrixXd d(size, size);
            for (int i = 0; i < size; ++i)
                for (int j = 0; j < size; ++j) {
                    d(i, j) = 0.0;
                    for (int k = 1; k <= size / 2; ++k)
                        d(i, j) -= 4.0 * std::numbers::pi * k / size *
                                   std::sin(2.0 * std::numbers::pi * (k * (i - j) % size) / size);
                }
            return d;
        }();
        return matrix;
    }
};

/// A uniform value and the amplitudes of small waves exp(i q.r), one for each component that deviates.
struct Wave {
    double base = 0.0;
    Eigen::RowVectorXcd slope;

    friend Wave operator+(const Wave& a, const Wave& b) { return {a.base + b.base, a.slope + b.slope}; }
    friend Wave operator-(const Wave& a, const Wave& b) { return {a.base - b.base, a.slope - b.slope}; }
    friend Wave operator*(double a, const Wave& b) { return {a * b.base, a * b.slope}; }
    friend Wave operator*(const Wave& a, const Wave& b) {
        return {a.base * b.base, a.base * b.slope + b.base * a.slope};
    }
    friend Wave operator/(const Wave& a, const Wave& b) {
        return {a.base / b.base, (a.slope - (a.base / b.base) * b.slope) / b.base};
    }
};

/// First-order perturbations of a uniform state.
struct WaveWorld {
    using Number = Wave;

    std::vector<double> state;
    double qx = 0.0, qy = 0.0;

    Eigen::Index count() const { return static_cast<Eigen::Index>(state.size()); }
    Wave constant(double value) const { return {value, Eigen::RowVectorXcd::Zero(count())}; }
    Wave component(int index) const {
        Wave result = constant(state[static_cast<std::size_t>(index)]);
        result.slope(index) = 1.0;
        return result;
    }
    Wave slope(const Wave& a, int axis) const {
        return {0.0, std::complex<double>(0.0, axis == 0 ? qx : qy) * a.slope};
    }
    template <class Function, class Slope>
    Wave mapped(const Wave& a, Function function, Slope slope_of) const {
        return {function(a.base), slope_of(a.base) * a.slope};
    }
};

}  // namespace drover::model
