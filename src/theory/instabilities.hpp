// theory/instabilities.hpp: what grows on a uniform state and what kind it is; branches of modes over all waves.
#pragma once
#include <array>
#include <utility>
#include <vector>

#include "drover/theory/theory.hpp"

namespace drover::theory {

/// On a state without a direction: `order` (fields with a spin grow: a flock or a nematic forms), `pattern` (waves of
/// scalars that are not conserved), `phase separation` (waves that move a conserved mean).  On a state with one:
/// `banding` (waves along it), `phase separation` (stationary waves across it), `oblique`.  On both: `uniform` (the
/// uniform state itself changes).
enum class InstabilityKind { order, phase_separation, banding, oblique, uniform, pattern };
constexpr auto names_of(InstabilityKind) {
    return std::array{"order", "phase separation", "banding", "oblique", "uniform", "pattern"};
}

/// The fastest wave of its kind.
struct Instability {
    InstabilityKind kind = InstabilityKind::order;
    double rate = 0.0, frequency = 0.0;  ///< Re s, -Im s
    double q = 0.0, angle = 0.0;         ///< |q|, and its angle from the direction of the state [rad]; q = 0: uniform
    /// |q| that grow at this angle, or where q = 0 at any; 0 and infinite: beyond the search.
    double min = 0.0, max = 0.0;
    bool at_longest = false;   ///< growth increases down to the smallest |q| searched
    bool at_shortest = false;  ///< growth increases up to the largest |q| searched: no short-wave cutoff
};

struct GrowingWaves {
    std::vector<Instability> kinds;  ///< fastest first; none: stable against all waves of the search
    FastestWave fastest;             ///< that of the largest growth rate, which may be below 0
};
/// The `angles` of the search are not used: every second degree is looked at, and every maximum is refined.  Throws an
/// input Error for an invalid search.
GrowingWaves growing_waves(const model::LinearisedAt& at, const GrowthSearch& search, Threads& threads);

/// All branches over wavenumbers and angles.  Each branch is followed along q from the smallest q, where it is followed
/// from angle to angle.  Modes of successive points are matched by shape or, near defective matrices, by nearest rate.
struct ModeMap {
    std::vector<double> wavenumbers;  ///< |q|, ascending
    std::vector<double> angles;       ///< of q, from the direction of the state [rad]
    std::vector<Modes> modes;         ///< [angle][wavenumber]
    const Modes& at(std::size_t angle, std::size_t wavenumber) const {
        return modes[angle * wavenumbers.size() + wavenumber];
    }
};
ModeMap mode_map(const model::LinearisedAt& at, const std::vector<double>& wavenumbers,
                 const std::vector<double>& angles, Threads& threads);

/// Of a state whose direction is free: the diffusion constant of its direction times the area of the cell [rad^2 area
/// per time], by noise that turns the whole state: <theta^2> = 2 D t after the fast modes have relaxed.  waves: of the
/// state; NaN without them, and where the noise drives another slow mode that is no turn.
double direction_diffusion(const model::LinearisedAt& at, const LongWaves& waves);

}  // namespace drover::theory
