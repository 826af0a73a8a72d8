// numerics/steppers/local_errors.cpp: how errors of single steps turn.
#include "numerics/steppers/local_errors.hpp"

#include <algorithm>
#include <cmath>

#include "numerics/fields/shells.hpp"

namespace drover::numerics {

namespace {
constexpr double min_sine = 0.2;  // of the angle between two motions that span a plane
}

double product_of(const Spectra& a, const Spectra& b, const std::vector<FieldSize>& fields, const KeptGrid& on) {
    double product = 0.0;
    for (const FieldSize& field : fields) {
        const double scale = field.fluctuation();
        if (scale == 0.0) continue;
        for (int c = field.first; c < field.first + field.count; ++c)
            product += sum_over_modes(on,
                                      [x = a[c], y = b[c]](std::size_t mode) {
                                          return x[mode].real() * y[mode].real() + x[mode].imag() * y[mode].imag();
                                      }) /
                       (scale * scale);
    }
    return product;
}

double angle_between(const Spectra& a, const Spectra& b, const std::vector<FieldSize>& fields, const KeptGrid& on) {
    const double sizes = std::sqrt(product_of(a, a, fields, on)) * std::sqrt(product_of(b, b, fields, on));
    return sizes > 0.0 ? std::acos(std::clamp(product_of(a, b, fields, on) / sizes, -1.0, 1.0)) : 0.0;
}

void LocalErrors::add(const Spectra& local, const Spectra& change, double size_now, double size_before,
                      const std::vector<FieldSize>& fields, const KeptGrid& coarse) {
    const double from_last = std::sin(angle_between(change, motion, fields, coarse)),
                 from_other = std::sin(angle_between(change, other_motion, fields, coarse));
    if (from_last > min_sine || from_other <= min_sine) {
        other.values = last.values;
        other_motion.values = motion.values;
    }
    std::swap(last, before);
    last.values = local.values;
    motion.values = change.values;
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

bool LocalErrors::follow(const Spectra& change, const std::vector<FieldSize>& fields, const KeptGrid& coarse,
                         Spectra& error) const {
    const auto product = [&](const Spectra& a, const Spectra& b) { return product_of(a, b, fields, coarse); };
    const double square = product(motion, motion), other_square = product(other_motion, other_motion),
                 both = product(motion, other_motion), of_last = product(change, motion),
                 of_other = product(change, other_motion), all = product(change, change);
    if (!(square > 0.0)) return false;
    double a = of_last / square, b = 0.0;
    const double area = square * other_square - both * both;
    if (area > min_sine * min_sine * square * other_square) {
        a = (of_last * other_square - of_other * both) / area;
        b = (of_other * square - of_last * both) / area;
    }
    constexpr double largest_rest = 0.5, largest_factor = 4.0;
    const double rest = all - a * of_last - b * of_other;
    if (!(rest <= largest_rest * largest_rest * all) || std::abs(a) + std::abs(b) > largest_factor) return false;
    for (std::size_t k = 0; k < error.values.size(); ++k) error.values[k] = a * last.values[k] + b * other.values[k];
    return true;
}

}  // namespace drover::numerics
