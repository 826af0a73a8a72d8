// base/random.cpp: uniform and normal numbers from Random123's Philox.
#include "drover/base/random.hpp"

#include <Random123/philox.h>

#include <algorithm>
#include <array>

#include "base/normal_pairs.hpp"
#include "drover/base/error.hpp"

namespace drover {

namespace {
using Generator = r123::Philox4x64;

/// The midpoint of one of 2^53 equal cells of (0, 1): never 0 or 1.
double uniform(std::uint64_t word) { return (static_cast<double>(word >> 11) + 0.5) * 0x1p-53; }

/// Calls take(j, words) for the words 4j .. 4j + 3 of each index.
template <class Take>
void for_words(const RandomKey& key, std::uint64_t first, std::size_t per_index, std::span<double> out, Take take) {
    require(per_index >= 1 && out.size() % per_index == 0, {},
            "random numbers: {} numbers requested, {} per index; expected a multiple", out.size(), per_index);
    Generator generator;
    const Generator::key_type philox_key{{key.seed, static_cast<std::uint64_t>(key.stream)}};
    const std::size_t count = out.size() / per_index;
    for (std::size_t i = 0; i < count; ++i) {
        double* to = out.data() + i * per_index;
        for (std::size_t j = 0; j < per_index; j += 4) {
            const Generator::ctr_type words = generator({{first + i, key.step, key.substep, j / 4}}, philox_key);
            take(words, to + j, std::min<std::size_t>(4, per_index - j));
        }
    }
}
}  // namespace

void fill_normal(const RandomKey& key, std::uint64_t first, std::size_t per_index, std::span<double> out) {
    alignas(64) PairBlock x{}, y{};
    x.fill(0.5);
    std::array<double*, pair_block> targets;
    std::array<bool, pair_block> both;
    std::size_t waiting = 0;
    const auto flush = [&] {
        make_normal_pairs(x, y);
        for (std::size_t k = 0; k < waiting; ++k) {
            targets[k][0] = x[k];
            if (both[k]) targets[k][1] = y[k];
        }
        x.fill(0.5);  // unused elements must stay in the domain of the logarithm
        waiting = 0;
    };
    for_words(key, first, per_index, out, [&](const Generator::ctr_type& words, double* to, std::size_t count) {
        for (std::size_t k = 0; k < count; k += 2) {
            x[waiting] = uniform(words[k]);
            y[waiting] = uniform(words[k + 1]);
            targets[waiting] = to + k;
            both[waiting] = k + 1 < count;
            if (++waiting == pair_block) flush();
        }
    });
    if (waiting > 0) flush();
}

void fill_uniform(const RandomKey& key, std::uint64_t first, std::size_t per_index, std::span<double> out) {
    for_words(key, first, per_index, out, [](const Generator::ctr_type& words, double* to, std::size_t count) {
        for (std::size_t k = 0; k < count; ++k) to[k] = uniform(words[k]);
    });
}

}  // namespace drover
