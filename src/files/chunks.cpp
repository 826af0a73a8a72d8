// files/chunks.cpp: reads the chunks of an HDF5 file, undoes their filters and copies them into an array.
//
// HDF5 1.10 trusts the size that a chunk has after its filters, and reads past its end when a damaged index names no
// filters or a stream inflates to less.  So chunks are read as stored, and the filters are undone here.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "files/hdf5_file.hpp"
#include "files/packed_chunk.hpp"

namespace drover::files {
namespace {

using Buffer = std::vector<unsigned char>;
using Sizes = std::vector<std::size_t>;

constexpr std::size_t checksum_bytes = 4;

bool remove_checksum(Buffer& bytes) {
    if (bytes.size() < checksum_bytes) return false;
    std::uint32_t stored = 0;
    std::memcpy(&stored, bytes.data() + bytes.size() - checksum_bytes, checksum_bytes);
    bytes.resize(bytes.size() - checksum_bytes);
    return stored == fletcher32(bytes);
}

bool inflate_to(Buffer& bytes, std::size_t size) {
    Buffer inflated(size);
    uLongf got = size;
    if (::uncompress(inflated.data(), &got, bytes.data(), bytes.size()) != Z_OK || got != size) return false;
    bytes = std::move(inflated);
    return true;
}

/// Shuffled data: the first bytes of all numbers, then the second ones, ...; a remainder stays at the end.
void unshuffle(Buffer& bytes) {
    constexpr std::size_t width = sizeof(double);
    const std::size_t count = bytes.size() / width;
    Buffer plain(bytes);
    for (std::size_t byte = 0; byte < width; ++byte)
        for (std::size_t i = 0; i < count; ++i) plain[i * width + byte] = bytes[byte * count + i];
    bytes = std::move(plain);
}

/// Undoes the filters, last first, except those whose bit is set in `skipped`.  Returns whether the result has the size
/// of a chunk.
bool undo_filters(Buffer& bytes, const Storage& storage, std::uint32_t skipped) {
    Sizes size_before;  // the input of each filter at writing; unknown, and not needed, after a deflate
    std::size_t size = storage.bytes;
    for (std::size_t i = 0; i < storage.filters.size(); ++i) {
        size_before.push_back(size);
        if (storage.filters[i] == H5Z_FILTER_FLETCHER32 && (skipped >> i & 1u) == 0) size += checksum_bytes;
    }
    for (std::size_t i = storage.filters.size(); i-- > 0;) {
        if ((skipped >> i & 1u) != 0) continue;
        bool is_valid = true;
        if (storage.filters[i] == H5Z_FILTER_FLETCHER32) is_valid = remove_checksum(bytes);
        if (storage.filters[i] == H5Z_FILTER_DEFLATE) is_valid = inflate_to(bytes, size_before[i]);
        if (storage.filters[i] == H5Z_FILTER_SHUFFLE) unshuffle(bytes);
        if (!is_valid) return false;
    }
    return bytes.size() == storage.bytes;
}

/// The numbers of the chunk whose first element is at `corner`.
std::vector<double> read_chunk(hid_t dataset, const std::string& name, const Storage& storage, double fill,
                               const Sizes& corner, std::uint64_t file_bytes, const Hdf5Errors& errors) {
    const std::string doing = text("reading a chunk of {}", name);
    const std::vector<hsize_t> offset(corner.begin(), corner.end());
    // By the same search in the index as that of H5Dread_chunk: H5Dget_chunk_info_by_coord may find another size where
    // the index is damaged.
    hsize_t stored = 0;
    errors.check(H5Dget_chunk_storage_size(dataset, offset.data(), &stored), doing);
    std::vector<double> numbers(storage.bytes / sizeof(double), fill);
    if (stored == 0) return numbers;  // never written
    Buffer bytes;
    std::uint32_t skipped = 0;
    bool is_valid = stored <= file_bytes;
    if (is_valid) {
        bytes.resize(static_cast<std::size_t>(stored));
        errors.check(H5Dread_chunk(dataset, H5P_DEFAULT, offset.data(), &skipped, bytes.data()), doing);
        is_valid = undo_filters(bytes, storage, skipped);
    }
    require(is_valid, {errors.file}, "a chunk of {} is damaged (wrong checksum or size); expected an undamaged archive",
            name);
    const Handle type = errors.own(H5Dget_type(dataset), H5Tclose, doing);
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    errors.check(H5Tconvert(type, H5T_NATIVE_DOUBLE, numbers.size(), numbers.data(), nullptr, H5P_DEFAULT), doing);
    return numbers;
}

/// The next index of an array of these sizes, the last axis fastest; false after the last one.
bool advance(Sizes& index, const Sizes& sizes) {
    for (std::size_t axis = sizes.size(); axis-- > 0;) {
        if (++index[axis] < sizes[axis]) return true;
        index[axis] = 0;
    }
    return false;
}

/// Copies the part of a chunk that lies in the rows into the array of the rows, line by line along the last axis.
void copy_chunk(const std::vector<double>& numbers, const Sizes& chunk, const Sizes& corner, const RowRange& rows,
                std::span<double> to) {
    const std::size_t rank = chunk.size();
    Sizes begin(corner), lines(rank), wanted(rows.shape);  // the common box: its first element, and its size
    wanted[0] = rows.count;
    begin[0] = std::max(corner[0], rows.first);
    for (std::size_t axis = 0; axis < rank; ++axis) {
        const std::size_t end = axis == 0 ? rows.first + rows.count : rows.shape[axis];
        lines[axis] = std::min(corner[axis] + chunk[axis], end) - begin[axis];
    }
    const std::size_t line = std::exchange(lines[rank - 1], 1);
    Sizes at(rank, 0);
    for (bool more = true; more; more = advance(at, lines)) {
        std::size_t from = 0, into = 0;
        for (std::size_t axis = 0; axis < rank; ++axis) {
            const std::size_t index = begin[axis] + at[axis];
            from = from * chunk[axis] + (index - corner[axis]);
            into = into * wanted[axis] + (axis == 0 ? index - rows.first : index);
        }
        std::memcpy(to.data() + into, numbers.data() + from, line * sizeof(double));
    }
}

}  // namespace

Storage storage_of(hid_t dataset, const std::string& name, const Hdf5Errors& errors) {
    const std::string doing = text("inspecting {}", name);
    Storage storage{.creation = errors.own(H5Dget_create_plist(dataset), H5Pclose, doing)};
    const hid_t creation = storage.creation;
    const H5D_layout_t layout = H5Pget_layout(creation);
    require(layout != H5D_VIRTUAL, {errors.file},
            "{} is a virtual dataset, composed of other files; expected the data itself", name);
    require(layout == H5D_COMPACT || layout == H5D_CONTIGUOUS || layout == H5D_CHUNKED, {errors.file},
            "{} has an unknown storage layout; expected compact, contiguous or chunked storage", name);
    require(H5Pget_external_count(creation) == 0, {errors.file},
            "{} stores its data in another file; expected the data itself", name);
    const int count = errors.check(H5Pget_nfilters(creation), text("reading the filters of {}", name));
    for (int i = 0; i < count; ++i) {
        unsigned flags = 0;
        std::size_t values = 0;
        const H5Z_filter_t filter =
            H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, nullptr);
        require(filter == H5Z_FILTER_DEFLATE || filter == H5Z_FILTER_SHUFFLE || filter == H5Z_FILTER_FLETCHER32,
                {errors.file}, "{} is stored with the HDF5 filter {}; expected deflate, shuffle or fletcher32, or none",
                name, static_cast<int>(filter));
        storage.filters.push_back(filter);
    }
    if (layout != H5D_CHUNKED) return storage;
    std::array<hsize_t, H5S_MAX_RANK> sizes{};
    const int rank = errors.check(H5Pget_chunk(creation, H5S_MAX_RANK, sizes.data()), doing);
    storage.chunk.assign(sizes.begin(), sizes.begin() + rank);
    const double bytes = bytes_of(storage.chunk);
    require(bytes <= static_cast<double>(memory_available()) / 2, {errors.file},
            "{} has chunks of {}, more than half of the free memory; expected smaller ones", name, bytes_text(bytes));
    storage.bytes = static_cast<std::size_t>(bytes);
    return storage;
}

void read_chunked(hid_t dataset, const Storage& storage, const std::string& name, const RowRange& rows,
                  std::uint64_t file_bytes, std::span<double> to, const Hdf5Errors& errors) {
    double fill = 0.0;
    errors.check(H5Pget_fill_value(storage.creation, H5T_NATIVE_DOUBLE, &fill),
                 text("looking at the storage of {}", name));
    const std::size_t first_chunk = rows.first / storage.chunk[0];
    Sizes chunks(rows.shape.size());
    for (std::size_t axis = 0; axis < chunks.size(); ++axis) {
        const std::size_t end = axis == 0 ? rows.first + rows.count : rows.shape[axis];
        chunks[axis] = (end - 1) / storage.chunk[axis] + 1;
    }
    chunks[0] -= first_chunk;
    Sizes index(chunks.size(), 0);
    for (bool more = true; more; more = advance(index, chunks)) {
        Sizes corner(index);
        corner[0] += first_chunk;
        for (std::size_t axis = 0; axis < corner.size(); ++axis) corner[axis] *= storage.chunk[axis];
        copy_chunk(read_chunk(dataset, name, storage, fill, corner, file_bytes, errors), storage.chunk, corner, rows,
                   to);
    }
}

}  // namespace drover::files
