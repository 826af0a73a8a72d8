// numerics/steppers/noise_path.cpp: a binary tree of noise increments over time.
#include "numerics/steppers/noise_path.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace drover::numerics {

namespace {
/// Roots are shorter than this [s], where dt is: the longest interval over which steps of dt and dt/2^k share noise.
constexpr double max_root = 16.0;
/// A mode grows by at most e^8 within a root: the halves are differences of its increments.
constexpr double max_growth = 8.0;
constexpr int max_levels = 30;

double fastest_growth(const System& system, const std::vector<double>& wavenumbers) {
    double largest = 0.0;
    for (const double q : wavenumbers) {
        const IsotropicBlocks rates = linear_blocks(system, q);
        for (const Block* block : {&rates.even, &rates.odd})
            for (const std::complex<double>& rate : eigenvalues(*block)) largest = std::max(largest, rate.real());
    }
    return largest;
}

/// Doublings of dt up to the length of a root.
int doublings_to_root(const System& system, const std::vector<double>& wavenumbers, double dt) {
    const auto doublings = [dt](double longest) {
        int level = 0;
        while (level < max_levels && std::ldexp(dt, level + 1) < longest) ++level;
        return level;
    };
    const int max_doublings = doublings(max_root);
    if (max_doublings == 0) return 0;
    const double growth = fastest_growth(system, wavenumbers);
    return growth > 0.0 ? std::min(max_doublings, doublings(max_growth / growth)) : max_doublings;
}

std::size_t numbers_of(const Layout& layout) { return 2 * static_cast<std::size_t>(components(layout)); }

/// The noises of products as fields.
System noises_of_products(const System& system) {
    const ProductNoise& noise = *system.product_noise;
    System result{.grid = system.grid, .layout = noise.layout, .linear = noise.linear};
    result.noise = noise.noise;
    result.degree = system.degree;
    result.noise_path = system.noise_path;
    return result;
}
}  // namespace

NoisePath::NoisePath(const System& system, double dt, std::uint64_t seed, Threads& threads, Stream stream)
    : system_(system),
      wavenumbers_(distinct_wavenumbers(system.grid, system.degree)),
      seed_(seed),
      stream_(stream),
      threads_(threads),
      level_(doublings_to_root(system, wavenumbers_.q, dt)),
      root_(std::ldexp(dt, level_)),
      numbers_(numbers_of(system.layout)),
      row_begin_{0} {
    for (std::size_t row = 0; row < static_cast<std::size_t>(system.grid.ny); ++row)
        row_begin_.push_back(row_begin_.back() + kept_in_row(system.grid, wavenumbers_, row));
    if (system.product_noise)
        of_products_ =
            std::make_unique<NoisePath>(noises_of_products(system), dt, seed, threads, Stream::product_noise);
}

const double* NoisePath::row(int level, std::size_t row) const {
    return levels_[static_cast<std::size_t>(level)].values.data() + row_begin_[row] * numbers_;
}

