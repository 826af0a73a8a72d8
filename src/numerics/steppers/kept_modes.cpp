// numerics/steppers/kept_modes.cpp: the first modes of the rows that have any.
#include "numerics/steppers/kept_modes.hpp"

#include <algorithm>

namespace drover::numerics {

int kept_degree(int degree, DealiasingRule rule) {
    if (rule == DealiasingRule::exact) return degree;
    return rule == DealiasingRule::two_thirds ? 2 : 1;
}

void store_kept(const System& system, const Spectra& state, KeptModes& to) {
    to.clear();
    for (int c = 0; c < state.count(); ++c)
        for_kept_rows({system.grid, system.degree}, [&](std::size_t first, std::size_t count) {
            const auto from = state[c].subspan(first, count);
            to.insert(to.end(), from.begin(), from.end());
        });
}

Spectra with_kept(const System& system, const KeptModes& modes) {
    Spectra state(system.grid, components(system.layout));
    auto from = modes.begin();
    for (int c = 0; c < state.count(); ++c)
        for_kept_rows({system.grid, system.degree}, [&](std::size_t first, std::size_t count) {
            std::copy_n(from, count, state[c].begin() + static_cast<std::ptrdiff_t>(first));
            from += static_cast<std::ptrdiff_t>(count);
        });
    return state;
}

Rows<Dealiasing> Dealiasing::rows() {
    return Rows<Dealiasing>{
        {"rule", &Dealiasing::rule,
         "which modes are kept: exact: |k| < N/(d + 1) on each axis, d the degree of the highest product; "
         "two-thirds: |k| < N/3 for any d; none: |k| < N/2; outputs report the tail of the spectrum"},
        {"degree", &Dealiasing::degree,
         "exact: with at least this degree, so that scenes with and without a term keep the same modes; 0: that of the "
         "equations",
         "", within(0.0, 20.0)},
    };
}

}  // namespace drover::numerics
