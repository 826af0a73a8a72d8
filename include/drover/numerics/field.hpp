// numerics/field.hpp: sets of fields on a grid, in real space and as Fourier coefficients.
#pragma once
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "drover/numerics/layout.hpp"

namespace drover::numerics {

using Complex = std::complex<double>;

/// `components` consecutive real arrays [y][x].
struct Fields {
    Fields() = default;
    Fields(const Grid& grid, int components)
        : size(points(grid)), values(size * static_cast<std::size_t>(components), 0.0) {}
    std::span<double> operator[](int c) { return {values.data() + size * static_cast<std::size_t>(c), size}; }
    std::span<const double> operator[](int c) const {
        return {values.data() + size * static_cast<std::size_t>(c), size};
    }
    int count() const { return size == 0 ? 0 : static_cast<int>(values.size() / size); }

    std::size_t size = 0;  ///< points of one component
    std::vector<double> values;
};

/// Fourier coefficients of `components` real fields: a(r) = sum_q a_q exp(i q.r), so that a_0 is the mean.
/// Consecutive arrays [row][column] of the spectral shape of the grid.
struct Spectra {
    Spectra() = default;
    Spectra(const Grid& grid, int components)
        : size(modes(grid)), stride(size + gap), values(stride * static_cast<std::size_t>(components), Complex(0.0)) {}
    std::span<Complex> operator[](int c) { return {values.data() + stride * static_cast<std::size_t>(c), size}; }
    std::span<const Complex> operator[](int c) const {
        return {values.data() + stride * static_cast<std::size_t>(c), size};
    }
    int count() const { return size == 0 ? 0 : static_cast<int>(values.size() / stride); }

    /// Padding between components: without it the same mode of all components falls in the same first-level cache set
    /// (on power-of-two grids), which causes cache-set conflicts.
    static constexpr std::size_t gap = 20;
    std::size_t size = 0;    ///< modes of one component
    std::size_t stride = 0;  ///< from a mode of one component to the same of the next
    std::vector<Complex> values;
};

}  // namespace drover::numerics
