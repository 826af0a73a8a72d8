// files/archive.hpp: the archive of a run: one HDF5 file that obeys netCDF-4 and, for trajectories, H5MD 1.1.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "files/archive_layout.hpp"
#include "files/archive_reader.hpp"

namespace drover::files {

/// The writer.  Appended data reaches the file only by commit(), which is atomic: after kill -9 at any moment the file
/// is that of the last commit, or drover restores it from the journal beside it (file.journal) when it next opens the
/// file. Readers may open the file between commits while the run continues.  HDF5 is not thread-safe: use the archives
/// and readers of a process from one thread at a time.
class Archive {
public:
    /// A new file with no rows.  Throws an input Error, leaving nothing behind, if the file exists (unless `overwrite`:
    /// then the old file stays until the new one is complete, which it is, without rows, when this returns), if it
    /// cannot be created, or if another process is writing it.
    static Archive create(const std::filesystem::path& file, const std::vector<Recording>& recordings,
                          const std::vector<Attribute>& attributes, bool overwrite);

    /// Reopens the file of an earlier run, truncated to rows[r] rows of recording r.  Throws an input Error if it is
    /// not an archive of these recordings or has fewer rows.  Rewrites the root attributes and drops the result groups.
    /// The file changes at the next commit().  `check`, called first, with the file locked, may throw.  A run id stays.
    static Archive resume(const std::filesystem::path& file, const std::vector<Recording>& recordings,
                          const std::vector<Attribute>& attributes, std::span<const std::size_t> rows,
                          const std::function<void(const ArchiveReader&)>& check = {});

    Archive(Archive&&) noexcept;
    Archive& operator=(Archive&&) noexcept;
    ~Archive();  ///< discards what is not committed

    /// Current number of rows of each recording.
    std::vector<std::size_t> rows() const;
    /// Of the last row of each recording; 0 without rows.
    std::vector<std::uint64_t> row_checksums() const;

    /// Appends one row: the time [s] and one array for each quantity of the recording; trajectories also store the
    /// step.
    void append(std::size_t recording, double time, std::span<const std::span<const double>> arrays,
                std::int64_t step = 0);

    /// Writes a group of results, replacing one of the same name.
    void replace(const ResultTable& table);

    /// Makes all changes durable.  Throws a run Error, with the bytes needed and free, when the disk is full; the file
    /// then stays as it was at the last commit, and commit() may be retried.  Throws a run Error that says whether the
    /// run can be resumed when another program has removed, replaced or changed the file; a file that has no name any
    /// more is then written again, as of the last commit, where a checkpoint remains.
    void commit();

    /// Removes the file, unless its name refers to another one now.
    void remove();

    /// Whether the last frame is still being compressed, which append() and commit() wait for.
    bool is_compressing() const;

private:
    struct File;
    explicit Archive(std::unique_ptr<File> file);
    std::unique_ptr<File> file_;
};

/// An archive that appears under its name, or replaces the file there, when `fill` has written it and it is durable.
/// Throws as Archive::create and Archive::commit; then the old file stays, and nothing new is left.
void write_archive(const std::filesystem::path& file, const std::vector<Recording>& recordings,
                   const std::vector<Attribute>& attributes, const std::function<void(Archive&)>& fill);

/// For the start of a program that uses HDF5 only through this layer.  HDF5 does nothing when the process ends, where
/// it would crash after a file that could not be closed; no data depend on that.
void leave_hdf5_open();

/// Name and version of the library that writes archives.
std::string archive_library();

}  // namespace drover::files
