// physics/terms.hpp: the coefficients of the terms of the rod-bead equations, as a scene says them.
//
//     d_t sigma     = -div J + D_sigma lap sigma + noise,    J = u p  or  u sigma p                        (rodcont)
//     d_t rho       = -div(rho v) + D_rho lap rho + noise                                                 (beadcont)
//     m rho d_t v   = -m rho v.grad v [optional] - Gamma v + eta lap v + zeta grad(div v) + alpha p
//                     - E grad rho - F grad sigma + force                                                  (beadmom)
//     d_t p         = -w p.grad p - (a + b |p|^2) p + K3 lap p + K1 grad(div p) + lambda v
//                     - A grad rho - B grad sigma + orienting field + noise                                (polarfull)
//
// rho, sigma: densities of beads and rods [1/mm^2]; v: velocity of the beads; p: polar order, either the density sigma
// times the mean orientation (J = u p) or the mean orientation itself (J = u sigma p).  [p] stands for its unit below.
// a, b, Gamma, alpha, lambda may depend on both densities: what ends in `_terms` adds monomials "c rho^i sigma^j".
// Source: Kumar, Soni, Ramaswamy & Sood, Nat. Commun. 5, 4688 (2014), Methods; the names are theirs.
#pragma once
#include <string>
#include <vector>

#include "drover/base/schema.hpp"

