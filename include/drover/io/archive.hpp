// io/archive.hpp: the one file of a run: HDF5 that obeys netCDF-4 and, for trajectories, H5MD 1.1; whole at every moment.
#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace drover::io {

/// One axis of an array besides time: a dimension scale.
struct Axis {
    std::string name;            ///< "x"
    std::string unit;            ///< UDUNITS text; "1" for a pure number
    std::string meaning;         ///< CF long_name
    std::vector<double> values;  ///< coordinates
};

/// One array.
struct Quantity {
    std::string name;               ///< "rod_density"
    std::string unit;               ///< UDUNITS text; "1" for a pure number
    std::string meaning;            ///< CF long_name: what it is, with its formula
    std::vector<std::string> axes;  ///< names, slowest first, without time; each must be an axis of the same group
    bool whole = false;             ///< stored as integers
};

/// An array that a trajectory holds once: radii, species.
struct FixedArray {
    std::string name, unit, meaning;
    bool whole = false;          ///< stored as integers
    std::size_t components = 1;  ///< numbers for each particle; more than one: a second axis
    std::vector<double> values;
};

/// What a group of H5MD has besides the elements that grow with time.
struct Trajectory {
    std::vector<FixedArray> fixed;
    bool has_box = false;            ///< with the element box/edges among the quantities
    std::array<bool, 3> periodic{};  ///< of that box
};

/// A group of arrays that grow along a common time axis, one row at each append.  With a trajectory the group is laid out as H5MD:
/// each quantity is a group of its own, <name>/{value,step,time}, the last two shared by hard links; axes give sizes and are not
/// written.  Units stand in the attribute `units`, as everywhere in the file.
struct Recording {
    std::string group;  ///< "/", "/observables"; of a trajectory "/particles/spheres" too
    std::vector<Axis> axes;
    std::vector<Quantity> quantities;
    int rows_per_chunk = 1;  ///< 1 for fields, many for scalars
    std::optional<Trajectory> trajectory = {};
};

/// A group of arrays without time: the results of a run.
struct ResultTable {
    std::string group;  ///< "/summary"
    std::vector<Axis> axes;
    std::vector<Quantity> quantities;         ///< no axes: a single number
    std::vector<std::vector<double>> values;  ///< of each quantity, in the order of `quantities`
};

using Attribute = std::pair<std::string, std::variant<std::int64_t, double, std::string>>;

/// The writer.  What is appended reaches the file only by commit(), which is all or nothing: after kill -9 at any moment the
/// file on disk is that of the last commit, or is made so from the journal that stands beside it (file.journal) when it is next
/// opened by drover.  Readers may open the file between commits while the run goes on.  HDF5 keeps its own books: use archives
/// and readers of one process from one thread at a time.
class Archive {
public:
    /// A new file with no rows.  Throws an input Error if the file exists (unless `overwrite`: then the old file stays until
    /// the new one is complete, which it is, without rows, when this returns) or cannot be made, leaving nothing behind; or if
    /// another process writes it.
    static Archive create(const std::filesystem::path& file, const std::vector<Recording>& recordings,
                          const std::vector<Attribute>& attributes, bool overwrite);

    /// The file of an earlier run, cut to rows[r] rows of each recording, to go on with.  Throws an input Error if it is not an
    /// archive of these recordings, or has fewer rows.  Root attributes are written anew and groups of results are dropped.
    /// The file changes at the next commit().
    static Archive resume(const std::filesystem::path& file, const std::vector<Recording>& recordings,
                          const std::vector<Attribute>& attributes, std::span<const std::size_t> rows);

    Archive(Archive&&) noexcept;
    Archive& operator=(Archive&&) noexcept;
    ~Archive();  ///< what is not committed is lost

    /// Rows so far of each recording.
    std::vector<std::size_t> rows() const;

    /// One row: the time [s] and one array for each quantity of the recording; the step is kept by trajectories.
    void append(std::size_t recording, double time, std::span<const std::span<const double>> arrays,
                std::int64_t step = 0);

    /// Writes a group of results, in place of one of the same name.
    void replace(const ResultTable& table);

    /// Makes all of this durable.  Throws a run Error, with the bytes that were needed and the bytes that are free, when the disk
    /// is full; the file then stays as it was at the last commit, and commit() may be tried again.
    void commit();

private:
    struct File;
    explicit Archive(std::unique_ptr<File> file);
    std::unique_ptr<File> file_;
};

/// An array read back.
struct Array {
    std::vector<std::size_t> shape;
    std::vector<double> values;
};

/// By its first eight bytes, whatever its name; false where there is no such file.
bool is_hdf5(const std::filesystem::path& file);

/// The reader.  It trusts nothing: external links, external storage, virtual datasets and plugin filters are refused; shapes,
/// types and sizes are checked before memory is taken.  Every failure is an input Error that names file and dataset.
class ArchiveReader {
public:
    explicit ArchiveReader(const std::filesystem::path& file);
    ArchiveReader(ArchiveReader&&) noexcept;
    ~ArchiveReader();

    /// All root attributes that are one number or a text of fixed length, by name.
    std::vector<Attribute> attributes() const;
    std::string text_attribute(const std::string& name) const;  ///< throws when absent or not text

    /// A text of a dataset: "units", "long_name".  Throws when absent or not text.
    std::string text_attribute(const std::string& dataset, const std::string& name) const;

    bool has(const std::string& dataset) const;  ///< "/observables/time"
    std::vector<std::size_t> shape(const std::string& dataset) const;
    Array read(const std::string& dataset) const;
    /// Row `row` of the first axis.
    Array read_row(const std::string& dataset, std::size_t row) const;

private:
    struct File;
    std::unique_ptr<File> file_;
};

/// The library that does it, with its version.
std::string archive_library();

}  // namespace drover::io
