// numerics/steppers/linear_operator.cpp: isotropic blocks on the modes of a state, and the sum with the remainder.
#include "numerics/steppers/linear_operator.hpp"

#include <algorithm>

#include "numerics/algebra/dense.hpp"
#include "numerics/steppers/isotropic.hpp"

namespace drover::numerics {

LinearOperator::LinearOperator(const System& system)
    : grid_(system.grid), layout_(system.layout), wavenumbers_(distinct_wavenumbers(system.grid, system.degree)) {
    for (const double q : wavenumbers_.q) append_entries(linear_blocks(system, q), matrices_);
}

void LinearOperator::add(const Spectra& state, Spectra& rate) const {
    for_layout(layout_, [&](const auto& kernel) {
        const std::size_t width = columns(grid_), rows = static_cast<std::size_t>(grid_.ny);
        for (std::size_t row = 0; row < rows; ++row)
            for (std::size_t i = 0, kept = kept_in_row(grid_, wavenumbers_, row); i < kept; ++i) {
                const std::size_t m = row * width + i;
                const auto n = static_cast<std::size_t>(wavenumbers_.of_mode[m]);
                const auto frame = kernel.frame(direction(wavevector(grid_, i, row), wavenumbers_.inverse[n]));
                auto sum = zero_parts(kernel);
                add_blocks(kernel, matrices_.data() + n * kernel.entries,
                           parts_of(kernel, {state.values.data() + m, state.stride}, frame), sum);
                write_parts(kernel, sum, rate.values.data() + m, {rate.values.data() + m, rate.stride}, frame);
            }
    });
}

namespace {
/// m = (1 - gamma m)^-1, row by row.
void invert_shifted(double* m, std::size_t size, double gamma) {
    using Rows = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
    const auto rows = static_cast<Eigen::Index>(size);
    Rows matrix(m, rows, rows);
    const Eigen::MatrixXd shifted = Eigen::MatrixXd::Identity(rows, rows) - gamma * matrix;
    matrix = inverse(shifted);
}
}  // namespace

LinearOperator LinearOperator::shifted_inverse(double gamma) const {
    LinearOperator result = *this;
    const BlockParts parts = block_parts(layout_);
    double* matrix = result.matrices_.data();
    for (std::size_t n = 0; n < wavenumbers_.q.size(); ++n)
        for (const std::size_t size : {parts.even.size(), parts.odd.size()}) {
            invert_shifted(matrix, size, gamma);
            matrix += size * size;
        }
    return result;
}

void WholeRate::write(double t, const Spectra& state, Spectra& rate) const {
    std::ranges::fill(rate.values, Complex(0.0));
    if (system.nonlinear) system.nonlinear(t, state, rate);
    linear.add(state, rate);
}

Spectra WholeRate::operator()(double t, const Spectra& state) const {
    Spectra rate(system.grid, state.count());
    write(t, state, rate);
    return rate;
}

}  // namespace drover::numerics
