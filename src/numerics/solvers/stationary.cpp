// numerics/solvers/stationary.cpp: samples of the stationary distribution of a linear system.
#include <algorithm>

#include "drover/base/error.hpp"
#include "drover/numerics/stepper.hpp"
#include "numerics/steppers/isotropic.hpp"

namespace drover::numerics {

namespace {
/// The factor of the stationary covariance; zero for variables that do not change (a conserved mean).
Block stationary_factor(const Block& m, const Block& q) {
    std::vector<int> moving;
    for (int i = 0; i < m.size; ++i) {
        bool moves = false;
        for (int k = 0; k < m.size; ++k) moves = moves || m(i, k) != 0.0 || q(i, k) != 0.0;
        if (moves) moving.push_back(i);
    }
    Block result(m.size);
    if (moving.empty()) return result;
    const Block inner = factor(stationary_covariance(of_rows(m, moving), of_rows(q, moving)));
    for (int i = 0; i < inner.size; ++i)
        for (int k = 0; k < inner.size; ++k)
            result(moving[static_cast<std::size_t>(i)], moving[static_cast<std::size_t>(k)]) = inner(i, k);
    return result;
}
}  // namespace

void draw_stationary(const System& system, const RandomKey& key, Spectra& state) {
    require(static_cast<bool>(system.noise), {}, "a stationary initial state needs noise; this system has none");
    check(state, system.grid, components(system.layout));
    const DistinctWavenumbers wavenumbers = distinct_wavenumbers(system.grid, system.degree);
    std::vector<double> factors;
    for (const double q : wavenumbers.q) {
        const IsotropicBlocks m = linear_blocks(system, q), covariance = noise_blocks(system, q);
        append_entries({stationary_factor(m.even, covariance.even), stationary_factor(m.odd, covariance.odd)}, factors);
    }
    std::ranges::fill(state.values, Complex(0.0));
    for_layout(system.layout, [&](const auto& kernel) {
        std::vector<double> normal;
        for (std::size_t row = 0; row < static_cast<std::size_t>(system.grid.ny); ++row) {
            const std::size_t kept = kept_in_row(system.grid, wavenumbers, row);
            fill_row_normals(system.grid, key, row, kept, kernel.parts, normal);
            for (std::size_t i = 0; i < kept; ++i) {
                const std::size_t m = row * columns(system.grid) + i;
                const auto n = static_cast<std::size_t>(wavenumbers.of_mode[m]);
                auto sum = zero_parts(kernel);
                add_blocks(kernel, factors.data() + n * kernel.entries,
                           load_parts(kernel, normal.data() + i * 2 * kernel.parts), sum);
                Complex* mode = state.values.data() + m;
                write_parts(kernel, sum, mode, {mode, state.stride},
                            kernel.frame(direction(wavevector(system.grid, i, row), wavenumbers.inverse[n])));
            }
        }
    });
}

}  // namespace drover::numerics
