// numerics/system.hpp: what a model hands to a time stepper: L, N, Q, and nothing else.
#pragma once
#include <functional>
#include <memory>

#include "drover/numerics/block.hpp"
#include "drover/numerics/field.hpp"

namespace drover::numerics {

/// An isotropic linear operator at one |q|, in the variables that turn with q.  Where q has the angle theta, a field of
/// spin m has the parts
///     along:   i^m ( cos(m theta) F_1 + sin(m theta) F_2)
///     across:  i^m (-sin(m theta) F_1 + cos(m theta) F_2);
/// a scalar is one part, itself.  In these variables the operator is real and depends on |q| alone.  The reflection
/// about q keeps the even parts and changes the sign of the odd ones (block_parts): only chiral operators couple them.
/// At q = 0 theta is 0, and the factor i^m is left out: along is F_1, across is F_2; only fields of equal spin are
/// coupled, and the factors of L cancel.
struct IsotropicBlocks {
    Block even;
    Block odd;  ///< of a chiral layout: without rows
};

/// The blocks whose entries are entry(row, column), for each two parts of a block.
template <class Entry>
IsotropicBlocks blocks_of(const BlockParts& parts, Entry entry) {
    const auto block = [&](const std::vector<Part>& members) {
        Block result(static_cast<int>(members.size()));
        for (int i = 0; i < result.size; ++i)
            for (int k = 0; k < result.size; ++k)
                result(i, k) = entry(members[static_cast<std::size_t>(i)], members[static_cast<std::size_t>(k)]);
        return result;
    };
    return {.even = block(parts.even), .odd = block(parts.odd)};
}

/// Noise whose strength depends on the fields, in the sense of Ito: its strength is that at the start of a step.  Over
/// a step each noise is integrated with the decay of the field that it drives, as if its strength commuted with that:
/// exact for a uniform strength in a field without couplings, otherwise of weak order 1.
struct ProductNoise {
    Layout layout;  ///< of the noises, one for each field that it drives
    /// L and Q of the noises, as those of a System; the Q of one noise that drives several fields couples them.
    std::function<IsotropicBlocks(double q)> linear, noise;
    /// Adds to `to` the effect of the increments of the noises over a step with the middle t, which begins at `state`.
    std::function<void(double t, const Spectra& state, const Spectra& increments, Spectra& to)> add;
};

/// A system of fields: da/dt = L a + N(t, a) + noise.
struct System {
    Grid grid;
    Layout layout;
    /// L at |q|: rates, per time.  Smooth in q; even and odd powers as the parities of the fields require.
    std::function<IsotropicBlocks(double q)> linear;
    /// N: writes all of `rate`, never `state`.  Empty: the system is linear.
    std::function<void(double t, const Spectra& state, Spectra& rate)> nonlinear;
    /// Called by a stepper with its dt before each step: where N is stiff it may depend on dt, and must converge with
    /// it.  Empty: N does not depend on dt.
    std::function<void(double dt)> set_step = {};
    /// Q at |q|: <f_q(t) f_q'(t')^H> = Q delta(t - t') delta_qq' / area, symmetric.  Empty: no noise.
    std::function<IsotropicBlocks(double q)> noise;
    std::shared_ptr<const ProductNoise> product_noise = {};
    /// Degree of the highest product in N: modes |k| >= N/(degree + 1) on an axis are zero.  1 when linear.
    int degree = 1;
    /// Which of independent noise paths of one seed, below 2^31.  A system that takes the place of another with another
    /// L in the middle of a run has another: what is left of the path of the other law depends on what has been.
    std::uint64_t noise_path = 0;
    bool is_timed = false;  ///< N depends on t beside the state: no step may be longer than dt, which resolves that
};

}  // namespace drover::numerics
