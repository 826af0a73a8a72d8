// physics/equations.hpp: the equations of a model as a list of terms, and their linearisations.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "drover/physics/term.hpp"

namespace drover::physics {

/// A model made ready for use.
struct Equations : CompiledModel {
    explicit Equations(const Model& model);  ///< throws as check()
    /// With further terms.  Throws an input Error where one is not what it declares, see check_linear_part().
    Equations(const Model& model, const std::vector<Term>& further);
    /// Shares the tables that `like` has made of the same numbers: for many models that differ in little.
    Equations(const Model& model, const Equations& like);

    std::vector<Term> active;  ///< those with a part in the model

private:
    void choose_terms(const std::vector<Term>& further);
};

/// Throws an input Error, at its location, for a model that cannot be: its numbers and its texts.
void check(const Model& model, const LocationOf& location_of = no_location);

/// A term that has a part in a model, for people.
struct ActiveTerm {
    std::string name;      ///< the key of its coefficient, or terms[n] of a text
    std::string equation;  ///< "d_t p: -a p, a = 0.5 1/s"
};
std::vector<ActiveTerm> active_terms(const Equations& equations);

/// A slaved velocity that is no linear function of the fields: a force on the beads acts at points.
bool has_pointwise_velocity(const Equations& equations);

/// What a term costs at points; nothing when it is linear.  The degree counts a pointwise velocity as two factors.
PointCost point_cost(const Equations& equations, const Term& term);

/// Sum of the linearisations of the active terms; forces on the beads not yet divided by m rho.  Throws an input Error
/// for a term that depends on position or time: no uniform state satisfies it.
Symbol force_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The linearised equations of the form about any uniform state: rows and columns of absent fields are zero, a slaved
/// velocity is eliminated.  Exact for any state, stationary or not.
Symbol linear_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The part of the linear symbol about a reference that the propagator takes, at q along x.
Symbol propagator_symbol(const Equations& equations, const Reference& reference, double q);

/// Right-hand sides of a uniform state, as rows of a Symbol: forces on the beads not divided by m rho.
using UniformRates = Eigen::Matrix<double, FieldIndex::count, 1>;
UniformRates uniform_rates(const Equations& equations, const UniformPoint& at);

}  // namespace drover::physics
