// files/archive_reader.cpp: reads archives; checks links, storage, types and sizes before it reads.
#include "files/archive_reader.hpp"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <tuple>

#include "base/duration.hpp"
#include "files/archive_contents.hpp"
#include "files/hdf5_file.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"

namespace drover::files {

bool is_hdf5(const std::filesystem::path& file) { return read_start(file, hdf5_signature.size()) == hdf5_signature; }

std::string text_in(const std::vector<Attribute>& attributes, const std::string& name) {
    for (const auto& [found, value] : attributes)
        if (const auto* words = std::get_if<std::string>(&value); words != nullptr && found == name) return *words;
    return "";
}

bool is_being_written(const std::filesystem::path& file) {
    const Descriptor open = try_open(file, O_RDONLY);
    return open.is_open() && has_locks(open) && has_writer(open);
}

namespace {

/// HDF5's view of the file as of one commit.
struct View {
    View(const std::filesystem::path& file, const Descriptor& guard, bool is_own)
        : state(state_of(file)), is_live(!is_own && has_writer(guard)), hdf5(open_for_reading(file)) {}

    FileState state;
    bool is_live;  ///< a run is writing the file
    std::unique_ptr<Hdf5File> hdf5;
};

/// Whether the file that is open no longer changes: it is as it was, or another one has its name.
bool is_same(const FileState& opened, const FileState& now) { return now == opened || now.number != opened.number; }

/// An array of any size up to small_array bytes, and else at most this multiple of the file.  Series of a run compress
/// far less together; deflate could inflate one byte to 1032, to fill the memory.
constexpr double max_inflation = 100.0, small_array = 64e6;

void require_plain_file(const std::filesystem::path& file) {
    std::error_code error;
    const auto status = std::filesystem::status(file, error);
    require(std::filesystem::exists(status), {file.string()},
            "does not exist or is not accessible; expected an archive of drover");
    require(!std::filesystem::is_directory(status), {file.string()}, "is a folder; expected an archive of drover");
    require(std::filesystem::is_regular_file(status), {file.string()},
            "is not a plain file; expected an archive of drover");
}

/// A dataset that drover may read, and how it is stored.
struct OpenDataset {
    Handle id;
    Storage storage;
};

OpenDataset open_dataset(hid_t file, const std::string& name, const Hdf5Errors& errors) {
    require(leads_to(file, name, H5O_TYPE_DATASET, errors), {errors.file},
            "has no dataset {}; expected an archive that contains it", name);
    Handle dataset = errors.own(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose, text("opening {}", name));
    Storage storage = storage_of(dataset, name, errors);
    return {std::move(dataset), std::move(storage)};
}

std::vector<std::size_t> shape_of(hid_t dataset, const std::string& name, const Hdf5Errors& errors) {
    const Handle space = errors.own(H5Dget_space(dataset), H5Sclose, text("reading the shape of {}", name));
    require(H5Sget_simple_extent_type(space) != H5S_NULL, {errors.file}, "{} is an empty dataspace; expected numbers",
            name);
    std::vector<hsize_t> sizes(static_cast<std::size_t>(
        errors.check(H5Sget_simple_extent_ndims(space), text("reading the rank of {}", name))));
    errors.check(H5Sget_simple_extent_dims(space, sizes.data(), nullptr), text("reading the shape of {}", name));
    return {sizes.begin(), sizes.end()};
}

/// Throws an input Error for numbers that drover does not read; returns whether they are integers.
bool check_type(hid_t dataset, const std::string& name, const Hdf5Errors& errors) {
    const Handle type = errors.own(H5Dget_type(dataset), H5Tclose, text("reading the type of {}", name));
    // All are as wide as a double, as the check of what is stored requires.
    for (const hid_t known : {H5T_IEEE_F64LE, H5T_IEEE_F64BE, H5T_STD_I64LE})
        if (H5Tequal(type, known) > 0) return known == H5T_STD_I64LE;
    fail_input({errors.file}, "{} holds neither float64 nor int64 numbers; expected one of these types", name);
}

/// A whole array may be far larger than memory, but no larger than deflate can make its bytes.
void check_inflation(hid_t dataset, const StoredArray& array, const Hdf5Errors& errors) {
    constexpr double max_ratio = 1032.0;
    const double bytes = bytes_of(array.shape);
    const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
    require(bytes <= max_ratio * stored, {errors.file},
            "{} claims {} but stores {}; expected at most {} times as many: it is damaged", array.path,
            bytes_text(bytes), bytes_text(stored), max_ratio);
}

/// Reads rows into an array of matching size.
void read_rows(const OpenDataset& open, const std::string& name, const RowRange& rows, std::uint64_t file_bytes,
               std::span<double> to, const Hdf5Errors& errors) {
    if (to.empty()) return;
    const hid_t dataset = open.id;
    if (!open.storage.chunk.empty()) return read_chunked(dataset, open.storage, name, rows, file_bytes, to, errors);
    const std::string doing = text("reading {}", name);
    const Handle space = errors.own(H5Dget_space(dataset), H5Sclose, doing);
    const hsize_t stored = H5Dget_storage_size(dataset);  // 0: never written; HDF5 then reads the fill value
    const auto count = static_cast<hsize_t>(errors.check(H5Sget_simple_extent_npoints(space), doing));
    require(stored == 0 || stored / sizeof(double) >= count, {errors.file},
            "{} has {} bytes for {} numbers; expected 8 bytes per number: it is damaged", name, stored, count);
    std::vector<hsize_t> start(rows.shape.size(), 0), sizes(rows.shape.begin(), rows.shape.end());
    if (!sizes.empty()) {
        start[0] = rows.first;
        sizes[0] = rows.count;
        errors.check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, sizes.data(), nullptr), doing);
    }
    const hsize_t size = to.size();
    const Handle memory = errors.own(H5Screate_simple(1, &size, nullptr), H5Sclose, doing);
    errors.check(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, to.data()), doing);
}

