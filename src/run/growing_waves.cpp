// run/growing_waves.cpp: a search over wavenumbers.
#include "run/growing_waves.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/base/text.hpp"

namespace drover::run {

namespace {
bool waves_grow(const numerics::System& system, double q) {
    const numerics::IsotropicBlocks rates = system.linear(q);
    for (const numerics::Block* block : {&rates.even, &rates.odd}) {
        const auto eigenvalues = numerics::eigenvalues(*block);
        double size = 0.0;
        for (const numerics::Complex s : eigenvalues) size = std::max(size, std::abs(s));
        constexpr double rounding = 1e-12;  // of the largest
        for (const numerics::Complex s : eigenvalues)
            if (s.real() > rounding * size) return true;
    }
    return false;
}

/// Beyond it waves along an axis are cut.
double cut_of(const numerics::System& system) {
    const auto along = [&](int points, double side) {
        return points > 1 ? 2.0 * std::numbers::pi / side * points / (system.degree + 1) : INFINITY;
    };
    return std::min(along(system.grid.nx, system.grid.lx), along(system.grid.ny, system.grid.ly));
}
}  // namespace

double largest_growing(const numerics::System& system, double max_q) {
    constexpr int looks = 400;
    for (int n = looks; n >= 1; --n)
        if (waves_grow(system, max_q * n / looks)) return max_q * n / looks;
    return 0.0;
}

std::string growing_waves_warning(const numerics::System& system) {
    constexpr int max_octaves = 10, per_octave = 32;
    const double cut = cut_of(system);
    int last = max_octaves * per_octave;
    while (last >= 0 && !waves_grow(system, cut * std::exp2(static_cast<double>(last) / per_octave))) --last;
    if (last < 0) return "";
    if (last == max_octaves * per_octave)
        return "waves of any length grow about the references, however short: what a run gives depends on its grid; "
               "add "
               "a term that damps short waves, such as a Laplacian";
    const double shortest = cut * std::exp2(static_cast<double>(last) / per_octave);
    int factor = 2;
    while (cut * factor <= 1.25 * shortest) factor *= 2;
    const auto length = [](double q) { return 2.0 * std::numbers::pi / q; };
    return text(
        "waves down to a length of {:.3g} mm grow about the references, and {} keeps no waves shorter than "
        "{:.3g} mm: choose {}, or terms that damp short waves more",
        length(shortest), grid_keys(system.grid), length(cut), grid_keys(system.grid, factor));
}

std::string grid_keys(const numerics::Grid& grid, int factor) {
    const std::string along_x = text("grid.nx = {}", factor * grid.nx);
    return grid.ny == 1 ? along_x : text("{} and grid.ny = {}", along_x, factor * grid.ny);
}

}  // namespace drover::run
