// numerics/linear_operator.cpp: isotropic blocks on the modes of a state.
#include "drover/numerics/linear_operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isotropic.hpp"
#include "mode_noise.hpp"

namespace drover::numerics {

LinearOperator::LinearOperator(const System& system)
    : grid_(system.grid), layout_(system.layout), wavenumbers_(distinct_wavenumbers(system.grid, system.degree)) {
    for (const double q : wavenumbers_.q) append_entries(system.linear(q), matrices_);
}

void LinearOperator::add(const Spectra& state, Spectra& rate) const {
    for_layout(layout_, [&]<int Scalars, int Vectors>() {
        constexpr std::size_t along = Scalars + Vectors, across = Vectors, entries = along * along + across * across;
        const std::size_t width = columns(grid_), rows = static_cast<std::size_t>(grid_.ny);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t i = 0, kept = kept_in_row(grid_, wavenumbers_, row); i < kept; ++i) {
                const std::size_t m = row * width + i;
                const auto n = static_cast<std::size_t>(wavenumbers_.of_mode[m]);
                const Direction d = direction(wavevector(grid_, i, row), wavenumbers_.inverse[n]);
                const auto parts = parts_of<Scalars, Vectors>(state.values.data(), state.stride, m, d);
                ModeParts<Scalars, Vectors> sum{};
                const double* matrix = matrices_.data() + n * entries;
                add_product(matrix, parts.along, sum.along);
                add_product(matrix + along * along, parts.across, sum.across);
                add_parts(sum, rate.values.data(), rate.stride, m, d);
            }
    });
}

namespace {
/// m = (1 - gamma m)^-1 by Gauss-Jordan elimination with partial pivoting, row by row.
void invert_shifted(double* m, std::size_t size, double gamma) {
    std::array<std::array<double, 2 * max_block>, max_block> work{};
    for (std::size_t i = 0; i < size; ++i)
        for (std::size_t k = 0; k < size; ++k) {
            work[i][k] = (i == k ? 1.0 : 0.0) - gamma * m[i * size + k];
            work[i][size + k] = i == k ? 1.0 : 0.0;
        }
    for (std::size_t k = 0; k < size; ++k) {
        std::size_t pivot = k;
        for (std::size_t i = k + 1; i < size; ++i)
            if (std::abs(work[i][k]) > std::abs(work[pivot][k])) pivot = i;
        std::swap(work[k], work[pivot]);
        const double scale = 1.0 / work[k][k];
        for (double& value : work[k]) value *= scale;
        for (std::size_t i = 0; i < size; ++i) {
            if (i == k) continue;
            const double factor = work[i][k];
            for (std::size_t j = k; j < 2 * size; ++j) work[i][j] -= factor * work[k][j];
        }
    }
    for (std::size_t i = 0; i < size; ++i)
        for (std::size_t k = 0; k < size; ++k) m[i * size + k] = work[i][size + k];
}
}  // namespace

LinearOperator LinearOperator::shifted_inverse(double gamma) const {
    LinearOperator result = *this;
    const auto along = static_cast<std::size_t>(layout_.scalars + layout_.vectors),
               across = static_cast<std::size_t>(layout_.vectors);
    double* matrix = result.matrices_.data();
    for (std::size_t n = 0; n < wavenumbers_.q.size(); ++n)
        for (const std::size_t size : {along, across}) {
            invert_shifted(matrix, size, gamma);
            matrix += size * size;
        }
    return result;
}

}  // namespace drover::numerics
