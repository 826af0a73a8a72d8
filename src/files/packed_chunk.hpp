// files/packed_chunk.hpp: numbers as HDF5's filters shuffle, deflate and fletcher32 store them.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace drover::files {

/// HDF5's variant: Fletcher's sums of big-endian 16-bit words, modulo 65535 with end-around carry.
std::uint32_t fletcher32(std::span<const unsigned char> bytes);

/// A chunk as H5Dwrite_chunk expects it.  Every reader of deflate undoes it, and it takes a fraction of the time of
/// HDF5's own filter: of noisy numbers most of the eight bytes cannot be compressed, and are stored as they are.  The
/// bytes depend on the numbers alone.  Throws std::bad_alloc.
std::vector<unsigned char> packed_chunk(std::span<const double> numbers);

}  // namespace drover::files
