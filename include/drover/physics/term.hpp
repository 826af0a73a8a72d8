// physics/term.hpp: one term of the equations: its exact linearisation, its isotropic linear part, its action.
//
// The propagator integrates only the isotropic linear part about a state at rest.  The action is the term minus that
// part, so their sum is always the complete term, whatever its symmetry or order in q.
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

/// The inputs of a term at grid points: fields, their derivatives, position and time.  Each except position and time
/// costs a transform.
struct Input {
    enum Value : int {
        bead_density,
        rod_density,
        bead_velocity_x,
        bead_velocity_y,
        polar_order_x,
        polar_order_y,
        d_x,                            ///< d/dx of the six fields, in the same order
        d_y = d_x + 6,                  ///< d/dy of the six fields
        laplacian = d_y + 6,            ///< lap of the six fields
        velocity_curl = laplacian + 6,  ///< d_x v_y - d_y v_x
        order_curl,                     ///< d_x p_y - d_y p_x
        velocity_divergence,
        order_divergence,
        velocity_grad_div,                       ///< d_x and d_y of div v
        order_grad_div = velocity_grad_div + 2,  ///< of div p
        x = order_grad_div + 2,                  ///< position and time
        y,
        t,
        count
    };
};
constexpr std::uint64_t reads(int input) { return std::uint64_t{1} << input; }
inline constexpr std::uint64_t reads_velocity = reads(Input::bead_velocity_x) | reads(Input::bead_velocity_y),
                               reads_order = reads(Input::polar_order_x) | reads(Input::polar_order_y),
                               reads_position = reads(Input::x) | reads(Input::y) | reads(Input::t);

/// The outputs of a term at grid points; vectors occupy two indices.
struct Output {
    enum Value : int {
        bead_flux,
        rod_flux = bead_flux + 2,  ///< d_t density = -div flux
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

/// Fields at a set of grid points; null if no term reads them.
struct PointFields {
    std::size_t size = 0;
    std::array<const double*, Input::count> values{};  ///< by Input
    VectorStrip<const double> linear_velocity;         ///< slaved: v from the linear part only; dynamic: v
    VectorStrip<const double> linear_force;            ///< force on the beads from the linear part [mg/(mm s^2)]
    double time = 0.0;

    const double* operator[](int input) const { return values[static_cast<std::size_t>(input)]; }
    VectorStrip<const double> vector(int first) const { return {(*this)[first], (*this)[first + 1]}; }
    VectorStrip<const double> velocity() const { return vector(Input::bead_velocity_x); }
    VectorStrip<const double> order() const { return vector(Input::polar_order_x); }
};

/// Rates to which the terms add, at the same points.
struct PointRates {
    std::array<double*, Output::count> values{};  ///< by Output

    double* operator[](int output) const { return values[static_cast<std::size_t>(output)]; }
    VectorStrip<double> vector(int first) const { return {(*this)[first], (*this)[first + 1]}; }
};

/// Cost of evaluating a term at grid points.
struct PointCost {
    std::uint64_t reads = 0;
    unsigned writes = 0;  ///< 0: no evaluation is needed
    int degree = 1;       ///< of its products; a slaved velocity counts as one factor
    bool has_finite_degree = true;
};

/// Fourier coefficients of a vector at one q.
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

/// The part of a term's linearisation about a state at rest that the propagator integrates.
enum class LinearPart {
    isotropic,  ///< all; the linearisation must commute with rotations and reflections (checked)
    averaged,   ///< the average over the directions of q
    none        ///< none; the complete term is evaluated at grid points
};

/// One term.  At most one of `remainder` and `whole` is set.  If neither is set the term is linear, and the part of its
/// linearisation that `linear_part` excludes is applied mode by mode.
struct Term {
    using Act = std::function<void(const CompiledModel&, const Reference&, const PointFields&, const PointRates&)>;

    std::string name;  ///< the key of its coefficient; terms[n] for a text term
    Equation of = Equation::polar_order;
    std::function<bool(const CompiledModel&)> is_active;
    std::function<std::string(const CompiledModel&)> equation;  ///< readable form
    /// Adds the exact linearisation about any uniform state.  Empty for a source, which does not depend on the fields.
    std::function<void(const CompiledModel&, const UniformPoint& about, const numerics::Wavevector& q, Symbol&)>
        linearise;
    LinearPart linear_part = LinearPart::isotropic;
    int degree_in_q = 2;  ///< degree of the linearisation as a polynomial in q, at most 4; -1: not a polynomial
    /// Cost of the action at points; `pointwise_velocity`: a slaved velocity is a nonlinear function of the fields.
    std::function<PointCost(const CompiledModel&, bool pointwise_velocity)> cost;
    /// Adds the term minus its isotropic linear part about the reference; must not allocate memory.
    Act remainder;
    Act whole;  ///< adds the complete term; the solver subtracts the linear part
    /// Fourier coefficients of a source in a vector equation; a uniform source is nonzero only at q = 0.
    std::function<VectorMode(const CompiledModel&, const numerics::Grid&, double t, const numerics::Wavevector& q)>
        source;
    bool source_is_uniform = false;
    bool is_uniform_in_space = true;    ///< false: the term depends on x, y or t, so no uniform state satisfies it
    bool closed_uniform_states = true;  ///< false: the uniform states differ from those of the built-in equations
};

/// The terms of the rod-bead equations, in the order of the equations.
const std::vector<Term>& built_in_terms();

}  // namespace drover::physics
