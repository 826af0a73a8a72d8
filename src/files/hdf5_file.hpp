// files/hdf5_file.hpp: an open HDF5 file with atomic commits, and bounded reads of its chunks.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "files/overlay.hpp"

namespace drover::files {

inline constexpr std::string_view hdf5_signature = "\x89HDF\r\n\x1a\n";

/// An open HDF5 file.  Changes stay in memory until commit(), which makes all of them durable or none; closing discards
/// the rest.  A commit that a kill interrupted is completed or undone, from the journal beside the file, at the next
/// opening by drover.  Members are closed from last to first: file, access list, driver, then the pages that they use.
struct Hdf5File {
    Hdf5File(Overlay opened, const std::string& name, Fault fault);
    ~Hdf5File();
    Hdf5File(const Hdf5File&) = delete;
    Hdf5File& operator=(const Hdf5File&) = delete;

    std::shared_ptr<Overlay> overlay;
    Hdf5Errors errors;    ///< of calls on this file: they report a failure of the disk behind one of HDF5 as such
    Hdf5Failure failure;  ///< for QuietErrors: commit() throws if it has happened
    Handle driver, access, file;
};

/// A new file in an empty one that is open and locked for writing.  `name` is what messages call it.
std::unique_ptr<Hdf5File> create_hdf5(Descriptor empty, const std::filesystem::path& path, const std::string& name,
                                      const Handle& creation);

/// An existing file that is open, locked for writing and recovered (see recover).
std::unique_ptr<Hdf5File> open_for_writing(Descriptor locked, const std::filesystem::path& path);

/// An existing file, as of its last commit.  Throws std::system_error when it cannot be opened, an input Error when
/// it is not HDF5.
std::unique_ptr<Hdf5File> open_for_reading(const std::filesystem::path& path);

/// Throws the run Error of write_failure.  Throws, and writes nothing, when an earlier call to HDF5 or to the disk
/// failed, so that the changes in memory are not known to be complete.
///
/// Throws, now and at all later calls, a run Error unless the name of the file still refers to it, and it is as the
/// last commit left it.  The Error says whether the run can be resumed, and how.  A file without any name is written
/// again, as of the last commit, where a checkpoint of the run remains: under its name, or where another file has that,
/// under the name with ".rescued".
void commit(Hdf5File& hdf5);

/// Rows [first, first + count) of the first axis of a dataset of this shape; no size is 0, nor is count.
struct RowRange {
    std::vector<std::size_t> shape;
    std::size_t first = 0;
    std::size_t count = 0;
};

/// How a dataset is stored.
struct Storage {
    Handle creation;  ///< its property list
    std::vector<H5Z_filter_t> filters = {};
    std::vector<std::size_t> chunk = {};  ///< none unless it is chunked
    std::size_t bytes = 0;                ///< of an unfiltered chunk
};

/// Throws an input Error unless the dataset is in the file itself, in chunks that fit the memory, and with the filters
/// deflate, shuffle and fletcher32 alone, which HDF5 contains: any other could load a plugin.
Storage storage_of(hid_t dataset, const std::string& name, const Hdf5Errors& errors);

/// Reads rows of a chunked float64 dataset, without trusting the chunk sizes that the file claims.  Throws an input
/// Error when a chunk is damaged.  file_bytes: length of the file, which no stored chunk exceeds.
void read_chunked(hid_t dataset, const Storage& storage, const std::string& name, const RowRange& rows,
                  std::uint64_t file_bytes, std::span<double> to, const Hdf5Errors& errors);

}  // namespace drover::files