/// The matrices of a level and of those above it, of all |q|.
void NoisePath::prepare(int level) {
    const auto first = static_cast<int>(levels_.size());
    if (first > level) return;
    const std::size_t entries = block_entries(system_.layout);
    std::vector<Level> made(static_cast<std::size_t>(level - first + 1));
    for (int k = first; k <= level; ++k) {
        Level& now = made[static_cast<std::size_t>(k - first)];
        now.values.resize(row_begin_.back() * numbers_);
        now.draw.resize(wavenumbers_.q.size() * entries * (k == 0 ? 1 : 2));
        now.propagator.resize(k == 0 ? 0 : wavenumbers_.q.size() * entries);
    }
    const int first_halves = std::max(first, 1), halves = level - first_halves + 1;
    const auto of_wavenumber = [&](std::size_t n) {
        const double q = wavenumbers_.q[n];
        const IsotropicBlocks m = linear_blocks(system_, q), covariance = noise_blocks(system_, q);
        std::vector<double> entries_of_n;
        const auto store = [&](std::vector<double>& to) {
            std::ranges::copy(entries_of_n, to.data() + n * entries_of_n.size());
            entries_of_n.clear();
        };
        const double whole = std::ldexp(root_, 1 - first_halves);
        const NoiseTree even = noise_tree(m.even, covariance.even, whole, halves),
                        odd = noise_tree(m.odd, covariance.odd, whole, halves);
        if (first == 0) {
            append_entries({factor(even.covariance), factor(odd.covariance)}, entries_of_n);
            store(made.front().draw);
        }
        for (std::size_t k = 0; k < even.halves.size(); ++k) {
            Level& now = made[static_cast<std::size_t>(first_halves - first) + k];
            append_entries({even.halves[k].regression, odd.halves[k].regression}, entries_of_n);
            append_entries({even.halves[k].spread, odd.halves[k].spread}, entries_of_n);
            store(now.draw);
            append_entries({even.halves[k].propagator, odd.halves[k].propagator}, entries_of_n);
            store(now.propagator);
        }
    };
    constexpr std::size_t wavenumbers_per_chunk = 64;
    threads_.for_chunks(wavenumbers_.q.size(), wavenumbers_per_chunk, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) of_wavenumber(n);
    });
    std::move(made.begin(), made.end(), std::back_inserter(levels_));
}

/// One kept mode of a row.
struct NoisePath::Mode {
    std::size_t row, column;
    std::size_t wavenumber;  ///< the index of its |q|
    std::size_t begin;       ///< of its numbers, in Level::values
    const double* normal;    ///< normal numbers, where there is a key
};

/// body(kernel, Mode) for every kept mode, on any thread.  key: of normal numbers; nullptr: none.
template <class Body>
void NoisePath::for_modes(const RandomKey* key, Body body) {
    for_layout(system_.layout, [&](const auto& kernel) {
        const auto of_row = [&](std::size_t row, std::vector<double>& normal) {
            const std::size_t kept = row_begin_[row + 1] - row_begin_[row];
            if (key != nullptr) fill_row_normals(system_.grid, *key, row, kept, numbers_ / 2, normal);
            const std::int32_t* of_mode = wavenumbers_.of_mode.data() + row * columns(system_.grid);
            for (std::size_t i = 0; i < kept; ++i)
                body(kernel, Mode{.row = row,
                                  .column = i,
                                  .wavenumber = static_cast<std::size_t>(of_mode[i]),
                                  .begin = (row_begin_[row] + i) * numbers_,
                                  .normal = key != nullptr ? normal.data() + i * numbers_ : nullptr});
        };
        threads_.for_chunks(static_cast<std::size_t>(system_.grid.ny), rows_per_chunk(system_.grid),
                            [&](std::size_t begin, std::size_t end) {
                                std::vector<double> normal;
                                for (std::size_t row = begin; row < end; ++row) of_row(row, normal);
                            });
    });
}

void NoisePath::draw_root(std::uint64_t index) {
    Level& root = levels_.front();
    const RandomKey key{.seed = seed_, .stream = stream_, .step = index, .substep = system_.noise_path << 32u};
    for_modes(&key, [&](const auto& kernel, const Mode& mode) {
        auto sum = zero_parts(kernel);
        add_blocks(kernel, root.draw.data() + mode.wavenumber * kernel.entries, load_parts(kernel, mode.normal), sum);
        store_parts(kernel, sum, root.values.data() + mode.begin);
    });
}

