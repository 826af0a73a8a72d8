// base/random.hpp: counter-based random numbers, independent of the number of threads and of restarts.
#pragma once
#include <cstdint>
#include <span>

namespace drover {

/// Purpose of a stream of random numbers.  Different streams are independent.
enum class Stream : std::uint64_t {
    noise = 1,
    initial_state = 2,
    stationary_state = 3,
    packing = 4,
    kick = 5,
    trial = 6,          ///< seeds of the trials of an assay
    bootstrap = 7,      ///< resamples
    step_error = 8,     ///< signs of local errors under noise
    contact_order = 9,  ///< of the contacts of a rod
    product_noise = 10,
    uncertainty = 11,  ///< draws of numbers within their errors
    test = 1000
};

/// Position in a stream: every number is a pure function of (seed, stream, step, index, position).
struct RandomKey {
    std::uint64_t seed = 0;
    Stream stream = Stream::noise;
    std::uint64_t step = 0;
    std::uint64_t substep = 0;  ///< part of a step with its own numbers
};

/// Standard normal numbers for the indices first, first + 1, ...: out[i * per_index + j] is number j of index first + i
/// and depends on (key, first + i, j) only.  out.size() is a multiple of per_index >= 1.
/// Source: Philox4x64-10 (Salmon et al., SC 2011, doi:10.1145/2063384.2063405) and the Box-Muller transform.
void fill_normal(const RandomKey& key, std::uint64_t first, std::size_t per_index, std::span<double> out);

/// As fill_normal, uniform in the open interval (0, 1).
void fill_uniform(const RandomKey& key, std::uint64_t first, std::size_t per_index, std::span<double> out);

}  // namespace drover
