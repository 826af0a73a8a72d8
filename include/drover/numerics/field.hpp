// numerics/field.hpp: how fields transform under rotations; sets of them on a grid, in real space and as Fourier
// coefficients.
#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "drover/numerics/grid.hpp"

namespace drover::numerics {

using Complex = std::complex<double>;

/// The real and the imaginary part of each.
inline std::span<const double> parts_of(const std::vector<Complex>& values) {
    return {reinterpret_cast<const double*>(values.data()), 2 * values.size()};
}
inline std::span<double> parts_of(std::vector<Complex>& values) {
    return {reinterpret_cast<double*>(values.data()), 2 * values.size()};
}

/// i^n.
inline Complex power_of_i(int n) {
    constexpr std::array<Complex, 4> powers{{{1.0, 0.0}, {0.0, 1.0}, {-1.0, 0.0}, {0.0, -1.0}}};
    return powers[static_cast<std::size_t>(n & 3)];
}

/// How a field transforms under rotations.  Spin 0: one component.  Spin m >= 1: two, F_1 and F_2, and a rotation of
/// the system by an angle multiplies F_1 + i F_2 by exp(i m angle): a vector (x and y) has spin 1, a nematic (Q_xx and
/// Q_xy) spin 2.
struct FieldKind {
    int spin = 0;
    bool odd = false;          ///< a reflection changes its sign as well: a pseudoscalar, a pseudovector
    bool across_only = false;  ///< its part along q is 0 but in the mean: a field without divergence
    bool operator==(const FieldKind&) const = default;
};
inline constexpr int max_spin = 12;

/// The fields of a system.
struct Layout {
    std::vector<FieldKind> fields;  ///< in the order of their components
    bool chiral = false;            ///< operators may couple the even and the odd parts, which a reflection tells apart
    bool operator==(const Layout&) const = default;
};

/// True scalars, then true vectors.
Layout scalars_and_vectors(int scalars, int vectors);

inline int components(const FieldKind& kind) { return kind.spin == 0 ? 1 : 2; }
int components(const Layout& layout);
/// Those of the fields of spin 0.
std::vector<int> scalar_components(const Layout& layout);

/// A variable of the blocks of a layout (see IsotropicBlocks).
struct Part {
    int component = 0;  ///< that it is where q points along x, but for the factor
    int spin = 0;       ///< m of its factor i^m
};

/// Even: true scalars, parts along of true spins, parts across of odd spins.  Odd: the others.  Each in the order of
/// the fields.  A chiral layout has one block: `even` has all of them, the even ones first.
struct BlockParts {
    std::vector<Part> even, odd;
};

/// Throws an input Error for a layout without fields, for spins beyond 0 to max_spin, and for blocks of more than
/// max_block rows.
BlockParts block_parts(const Layout& layout);

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
    int count() const { return stride == 0 ? 0 : static_cast<int>(values.size() / stride); }

    /// Padding between components: without it the same mode of all components falls in the same first-level cache set
    /// (on power-of-two grids), which causes cache-set conflicts.
    static constexpr std::size_t gap = 20;
    std::size_t size = 0;    ///< modes of one component
    std::size_t stride = 0;  ///< from a mode of one component to the same of the next
    std::vector<Complex> values;
};

/// Throws an input Error for arrays of another size than those of the grid, or of another number of components.  Arrays
/// of a grid with as many points are not told apart.
void check(const Fields& fields, const Grid& grid, int components);
void check(const Spectra& spectra, const Grid& grid, int components);

}  // namespace drover::numerics
