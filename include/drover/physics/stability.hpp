// physics/stability.hpp: modes of small waves on a uniform state: rates, frequencies, shapes, branches, and what grows.
#pragma once
#include <Eigen/Core>
#include <complex>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

/// At most `places` numbers, or columns of them.
using ModeRates = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, 1, 0, FieldIndex::count, 1>;
using ModeShapes =
    Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, 0, FieldIndex::count, FieldIndex::count>;

/// The places of a Symbol that a form's fields take, in order: as many modes as there are.
std::vector<int> places_of(const Form& form);

/// The modes of one wavevector: fields ~ exp(i q.r + s t).  Rows of `shapes`: the form's fields in the order of
/// places_of, a column for each mode, of length 1; `duals` times shapes is the identity.  Nearly equal columns of
/// shapes: M is defective there, `duals` large.
struct Modes {
    ModeRates rates;  ///< s [1/s]: growth Re s, frequency -Im s
    ModeShapes shapes, duals;
};

/// By rate, fastest growing first.
Modes modes(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The rates alone, in no order.
ModeRates mode_rates(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q);

/// The largest growth rate of one wavevector, with its frequency -Im s [1/s].
struct Growth {
    double rate = 0.0, frequency = 0.0;
};
Growth growth(const Equations& equations, const UniformPoint& about, double q, double angle);

/// All branches over wavenumbers and angles, each followed along q from the smallest, and there from angle to angle: a
/// mode goes on as the one whose shape it has or, where shapes are no guide (defective), whose rate is nearest.
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

/// The wavevector at an angle from the direction of the state's order.
numerics::Wavevector wavevector_from_order(const UniformPoint& about, double q, double angle);

/// A kind of instability: its fastest wave.
struct Instability {
    /// Of the isotropic state: "order" (a flock forms), "phase separation".  Of a flock: "banding" (waves along p0),
    /// "oblique", "phase separation" (waves across p0 that stand still), "uniform" (the whole of it turns or grows,
    /// without a wave).
    std::string name;
    double rate = 0.0, frequency = 0.0;  ///< Re s, -Im s [1/s]
    double q = 0.0, angle = 0.0;         ///< [1/mm], [rad]; q = 0: without a wave
    double min = 0.0, max = 0.0;         ///< at this angle waves grow between these [1/mm]; infinite: beyond the search
    bool at_longest = false;             ///< the longer the wave the faster it grows, down to the smallest |q| searched
    bool at_shortest = false;            ///< still growing faster where the search ends: the model has no shortest wave
};

/// What grows on a state, fastest first; empty: it is stable against waves from min to max.  Searched on `wavenumbers`
/// |q|, evenly by their logarithm, at 46 angles, every maximum then refined.
struct Search {
    double min = 1e-4, max = 1e2;  ///< |q| [1/mm]
    int wavenumbers = 96;
};
std::vector<Instability> instabilities(const Equations& equations, const StationaryState& about, const Search& search);

/// Where the growth at an angle changes sign, ascending [1/mm].
std::vector<double> neutral_wavenumbers(const Equations& equations, const StationaryState& about, double angle,
                                        const Search& search);

}  // namespace drover::physics