namespace drover::physics {

/// Rods moving along their order: -div J.
struct RodCurrent {
    double speed = 0.0;          ///< u [mm/s]
    std::string kind = "order";  ///< order: J = u p; density-order: J = u sigma p
};

/// What the force on the beads has to move.
struct Inertia {
    double bead_mass = 1.0;  ///< m [mg]
    bool advection = false;  ///< with m rho v.grad v
};

/// Friction of the beads with the plate: -Gamma v.
struct Drag {
    double coefficient = 0.0;                    ///< Gamma [mg/(mm^2 s)]
    std::vector<std::string> coefficient_terms;  ///< its dependence on the densities
};

/// Viscosity of the beads: eta lap v + zeta grad(div v).
struct Viscosity {
    double shear = 0.0;  ///< eta [mg/s]
    double bulk = 0.0;   ///< zeta [mg/s]
};

/// Rods driving beads: alpha p.
struct Driving {
    double strength = 0.0;                    ///< alpha [mg/(mm s^2)/[p]]
    std::vector<std::string> strength_terms;  ///< its dependence on the densities
};

/// Pressure on the beads: -E grad rho - F grad sigma.
struct Stiffness {
    double beads = 0.0;  ///< E [mg mm^2/s^2]
    double rods = 0.0;   ///< F [mg mm^2/s^2]
};

/// Relaxation of the order: -(a + b |p|^2) p.
struct Relaxation {
    double rate = 1.0;                          ///< a [1/s]; < 0: order grows
    std::vector<std::string> rate_terms;        ///< its dependence on the densities
    double saturation = 0.0;                    ///< b [1/s/[p]^2] >= 0
    std::vector<std::string> saturation_terms;  ///< its dependence on the densities
};

/// Elasticity of the order: K3 lap p + K1 grad(div p).
struct Elasticity {
    double stiffness = 0.0;  ///< K3 [mm^2/s]
    double splay = 0.0;      ///< K1 [mm^2/s]
};

/// Beads turning rods like weathercocks: lambda v.
struct Weathercock {
    double strength = 0.0;                    ///< lambda [[p]/mm], or lambda_s, as `convention` says
    std::vector<std::string> strength_terms;  ///< its dependence on the densities
    /// mean: lambda of the equations; single-rod: lambda_s of one rod, dn/dt = lambda_s (1 - nn).v, as an assay of one rod measures it;
    /// averaged over directions lambda = lambda_s/2.
    std::string convention = "mean";
};

/// Order carried by itself: -w p.grad p.
struct SelfAdvection {
    double strength = 0.0;  ///< w [mm/s/[p]]
};

/// Rods turning away from crowded places: -A grad rho - B grad sigma.
struct Pressure {
    double beads = 0.0;  ///< A [[p] mm^3/s]
    double rods = 0.0;   ///< B [[p] mm^3/s]
};

/// Diffusion of the densities: D_sigma lap sigma, D_rho lap rho.
struct Diffusion {
    double beads = 0.0;  ///< D_rho [mm^2/s]
    double rods = 0.0;   ///< D_sigma [mm^2/s]
};

/// White noise: <f_i f_j> = Delta delta_ij delta(r - r') delta(t - t') on p; the divergence of such a current on each density.
struct Noise {
    double order = 0.0;  ///< Delta [[p]^2 mm^2/s]
    double rods = 0.0;   ///< conserved noise on sigma [1/s]; 2 D_sigma sigma is that of independent rods
    double beads = 0.0;  ///< conserved noise on rho [1/s]
};

/// A force on the beads from outside: uniform, or at a point that may move.
struct BodyForce {
    std::string kind = "none";                  ///< none, uniform or point
    double x = 0.0, y = 0.0;                    ///< uniform: force per area [mg/(mm s^2)]; point: force [mg mm/s^2]
    double at_x = 0.0, at_y = 0.0;              ///< point: where it stands at t = 0 [mm]
    double velocity_x = 0.0, velocity_y = 0.0;  ///< point: how it moves [mm/s]
    double width = 0.0;  ///< point: standard deviation of the Gaussian it is spread over [mm]; 0: band-limited
};

/// A field that orients rods: d_t p = ... + h.
struct OrientingField {
    double x = 0.0, y = 0.0;  ///< [[p]/s]
};

/// Measured coefficients on a mesh of densities: a list that is given takes the place of its coefficient.
struct TableData {
    std::vector<double> bead_density, rod_density;  ///< the nodes, ascending; empty: no dependence
    std::vector<double> relaxation_rate, relaxation_saturation, drag_coefficient, driving_strength,
        weathercock_strength;  ///< [bead][rod], rods fastest
    std::vector<double> relaxation_rate_error, relaxation_saturation_error, drag_coefficient_error,
        driving_strength_error,
        weathercock_strength_error;  ///< standard errors of the same, for phase boundaries; empty: none known
    std::string outside = "refuse";  ///< refuse or hold: what to do beyond the nodes
};

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::RodCurrent>>& schema<physics::RodCurrent>();
template <>
const std::vector<Row<physics::Inertia>>& schema<physics::Inertia>();
template <>
const std::vector<Row<physics::Drag>>& schema<physics::Drag>();
template <>
const std::vector<Row<physics::Viscosity>>& schema<physics::Viscosity>();
template <>
const std::vector<Row<physics::Driving>>& schema<physics::Driving>();
template <>
const std::vector<Row<physics::Stiffness>>& schema<physics::Stiffness>();
template <>
const std::vector<Row<physics::Relaxation>>& schema<physics::Relaxation>();
template <>
const std::vector<Row<physics::Elasticity>>& schema<physics::Elasticity>();
template <>
const std::vector<Row<physics::Weathercock>>& schema<physics::Weathercock>();
template <>
const std::vector<Row<physics::SelfAdvection>>& schema<physics::SelfAdvection>();
template <>
const std::vector<Row<physics::Pressure>>& schema<physics::Pressure>();
template <>
const std::vector<Row<physics::Diffusion>>& schema<physics::Diffusion>();
template <>
const std::vector<Row<physics::Noise>>& schema<physics::Noise>();
template <>
const std::vector<Row<physics::BodyForce>>& schema<physics::BodyForce>();
template <>
const std::vector<Row<physics::OrientingField>>& schema<physics::OrientingField>();
template <>
const std::vector<Row<physics::TableData>>& schema<physics::TableData>();
}  // namespace drover