/// The number of elements of this shape, after checking that they can fit in this file and in memory.
std::size_t checked_count(const std::vector<std::size_t>& shape, std::uint64_t file_bytes, const std::string& name,
                          const Hdf5Errors& errors) {
    const auto memory = static_cast<double>(memory_available());
    if (std::ranges::find(shape, std::size_t{0}) != shape.end()) return 0;
    const double bytes = bytes_of(shape);
    require(bytes <= std::max(small_array, static_cast<double>(file_bytes) * max_inflation), {errors.file},
            "{} claims {} in a file of {}; expected no more than a file of that size can hold: it is damaged", name,
            bytes_text(bytes), bytes_text(static_cast<double>(file_bytes)));
    require(bytes <= memory / 2, {errors.file},
            "{} takes {}, more than half of the {} of free memory; read it row by row", name, bytes_text(bytes),
            bytes_text(memory));
    return static_cast<std::size_t>(bytes / sizeof(double));
}

/// All rows, or `count` from `first` on.
Array read_part(const View& view, const std::string& dataset,
                const std::optional<std::pair<std::size_t, std::size_t>>& part = {}) {
    const Hdf5Errors& errors = view.hdf5->errors;
    const OpenDataset open = open_dataset(view.hdf5->file, dataset, errors);
    check_type(open.id, dataset, errors);
    RowRange rows{.shape = shape_of(open.id, dataset, errors), .first = 0, .count = 1};
    if (!rows.shape.empty()) rows.count = rows.shape[0];
    if (part) {
        require(!rows.shape.empty(), {errors.file}, "{} is a single number; expected an array with rows", dataset);
        require(part->second <= rows.count && part->first <= rows.count - part->second, {errors.file},
                "{} has {} rows; expected one with the number {}, counted from 0", dataset, rows.count,
                part->first + std::max<std::size_t>(part->second, 1) - 1);
        std::tie(rows.first, rows.count) = *part;
    }
    Array array{.shape = rows.shape, .values = {}};
    if (part) array.shape[0] = rows.count;
    array.values.resize(checked_count(array.shape, view.hdf5->overlay->length, dataset, errors));
    read_rows(open, dataset, rows, view.hdf5->overlay->length, array.values, errors);
    return array;
}

}  // namespace

