// numerics/local_errors.cpp: how errors of single steps turn.
#include "numerics/local_errors.hpp"

#include <algorithm>
#include <cmath>

#include "drover/numerics/shells.hpp"

namespace drover::numerics {

namespace {
double angle_between(const Spectra& a, const Spectra& b, const std::vector<FieldSize>& fields, const Grid& grid) {
    double product = 0.0, squares_a = 0.0, squares_b = 0.0;
    for (const FieldSize& field : fields) {
        const double scale = field.fluctuation(), per_square = scale > 0.0 ? 1.0 / (scale * scale) : 0.0;
        for (int c = field.first; c < field.first + field.count; ++c)
            for (std::size_t m = 0; m < a.size; ++m) {
                const double weight = per_square * mode_weight(grid, m % columns(grid));
                product += weight * (a[c][m].real() * b[c][m].real() + a[c][m].imag() * b[c][m].imag());
                squares_a += weight * std::norm(a[c][m]);
                squares_b += weight * std::norm(b[c][m]);
            }
    }
    const double sizes = std::sqrt(squares_a) * std::sqrt(squares_b);
    return sizes > 0.0 ? std::acos(std::clamp(product / sizes, -1.0, 1.0)) : 0.0;
}
}  // namespace

void LocalErrors::add(const Spectra& local, double size_now, double size_before, const std::vector<FieldSize>& fields,
                      const Grid& coarse) {
    std::swap(last, before);
    last.values = local.values;
    angle = angle_between(last, before, fields, coarse);
    const double factor = size_now / size_before;
    trend = factor > 0.0 && std::isfinite(factor) ? std::clamp(factor, 0.09, 4.0) : 1.0;
}

void LocalErrors::predict(double intervals, Spectra& mean) const {
    double of_last = std::sqrt(trend), of_before = 0.0;
    constexpr double furthest = 1.2661;  // radians: beyond, what comes is unknown
    if (angle < furthest && angle > 1e-6) {
        const double half = 0.5 * std::min(intervals, 2.0) * angle;  // of the turn to come
        const double length = std::sin(half) / half;
        of_before = -of_last * trend * length * std::sin(half) / std::sin(angle);
        of_last *= length * std::sin(angle + half) / std::sin(angle);
    }
    for (std::size_t k = 0; k < mean.values.size(); ++k)
        mean.values[k] = of_last * last.values[k] + of_before * before.values[k];
}

}  // namespace drover::numerics
