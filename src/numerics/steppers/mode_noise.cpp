// numerics/steppers/mode_noise.cpp: noise for all modes of a state.
#include "numerics/steppers/mode_noise.hpp"

namespace drover::numerics {

void add_mode_noise(const NoiseDraw& draw, const Layout& layout, Threads& threads, Spectra& to) {
    for_layout(layout, [&](const auto& kernel) {
        const std::size_t width = columns(draw.grid);
        const auto of_row = [&](std::size_t row, std::vector<double>& normal) {
            const std::size_t kept = kept_in_row(draw.grid, draw.wavenumbers, row);
            fill_row_normals(draw.grid, draw.key, row, kept, kernel.parts, normal);
            for (std::size_t i = 0; i < kept; ++i) {
                const auto n = static_cast<std::size_t>(draw.wavenumbers.of_mode[row * width + i]);
                auto sum = zero_parts(kernel);
                add_blocks(kernel, draw.factors.data() + n * kernel.entries,
                           load_parts(kernel, normal.data() + i * 2 * kernel.parts), sum);
                Complex* mode = to.values.data() + row * width + i;
                write_parts(kernel, sum, mode, {mode, to.stride},
                            kernel.frame(direction(wavevector(draw.grid, i, row), draw.wavenumbers.inverse[n])));
            }
        };
        threads.for_chunks(static_cast<std::size_t>(draw.grid.ny), rows_per_chunk(draw.grid),
                           [&](std::size_t begin, std::size_t end) {
                               std::vector<double> normal;
                               for (std::size_t row = begin; row < end; ++row) of_row(row, normal);
                           });
    });
}

}  // namespace drover::numerics
