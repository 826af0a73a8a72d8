// model/conservation.hpp: whether a rate conserves the mean of its field.
#pragma once
#include "algebra.hpp"

namespace drover::model {

/// Whether a component is the divergence of something, whatever the fields: its Euler operator vanishes identically.
/// Tried at random derivatives of the fields.  solenoidal: the first components of divergence-free vectors.
bool is_divergence(Algebra& algebra, const Component& source, const std::vector<int>& solenoidal);

}  // namespace drover::model