/// The first half of the interval that the level above holds.
void NoisePath::draw_first_half(int level, std::uint64_t index) {
    Level& now = levels_[static_cast<std::size_t>(level)];
    const Level& above = levels_[static_cast<std::size_t>(level - 1)];
    // The intervals of a root, row by row from the top: 1, then 2 and 3, ...; each has the numbers of its first half.
    const std::uint64_t in_root = index & ((std::uint64_t{1} << level) - 1);
    const RandomKey key{.seed = seed_,
                        .stream = stream_,
                        .step = index >> level,
                        .substep = (system_.noise_path << 32u) + (((std::uint64_t{1} << level) + in_root) >> 1)};
    for_modes(&key, [&](const auto& kernel, const Mode& mode) {
        auto sum = zero_parts(kernel);
        const double* matrix = now.draw.data() + mode.wavenumber * 2 * kernel.entries;
        matrix = add_blocks(kernel, matrix, load_parts(kernel, above.values.data() + mode.begin), sum);
        add_blocks(kernel, matrix, load_parts(kernel, mode.normal), sum);
        store_parts(kernel, sum, now.values.data() + mode.begin);
    });
}

/// From the first half, which the level holds, and the interval that the level above holds.
void NoisePath::compute_second_half(int level) {
    Level& now = levels_[static_cast<std::size_t>(level)];
    const Level& above = levels_[static_cast<std::size_t>(level - 1)];
    for_modes(nullptr, [&](const auto& kernel, const Mode& mode) {
        double* half = now.values.data() + mode.begin;
        auto sum = zero_parts(kernel);
        add_blocks(kernel, now.propagator.data() + mode.wavenumber * kernel.entries, load_parts(kernel, half), sum);
        auto second = load_parts(kernel, above.values.data() + mode.begin);
        for (std::size_t k = 0; k < kernel.parts; ++k) second.values[k] -= sum.values[k];
        store_parts(kernel, second, half);
    });
}

void NoisePath::compute(const NoiseInterval& interval) {
    prepare(interval.level);
    for (int level = 0; level <= interval.level; ++level) {
        Level& now = levels_[static_cast<std::size_t>(level)];
        const std::uint64_t index = interval.index >> (interval.level - level);
        if (now.is_known && now.index == index) continue;
        // What follows from an interval that changes is not known any more.
        for (std::size_t below = static_cast<std::size_t>(level) + 1; below < levels_.size(); ++below)
            levels_[below].is_known = false;
        const bool has_first = now.is_known && now.index + 1 == index && index % 2 == 1;
        if (level == 0) draw_root(index);
        else if (!has_first) draw_first_half(level, index & ~std::uint64_t{1});
        if (level > 0 && index % 2 == 1) compute_second_half(level);
        now.index = index;
        now.is_known = true;
    }
}

void NoisePath::write(int level, Spectra& to) {
    const Level& now = levels_[static_cast<std::size_t>(level)];
    for_modes(nullptr, [&](const auto& kernel, const Mode& mode) {
        Complex* at = to.values.data() + mode.row * columns(system_.grid) + mode.column;
        write_parts(kernel, load_parts(kernel, now.values.data() + mode.begin), nullptr, {at, to.stride},
                    kernel.frame(direction(wavevector(system_.grid, mode.column, mode.row),
                                           wavenumbers_.inverse[mode.wavenumber])));
    });
}

std::shared_ptr<NoisePath> make_noise_path(const System& system, double dt, std::uint64_t seed, Threads& threads) {
    return system.noise || system.product_noise ? std::make_shared<NoisePath>(system, dt, seed, threads) : nullptr;
}

double noise_path_bytes(const System& system, double dt, int halvings) {
    const double of_products = system.product_noise ? noise_path_bytes(noises_of_products(system), dt, halvings) : 0.0;
    if (!system.noise) return of_products;
    const double levels = 2.0 + std::max(0.0, std::ceil(std::log2(max_root / dt))) + halvings;
    const double kept =
                     std::min(1.0, std::pow(2.0 / (system.degree + 1), 2.0)) * static_cast<double>(modes(system.grid)),
                 matrices = 3.0 * static_cast<double>(block_entries(system.layout)) /
                            (system.grid.lx == system.grid.ly ? 8.0 : 4.0);
    return of_products + levels * kept * (static_cast<double>(numbers_of(system.layout)) + matrices) * sizeof(double);
}

}  // namespace drover::numerics
