// model/mode_operators.cpp: sums of derivatives by loops over a row, for polynomials in q of low and of any degree;
// fields to the frame of q, the entries of the matrices, and back.
#include "model/mode_operators.hpp"

#include <algorithm>

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

const double* parts_of(const Complex* values) { return reinterpret_cast<const double*>(values); }
double* parts_of(Complex* values) { return reinterpret_cast<double*>(values); }

/// to += i factor * from, or factor * from; `factor` of each mode is given twice.
void add_entry(std::size_t modes, bool is_imaginary, const double* factor, const double* from, double* __restrict to) {
    if (!is_imaginary) {
        for (std::size_t i = 0; i < 2 * modes; ++i) to[i] += factor[i] * from[i];
        return;
    }
    for (std::size_t i = 0; i < 2 * modes; i += 2) {
        to[i] -= factor[i] * from[i + 1];
        to[i + 1] += factor[i] * from[i];
    }
}

/// Two components to the frame of q, or back if the sign is -1.
void turn_pair(std::size_t size, const double* cosine, const double* sine, double sign, const double* first,
               const double* second, double* to_first, double* to_second) {
#pragma GCC ivdep  // the results may be where the components are, and nowhere else
    for (std::size_t i = 0; i < size; ++i) {
        const double s = sign * sine[i], a = first[i], b = second[i];
        to_first[i] = cosine[i] * a + s * b;
        to_second[i] = cosine[i] * b - s * a;
    }
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
    auto part =
        std::ranges::find_if(parts_, [&](const Part& one) { return one.array == array && one.is_odd == is_odd; });
    if (part == parts_.end())
        part =
            parts_.insert(is_odd ? parts_.end() : std::ranges::find_if(parts_, [](const Part& p) { return p.is_odd; }),
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

FrameOperator::FrameOperator(const CompiledEquations& equations, const std::vector<Symbol>& matrices,
                             const numerics::DistinctWavenumbers& wavenumbers, const std::vector<bool>& results)
    : inverse_(wavenumbers.inverse) {
    const int count = equations.components;
    std::vector<bool> is_read(results.size(), false), is_written = results;
    const auto has_entry = [&](int row, int column) {
        return std::ranges::any_of(matrices, [&](const Symbol& m) { return m(row, column) != 0.0; });
    };
    std::vector<std::pair<int, int>> found;
    for (int row = 0; row < count; ++row)
        for (int column = 0; column < count; ++column) {
            if (!has_entry(row, column)) continue;
            found.emplace_back(row, column);
            is_written[static_cast<std::size_t>(row)] = is_read[static_cast<std::size_t>(column)] = true;
        }
    add_parts(equations, is_read, from_);
    add_parts(equations, is_written, to_);
    const auto part_with = [](const std::vector<Part>& parts, int component) {
        const auto is_it = [&](const Part& part) { return part.component == component; };
        return static_cast<std::size_t>(std::ranges::find_if(parts, is_it) - parts.begin());
    };
    for (const auto& [row, column] : found)
        entries_.push_back({.to = part_with(to_, row),
                            .from = part_with(from_, column),
                            .is_imaginary = (equations.spin_of(row) - equations.spin_of(column)) % 2 != 0});
    for (const Symbol& m : matrices)
        for (std::size_t e = 0; e < entries_.size(); ++e) {
            const Complex value = m(found[e].first, found[e].second);
            values_.push_back(entries_[e].is_imaginary ? value.imag() : value.real());
        }
}

/// Both components of a field of which one takes part.
void FrameOperator::add_parts(const CompiledEquations& equations, const std::vector<bool>& takes_part,
                              std::vector<Part>& parts) {
    for (std::size_t i = 0; i < equations.model.fields.size(); ++i) {
        const int first = equations.first_component[i], width = components(equations.model.fields[i]);
        const auto spin = static_cast<std::size_t>(equations.spin_of(first));
        const auto begin = takes_part.begin() + first;
        if (std::find(begin, begin + width, true) == begin + width) continue;
        for (int k = 0; k < width; ++k) parts.push_back({.component = first + k, .spin = spin});
        max_spin_ = std::max(max_spin_, spin);
    }
}

/// Of each spin from 1 up, at the modes of a row.
void FrameOperator::find_turns(const ModeRow& row, Turn* turns) const {
    if (max_spin_ == 0) return;
    Turn& unit = turns[0];
    for (std::size_t i = 0; i < row.size; ++i) {
        const double inverse = inverse_[static_cast<std::size_t>(row.length[i])];
        unit.cosine[2 * i] = unit.cosine[2 * i + 1] = inverse == 0.0 ? 1.0 : row.x[2 * i] * inverse;
        unit.sine[2 * i] = unit.sine[2 * i + 1] = row.y * inverse;
    }
    for (std::size_t n = 1; n < max_spin_; ++n) {
        const Turn& last = turns[n - 1];
        for (std::size_t i = 0; i < 2 * row.size; ++i) {
            turns[n].cosine[i] = last.cosine[i] * unit.cosine[i] - last.sine[i] * unit.sine[i];
            turns[n].sine[i] = last.sine[i] * unit.cosine[i] + last.cosine[i] * unit.sine[i];
        }
    }
}

/// The components that turn, into rows; `values` follows.
void FrameOperator::turn(const std::vector<Part>& parts, std::size_t size, const Turn* turns, double sign,
                         const double** values, Row* rows) {
    for (std::size_t k = 0; k + 1 < parts.size(); ++k) {
        if (parts[k].spin == 0) continue;
        const Turn& turn = turns[parts[k].spin - 1];
        turn_pair(size, turn.cosine.data(), turn.sine.data(), sign, values[k], values[k + 1], rows[k].data(),
                  rows[k + 1].data());
        for (const std::size_t i : {k, k + 1}) values[i] = rows[i].data();
        ++k;
    }
}

void FrameOperator::apply(const ModeRow& row, std::span<const Complex* const> from, std::span<Complex* const> to,
                          bool subtracts) const {
    if (to_.empty()) return;
    const std::size_t size = 2 * row.size, count = from_.size() + to_.size();
    const auto rows = std::make_unique_for_overwrite<Row[]>(count);
    const auto values = std::make_unique_for_overwrite<const double*[]>(count);
    const auto turns = std::make_unique_for_overwrite<Turn[]>(max_spin_);
    find_turns(row, turns.get());
    for (std::size_t k = 0; k < from_.size(); ++k)
        values[k] = parts_of(from[static_cast<std::size_t>(from_[k].component)] + row.first);
    turn(from_, size, turns.get(), 1.0, values.get(), rows.get());
    Row* const results = rows.get() + from_.size();
    for (std::size_t k = 0; k < to_.size(); ++k) {
        values[from_.size() + k] = results[k].data();
        std::fill_n(results[k].begin(), size, 0.0);
    }
    Row factor;
    for (std::size_t e = 0; e < entries_.size(); ++e) {
        for (std::size_t i = 0; i < row.size; ++i)
            factor[2 * i] = factor[2 * i + 1] = values_[static_cast<std::size_t>(row.length[i]) * entries_.size() + e];
        add_entry(row.size, entries_[e].is_imaginary, factor.data(), values[entries_[e].from],
                  results[entries_[e].to].data());
    }
    turn(to_, size, turns.get(), -1.0, values.get() + from_.size(), results);
    for (std::size_t k = 0; k < to_.size(); ++k) {
        double* result = parts_of(to[static_cast<std::size_t>(to_[k].component)] + row.first);
        if (!subtracts) std::copy_n(results[k].begin(), size, result);
        else
            for (std::size_t i = 0; i < size; ++i) result[i] -= results[k][i];
    }
}

}  // namespace drover::model
