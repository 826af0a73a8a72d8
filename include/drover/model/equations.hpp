// model/equations.hpp: the equations of a model: their linearisations, their noise, and what a solver evaluates.
#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/model.hpp"
#include "drover/model/symbol.hpp"
#include "drover/numerics/grid.hpp"
#include "drover/numerics/system.hpp"

namespace drover::model {

struct CompiledEquations;  // src/model/compiled.hpp

class ExplicitPart;  // model/explicit_part.hpp

/// Copies share the equations; one that was moved from can only be assigned to or destroyed.
class Equations {
public:
    /// Throws an input Error, at its column, for a name, rank or parity that does not fit, and for a GivenFunction
    /// that is not complete.
    explicit Equations(const Model& model);

    const Model& model() const;
    /// All components, of fields with a rate and of fields in balance.
    int components() const;
    /// The components that are integrated: those of fields with a rate, in the order of the fields.
    const std::vector<int>& state_components() const;
    const std::vector<TermSummary>& terms() const;

    /// The first term that depends on position or time, so that no uniform state satisfies it; nullptr without one.
    const TermSummary* placed_term() const;
    /// The first noise of this kind.
    const TermSummary* placed_noise() const;

    /// All fields at their reference: the state about which the linear part is exact, unless about() gave another.
    UniformState reference() const;
    /// The same equations with the linear part about this state of all components.  Throws an input Error for a state
    /// of another size or with values that are not finite, as all that take a uniform state.
    Equations about(const UniformState& state) const;
    /// The same with one term of a field with a rate, by its number in terms(), and with all balances; without noise.
    /// Throws an input Error for a number that no term has, as all that take one.
    Equations only(std::size_t term) const;
    /// A uniform state with the values of fields in balance that follow from the others.  Throws as uniform_rates.
    UniformState completed(const UniformState& at) const;
    /// Rates of a uniform state; its values of fields in balance are replaced by those that follow from the others.
    /// factors: of each term; empty: 1.
    /// Throws an input Error for a state of another size, and for another number of factors than of terms.
    Eigen::VectorXd uniform_rates(const UniformState& at, const std::vector<double>& factors = {}) const;
    /// For each component the sum of the absolute values of its terms in a uniform state: rounding is relative to it.
    Eigen::VectorXd uniform_rate_sizes(const UniformState& at) const;
    /// The linearisation about any uniform state.  Fields in balance are eliminated: their rows and columns are zero.
    /// LinearisedAt is faster for many q.
    /// Throws an input Error for a term that depends on position or time.
    Symbol symbol(const UniformState& about, const numerics::Wavevector& q) const;
    /// The mass of a field in a uniform state, at x = y = t = 0; 1 unless it varies.  Throws an input Error for a
    /// number that no field has, as latex().
    double varying_mass(std::size_t field, const UniformState& at) const;
    /// Whether a term that does not depend on position or time has a finite derivative in a uniform state.
    bool has_derivative(std::size_t term, const UniformState& at) const;
    /// Whether the linearisation of a term about the references exists, and commutes with turns and reflections.
    bool is_isotropic(std::size_t term) const;
    /// What one term contributes, without elimination.
    Symbol term_symbol(std::size_t term, const UniformState& about, const numerics::Wavevector& q) const;
    /// Strengths of the noise of all components at q in a uniform state: <f f^H> = noise delta(t - t') per area,
    /// Hermitian.
    Symbol noise(const UniformState& about, const numerics::Wavevector& q) const;
    bool has_noise() const;
    /// Whether the strength of some noise depends on fields, position or time.
    bool has_product_noise() const;
    /// The summands of equations that are noise alone; they are not among terms().
    const std::vector<TermSummary>& noise_terms() const;

    /// Whether anything is left to the explicit part, so that steps have an error.
    bool has_explicit_part() const;
    /// The same, or sources: N is not zero.
    bool has_nonlinear_part() const;
    /// Degree of the products that are evaluated at points; 1 if there are none.
    int degree() const;
    bool has_finite_degree() const;  ///< false: some are no polynomials, and count as products of two

    /// L, N and Q on a grid.  N keeps what it needs of these equations.  kept_degree: the degree that decides which
    /// modes are kept; 0: that of the products.  part (for drover itself): what evaluates N;
    /// nullptr where N is 0.
    numerics::System system(const numerics::Grid& grid, Threads& threads, int kept_degree = 0,
                            std::shared_ptr<ExplicitPart>* part = nullptr) const;
    /// Without N: see ExplicitPart.
    numerics::System linear_system(const numerics::Grid& grid, int kept_degree = 0) const;
    TransformCount transforms() const;
    /// The largest |s|, in 1/time, of the linear part about the reference that `system` leaves to N, at time t: of
    /// terms that name an axis or depend on position or time.  A step of dt needs dt times it below about 1.  Searched
    /// on at most 32 by 63 of the kept modes and 8 by 8 positions, with the coefficients of a position everywhere.
    double explicit_rate(const numerics::Grid& grid, double t = 0.0) const;
    /// The fraction of slow changes about a uniform state of all components that an exponential step of dt reproduces;
    /// the smallest over some kept modes.  Far below 1 where the exact linear part, taken about another state, is fast
    /// and N nearly cancels it: the fields then do not move, for steps of dt and of dt/2 alike.  1 where a term depends
    /// on position or time, or has no derivative there.
    double part_of_slow_change(const UniformState& at, const numerics::Grid& grid, double dt) const;

    /// The equation of a field as LaTeX: "\\partial_t \\phi = ...".
    std::string latex(std::size_t field) const;

private:
    friend class LinearisedAt;  // model/linearised_at.hpp
    friend class ExplicitPart;  // model/explicit_part.hpp
    friend class EnergyMeter;   // model/energy.hpp
    explicit Equations(std::shared_ptr<const CompiledEquations> compiled) : compiled_(std::move(compiled)) {}
    std::shared_ptr<const CompiledEquations> compiled_;
};

}  // namespace drover::model
