// physics/coefficients.hpp: the parameters of the rod-bead equations, grouped as the sections of a scene.
//
//     d_t sigma     = -div J + D_sigma lap sigma + noise,    J = u p  or  u sigma p                        (rodcont)
//     d_t rho       = -div(rho v) + D_rho lap rho + noise                                                 (beadcont)
//     m rho d_t v   = -m rho v.grad v [optional] - Gamma v + eta lap v + zeta grad(div v)
//                     + (alpha + alpha_3 |p|^2) p - E grad rho - F grad sigma + force + noise              (beadmom)
//     d_t p         = -w p.grad p - (a - c sigma + b |p|^2) p + K3 lap p + K1 grad(div p) - K4 lap^2 p
//                     + lambda v - A grad rho - B grad sigma - lambda_2 p div p - lambda_3 grad |p|^2
//                     + orienting field + noise                                                            (polarfull)
//
// rho, sigma: densities of beads and rods [1/mm^2]; v: velocity of the beads; p: polar order, either the density sigma
// times the mean orientation (J = u p) or the mean orientation itself (J = u sigma p).  [p] is the unit of p.
// Units, ranges and meanings are defined in physics/coefficient_registry.hpp.
// Source: Kumar, Soni, Ramaswamy & Sood, Nat. Commun. 5, 4688 (2014), Methods; the symbols are theirs.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"

namespace drover::physics {

// The sections of a model.  Keys that end in `_terms` add monomials "c rho^i sigma^j".

struct RodCurrent {
    double speed = 0.0;
    std::string kind = "order";  ///< order: J = u p; density-order: J = u sigma p
};
struct Inertia {
    double bead_mass = 1.0;
    bool advection = false;  ///< include m rho v.grad v
    bool operator==(const Inertia&) const = default;
};
struct Drag {
    double coefficient = 0.0;
    std::vector<std::string> coefficient_terms;
};
struct Viscosity {
    double shear = 0.0, bulk = 0.0;
};
struct Driving {
    double strength = 0.0, cubic = 0.0;
    std::vector<std::string> strength_terms;
};
struct Stiffness {
    double beads = 0.0, rods = 0.0;
};
struct Relaxation {
    double rate = 1.0;
    std::vector<std::string> rate_terms;
    double saturation = 0.0;
    std::vector<std::string> saturation_terms;
    double contact = 0.0;  ///< c: the compiled rate is a - c sigma
};
struct Elasticity {
    double stiffness = 0.0, splay = 0.0, bilaplacian = 0.0;
};
struct Weathercock {
    double strength = 0.0;
    std::vector<std::string> strength_terms;
    /// mean: lambda in the equations; single-rod: lambda_s in dn/dt = lambda_s (1 - nn).v, as measured on a single
    /// rod.  The average over rod directions gives lambda = lambda_s/2.
    std::string convention = "mean";
};
struct SelfAdvection {
    double strength = 0.0, divergence = 0.0, gradient = 0.0;
};
struct Pressure {
    double beads = 0.0, rods = 0.0;
};
struct Diffusion {
    double beads = 0.0, rods = 0.0;
};
struct Noise {
    double order = 0.0, velocity = 0.0, rods = 0.0, beads = 0.0;
};

/// Whether any strength is not zero.
bool has_noise(const Noise& noise);

/// lambda_s/lambda: in two dimensions the average of (1 - nn).v over rod directions is v/2.
inline constexpr double single_rod_factor = 2.0;

/// An external force on the beads: uniform, or at a fixed or moving point.
struct BodyForce {
    std::string kind = "none";                  ///< none, uniform or point
    double x = 0.0, y = 0.0;                    ///< uniform: force per area [mg/(mm s^2)]; point: force [mg mm/s^2]
    double at_x = 0.0, at_y = 0.0;              ///< point: its position at t = 0 [mm]
    double velocity_x = 0.0, velocity_y = 0.0;  ///< point: its velocity [mm/s]
    double width = 0.0;  ///< point: standard deviation of its Gaussian profile [mm]; 0: band-limited delta function
    bool operator==(const BodyForce&) const = default;
};

/// A field that orients rods: d_t p = ... + h.
struct OrientingField {
    double x = 0.0, y = 0.0;  ///< [[p]/s]
    bool operator==(const OrientingField&) const = default;
};

/// What the equations leave out.
struct Approximation {
    bool quasi_linear = false;        ///< short waves change the long ones and are changed by them, not by each other
    double quasi_linear_above = 0.0;  ///< the largest |q| of a long wave [1/mm]; 0: only the means are long
};

/// Values of one coefficient at the nodes of a table, [bead][rod], rods fastest; standard errors may be empty.
struct TableColumn {
    std::vector<double> values, errors;
};

/// Measured coefficients on a mesh of densities.  A column replaces the coefficient of the same key.
struct TableData {
    std::vector<double> bead_density, rod_density;  ///< the nodes, ascending; empty: no dependence
    std::map<std::string, TableColumn> columns;     ///< by key of the coefficient, "relaxation.rate"
    std::string outside = "refuse";                 ///< treatment of densities beyond the nodes: refuse or hold

    /// The column of a key; empty if the table has no such column.
    const TableColumn& column(const std::string& key) const;
    bool has_values() const;
};

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::BodyForce>>& schema<physics::BodyForce>();
template <>
const std::vector<Row<physics::OrientingField>>& schema<physics::OrientingField>();
template <>
const std::vector<Row<physics::Approximation>>& schema<physics::Approximation>();
}  // namespace drover
