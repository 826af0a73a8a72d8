// numerics/steppers/perturbation.hpp: perturbations of an initial state.
#pragma once
#include <cstdint>

#include "drover/base/error.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// Adds independent normal numbers of standard deviation `amplitude` in each cell of each component; the means of
/// scalars do not change.
void add_random(const System& system, double amplitude, std::uint64_t seed, Threads& threads, Spectra& state);

/// A wave amplitude cos(q.r + phase) with whole numbers of wavelengths in the cell.
struct CosineMode {
    int x = 1, y = 0;
    double amplitude = 0.0, phase = 0.0;
};
/// Throws an input Error at initial.mode_x or initial.mode_y for a mode that a grid does not keep.
void check(const CosineMode& mode, const Grid& grid, int degree, const Locate& locate);
/// Adds it to a component.  The mode must be one of the grid.
void add_mode(const Grid& grid, const CosineMode& mode, int component, Spectra& state);

}  // namespace drover::numerics
