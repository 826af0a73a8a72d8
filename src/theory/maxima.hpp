// theory/maxima.hpp: maxima of growth over waves, also of modes that others hide at the waves of a search.
#pragma once
#include <Eigen/Core>
#include <functional>
#include <utility>
#include <vector>

#include "drover/theory/theory.hpp"

namespace drover::theory {

/// A wave as log |q| and its angle from the direction of the state [rad].
using WavePlace = std::pair<double, double>;

/// Numbers of all modes of a wave, in any order: growth rates or these in a unit of the wave's own.
using GrowthOfModes = std::function<Eigen::VectorXd(double log_q, double angle)>;
GrowthOfModes growth_of_modes(const model::LinearisedAt& at);

/// Places of the maxima of the largest growth, in no order.  log_q: evenly spaced, >= 2; angles: evenly spaced over
/// half a turn; a single one is kept.  A maximum of a mode that lies below another mode at all these places is found
/// too, by the sums of the k largest, which have no kinks where these modes cross.
std::vector<WavePlace> growth_maxima(const GrowthOfModes& growth, const std::vector<double>& log_q,
                                     const std::vector<double>& angles);

}  // namespace drover::theory
