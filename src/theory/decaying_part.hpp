// theory/decaying_part.hpp: the linear equations of one wave in units and an order in which rounding errors are small.
#pragma once
#include "drover/theory/theory.hpp"

namespace drover::theory {

/// The symbol of one wave among the changes that leave the conserved means, in sets that are not coupled to each other,
/// each balanced: the rates of one set are no rounding errors of another.  Without sets that neither grow nor decay nor
/// have noise, which do not fluctuate.
struct DecayingPart {
    model::Symbol basis;    ///< columns: the changes
    model::Symbol inverse;  ///< rows: the amplitudes of the changes
    model::Symbol symbol;   ///< inverse M basis, in blocks
    model::Symbol noise;    ///< of the amplitudes
    bool decays = true;  ///< whether each growth rate is certainly below 0: closer, its sign is one of rounding errors
};
DecayingPart decaying_part(const model::LinearisedAt& at, const numerics::Wavevector& q);

}  // namespace drover::theory
