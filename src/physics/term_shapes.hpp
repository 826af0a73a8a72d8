// physics/term_shapes.hpp: the shapes that terms have: linear operators, coefficients times a vector, products.
#pragma once
#include <algorithm>
#include <array>
#include <span>

#include "drover/physics/term.hpp"

namespace drover::physics {

// The fields, as rows and columns of a Symbol.
inline constexpr int rho = FieldIndex::bead_density, sigma = FieldIndex::rod_density, v_x = FieldIndex::bead_velocity_x,
                     v_y = FieldIndex::bead_velocity_y, p_x = FieldIndex::polar_order_x,
                     p_y = FieldIndex::polar_order_y;
inline constexpr std::complex<double> i_unit{0.0, 1.0};

// ---- linear operators: each adds constant * operator to a symbol

using Operator = void (*)(double constant, const numerics::Wavevector& q, Symbol& m);

template <int Density>
void laplacian(double constant, const numerics::Wavevector& q, Symbol& m) {
    m(Density, Density) -= constant * (q.x * q.x + q.y * q.y);
}
template <int Vector>
void vector_laplacian(double constant, const numerics::Wavevector& q, Symbol& m) {
    const double decay = constant * (q.x * q.x + q.y * q.y);
    m(Vector, Vector) -= decay;
    m(Vector + 1, Vector + 1) -= decay;
}
template <int Vector>
void gradient_of_divergence(double constant, const numerics::Wavevector& q, Symbol& m) {
    const std::array<double, 2> k{q.x, q.y};
    for (std::size_t i = 0; i < 2; ++i)
        for (std::size_t j = 0; j < 2; ++j)
            m(Vector + static_cast<int>(i), Vector + static_cast<int>(j)) -= constant * k[i] * k[j];
}
template <int Density, int Vector>
void minus_gradient(double constant, const numerics::Wavevector& q, Symbol& m) {
    m(Vector, Density) -= i_unit * constant * q.x;
    m(Vector + 1, Density) -= i_unit * constant * q.y;
}

// ---- parts of linearisations and actions

inline void add_diagonal(std::complex<double> factor, int row, int column, Symbol& m) {
    m(row, column) += factor;
    m(row + 1, column + 1) += factor;
}

/// In the columns of the densities, the slopes of a coefficient times sign * vector.
void add_slopes(const Dependence& coefficient, const Eigen::Vector2d& vector, double sign, int row, Symbol& m);

/// -strength v.grad v = -strength [grad v^2/2 + curl v (z x v)].
void add_self_advection(double strength, const VectorStrip<const double>& v, const double* curl, std::size_t size,
                        const VectorStrip<double>& rate, double* potential);

/// Whether an input is the bead velocity or a derivative of it.
bool is_of_velocity(int input);

/// The densities that a coefficient depends on, as inputs.
std::uint64_t reads_of(const Coefficient& coefficient);

/// body(i) at each of some points, several at once: the arrays that it writes must not overlap others.
template <class Body>
void for_points(std::size_t size, Body body) {
#pragma GCC ivdep
    for (std::size_t i = 0; i < size; ++i) body(i);
}

/// body(i, value of the coefficient less a reference) at every point.
template <class Body>
void for_coefficient(const Coefficient& c, double reference_value, const PointFields& f, Body body) {
    constexpr std::size_t max_strip = 256;
    std::array<double, max_strip> values;
    const double *beads = f[Input::bead_density], *rods = f[Input::rod_density];
    for (std::size_t begin = 0; begin < f.size; begin += max_strip) {
        const std::size_t count = std::min(max_strip, f.size - begin);
        c.evaluate(beads ? beads + begin : nullptr, rods ? rods + begin : nullptr, reference_value,
                   std::span(values.data(), count));
        for_points(count, [&](std::size_t i) { body(begin + i, values[i]); });
    }
}

// ---- shapes of terms.  `equation` names the equation and the term, "d_t p: -a p"; `key` its coefficient.

/// constant * operator.
Term linear(const char* equation, const char* key, Operator operation);

/// sign * coefficient(rho, sigma) * vector, in the equation of another vector.
Term proportional(const char* equation, const char* key, double sign, int vector, int row);

/// constant * a product of fields without isotropic linear part.
using ProductSymbol = void (*)(double constant, const UniformPoint& about, const numerics::Wavevector& q, Symbol& m);
using ProductAction = void (*)(double constant, const PointFields& fields, const PointRates& rates);
Term product(const char* equation, const char* key, const PointCost& cost, ProductSymbol symbol, ProductAction action);

}  // namespace drover::physics
