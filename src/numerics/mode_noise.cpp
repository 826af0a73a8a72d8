// numerics/mode_noise.cpp: noise for all modes of a state.
#include "mode_noise.hpp"

namespace drover::numerics {

void add_mode_noise(const NoiseDraw& draw, const Layout& layout, Threads& threads, Spectra& to) {
    for_layout(layout, [&]<int Scalars, int Vectors>() {
        threads.for_chunks(static_cast<std::size_t>(draw.grid.ny), rows_per_chunk(draw.grid),
                           [&](std::size_t begin, std::size_t end) {
                               std::vector<double> normal;
                               for (std::size_t row = begin; row < end; ++row)
                                   add_row_noise<Scalars, Vectors>(draw, row,
                                                                   kept_in_row(draw.grid, draw.wavenumbers, row),
                                                                   normal, to.values.data() + row * columns(draw.grid),
                                                                   to.stride);
                           });
    });
}

}  // namespace drover::numerics
