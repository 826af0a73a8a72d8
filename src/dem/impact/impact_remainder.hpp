// dem/impact/impact_remainder.hpp: the end of an approach that the law of a group has left.
#pragma once
#include <span>
#include <vector>

#include "dem/impact/impact_frame.hpp"

namespace drover::dem {

/// Normal impulses p >= 0 without rebound or friction, after which no contact approaches at `velocities` along the
/// normals: of those that do this, the ones which leave the least kinetic energy.  Empty where there are none, as for a
/// body between walls that approach each other.
std::vector<double> inelastic_impulses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                       std::span<const Frame> frames, std::span<const double> velocities);

}  // namespace drover::dem
