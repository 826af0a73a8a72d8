// files/packed_chunk.hpp: numbers as HDF5's filters shuffle, deflate and fletcher32 store them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace drover::files {

/// Of all datasets: higher levels gain almost nothing on shuffled noise and take twice the time.
constexpr int deflate_level = 1;

/// HDF5's variant: Fletcher's sums of big-endian 16-bit words, modulo 65535 with end-around carry.
std::uint32_t fletcher32(std::span<const unsigned char> bytes);

/// A chunk as H5Dwrite_chunk expects it, for a thread of its own: HDF5's filters work in the thread that calls it.  The
/// bytes depend on the numbers alone.  Throws std::bad_alloc.
std::vector<unsigned char> packed_chunk(std::span<const double> numbers);

}  // namespace drover::files
