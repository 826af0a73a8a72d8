// files/hdf5_file.hpp: an open HDF5 file with atomic commits and bounded reads; hides pages, journal and chunks.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "files/hdf5_handle.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

/// Changes stay in memory until commit(), which makes all of them durable or none; closing discards the rest.  A commit
/// that a kill interrupted is completed or undone, from the journal beside the file, at the next opening by drover.
class Hdf5File {
public:
    /// A new file in an empty one that is open and locked for writing.  `name` is what messages call it.
    static Hdf5File create(Descriptor empty, const std::filesystem::path& path, const std::string& name,
                           const Handle& creation);
    /// The same file under another name.
    void rename(const std::filesystem::path& path);
    /// The id of the run that writes it, an attribute that is committed.
    void know_by(const std::string& run_id);
    /// Removes the file, unless its name refers to another one now.
    void remove();

    /// An existing file that is open, locked for writing and recovered (see recover_file).
    static Hdf5File open_for_writing(Descriptor locked, const std::filesystem::path& path);

    /// An existing file, as of its last commit.  Throws std::system_error when it cannot be opened, an input Error when
    /// it is not HDF5.
    static Hdf5File open_for_reading(const std::filesystem::path& path);

    Hdf5File(Hdf5File&&) noexcept;
    Hdf5File& operator=(Hdf5File&&) noexcept;
    ~Hdf5File();

    hid_t id() const;
    /// For calls on this file.  They report a failure of the disk behind one of HDF5 as such.
    Hdf5Errors errors(Fault fault) const;
    /// For QuietErrors: commit() throws if it has happened.
    Hdf5Failure& failure();
    /// Throws the failure of the disk that a call passed over in silence, if there was one.
    void require_disk() const;
    std::uint64_t length() const;  ///< [bytes], with the uncommitted changes

    /// Throws the run Error of write_failure, or of require_in_place when another program removed, replaced or changed
    /// the file.  Throws, and writes nothing, when an earlier call to HDF5 or to the disk
    /// failed, so that the changes in memory are not known to be complete.
    void commit();

private:
    struct Parts;
    explicit Hdf5File(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

/// Completes or undoes the commit that a kill interrupted.  The file must be locked for writing.
void recover_file(const Descriptor& locked, const std::filesystem::path& file);

/// Removes the journal of a file that no longer exists, so that it is not applied to a new one.
void discard_journal(const std::filesystem::path& file);

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
