// dem/impact_group.hpp: all contacts of a group pressed together.
#pragma once
#include <span>

#include "impact_frame.hpp"

namespace drover::dem {

/// The law `simultaneous` of resolve(), for a group that approaches at outcome.approach: changes the bodies, gives the contacts their impulses
/// and says what they did.
void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome);

}  // namespace drover::dem
