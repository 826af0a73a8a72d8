// model/conservation.hpp: whether a rate conserves the mean of its field.
#pragma once
#include "model/summands.hpp"

namespace drover::model {

/// Whether a component is the divergence of something, whatever the fields: its Euler operator vanishes identically.
/// Tried at random derivatives of the fields.  solenoidal: the first components of divergence-free vectors.
bool is_divergence(Algebra& algebra, const Component& source, const std::vector<int>& solenoidal);

/// Throws an input Error where a field that is declared as conserved is no scalar with a rate, or where its summands
/// and their noise are not divergences together.
void check_conserved(Algebra& algebra, const Field& field, const std::vector<Summand>& parts,
                     const std::vector<int>& solenoidal);

}  // namespace drover::model