struct ArchiveReader::File {
    std::filesystem::path path;
    bool is_own = false;  ///< this process writes it, and does not meanwhile
    Descriptor guard = {};
    std::optional<View> view = {};
    std::chrono::milliseconds patience{2000};                 ///< with the commit of a run
    std::optional<std::map<std::string, Array>> memory = {};  ///< instead of a file

    const Array& in_memory(const std::string& dataset) const {
        const auto found = memory->find(dataset);
        require(found != memory->end(), {}, "the run has no {}", dataset);
        return found->second;
    }

    /// What `read` returns for a view that no commit changed meanwhile: HDF5 would combine old metadata with new data.
    /// Opens the file again for each reading while a run writes it.
    template <class Read>
    auto steady(Read read) try {
        const QuietErrors quiet;
        const auto end = Clock::now() + std::chrono::seconds(5);
        for (;;) {
            const bool is_replaced = view && state_of(path).number != view->state.number;
            if (view && !is_replaced && (view->is_live || !is_same(view->state, state_of(path)))) view.reset();
            if (!view) guard = open_file(path, O_RDONLY);
            const CommitLock lock(guard, CommitLock::Side::reader, patience);
            if (!lock.is_held()) patience = {};  // the run was stopped within a commit: no second wait
            const FileState before = state_of(path);
            const auto begin = Clock::now();
            const auto is_sure = [&] {
                return (lock.is_held() && Clock::now() - begin < patience_with_readers) ||
                       is_same(before, state_of(path));
            };
            try {
                if (!view) view.emplace(path, guard, is_own);
                auto result = read(*view);
                throw_failure(*view->hdf5->overlay);
                if (is_sure()) return result;
            } catch (const Error&) {
                if (is_sure() || Clock::now() > end) throw;
            }
            if (Clock::now() > end)
                fail_input({path.string()},
                           "is being written faster than it can be read; try again, or wait for the end of its run");
        }
    } catch (const std::system_error& cause) {
        throw access_failure(path, cause, "cannot be read", "expected a readable archive of drover");
    }
};

ArchiveReader::ArchiveReader(const std::filesystem::path& file, Writer writer) {
    require_plain_file(file);
    file_ = std::make_unique<File>(File{.path = behind_links(file), .is_own = writer == Writer::this_process});
    file_->steady([](const View&) { return true; });
}

ArchiveReader::ArchiveReader(std::map<std::string, Array> arrays)
    : file_(std::make_unique<File>(File{.path = {}, .memory = std::move(arrays)})) {}

ArchiveReader::ArchiveReader(ArchiveReader&&) noexcept = default;
ArchiveReader::~ArchiveReader() {
    const QuietErrors quiet;
    file_.reset();
}

std::vector<Attribute> ArchiveReader::attributes() const {
    if (file_->memory) return {};
    return file_->steady(
        [](const View& view) { return attributes_of(view.hdf5->file, view.hdf5->overlay->length, view.hdf5->errors); });
}

std::string ArchiveReader::text_attribute(const std::string& name) const {
    const std::vector<Attribute> all = attributes();
    const auto found = std::ranges::find_if(all, [&](const Attribute& one) { return one.first == name; });
    require(found != all.end(), {file_->path.string()}, "has no attribute {}; expected an archive of drover", name);
    const auto* words = std::get_if<std::string>(&found->second);
    require(words != nullptr, {file_->path.string()}, "attribute {} is a number; expected a string", name);
    return *words;
}

