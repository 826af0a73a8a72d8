// numerics/steppers/perturbation.cpp: random and harmonic perturbations.
#include "numerics/steppers/perturbation.hpp"

#include <complex>
#include <cstdlib>
#include <tuple>

#include "drover/base/random.hpp"
#include "drover/numerics/transform.hpp"

namespace drover::numerics {

void add_random(const System& system, double amplitude, std::uint64_t seed, Threads& threads, Spectra& state) {
    Fields cells(system.grid, state.count());
    for (int c = 0; c < state.count(); ++c) {
        const RandomKey key{.seed = seed, .stream = Stream::initial_state, .substep = static_cast<std::uint32_t>(c)};
        const std::span<double> all = cells[c];
        constexpr std::size_t cells_per_chunk = 4096;
        threads.for_chunks(all.size(), cells_per_chunk, [&](std::size_t begin, std::size_t end) {
            fill_normal(key, begin, 1, all.subspan(begin, end - begin));
            for (double& value : all.subspan(begin, end - begin)) value *= amplitude;
        });
    }
    Spectra noise(system.grid, state.count());
    Transform(system.grid, system.degree, threads).forward(cells, noise);
    for (const int c : scalar_components(system.layout)) noise[c][0] = 0.0;
    for (std::size_t m = 0; m < state.values.size(); ++m) state.values[m] += noise.values[m];
}

void check(const CosineMode& mode, const Grid& grid, int degree, const Locate& locate) {
    const int parts = degree + 1;
    for (const auto& [name, number, size] :
         {std::tuple{"mode_x", mode.x, grid.nx}, std::tuple{"mode_y", mode.y, grid.ny}})
        require(std::abs(std::int64_t{number}) * parts < size, locate(text("initial.{}", name)),
                "initial.{} = {}; expected a magnitude less than {:.4g}: the grid keeps modes below 1/{} of the points "
                "of that axis",
                name, number, static_cast<double>(size) / parts, parts);
}

void add_mode(const Grid& grid, const CosineMode& mode, int component, Spectra& state) {
    // A real mode is its own conjugate at -q: the half with kx >= 0 is stored.
    const int sign = mode.x < 0 ? -1 : 1, kx = sign * mode.x, ky = sign * mode.y;
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny);
    const auto column = static_cast<std::size_t>(kx);
    const auto row = static_cast<std::size_t>(ky < 0 ? ky + grid.ny : ky);
    const Complex half = 0.5 * std::polar(mode.amplitude, sign * mode.phase);
    state[component][row * width + column] += half;
    if (column == 0) state[component][(rows - row) % rows * width] += std::conj(half);
}

}  // namespace drover::numerics
