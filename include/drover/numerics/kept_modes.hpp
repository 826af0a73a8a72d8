// numerics/kept_modes.hpp: which modes are kept, and states without the others, a quarter to a half of their size.
#pragma once
#include <string>
#include <vector>

#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// The degree that decides which modes are kept where products have this degree: by the rule "exact", their own; by
/// "two-thirds" 2 and by "none" 1 for any products.
int kept_degree(int degree, const std::string& rule);

/// The kept modes of a state: component by component, row by row.
using KeptModes = std::vector<Complex>;

/// Copies the kept modes of a state of `system`.
void store_kept(const System& system, const Spectra& state, KeptModes& to);

/// The state with these kept modes; the others are zero.
Spectra with_kept(const System& system, const KeptModes& modes);

}  // namespace drover::numerics
