// physics/term.hpp: one term of the equations: its exact linearisation, its isotropic linear part, its action.
//
// A term is complete in itself.  The propagator takes the isotropic linear part about a state at rest, nothing else;
// the action is the whole term less that part, so the two together are always the term, whatever its symmetry or order
// in q.
#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "drover/physics/compiled_model.hpp"

namespace drover::physics {

/// The fields as rows and columns of a Symbol, for every form.
struct FieldIndex {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        count
    };
};

/// d/dt of small deviations ~ exp(i q.r) from a uniform state: rates = symbol * deviations.  The rows of the velocity
/// hold forces on the beads per area [mg/(mm s^2)], not divided by m rho.
using Symbol = Eigen::Matrix<std::complex<double>, FieldIndex::count, FieldIndex::count>;

/// The uniform state about which the exact linear part is taken: its densities, the beads at rest, no order.
struct Reference {
    double bead_density = 1.0, rod_density = 1.0;
};
inline Reference reference(const UniformState& uniform) {
    return {.bead_density = uniform.bead_density, .rod_density = uniform.rod_density};
}

/// A uniform state.
struct UniformPoint {
    double bead_density = 1.0, rod_density = 1.0;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero(), order = Eigen::Vector2d::Zero();
};
inline UniformPoint at_rest(const Reference& densities) {
    return {.bead_density = densities.bead_density, .rod_density = densities.rod_density};
}

/// What a term reads at points of the grid: fields, derivatives of them, the point itself.  Each but the point costs a
/// transform.
struct Input {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        d_x,                            ///< d/dx of the six fields, in the same order
        d_y = d_x + 6,                  ///< d/dy of them
        laplacian = d_y + 6,            ///< lap of them
        velocity_curl = laplacian + 6,  ///< d_x v_y - d_y v_x
        order_curl,                     ///< d_x p_y - d_y p_x
        velocity_divergence,
        order_divergence,
        velocity_grad_div,                       ///< d_x and d_y of div v
        order_grad_div = velocity_grad_div + 2,  ///< of div p
        x = order_grad_div + 2,                  ///< the point itself
        y,
        t,
        count
    };
};
constexpr std::uint64_t reads(int input) { return std::uint64_t{1} << input; }
inline constexpr std::uint64_t reads_velocity = reads(Input::bead_velocity_x) | reads(Input::bead_velocity_y),
                               reads_order = reads(Input::polar_order_x) | reads(Input::polar_order_y),
                               reads_position = reads(Input::x) | reads(Input::y) | reads(Input::t);

/// What a term writes there; vectors take two places.
struct Output {
    enum Value : int {
        bead_flux,
        rod_flux = bead_flux + 2,  ///< d_t density = -div of it
        force = rod_flux + 2,      ///< on the beads, per area
        velocity = force + 2,
        order = velocity + 2,  ///< d_t v, d_t p
        velocity_potential = order + 2,
        order_potential,  ///< their gradients are added to d_t v, d_t p
        bead_rate,
        rod_rate,  ///< d_t density
        count
    };
};
constexpr unsigned writes(int output) { return 1u << output; }

template <class Number>
struct VectorStrip {
    Number* x = nullptr;
    Number* y = nullptr;
};

/// Fields at some points of the grid; null where nothing reads them.
struct PointFields {
    std::size_t size = 0;
    std::array<const double*, Input::count> values{};  ///< by Input
    VectorStrip<const double> linear_velocity;         ///< slaved: v by the linear part alone; dynamic: v
    VectorStrip<const double> linear_force;            ///< on the beads, by the linear part [mg/(mm s^2)]
    double time = 0.0;

    const double* operator[](int input) const { return values[static_cast<std::size_t>(input)]; }
    VectorStrip<const double> vector(int first) const { return {(*this)[first], (*this)[first + 1]}; }
    VectorStrip<const double> velocity() const { return vector(Input::bead_velocity_x); }
    VectorStrip<const double> order() const { return vector(Input::polar_order_x); }
};

/// What the terms add there.
struct PointRates {
    std::array<double*, Output::count> values{};  ///< by Output

    double* operator[](int output) const { return values[static_cast<std::size_t>(output)]; }
    VectorStrip<double> vector(int first) const { return {(*this)[first], (*this)[first + 1]}; }
};

/// What evaluating a term at points costs.
struct PointCost {
    std::uint64_t reads = 0;
    unsigned writes = 0;  ///< 0: nothing is to be evaluated
    int degree = 1;       ///< of its products, a slaved velocity counting as one factor
    bool has_finite_degree = true;
};

/// A vector of Fourier coefficients at one q.
struct VectorMode {
    std::complex<double> x = 0.0, y = 0.0;
};

/// The equation to which a term belongs.
enum class Equation {
    bead_density,   ///< d_t rho
    rod_density,    ///< d_t sigma
    bead_velocity,  ///< m rho d_t v: the term is a force on the beads
    acceleration,   ///< d_t v
    polar_order     ///< d_t p
};

/// How much of a term's linearisation about a state at rest goes into the propagator.
enum class LinearPart {
    isotropic,  ///< all of it: it commutes with rotations and reflections (checked)
    averaged,   ///< its average over the directions of q
    none        ///< nothing: the term is evaluated at points as it is
};

/// One term.  Of `remainder` and `whole` at most one is given; with neither the term is linear, and what `linear_part`
/// leaves out is applied mode by mode.
struct Term {
    using Act = std::function<void(const CompiledModel&, const Reference&, const PointFields&, const PointRates&)>;

    std::string name;  ///< the key of its coefficient; terms[n] of a text
    Equation of = Equation::polar_order;
    std::function<bool(const CompiledModel&)> is_active;
    std::function<std::string(const CompiledModel&)> equation;  ///< for people
    /// Adds the exact linearisation about any uniform state.  Empty: a source, which depends on no field.
    std::function<void(const CompiledModel&, const UniformPoint& about, const numerics::Wavevector& q, Symbol&)>
        linearise;
    LinearPart linear_part = LinearPart::isotropic;
    int degree_in_q = 2;  ///< of the linearisation, a polynomial in q of at most fourth degree; -1: it is none
    /// Of the action at points; `pointwise_velocity`: a slaved velocity that is no linear function of the fields.
    std::function<PointCost(const CompiledModel&, bool pointwise_velocity)> cost;
    /// Adds the term less its isotropic linear part about the reference; reads fields, allocates nothing
    Act remainder;
    Act whole;  ///< or adds the whole term; the solver subtracts the linear part
    /// Fourier coefficients of a source of a vector equation; uniform: it has none but at q = 0.
    std::function<VectorMode(const CompiledModel&, const numerics::Grid&, double t, const numerics::Wavevector& q)>
        source;
    bool source_is_uniform = false;
    bool is_uniform_in_space = true;    ///< false: it depends on x, y or t, and no uniform state satisfies it
    bool closed_uniform_states = true;  ///< false: it changes the uniform states from those of the built-in equations
};

/// The terms of the rod-bead equations, in the order of the equations.
const std::vector<Term>& built_in_terms();

}  // namespace drover::physics
