// physics/fluctuations.hpp: stationary fluctuations of the linear theory about any uniform state, by the Lyapunov
// equation.
#pragma once
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/linear_theory.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

/// Equal-time structure factors S = <a_q a_q^H>/area of all fields at one wavevector, indexed as Symbol.  Solves
/// m S + S m^H + Q = 0 by the complex Schur form of m, which also handles defective m.  Throws a run Error if a mode
/// does not decay.
Symbol structure_matrix(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// S(q, omega) = (-i omega - m)^-1 Q (-i omega - m)^-H; its integral over omega/(2 pi) is S(q).  omega [1/s].
Symbol dynamic_structure_matrix(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q,
                                double omega);

/// Structure factors of each stored mode of a grid about a state; order and velocity are resolved along and across q.
/// Zero for modes that are not kept and at q = 0, where densities are conserved and the direction of a flock diffuses.
/// Throws as structure_matrix.
std::vector<StructureFactor> structure_factors(const Equations& equations, const UniformPoint& about,
                                               const numerics::Grid& grid, int degree, Threads& threads);

/// Diffusion of the direction theta of the mean order of a flock, times the area: D area [rad^2 mm^2/s], with
/// <theta^2> = 2 D t after the fast modes have relaxed.  Closed form without field: 2 D area = [Delta +
/// (m rho lambda/Gamma)^2 Delta_v]/(p0 chi)^2.  Zero without a free direction; NaN if long_waves is undefined.
double direction_diffusion(const Equations& equations, const StationaryState& about);

}  // namespace drover::physics
