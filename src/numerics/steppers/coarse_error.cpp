// numerics/steppers/coarse_error.cpp: modes that a coarse and a fine grid share, and how errors of single steps turn.
#include "numerics/steppers/coarse_error.hpp"

#include <numbers>

#include "drover/numerics/block.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::numerics {

namespace {
/// Points along an axis on which the error evolves, at least.
int coarse_points(int points) {
    if (points >= 256) return points / 16 * 2;
    if (points >= 64) return points / 8 * 2;
    return std::min(points, 16);
}

Grid coarse_grid_of(const Grid& fine, int degree, double shortest) {
    const auto points = [&](int of_fine, double length) {
        const int min_points = static_cast<int>(std::ceil(length / (2.0 * std::numbers::pi) * (degree + 1) * shortest));
        if (const int usual = coarse_points(of_fine); usual >= min_points) return usual;
        int result = of_fine;  // or the least of these, even and quick to transform
        for (const int few : {8, 10, 12})
            for (int fewer = few; fewer < result; fewer *= 2)
                if (fewer >= min_points) result = fewer;
        return result;
    };
    return {points(fine.nx, fine.lx), points(fine.ny, fine.ly), fine.lx, fine.ly};
}

std::size_t place(const Grid& grid, int kx, int ky) {
    return static_cast<std::size_t>(ky < 0 ? grid.ny + ky : ky) * columns(grid) + static_cast<std::size_t>(kx);
}

/// The largest rate and frequency; of the odd block where it oscillates.
void see_rates(const IsotropicBlocks& linear, double& rate, double& frequency) {
    for (const Block* block : {&linear.even, &linear.odd})
        for (const std::complex<double> s : eigenvalues(*block)) {
            if (block == &linear.odd && s.imag() == 0.0) continue;
            rate = std::max(rate, s.real());
            frequency = std::max(frequency, std::abs(s.imag()));
        }
}

constexpr double min_sine = 0.2;  // of the angle between two motions that span a plane
}  // namespace

KeptGrid coarse_grid(const Grid& fine, int degree, bool noisy, double shortest) {
    const int kept = noisy ? 1 : degree;
    const Grid usual = coarse_grid_of(fine, kept, 0.0), needed = coarse_grid_of(fine, kept, shortest);
    if (needed.nx == usual.nx && needed.ny == usual.ny) return {usual, kept};
    const int fewer = std::min(kept, 2);
    return {coarse_grid_of(fine, fewer, shortest), fewer};
}

std::vector<ModePair> shared_modes(const KeptGrid& coarse_modes, const KeptGrid& fine_modes) {
    const auto& [coarse, coarse_degree] = coarse_modes;
    const auto& [fine, fine_degree] = fine_modes;
    std::vector<ModePair> result;
    for (std::size_t j = 0; j < static_cast<std::size_t>(coarse.ny); ++j)
        for (std::size_t i = 0; i < columns(coarse); ++i) {
            if (!is_kept(coarse, coarse_degree, i, j)) continue;
            const std::size_t at = place(fine, static_cast<int>(i), mode_number_y(coarse, j));
            if (is_kept(fine, fine_degree, i, at / columns(fine))) result.push_back({j * columns(coarse) + i, at});
        }
    return result;
}

std::vector<ModePair> sampled_modes(const Grid& coarse, const KeptGrid& fine_modes) {
    const auto& [fine, fine_degree] = fine_modes;
    std::vector<ModePair> result;
    const auto folded = [](int k, int points) {
        const int rest = ((k % points) + points) % points;
        return 2 * rest > points ? rest - points : rest;
    };
    for (std::size_t j = 0; j < static_cast<std::size_t>(fine.ny); ++j)
        for (std::size_t i = 0; i < columns(fine); ++i) {
            if (!is_kept(fine, fine_degree, i, j)) continue;
            const int kx = static_cast<int>(i), ky = mode_number_y(fine, j);
            for (const int sign : {1, -1}) {
                if (sign < 0 && kx == 0) continue;  // its conjugate is stored
                const int to_x = folded(sign * kx, coarse.nx), to_y = folded(sign * ky, coarse.ny);
                const bool is_nyquist =
                    (coarse.nx > 1 && 2 * to_x == coarse.nx) || (coarse.ny > 1 && 2 * to_y == coarse.ny);
                if (to_x >= 0 && !is_nyquist)
                    result.push_back({place(coarse, to_x, to_y), j * columns(fine) + i, sign < 0});
            }
        }
    return result;
}

double FieldSize::size_of(const Spectra& spectra, const KeptGrid& on) const {
    double sum = 0.0;
    for (int c = first; c < first + count; ++c)
        sum += sum_over_modes(on, [values = spectra[c]](std::size_t mode) { return std::norm(values[mode]); });
    return std::sqrt(sum);
}

void FieldSize::add_moment(const Spectra& fields, const KeptGrid& on, bool noisy, double weight) {
    size = size_of(fields, on);
    std::array<double, 2> mean{};
    for (int c = 0; c < count; ++c) mean[static_cast<std::size_t>(c)] = fields[first + c][0].real();
    const double square = mean[0] * mean[0] + mean[1] * mean[1];
    variance = std::max(0.0, size * size - square);
    // Noise turns the direction of a flock without limit, which is no fluctuation of its own.
    if (noisy && count == 2) mean = {std::sqrt(square), 0.0};
    moments += weight;
    squares += weight * size * size;
    for (std::size_t k = 0; k < mean.size(); ++k) means[k] += weight * mean[k];
    largest = std::max(largest, size);
}

std::vector<FastWave> fast_waves(const System& system, double dt) {
    constexpr double turn = 0.5;  // radians a step
    const DistinctWavenumbers wavenumbers = distinct_wavenumbers(system.grid, system.degree);
    std::vector<double> rate(wavenumbers.q.size(), -INFINITY), frequency(wavenumbers.q.size());
    for (std::size_t n = 0; n < wavenumbers.q.size(); ++n)
        see_rates(system.linear(wavenumbers.q[n]), rate[n], frequency[n]);
    std::vector<FastWave> result;
    for (std::size_t mode = 0; mode < wavenumbers.of_mode.size(); ++mode) {
        if (wavenumbers.of_mode[mode] < 0) continue;
        const auto n = static_cast<std::size_t>(wavenumbers.of_mode[mode]);
        if (frequency[n] * dt > turn)
            result.push_back({mode, std::min(1.0, std::exp(rate[n] * dt)), frequency[n] * dt > 2.0});
    }
    return result;
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
