// theory/limits.hpp: limits of stability in the limit of long waves, and the regimes between them.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>

#include "theory/boundary.hpp"
#include "theory/point_theory.hpp"

namespace drover::theory {

/// The kind of stability boundary.  The order is the first field that turns.
enum class Limit {
    onset,             ///< order neither grows nor decays in the isotropic state
    phase_separation,  ///< isotropic state where order decays: a conserved density begins to grow
    banding,           ///< ordered state: long waves along its direction grow
    oblique  ///< ordered state: long waves at any angle grow, however small the angle; includes the banding region
};
constexpr auto names_of(Limit) { return std::array{"onset", "phase-separation", "banding", "oblique"}; }

/// Stability margins of one point, exact in the limit q -> 0, by second-order perturbation theory; waves of finite
/// length may become unstable earlier, see theory/instabilities.hpp.  The states of the point are searched once, when
/// they are needed first.
class PointMargins {
public:
    /// means: a state of all components, whose conserved means count.  Keeps references to all.
    PointMargins(const PointTheory& theory, const model::UniformState& means, const OrderSearch& search)
        : theory_(theory), means_(means), search_(search) {}
    /// At onset the rate at which order decays.  NaN: the state of this limit does not exist, or rates are not finite.
    /// Its angle is that from the direction of the state.  Throws as LinearisedAt.
    Margin at(Limit limit);

private:
    Margin of_isotropic(Limit limit);
    const PointTheory& theory_;
    const model::UniformState& means_;
    const OrderSearch& search_;
    std::optional<std::optional<PointState>> isotropic_, ordered_;
};

/// The uniform state at a point, and whether long waves grow on it.
enum class Regime { undefined = -1, isotropic = 0, separating = 1, flock = 2, banding = 3, oblique = 4 };

/// "-1 not defined, 0 isotropic, ...": the codes and their meanings.
std::string regime_legend();

/// From the margins of those limits that tell; NaN: the state that the limit concerns does not exist.
Regime regime_of(const std::function<double(Limit)>& margin);

}  // namespace drover::theory
