// numerics/steppers/mode_vector.hpp: the independent real numbers of the kept modes of a state, for solvers of vectors.
#pragma once
#include <span>
#include <vector>

#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// The storage of real fields in Fourier modes is redundant: the modes of column 0 come in conjugate pairs, and modes
/// that are not kept are zero.  Here each real number of a state occurs once, component by component.
class ModeVector {
public:
    /// A field of the state, with both of its components if it has two.
    struct Field {
        std::size_t begin = 0, end = 0;
    };

    ModeVector(const Grid& grid, const Layout& layout, int degree);

    std::size_t size() const { return size_; }
    const std::vector<Field>& fields() const { return fields_; }

    void pack(const Spectra& state, std::span<double> to) const;
    /// Writes the kept modes of `state`.
    void unpack(std::span<const double> from, Spectra& state) const;

    /// Mean squares over the cell of each field of a vector: a mode and its conjugate count.
    std::vector<double> mean_squares(std::span<const double> values) const;
    /// The weight of a number in the mean square of its field.
    double weight(std::size_t number) const { return weights_[number % weights_.size()]; }

private:
    struct Place {
        std::size_t mode, conjugate;  // equal where the conjugate is not stored
        bool is_real;
    };
    std::vector<Place> places_;    // of one component
    std::vector<double> weights_;  // of the numbers of one component
    std::vector<Field> fields_;
    std::size_t size_ = 0;
};

}  // namespace drover::numerics
