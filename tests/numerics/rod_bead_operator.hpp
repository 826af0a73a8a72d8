// tests/numerics/rod_bead_operator.hpp: the linear operator of rods and beads with inertia, all six fields, for tests
// of blocks.
#pragma once
#include "drover/numerics/system.hpp"

namespace drover::test {

/// Coefficients of  m rho d_t v = -Gamma v + eta lap v + zeta grad div v + alpha p - E grad rho - F grad sigma,
/// d_t p = -a p + K1 grad div p + K3 lap p + lambda v - A grad rho - B grad sigma, about rho0 and p = 0.
struct RodBeadCoefficients {
    double rho0 = 1.3, drag = 20.0, eta = 2.0, zeta = 0.7, alpha = 8.0, bead_pressure = 40.0, rod_pressure = 11.0;
    double decay = 0.9, splay = 0.6, stiffness = 1.1, weathercock = 1.5, order_beads = 0.8, order_rods = 1.2,
           speed = 1.0;
};

/// Along q: rho, sigma, i v.q/|q|, i p.q/|q|; across: i v, i p along q turned by 90 degrees.
inline numerics::IsotropicBlocks rod_bead_operator(const RodBeadCoefficients& c, double q) {
    numerics::IsotropicBlocks m{numerics::Block(4), numerics::Block(2)};
    m.even(0, 2) = -c.rho0 * q;
    m.even(1, 3) = -c.speed * q;
    m.even(2, 0) = c.bead_pressure * q / c.rho0;
    m.even(2, 1) = c.rod_pressure * q / c.rho0;
    m.even(2, 2) = -(c.drag + (c.eta + c.zeta) * q * q) / c.rho0;
    m.even(2, 3) = c.alpha / c.rho0;
    m.even(3, 0) = c.order_beads * q;
    m.even(3, 1) = c.order_rods * q;
    m.even(3, 2) = c.weathercock;
    m.even(3, 3) = -(c.decay + (c.splay + c.stiffness) * q * q);
    m.odd(0, 0) = -(c.drag + c.eta * q * q) / c.rho0;
    m.odd(0, 1) = c.alpha / c.rho0;
    m.odd(1, 0) = c.weathercock;
    m.odd(1, 1) = -(c.decay + c.stiffness * q * q);
    return m;
}

}  // namespace drover::test
