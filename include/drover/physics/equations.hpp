// physics/equations.hpp: the equations of a model as a list of terms, and their linearisations.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "drover/physics/term.hpp"

namespace drover::physics {

/// A compiled model with its active terms.
struct Equations : CompiledModel {
    explicit Equations(const Model& model);  ///< throws as check()
    /// Adds further terms.  Throws an input Error if a term contradicts its declaration, see check_linear_part().
    Equations(const Model& model, const std::vector<Term>& further);
    /// Shares the tables of `like` where their data are equal; saves time when many models differ in few values.
    Equations(const Model& model, const Equations& like);

    std::vector<Term> active;  ///< the terms that contribute to the model

private:
    void choose_terms(const std::vector<Term>& further);
};

/// Throws an input Error, with its location, for a model with invalid parameters or text terms.
void check(const Model& model, const LocationOf& location_of = no_location);

/// Readable description of an active term.
struct ActiveTerm {
    std::string name;      ///< the key of its coefficient, or terms[n] for a text term
    std::string equation;  ///< "d_t p: -a p, a = 0.5 1/s"
};
std::vector<ActiveTerm> active_terms(const Equations& equations);

/// Whether a slaved velocity is a nonlinear function of the fields: some force on the beads is evaluated on the grid.
bool has_pointwise_velocity(const Equations& equations);

/// Cost of evaluating a term on the grid; zero if it is linear.  A pointwise velocity counts as two factors in the
/// degree.
PointCost point_cost(const Equations& equations, const Term& term);

/// Sum of the linearisations of the active terms; forces on the beads are not divided by m rho.  Throws an input Error
/// for a term that depends on position or time, because no uniform state satisfies it.
Symbol force_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The linearised equations about any uniform state, stationary or not: rows and columns of absent fields are zero; a
/// slaved velocity is eliminated.
Symbol linear_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// Strengths of the noise at |q|: <f f^H> = noise_symbol delta(t - t') per area.
Symbol noise_symbol(const Equations& equations, double q);

/// The part of the linear symbol about a reference that the propagator integrates, at q along x.
Symbol propagator_symbol(const Equations& equations, const Reference& reference, double q);

/// Right-hand sides of a uniform state, indexed as the rows of a Symbol; forces on the beads are not divided by m rho.
using UniformRates = Eigen::Matrix<double, FieldIndex::count, 1>;
UniformRates uniform_rates(const Equations& equations, const UniformPoint& at);

}  // namespace drover::physics
