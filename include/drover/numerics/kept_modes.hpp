// numerics/kept_modes.hpp: states without the modes that are zero, a quarter to a half of their size.
#pragma once
#include <vector>

#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// The kept modes of a state: component by component, row by row.
using KeptModes = std::vector<Complex>;

/// Copies the kept modes of a state of `system`.
void store_kept(const System& system, const Spectra& state, KeptModes& to);

/// The state with these kept modes; the others are zero.
Spectra with_kept(const System& system, const KeptModes& modes);

}  // namespace drover::numerics
