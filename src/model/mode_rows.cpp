// model/mode_rows.cpp: sums of derivatives by loops over a row, for polynomials in q of low and of any degree.
#include "model/mode_rows.hpp"

#include <algorithm>
#include <array>

#include "numerics/steppers/isotropic.hpp"

namespace drover::model {

namespace {
using numerics::Complex;
using numerics::load_as;
using numerics::Quad;

constexpr int max_power = 3;  // of q_x, in the loops that the compiler knows

/// A polynomial in q_x, of one row, that multiplies an array.
struct Factor {
    const Complex* array = nullptr;
    const double* powers = nullptr;  ///< of q_x
};

/// The product with two modes: `x` has q_x of both twice.
template <int Power, bool IsOdd>
[[gnu::always_inline]] inline Quad term(const double* powers, const Quad& x, const Quad& field) {
    Quad factor = Quad{} + powers[Power];
    for (int n = Power - 1; n >= 0; --n) factor = factor * x + powers[n];
    if constexpr (!IsOdd) return factor * field;
    return factor * numerics::times_i(field);
}

/// to (+)= sum of polynomials times arrays, of one power and one parity.
template <int Power, bool IsOdd, bool Adds, std::size_t Count>
void write_terms(const ModeRow& row, const Factor* factors, Complex* to) {
    std::array<std::array<double, max_power + 1>, Count> powers;
    std::array<const Complex*, Count> arrays;
    for (std::size_t k = 0; k < Count; ++k) {
        std::copy_n(factors[k].powers, Power + 1, powers[k].begin());
        arrays[k] = factors[k].array + row.first;
    }
    to += row.first;
    const auto sum_at = [&](const Quad& x, const auto& load_field, Quad sum) __attribute__((always_inline)) {
        for (std::size_t k = 0; k < Count; ++k) sum += term<Power, IsOdd>(powers[k].data(), x, load_field(arrays[k]));
        return sum;
    };
    std::size_t i = 0;
    for (; i + 2 <= row.size; i += 2) {
        const auto load = [i](const Complex* from) { return load_as<Quad>(from + i); };
        const Quad sum = sum_at(load_as<Quad>(row.x + 2 * i), load, Adds ? load_as<Quad>(to + i) : Quad{});
        std::memcpy(reinterpret_cast<double*>(to + i), &sum, sizeof(sum));
    }
    if (i == row.size) return;
    const auto single = [i](const Complex* from) { return Quad{from[i].real(), from[i].imag(), 0.0, 0.0}; };
    const double x = row.x[2 * i];
    const Quad sum = sum_at(Quad{x, x, x, x}, single, Adds ? single(to) : Quad{});
    to[i] = {sum[0], sum[1]};
}

template <bool IsOdd, bool Adds, std::size_t Count>
void write_powers(int power, const ModeRow& row, const Factor* factors, Complex* to) {
    switch (power) {
        case 0: return write_terms<0, IsOdd, Adds, Count>(row, factors, to);
        case 1: return write_terms<1, IsOdd, Adds, Count>(row, factors, to);
        case 2: return write_terms<2, IsOdd, Adds, Count>(row, factors, to);
        default: return write_terms<3, IsOdd, Adds, Count>(row, factors, to);
    }
}

template <bool IsOdd, bool Adds>
void write_count(std::size_t count, int power, const ModeRow& row, const Factor* factors, Complex* to) {
    if (count == 1) write_powers<IsOdd, Adds, 1>(power, row, factors, to);
    else write_powers<IsOdd, Adds, 2>(power, row, factors, to);
}

/// Of any power of q_x: to (+)= polynomial * array.
void write_any(int power, bool is_odd, bool adds, const ModeRow& row, const Factor& factor, Complex* to) {
    for (std::size_t i = 0; i < row.size; ++i) {
        double value = factor.powers[power];
        for (int n = power - 1; n >= 0; --n) value = value * row.x[2 * i] + factor.powers[n];
        const Complex field = factor.array[row.first + i];
        const Complex product = is_odd ? Complex(-value * field.imag(), value * field.real()) : value * field;
        to[row.first + i] = adds ? to[row.first + i] + product : product;
    }
}

double power_of(double base, int exponent) {
    double result = 1.0;
    for (int i = 0; i < exponent; ++i) result *= base;
    return result;
}
}  // namespace

ModeRows::ModeRows(const numerics::Grid& grid, const numerics::DistinctWavenumbers& wavenumbers) {
    const std::size_t width = numerics::columns(grid);
    for (std::size_t i = 0; i < width; ++i) x_.insert(x_.end(), 2, numerics::wavevector(grid, i, 0).x);
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j) {
        const std::int32_t* lengths = wavenumbers.of_mode.data() + j * width;
        const auto kept = static_cast<std::size_t>(std::find(lengths, lengths + width, -1) - lengths);
        for (std::size_t i = 0; i < kept; i += max_size)
            rows_.push_back({.first = j * width + i,
                             .size = std::min(max_size, kept - i),
                             .x = x_.data() + 2 * i,
                             .y = numerics::wavevector(grid, 0, j).y,
                             .length = lengths + i});
    }
}

void DerivativeSum::add(std::size_t array, const Order& order, double factor) {
    const int n = order.x + order.y;
    const bool is_odd = n % 2 == 1;
    auto part = std::find_if(parts_.begin(), parts_.end(),
                             [&](const Part& one) { return one.array == array && one.is_odd == is_odd; });
    if (part == parts_.end())
        part =
            parts_.insert(is_odd ? parts_.end()
                                 : std::find_if(parts_.begin(), parts_.end(), [](const Part& p) { return p.is_odd; }),
                          Part{.array = array, .is_odd = is_odd});
    part->monomials.emplace_back(order, n % 4 < 2 ? factor : -factor);
    part->power = std::max(part->power, order.x);
}

void DerivativeSum::write(const ModeRow& row, std::span<const Complex* const> arrays, Complex* to, bool adds) const {
    constexpr auto max_powers = static_cast<std::size_t>(max_order) + 1;
    std::array<std::array<double, max_powers>, 2> powers;
    for (std::size_t k = 0; k < parts_.size();) {
        std::array<Factor, 2> factors;
        const bool is_odd = parts_[k].is_odd;
        const std::size_t count = k + 1 < parts_.size() && parts_[k + 1].is_odd == is_odd ? 2 : 1;
        const int power = std::max(parts_[k].power, parts_[k + count - 1].power);
        for (std::size_t i = 0; i < count; ++i) {
            std::fill_n(powers[i].begin(), power + 1, 0.0);
            for (const auto& [order, factor] : parts_[k + i].monomials)
                powers[i][static_cast<std::size_t>(order.x)] += factor * power_of(row.y, order.y);
            factors[i] = {arrays[parts_[k + i].array], powers[i].data()};
        }
        if (power > max_power)
            for (std::size_t i = 0; i < count; ++i) write_any(power, is_odd, adds || i > 0, row, factors[i], to);
        else if (is_odd && adds) write_count<true, true>(count, power, row, factors.data(), to);
        else if (is_odd) write_count<true, false>(count, power, row, factors.data(), to);
        else if (adds) write_count<false, true>(count, power, row, factors.data(), to);
        else write_count<false, false>(count, power, row, factors.data(), to);
        adds = true;
        k += count;
    }
    if (!adds) std::fill_n(to + row.first, row.size, Complex(0.0));
}

}  // namespace drover::model
