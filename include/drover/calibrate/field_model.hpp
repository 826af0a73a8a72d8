// calibrate/field_model.hpp: from a table at two area fractions to the numbers of the equations, and what their mean field expects.
#pragma once
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/physics/model.hpp"

namespace drover::calibrate {

/// A state of a table.
struct StatePoint {
    double bead_fraction = 0.0, rod_fraction = 0.0;
    std::size_t varied = 0;
    physics::Outside outside = physics::Outside::refuse;
};

/// What p is in the equations: the mean orientation P of the rods, with J = u sigma P; or sigma P, with J = u p.
enum class OrderKind { orientation, density };

/// The power of sigma by which a coefficient is multiplied when p goes over from P to sigma P: -1 of driving.strength, 1 of weathercock.strength.
/// With u = 1 in J = u p, p is the current sigma u P of the paper's Methods: powers of sigma u then.
double power_of_density(const std::string& key);

/// Keys of a model that a table gives, in the order of a scene: "uniform.bead_density", "drag.coefficient".
const std::vector<std::string>& calibrated_keys();

struct FieldNumber {
    Uncertain number;
    Origin origin = Origin::set;
};

/// One of them:
///     rho = Phi_b/(area of a bead), sigma = Phi_r/(area of a rod), J = u sigma P,
///     Gamma = m rho/tau, alpha = (alpha/Gamma) Gamma, eta = [eta/(m rho)] m rho, E, a and lambda as measured,
///     K3 = u^2/(16 a), B = u/(2 sigma), Delta = a/sigma: independent rods (closures), D_r being a;
///     b such that the uniform flock has the order of the mean field of rods, see order_of_alignment();
///     w, A, F, zeta and K1 zero.
/// The error is of first order in those of the assays.  Throws an input Error where the table has a hole in what it needs, or does not reach.
FieldNumber field_number(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind);

/// The coefficients that may depend on densities, on all nodes of the table.  The error of alpha/Gamma stands with alpha; Gamma itself has none here.
physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind);

/// P of rods in the flow that they make: P = I1(gP)/I0(gP), g = lambda_s alpha/(Gamma D_r); 0 up to g = 2.
/// Source: the stationary f ~ exp(g P cos theta) of rods with rotational diffusion, as for any such mean field.
double order_of_alignment(double alignment);

/// b/D_r for p = P: (g/2 - 1)/P^2, which makes a - lambda alpha/Gamma + b P^2 = 0 at that P; g^2/8 at and below onset, its limit.
double saturation_of_alignment(double alignment);

/// What rods and beads of the same coefficients do together, all being uniform.
struct MeanField {
    Uncertain alignment;             ///< g
    Uncertain effective_relaxation;  ///< abar = a - lambda alpha/Gamma [1/s]
    Uncertain order;                 ///< P
    Uncertain bead_velocity;         ///< (alpha/Gamma) P [mm/s]
    Uncertain response_time;         ///< tau of the flow [s]
};
MeanField mean_field(const Table& table, const StatePoint& point);

}  // namespace drover::calibrate
