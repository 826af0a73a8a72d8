// physics/stability.hpp: linear modes of a uniform state: rates, frequencies, shapes, branches and instabilities.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/model/theory.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

using model::Growth;
using model::Modes;

/// Those of model/theory.hpp; angles are those from the direction of the state.
inline Modes modes(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    return model::modes(*equations.linearised(about), q);
}
inline Eigen::VectorXcd mode_rates(const Equations& equations, const UniformPoint& about,
                                   const numerics::Wavevector& q) {
    return model::mode_rates(*equations.linearised(about), q);
}
inline Growth growth(const Equations& equations, const UniformPoint& about, double q, double angle) {
    return model::growth(*equations.linearised(about), q, angle);
}

/// All branches over wavenumbers and angles.  Each branch is followed along q from the smallest q, where it is followed
/// from angle to angle.  Modes of successive points are matched by shape or, near defective matrices, by nearest rate.
struct ModeMap {
    std::vector<double> wavenumbers;  ///< |q| [1/mm], ascending
    std::vector<double> angles;       ///< of q, from the direction of p0 (from x without order) [rad]
    std::vector<Modes> modes;         ///< [angle][wavenumber]
    const Modes& at(std::size_t angle, std::size_t wavenumber) const {
        return modes[angle * wavenumbers.size() + wavenumber];
    }
};
ModeMap mode_map(const Equations& equations, const StationaryState& about, const std::vector<double>& wavenumbers,
                 const std::vector<double>& angles, Threads& threads);

/// The wavevector at an angle from the direction of the state.
inline numerics::Wavevector wavevector_from_order(const UniformPoint& about, double q, double angle) {
    const double direction = direction_of(about);
    return {.x = q * std::cos(direction + angle), .y = q * std::sin(direction + angle)};
}

/// A kind of instability: its fastest wave.
struct Instability {
    /// Isotropic state: "order" (a flock forms), "phase separation".  Flock: "banding" (waves along p0), "oblique",
    /// "phase separation" (stationary waves transverse to p0), "uniform" (the uniform order rotates or grows, q = 0).
    std::string name;
    double rate = 0.0, frequency = 0.0;  ///< Re s, -Im s [1/s]
    double q = 0.0, angle = 0.0;         ///< [1/mm], [rad]; q = 0: uniform
    double min = 0.0, max = 0.0;         ///< unstable range of |q| at this angle [1/mm]; infinite: beyond the search
    bool at_longest = false;             ///< growth increases down to the smallest |q| searched
    bool at_shortest = false;            ///< growth increases up to the largest |q| searched: no short-wave cutoff
};

/// Of |q|, at 46 angles of a quarter turn; every maximum is then refined.
using Search = model::GrowthSearch;
/// The instabilities of a state, fastest first; empty if it is stable against waves from search.min to search.max.
std::vector<Instability> instabilities(const Equations& equations, const StationaryState& about, const Search& search);

}  // namespace drover::physics