bool ArchiveReader::has_attribute(const std::string& dataset, const std::string& name) const {
    if (file_->memory) return false;
    return file_->steady([&](const View& view) {
        return H5Aexists(open_dataset(view.hdf5->file, dataset, view.hdf5->errors).id, name.c_str()) > 0;
    });
}

std::string ArchiveReader::text_attribute(const std::string& dataset, const std::string& name) const {
    return file_->steady([&](const View& view) {
        const Hdf5Errors& errors = view.hdf5->errors;
        const Handle open = open_dataset(view.hdf5->file, dataset, errors).id;
        require(H5Aexists(open, name.c_str()) > 0, {errors.file},
                "{} has no attribute {}; expected an archive of drover", dataset, name);
        const auto read = read_attribute(open, name, view.hdf5->overlay->length, errors);
        const auto* words = read ? std::get_if<std::string>(&read->second) : nullptr;
        require(words != nullptr, {errors.file}, "attribute {} of {} is not a string; expected one", name, dataset);
        return *words;
    });
}

Contents ArchiveReader::contents() const {
    if (file_->memory) return {};
    return file_->steady([&](const View& view) {
        const Hdf5Errors& errors = view.hdf5->errors;
        const hid_t file = view.hdf5->file;
        const std::uint64_t length = view.hdf5->overlay->length;
        const Objects objects = objects_of(file, errors);
        Contents all{.groups = objects.groups, .arrays = {}, .attributes = attributes_of(file, length, errors)};
        const NamesOfReferences names = names_of_references(file, objects.datasets, errors);
        for (const std::string& path : objects.datasets) {
            const Handle dataset = open_dataset(file, path, errors).id;
            const bool is_integer = check_type(dataset, path, errors);
            StoredArray array{.path = path, .shape = shape_of(dataset, path, errors), .is_integer = is_integer};
            check_inflation(dataset, array, errors);
            array.axes = axes_of(dataset, path, array.shape.size(), length, names, errors);
            array.attributes = attributes_of(dataset, length, errors);
            all.arrays.push_back(std::move(array));
        }
        return all;
    });
}

bool ArchiveReader::has(const std::string& dataset) const {
    if (file_->memory) return file_->memory->contains(dataset);
    return file_->steady(
        [&](const View& view) { return leads_to(view.hdf5->file, dataset, H5O_TYPE_DATASET, view.hdf5->errors); });
}

std::vector<std::size_t> ArchiveReader::shape(const std::string& dataset) const {
    if (file_->memory) return file_->in_memory(dataset).shape;
    return file_->steady([&](const View& view) {
        return shape_of(open_dataset(view.hdf5->file, dataset, view.hdf5->errors).id, dataset, view.hdf5->errors);
    });
}

Array ArchiveReader::read(const std::string& dataset) const {
    if (file_->memory) return file_->in_memory(dataset);
    return file_->steady([&](const View& view) { return read_part(view, dataset); });
}

Array ArchiveReader::read_row(const std::string& dataset, std::size_t row) const {
    if (file_->memory) {
        const Array& all = file_->in_memory(dataset);
        require(row < all.shape.at(0), {}, "{} has {} rows; expected one with the number {}", dataset, all.shape[0],
                row);
        const std::size_t size = all.values.size() / all.shape[0];
        const auto begin = all.values.begin() + static_cast<std::ptrdiff_t>(row * size);
        return {.shape = {all.shape.begin() + 1, all.shape.end()},
                .values = {begin, begin + static_cast<std::ptrdiff_t>(size)}};
    }
    Array array = read(dataset, row, 1);
    array.shape.erase(array.shape.begin());
    return array;
}

Array ArchiveReader::read(const std::string& dataset, std::size_t first, std::size_t count) const {
    return file_->steady([&](const View& view) { return read_part(view, dataset, {{first, count}}); });
}

std::string run_id_of(const ArchiveReader& archive) { return text_in(archive.attributes(), run_id_name); }

}  // namespace drover::files
