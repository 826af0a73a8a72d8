// dem/impact/impact_group.hpp: simultaneous impacts of a group of contacts.
#pragma once
#include <span>

#include "dem/impact/impact_frame.hpp"

namespace drover::dem {

/// The law `simultaneous` of resolve(), for a group that approaches at outcome.approach.  Changes the bodies'
/// velocities, the contacts' impulses and the outcome.
void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome);

}  // namespace drover::dem
