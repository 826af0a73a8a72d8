// numerics/kept_modes.cpp: the first modes of the rows that have any.
#include "drover/numerics/kept_modes.hpp"

#include <algorithm>

namespace drover::numerics {

namespace {
/// body(first mode, number of modes) for the kept modes of every row that has any.
template <class Body>
void for_kept_rows(const System& system, Body body) {
    const Grid& grid = system.grid;
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny);
    std::size_t kept = 0;  // of row 0, and so of every row that keeps its first mode
    while (kept < width && is_kept(grid, system.degree, kept, 0)) ++kept;
    for (std::size_t row = 0; row < rows; ++row)
        if (is_kept(grid, system.degree, 0, row)) body(row * width, kept);
}
}  // namespace

int kept_degree(int degree, const std::string& rule) {
    if (degree == 1 || rule == "exact") return degree;
    return rule == "two-thirds" ? 2 : 1;
}

void store_kept(const System& system, const Spectra& state, KeptModes& to) {
    to.clear();
    for (int c = 0; c < state.count(); ++c)
        for_kept_rows(system, [&](std::size_t first, std::size_t count) {
            const auto from = state[c].subspan(first, count);
            to.insert(to.end(), from.begin(), from.end());
        });
}

Spectra with_kept(const System& system, const KeptModes& modes) {
    Spectra state(system.grid, components(system.layout));
    auto from = modes.begin();
    for (int c = 0; c < state.count(); ++c)
        for_kept_rows(system, [&](std::size_t first, std::size_t count) {
            std::copy_n(from, count, state[c].begin() + static_cast<std::ptrdiff_t>(first));
            from += static_cast<std::ptrdiff_t>(count);
        });
    return state;
}

}  // namespace drover::numerics
