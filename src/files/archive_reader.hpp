// files/archive_reader.hpp: reads archives without trusting what a file says of itself.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "files/archive_layout.hpp"

namespace drover::files {

/// An array as read.
struct Array {
    std::vector<std::size_t> shape;
    std::vector<double> values;
};

/// A dataset in a file, not read yet.
struct StoredArray {
    std::string path;
    std::vector<std::size_t> shape;
    bool is_integer = false;
    std::vector<std::string> axes;  ///< names of its dimension scales, its own if it is one; empty without them
    std::vector<Attribute> attributes;
};

/// All that a file holds, as of one commit, in the order of creation.
struct Contents {
    std::vector<std::string> groups;
    std::vector<StoredArray> arrays;
    std::vector<Attribute> attributes;  ///< of the root
};

/// The attribute of this name; "" if it is absent or a number.
std::string text_in(const std::vector<Attribute>& attributes, const std::string& name);

/// Decided by the first eight bytes, not by the name; false if the file does not exist.
bool is_hdf5(const std::filesystem::path& file);

/// Whether a process has an archive open for writing; false if it does not exist.
bool is_being_written(const std::filesystem::path& file);

/// Treats every file as untrusted: rejects external links, external storage, virtual datasets and plugin filters;
/// checks shapes, types and sizes before it allocates memory.  Every failure is an input Error that names file and
/// dataset. HDF5 is not thread-safe: use the archives and readers of a process from one thread at a time.
class ArchiveReader {
public:
    /// this_process: an Archive of this process may have the file open, and commits nothing while this reader is used.
    /// Without that knowledge the file of a run is opened again for each reading.
    enum class Writer { unknown, this_process };

    explicit ArchiveReader(const std::filesystem::path& file, Writer writer = Writer::unknown);
    /// Of arrays in memory, by their paths, without attributes: a run that writes no archive.
    explicit ArchiveReader(std::map<std::string, Array> arrays);
    ArchiveReader(ArchiveReader&&) noexcept;
    ~ArchiveReader();

    /// All root attributes that are one number or a string, by name.
    std::vector<Attribute> attributes() const;
    std::string text_attribute(const std::string& name) const;  ///< throws if absent or not a string

    bool has_attribute(const std::string& dataset, const std::string& name) const;
    /// A string attribute of a dataset: "units", "comment".  Throws if absent or not a string.
    std::string text_attribute(const std::string& dataset, const std::string& name) const;

    /// Throws if any dataset could not be read.  Rejects links, and a file with more than some thousand objects.  Of
    /// arrays in memory: nothing.
    Contents contents() const;

    bool has(const std::string& dataset) const;  ///< "/observables/time"
    std::vector<std::size_t> shape(const std::string& dataset) const;
    Array read(const std::string& dataset) const;
    /// Row `row` of the first axis.
    Array read_row(const std::string& dataset, std::size_t row) const;
    /// `count` rows from `first` on, of a file.
    Array read(const std::string& dataset, std::size_t first, std::size_t count) const;

private:
    struct File;
    std::unique_ptr<File> file_;
};

/// Of the run that made an archive; "" if that was an earlier version of drover.
std::string run_id_of(const ArchiveReader& archive);

}  // namespace drover::files
