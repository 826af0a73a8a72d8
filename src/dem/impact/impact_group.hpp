// dem/impact/impact_group.hpp: simultaneous impacts of a group of contacts, and the end of an approach that its law
// has left.
#pragma once
#include <span>
#include <vector>

#include "dem/impact/impact_frame.hpp"

namespace drover::dem {

/// The law `simultaneous` of resolve(), for a group that approaches at outcome.approach.  Changes the bodies'
/// velocities, the contacts' impulses and the outcome.
void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome);

/// Normal impulses p >= 0 without rebound or friction, after which no contact approaches at `velocities` along the
/// normals: of those that do this, the ones which leave the least kinetic energy.  Empty where there are none, as for a
/// body between walls that approach each other.
std::vector<double> inelastic_impulses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                       std::span<const Frame> frames, std::span<const double> velocities);

}  // namespace drover::dem
