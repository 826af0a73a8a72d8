// physics/terms.hpp: the terms of the rod equations, each with its coefficients and its exact linearisation.
//
//     d_t sigma = -u div p + D lap sigma + conserved noise
//     d_t p     = -a p + K1 grad(div p) + K3 lap p - B grad sigma + noise
//
// sigma: rod density [1/mm^2]; p: polar order density, sigma times the mean orientation [1/mm^2].  Source: Kumar, Soni,
// Ramaswamy & Sood, Nat. Commun. 5, 4688 (2014), eqs. (rodcont) and (polarfull).
#pragma once
#include "drover/base/schema.hpp"
#include "drover/numerics/system.hpp"
#include "drover/physics/form.hpp"

namespace drover::physics {

/// Rods moving along their order: -u div p.
struct RodCurrent {
    double speed = 0.0;  ///< u [mm/s]
};

/// Relaxation of the order: -a p.
struct Relaxation {
    double rate = 1.0;  ///< a [1/s]; < 0: order grows
};

/// Elasticity of the order: K3 lap p + K1 grad(div p).
struct Elasticity {
    double stiffness = 0.0;  ///< K3 [mm^2/s]
    double splay = 0.0;      ///< K1 [mm^2/s]
};

/// Pressure of the rods on the order: -B grad sigma.
struct RodPressure {
    double strength = 0.0;  ///< B [mm/s]
};

/// Diffusion of the rods: D lap sigma.
struct RodDiffusion {
    double diffusivity = 0.0;  ///< D [mm^2/s]
};

/// White noise: <f_i f_j> = Delta delta_ij delta(r - r') delta(t - t') on p; the divergence of such a current on sigma.
struct Noise {
    double order = 0.0;  ///< Delta [1/(mm^2 s)]
    double rods = 0.0;   ///< strength of the conserved noise [1/s]; 2 D sigma is that of independent rods
};

// Each adds its exact linearisation about the uniform isotropic state to the blocks at |q| [1/mm].
void add_linearisation(const RodCurrent& term, const Form& form, double q, numerics::IsotropicBlocks& rates);
void add_linearisation(const Relaxation& term, const Form& form, double q, numerics::IsotropicBlocks& rates);
void add_linearisation(const Elasticity& term, const Form& form, double q, numerics::IsotropicBlocks& rates);
void add_linearisation(const RodPressure& term, const Form& form, double q, numerics::IsotropicBlocks& rates);
void add_linearisation(const RodDiffusion& term, const Form& form, double q, numerics::IsotropicBlocks& rates);

/// Adds the covariance of the noise per unit time and area.
void add_covariance(const Noise& noise, const Form& form, double q, numerics::IsotropicBlocks& covariance);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::RodCurrent>>& schema<physics::RodCurrent>();
template <>
const std::vector<Row<physics::Relaxation>>& schema<physics::Relaxation>();
template <>
const std::vector<Row<physics::Elasticity>>& schema<physics::Elasticity>();
template <>
const std::vector<Row<physics::RodPressure>>& schema<physics::RodPressure>();
template <>
const std::vector<Row<physics::RodDiffusion>>& schema<physics::RodDiffusion>();
template <>
const std::vector<Row<physics::Noise>>& schema<physics::Noise>();
}  // namespace drover
