// numerics/linear_operator.cpp: isotropic blocks on the modes of a state.
#include "drover/numerics/linear_operator.hpp"

#include "isotropic.hpp"

namespace drover::numerics {

LinearOperator::LinearOperator(const System& system)
    : grid_(system.grid), layout_(system.layout), wavenumbers_(distinct_wavenumbers(system.grid, system.degree)) {
    for (const double q : wavenumbers_.q) append_entries(system.linear(q), matrices_);
}

void LinearOperator::add(const Spectra& state, Spectra& rate) const {
    for_layout(layout_, [&]<int Scalars, int Vectors>() {
        constexpr std::size_t along = Scalars + Vectors, across = Vectors, entries = along * along + across * across;
        const std::size_t width = columns(grid_);
        for (std::size_t m = 0; m < state.size; ++m) {
            const std::int32_t index = wavenumbers_.of_mode[m];
            if (index < 0) continue;
            const auto n = static_cast<std::size_t>(index);
            const Direction d = direction(wavevector(grid_, m % width, m / width), wavenumbers_.inverse[n]);
            const auto parts = parts_of<Scalars, Vectors>(state.values.data(), state.stride, m, d);
            ModeParts<Scalars, Vectors> sum{};
            const double* matrix = matrices_.data() + n * entries;
            add_product(matrix, parts.along, sum.along);
            add_product(matrix + along * along, parts.across, sum.across);
            add_parts(sum, rate.values.data(), rate.stride, m, d);
        }
    });
}

}  // namespace drover::numerics
