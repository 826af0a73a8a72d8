// numerics/steppers/isotropic.hpp: isotropic blocks on the modes of a grid: components of fields to parts that turn
// with q, and Gaussian numbers for each.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "drover/base/random.hpp"
#include "drover/numerics/system.hpp"
#include "numerics/fields/complex_registers.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::numerics {

/// Unit vector along q; x at q = 0.
struct Direction {
    double x = 1.0, y = 0.0;
    bool turned = false;  ///< q != 0: the parts of a spin m carry the factor i^m
};

inline Direction direction(const Wavevector& q, double inverse_length) {
    if (inverse_length == 0.0) return {};
    return {.x = q.x * inverse_length, .y = q.y * inverse_length, .turned = true};
}

/// The frame of q for a spin m: its angle m theta, and the power of i.
template <class Power>
struct Turn {
    double cosine = 1.0, sine = 0.0;
    Power power = 0;
};
/// The sines of the modes: the second of two has the angle -m theta.
template <class Number>
Number sine_of(double sine) {
    if constexpr (sizeof(Number) == sizeof(Pair)) return Pair{sine, sine};
    else return Quad{sine, sine, -sine, -sine};
}

/// Where a field stands: its first component, and its parts among all parts, the even ones before the odd ones.
struct FieldPlace {
    std::size_t component, along, across;
    int spin;
};

/// A kernel is a layout as the loops over modes see it.  This one, of a size known at compile time: true scalars, then
/// true vectors.
template <int Scalars, int Vectors>
struct FixedKernel {
    static constexpr std::size_t even = Scalars + Vectors, odd = Vectors, parts = even + odd, max_parts = parts,
                                 entries = even * even + odd * odd;
    using Frame = Turn<bool>;
    static Frame frame(const Direction& d) { return {d.x, d.y, d.turned}; }
    static const Frame& turn(const Frame& frame, int) { return frame; }
    template <class Body>
    [[gnu::always_inline]] static void for_fields(Body body) {
        for (std::size_t s = 0; s < std::size_t{Scalars}; ++s) body(FieldPlace{s, s, s, 0});
        for (std::size_t v = 0; v < std::size_t{Vectors}; ++v)
            body(FieldPlace{Scalars + 2 * v, Scalars + v, even + v, 1});
    }
};

/// Of any layout.
struct AnyKernel {
    explicit AnyKernel(const Layout& layout);
    static constexpr std::size_t max_parts = 2 * max_block;
    using Frame = std::array<Turn<int>, max_spin + 1>;  // of each spin
    Frame frame(const Direction& d) const;
    static const Turn<int>& turn(const Frame& frame, int spin) { return frame[static_cast<std::size_t>(spin)]; }
    template <class Body>
    void for_fields(Body body) const {
        for (const FieldPlace& place : places) body(place);
    }

    std::size_t even, odd, parts, entries;
    std::vector<FieldPlace> places;
    std::size_t largest_spin = 0;
};

/// One mode or two in the variables of IsotropicBlocks: the even parts, then the odd ones.
template <class Kernel, class Number>
struct ModeParts {
    Number values[Kernel::max_parts];
};
template <class Number = Pair, class Kernel>
[[gnu::always_inline]] inline ModeParts<Kernel, Number> zero_parts(const Kernel& kernel) {
    ModeParts<Kernel, Number> parts;
    for (std::size_t k = 0; k < kernel.parts; ++k) parts.values[k] = Number{};
    return parts;
}

/// Components of modes in memory: the first, the distance between components, and that of the second row.
template <class Value>
struct ModePlace {
    Value* values = nullptr;
    std::size_t stride = 0;
    std::ptrdiff_t apart = 0;
};

/// Parts of the modes at `from`.
template <class Number = Pair, class Kernel>
[[gnu::always_inline]] inline ModeParts<Kernel, Number> parts_of(const Kernel& kernel,
                                                                 const ModePlace<const Complex>& from,
                                                                 const typename Kernel::Frame& frame) {
    ModeParts<Kernel, Number> parts;
    kernel.for_fields([&](const FieldPlace& place) __attribute__((always_inline)) {
        const Complex* first = from.values + place.component * from.stride;
        const Number f_1 = load_modes<Number>(first, from.apart);
        if (place.spin == 0) {
            parts.values[place.along] = f_1;
            return;
        }
        const Number f_2 = load_modes<Number>(first + from.stride, from.apart);
        const auto& turn = kernel.turn(frame, place.spin);
        const Number sine = sine_of<Number>(turn.sine);
        Number along = turn.cosine * f_1 + sine * f_2, across = turn.cosine * f_2 - sine * f_1;
        multiply_by_i(turn.power, along, across);
        parts.values[place.along] = along;
        parts.values[place.across] = across;
    });
    return parts;
}

/// to = base + the inverse of parts_of; without base: the inverse alone.
template <class Number, class Kernel>
[[gnu::always_inline]] inline void write_parts(const Kernel& kernel, const ModeParts<Kernel, Number>& parts,
                                               const Complex* base, const ModePlace<Complex>& to,
                                               const typename Kernel::Frame& frame) {
    const auto write = [&](std::size_t component, const Number& part) {
        const std::size_t at = component * to.stride;
        store_modes<Number>(base ? load_modes<Number>(base + at, to.apart) + part : part, to.values + at, to.apart);
    };
    kernel.for_fields([&](const FieldPlace& place) __attribute__((always_inline)) {
        if (place.spin == 0) return write(place.component, parts.values[place.along]);
        const auto& turn = kernel.turn(frame, place.spin);
        const Number sine = sine_of<Number>(turn.sine);
        Number along = parts.values[place.along], across = parts.values[place.across];
        divide_by_i(turn.power, along, across);
        write(place.component, turn.cosine * along - sine * across);
        write(place.component + 1, sine * along + turn.cosine * across);
    });
}

