// io/hdf5_chunks.hpp: reads chunked float64 datasets without trusting what the file says of the size of a chunk.
//
// HDF5 1.10 believes the size that a chunk has after its filters, and reads past its end when a damaged index names no
// filters or a stream inflates to less.  So chunks are taken as they are stored, and the filters are undone here.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/hdf5_handle.hpp"

namespace drover::io {

/// Rows [first, first + count) of the first axis of a dataset of this shape, none of whose sizes nor count is 0.
struct ChunkedRows {
    std::vector<std::size_t> shape;
    std::size_t first = 0;
    std::size_t count = 0;
};

/// Its filters must be deflate, shuffle and fletcher32 alone and its type a float64.  Throws an input Error when a chunk is
/// damaged.  file_bytes: no stored chunk is larger.
void read_chunked(hid_t dataset, const std::string& name, const ChunkedRows& rows, std::uint64_t file_bytes,
                  std::span<double> to, const Hdf5Errors& errors);

}  // namespace drover::io
