// numerics/steppers/mode_vector.cpp: kept modes to real numbers and back.
#include "numerics/steppers/mode_vector.hpp"
#include "base/mapped.hpp"

namespace drover::numerics {

ModeVector::ModeVector(const Grid& grid, const Layout& layout, int degree) {
    const std::size_t width = columns(grid), rows = static_cast<std::size_t>(grid.ny);
    for (std::size_t row = 0; row < rows; ++row)
        for (std::size_t column = 0; column < width; ++column) {
            if (!is_kept(grid, degree, column, row) || (column == 0 && 2 * row > rows)) continue;
            const std::size_t mode = row * width + column;
            const bool is_mean = mode == 0;
            places_.push_back({mode, column == 0 && !is_mean ? (rows - row) * width : mode, is_mean});
            weights_.insert(weights_.end(), is_mean ? 1 : 2, is_mean ? 1.0 : 2.0);
        }
    size_ = weights_.size() * static_cast<std::size_t>(components(layout));
    for (const FieldKind& kind : layout.fields) {
        const std::size_t begin = fields_.empty() ? 0 : fields_.back().end;
        fields_.push_back({begin, begin + weights_.size() * static_cast<std::size_t>(components(kind))});
    }
}

void ModeVector::pack(const Spectra& state, std::span<double> to) const {
    double* next = to.data();
    for (int c = 0; c < state.count(); ++c)
        for (const Place& place : places_) {
            const Complex value = state[c][place.mode];
            *next++ = value.real();
            if (!place.is_real) *next++ = value.imag();
        }
}

void ModeVector::unpack(std::span<const double> from, Spectra& state) const {
    const double* next = from.data();
    for (int c = 0; c < state.count(); ++c) {
        const std::span<Complex> values = state[c];
        for (const Place& place : places_) {
            const double real = *next++;
            const Complex value(real, place.is_real ? 0.0 : *next++);
            values[place.mode] = value;
            if (place.conjugate != place.mode) values[place.conjugate] = std::conj(value);
        }
    }
}

std::vector<double> ModeVector::mean_squares(std::span<const double> values) const {
    return mapped(fields_, [&](const Field& field) {
        double sum = 0.0;
        for (std::size_t i = field.begin; i < field.end; ++i) sum += weight(i) * values[i] * values[i];
        return sum;
    });
}

}  // namespace drover::numerics