/// out += matrix * in, the matrix row by row.
template <class Number>
[[gnu::always_inline]] inline void add_product(const double* matrix, std::size_t size, const Number* in, Number* out) {
    for (std::size_t i = 0; i < size; ++i) {
        Number sum = out[i];
        for (std::size_t k = 0; k < size; ++k) sum += matrix[i * size + k] * in[k];
        out[i] = sum;
    }
}

/// sum += (even block) (even parts), (odd block) (odd parts) of `in`; returns the matrix after them.
template <class Number, class Kernel>
[[gnu::always_inline]] inline const double* add_blocks(const Kernel& kernel, const double* matrix,
                                                       const ModeParts<Kernel, Number>& in,
                                                       ModeParts<Kernel, Number>& sum) {
    add_product(matrix, kernel.even, in.values, sum.values);
    add_product(matrix + kernel.even * kernel.even, kernel.odd, in.values + kernel.even, sum.values + kernel.even);
    return matrix + kernel.entries;
}

/// L and Q of a system at q.  Throws an input Error where their blocks have not the sizes of the layout.
IsotropicBlocks linear_blocks(const System& system, double q);
IsotropicBlocks noise_blocks(const System& system, double q);

/// The rows of a block, and the columns of the same numbers.
Block of_rows(const Block& m, const std::vector<int>& rows);

/// Appends the entries of both blocks.
void append_entries(const IsotropicBlocks& blocks, std::vector<double>& to);
/// Their number.
std::size_t block_entries(const Layout& layout);

/// 10 Scalars + Vectors of the FixedKernel for a layout; -1: there is none.
int fixed_kernel(const Layout& layout);

/// work(kernel) for a layout.
template <class Work>
void for_layout(const Layout& layout, Work work) {
    switch (fixed_kernel(layout)) {
        case 1: return work(FixedKernel<0, 1>{});
        case 2: return work(FixedKernel<0, 2>{});
        case 10: return work(FixedKernel<1, 0>{});
        case 11: return work(FixedKernel<1, 1>{});
        case 12: return work(FixedKernel<1, 2>{});
        case 20: return work(FixedKernel<2, 0>{});
        case 21: return work(FixedKernel<2, 1>{});
        case 22: return work(FixedKernel<2, 2>{});
        default: return work(AnyKernel(layout));
    }
}

/// Number of kept modes of a row, which are its first ones.
inline std::size_t kept_in_row(const Grid& grid, const DistinctWavenumbers& wavenumbers, std::size_t row) {
    const std::int32_t* index = wavenumbers.of_mode.data() + row * columns(grid);
    return static_cast<std::size_t>(std::find(index, index + columns(grid), -1) - index);
}

/// Rows of modes in one task of a thread.
inline std::size_t rows_per_chunk(const Grid& grid) {
    constexpr std::size_t modes_at_a_time = 1024;
    return std::max<std::size_t>(1, modes_at_a_time / columns(grid));
}

/// Normal numbers of covariance 1/area, `parts` complex ones for each of the first `kept` modes of a row.  Those of a
/// mode are a function of the key and its signed wavevector (kx, ky) alone: grids of N and 2N points share them.  Their
/// order is that of the parts: the even ones, then the odd ones, each in the order of the fields (block_parts); two
/// numbers for each, its real and its imaginary part.
inline void fill_row_normals(const Grid& grid, const RandomKey& key, std::size_t row, std::size_t kept,
                             std::size_t parts, std::vector<double>& normal) {
    const int ky = mode_number_y(grid, row);
    const auto first = [](int number) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(number)) << 32; };
    normal.resize(std::max(normal.size(), kept * 2 * parts));
    if (kept == 0) return;
    fill_normal(key, first(ky), 2 * parts, std::span(normal.data(), kept * 2 * parts));
    // The conjugate of a mode of column 0 is stored too: it uses the numbers of its partner.
    if (ky < 0) fill_normal(key, first(-ky), 2 * parts, std::span(normal.data(), 2 * parts));
    const double half = std::sqrt(0.5 / area(grid));
    for (std::size_t k = 0; k < kept * 2 * parts; ++k) normal[k] *= half;
    for (std::size_t k = 0; k < parts; ++k) {
        if (ky < 0) normal[2 * k + 1] *= -1.0;
        if (ky != 0) continue;
        normal[2 * k] *= std::numbers::sqrt2;  // the mean is real
        normal[2 * k + 1] = 0.0;
    }
}

/// One mode as an array of its parts; of two modes: one of each array.
template <class Number = Pair, class Kernel>
[[gnu::always_inline]] inline ModeParts<Kernel, Number> load_parts(const Kernel& kernel, const double* from,
                                                                   const double* second = nullptr) {
    ModeParts<Kernel, Number> parts;
    for (std::size_t k = 0; k < kernel.parts; ++k)
        if constexpr (sizeof(Number) == sizeof(Pair)) parts.values[k] = load_as<Pair>(from + 2 * k);
        else parts.values[k] = joined(load_as<Pair>(from + 2 * k), load_as<Pair>(second + 2 * k));
    return parts;
}

template <class Kernel>
[[gnu::always_inline]] inline void store_parts(const Kernel& kernel, const ModeParts<Kernel, Pair>& parts, double* to) {
    for (std::size_t k = 0; k < kernel.parts; ++k) std::memcpy(to + 2 * k, &parts.values[k], sizeof(Pair));
}

}  // namespace drover::numerics
