// numerics/steppers/kept_modes.hpp: which modes are kept, and states without the others, a quarter to a half of their
// size.
#pragma once
#include <array>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// exact: |k| < N/(degree + 1); two_thirds: |k| < N/3; none: |k| < N/2.
enum class DealiasingRule { exact, two_thirds, none };
constexpr auto names_of(DealiasingRule) { return std::array{"exact", "two-thirds", "none"}; }

/// Dealiasing of products.
struct Dealiasing {
    DealiasingRule rule = DealiasingRule::exact;
    int degree = 0;  ///< at least, with exact

    static Rows<Dealiasing> rows();
};

/// The degree that decides which modes are kept where products have this degree.
int kept_degree(int degree, DealiasingRule rule);

/// A grid, and the degree that decides which of its modes are kept; 1: all.
struct KeptGrid {
    Grid grid;
    int degree = 1;
};

/// body(first mode, number of modes) for the kept modes of every row that has any.
template <class Body>
void for_kept_rows(const KeptGrid& on, Body body) {
    const std::size_t width = columns(on.grid), rows = static_cast<std::size_t>(on.grid.ny);
    std::size_t kept = 0;  // of row 0, and so of every row that keeps its first mode
    while (kept < width && is_kept(on.grid, on.degree, kept, 0)) ++kept;
    for (std::size_t row = 0; row < rows; ++row)
        if (is_kept(on.grid, on.degree, 0, row)) body(row * width, kept);
}

/// The kept modes of a state: component by component, row by row.
using KeptModes = std::vector<Complex>;

/// Copies the kept modes of a state of `system`.
void store_kept(const System& system, const Spectra& state, KeptModes& to);

/// The state with these kept modes; the others are zero.
Spectra with_kept(const System& system, const KeptModes& modes);

}  // namespace drover::numerics
