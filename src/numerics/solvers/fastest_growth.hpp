// numerics/solvers/fastest_growth.hpp: the extreme rates of the linear part of a system.
#pragma once
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// The largest growth rate of the linear part over the modes of its grid [1/s], excluding conserved means, and its |q|
/// [1/mm].
struct FastestGrowth {
    double rate = 0.0, q = 0.0;
};
FastestGrowth fastest_growth(const System& system);

/// The largest |s| of the linear part over the kept modes [1/s], for comparison with 1/dt.
double fastest_rate(const System& system);

}  // namespace drover::numerics
