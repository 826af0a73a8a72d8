// tests/physics/symbols.hpp: linearisations and rates of uniform states as matrices and vectors of all fields.
#pragma once
#include "structure.hpp"

namespace drover::physics {

/// Sum of the linearisations of the active terms; forces on the beads are not divided by m rho.
inline Symbol force_symbol(const Equations& e, const UniformPoint& about, const numerics::Wavevector& q) {
    const auto at = linearised(e, about);
    return of_all_fields(e, at->whole(q)(at->members(), at->members()), at->members());
}

/// The linearised equations about any uniform state, stationary or not; a slaved velocity is eliminated.
inline Symbol linear_symbol(const Equations& e, const UniformPoint& about, const numerics::Wavevector& q) {
    const auto at = linearised(e, about);
    return of_all_fields(e, at->symbol(q), at->state_components());
}

/// Right-hand sides; forces on the beads are not divided by m rho.
inline Eigen::Matrix<double, FieldIndex::count, 1> uniform_rates(const Equations& e, const UniformPoint& at) {
    const Eigen::VectorXd rates = e.theory().rates(values_of(e, at));
    Eigen::Matrix<double, FieldIndex::count, 1> result = Eigen::Matrix<double, FieldIndex::count, 1>::Zero();
    for (int k = 0; k < FieldIndex::count; ++k)
        if (component(e, k) >= 0) result(k) = rates(component(e, k));
    return result;
}

}  // namespace drover::physics
