// model/frame_operator.cpp: fields of a row of modes to the frame of q, the entries of the matrices, and back.
#include "model/frame_operator.hpp"

#include <algorithm>
#include <memory>

namespace drover::model {

namespace {
using numerics::Complex;

const double* parts_of(const Complex* values) { return reinterpret_cast<const double*>(values); }
double* parts_of(Complex* values) { return reinterpret_cast<double*>(values); }
}  // namespace

FrameOperator::FrameOperator(const CompiledEquations& equations, const std::vector<Symbol>& matrices,
                             const numerics::DistinctWavenumbers& wavenumbers, const std::vector<bool>& results)
    : inverse_(wavenumbers.inverse) {
    const int count = equations.components;
    std::vector<bool> is_read(results.size(), false), is_written = results;
    const auto has_entry = [&](int row, int column) {
        return std::any_of(matrices.begin(), matrices.end(), [&](const Symbol& m) { return m(row, column) != 0.0; });
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
        return static_cast<std::size_t>(std::find_if(parts.begin(), parts.end(), is_it) - parts.begin());
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

namespace {
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
}  // namespace

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

namespace {
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
