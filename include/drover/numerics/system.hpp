// numerics/system.hpp: what a model hands to a time stepper: L, N, Q, and nothing else.
#pragma once
#include <functional>

#include "drover/numerics/block.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// An isotropic linear operator at one |q|.  Along q: the scalars, then i times the part of each vector along q.
/// Across q: i times the part of each vector along q rotated by +90 degrees.  In these variables the blocks are real.
/// At q = 0 both are used, without the i: "along" is x, "across" is y.
struct IsotropicBlocks {
    Block along;   ///< size scalars + vectors
    Block across;  ///< size vectors
};

/// A system of fields: da/dt = L a + N(t, a) + noise.
struct System {
    Grid grid;
    Layout layout;
    /// L at |q| [1/mm]: rates [1/s].  Smooth in q; even and odd powers as the parities of the fields require.
    std::function<IsotropicBlocks(double q)> linear;
    /// N: writes all of `rate`, never `state`.  Empty: the system is linear.
    std::function<void(double t, const Spectra& state, Spectra& rate)> nonlinear;
    /// Called by a stepper with its dt before each step: where N is stiff it may depend on dt, and must converge with
    /// it.  Empty: N does not depend on dt.
    std::function<void(double dt)> set_step = {};
    /// Q at |q|: <f_q(t) f_q'(t')^H> = Q delta(t - t') delta_qq' / area, symmetric.  Empty: no noise.
    std::function<IsotropicBlocks(double q)> noise;
    /// Degree of the highest product in N: modes |k| >= N/(degree + 1) on an axis are zero.  1 when linear.
    int degree = 1;
};

}  // namespace drover::numerics
