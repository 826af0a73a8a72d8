// physics/linear_rows.hpp: what the right-hand side needs of the linear parts of the terms, by |q| and by mode.
#pragma once
#include <array>
#include <vector>

#include "drover/physics/equations.hpp"

namespace drover::physics {

/// Rows of the linear parts that give the force on the beads (dynamic) or their velocity (slaved), at one |q|: along q
/// from both densities and the parts of v and p along q; across q from those across.  And what a slaved velocity
/// drives.
struct VelocityRow {
    std::array<double, 4> along{};
    std::array<double, 2> across{};
    double held_along = 1.0, held_across = 1.0;                               ///< slaved: what a force is divided by
    std::complex<double> to_beads, to_rods, to_order_along, to_order_across;  ///< rates for a velocity
};

/// Of the terms that are not evaluated at points as a whole: what they give there is in their action.
VelocityRow velocity_row(const Equations& equations, const Reference& reference, double q);

/// Fourier coefficients of all fields at one q, as rows of a Symbol.
using FieldModes = Eigen::Matrix<std::complex<double>, FieldIndex::count, 1>;

/// The linear parts that are not where the terms are: rates to add mode by mode, as an operator on all fields.
class LinearRemainder {
public:
    LinearRemainder(const Equations& equations, const Reference& reference, const std::vector<double>& wavenumbers);

    /// Terms that are evaluated as a whole have their isotropic part in the propagator too: it is taken away here.
    bool subtracts() const { return !subtracted_.empty(); }
    /// Linear terms that are not isotropic: what the propagator does not have of them.
    bool adds() const { return !anisotropic_.empty(); }

    /// At q, number n of the wavenumbers; rows of the velocity are forces.  added: of linear terms alone.
    Symbol added(const numerics::Wavevector& q) const;
    /// That operator on the fields of a mode; `inverse`: 1/|q|, 0 at q = 0.
    FieldModes subtracted(std::size_t n, const numerics::Wavevector& q, double inverse, const FieldModes& fields) const;

private:
    const Equations& equations_;
    Reference reference_;
    std::vector<const Term*> anisotropic_;
    /// Real in the variables (rho, sigma, i v.q/|q|, i p.q/|q|) along q and i times the parts across.
    struct Blocks {
        std::array<double, 16> along{};
        std::array<double, 4> across{};
    };
    std::vector<Blocks> subtracted_;  // for each |q|
};

}  // namespace drover::physics
