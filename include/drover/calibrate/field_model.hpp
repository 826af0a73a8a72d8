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
/// (For the current p = sigma u P of the paper's Methods it would be powers of sigma u, and J = p; a scene on a table keeps u.)
double power_of_density(const std::string& key);

/// Keys of a model that a table gives, in the order of a scene: "uniform.bead_density", "drag.coefficient".
const std::vector<std::string>& calibrated_keys();

/// A number of the model and what it rests on.
struct FieldNumber {
    Uncertain number;
    Origin origin = Origin::set;
};

/// One of them:
///     rho = Phi_b/(area of a bead), sigma = Phi_r/(area of a rod), J = u sigma P,
///     Gamma = m rho/tau, alpha = (alpha/Gamma) Gamma, eta = [eta/(m rho)] m rho, E, a and lambda as measured; a tau below its error is
///     taken as large as that (and Gamma and alpha are closures then): the flow follows faster than was resolved;
///     K3 = u^2/(16 a), B = u/(2 sigma), Delta = a/sigma: independent rods (closures), D_r being a;
///     b such that the uniform flock has the order of the mean field of rods, see order_of_alignment() in calibrate/alignment.hpp;
///     w, A, F, zeta and K1 zero.
/// The error is of first order in those of the rows, taken as independent (alpha/Gamma and tau, of one assay, are not quite).  Throws an input Error where the table has a hole in what it needs, or does not reach.
FieldNumber field_number(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind);

/// The coefficients that may depend on densities, on all nodes of the table.  The error of alpha/Gamma stands with alpha; Gamma and b have none here.  Rows that
/// depend on beads alone stand at every rod density, and a boundary takes errors of nodes as independent: halfway between two rod densities the part
/// of a and lambda in its band is sqrt(2) too narrow.  find_onset() has no such fault.
physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind);

/// What rods and beads of the same coefficients do together, all being uniform.
struct MeanField {
    Uncertain alignment;             ///< g
    Uncertain effective_relaxation;  ///< abar = a - lambda alpha/Gamma [1/s]
    Uncertain order;  ///< P; its error and that of the flow over whole errors of what they are made of, not by slopes
    Uncertain bead_velocity;  ///< (alpha/Gamma) P [mm/s]
    Uncertain response_time;  ///< tau of the flow, at least its error [s]
};
MeanField mean_field(const Table& table, const StatePoint& point);

}  // namespace drover::calibrate
