// files/archive.cpp: writes archives.
#include "files/archive.hpp"

#include <fcntl.h>

#include <algorithm>
#include <chrono>
#include <future>

#include "base/mapped.hpp"
#include "files/archive_contents.hpp"
#include "files/archive_netcdf.hpp"
#include "files/bytes.hpp"
#include "files/hdf5_file.hpp"
#include "files/new_file.hpp"
#include "files/packed_chunk.hpp"
#include "files/system_calls.hpp"

namespace drover::files {
namespace {

struct OpenRecording {
    Recording about;
    GroupDatasets datasets;
    std::size_t rows = 0;
    std::uint64_t checksum = 0;  ///< of the last row
};

using Chunks = std::vector<std::vector<unsigned char>>;

/// The last frame, while it is compressed beside the run.
struct PendingFrame {
    std::size_t recording = 0, row = 0;
    std::future<Chunks> chunks;
};

/// Groups in the root that belong to no recording: results of the earlier run, invalid once rows are cut.
std::vector<std::string> result_groups(hid_t file, const std::vector<OpenRecording>& recordings,
                                       const Hdf5Errors& errors) {
    std::vector<std::string> groups = objects_of(file, errors).groups;
    std::erase_if(groups, [&](const std::string& group) {
        return group.rfind('/') > 0 || group == "/h5md" ||
               std::ranges::any_of(recordings, [&](const OpenRecording& recording) {
                   return (recording.about.group + "/").starts_with(group + "/");
               });
    });
    return groups;
}

/// Sets the number of rows of every dataset of a recording; new rows hold zeros.
void set_rows(const OpenRecording& recording, std::size_t rows, const Hdf5Errors& errors) {
    const auto set = [&](hid_t dataset, const std::vector<std::size_t>& shape) {
        std::vector<hsize_t> extent{rows};
        extent.insert(extent.end(), shape.begin(), shape.end());
        errors.check(H5Dset_extent(dataset, extent.data()), text("setting {} rows in {}", rows, recording.about.group));
    };
    set(recording.datasets.time, {});
    if (recording.about.trajectory) set(recording.datasets.step, {});
    for (std::size_t i = 0; i < recording.about.quantities.size(); ++i)
        set(recording.datasets.quantities[i], shape_of(recording.about, recording.about.quantities[i]));
}

void write_row(hid_t dataset, std::size_t row, const std::vector<std::size_t>& shape, std::span<const double> values,
               const Hdf5Errors& errors) {
    constexpr const char* doing = "appending a row";
    std::vector<hsize_t> start(shape.size() + 1, 0), count{1};
    start[0] = row;
    count.insert(count.end(), shape.begin(), shape.end());
    const Handle space = errors.own(H5Dget_space(dataset), H5Sclose, doing);
    errors.check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), doing);
    const hsize_t size = values.size();
    const Handle memory = errors.own(H5Screate_simple(1, &size, nullptr), H5Sclose, doing);
    errors.check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()), doing);
}

/// The same for a row as appended and as read.
std::uint64_t row_checksum(const Recording& recording, double time, std::span<const std::span<const double>> arrays) {
    std::vector<std::uint64_t> parts{checksum(std::as_bytes(std::span(&time, 1)))};
    for (std::size_t i = 0; i < arrays.size(); ++i) {
        std::vector<double> integers;
        if (recording.quantities[i].is_integer)
            for (const double value : arrays[i]) integers.push_back(value == 0.0 ? 0.0 : value);  // -0 is stored as 0
        parts.push_back(checksum(std::as_bytes(integers.empty() ? arrays[i] : std::span<const double>(integers))));
    }
    return checksum(std::as_bytes(std::span(parts)));
}

/// Rows that are a chunk each can be compressed without HDF5, which must be called by one thread at a time.
bool is_frame(const Recording& recording) {
    const auto is_integer = [](const Quantity& quantity) { return quantity.is_integer; };
    return recording.rows_per_chunk == 1 && !recording.trajectory &&
           std::ranges::none_of(recording.quantities, is_integer);
}

/// Compresses a frame in another thread; a small one takes less time than the start of a thread.
std::future<Chunks> packed(std::span<const std::span<const double>> arrays) {
    std::vector<std::vector<double>> copies;
    std::size_t numbers = 0;
    for (const std::span<const double> array : arrays) {
        copies.emplace_back(array.begin(), array.end());
        numbers += array.size();
    }
    const auto pack = [copies = std::move(copies)] {
        return mapped(copies, [](const std::vector<double>& copy) { return packed_chunk(copy); });
    };
    constexpr std::size_t few = 16384;
    if (numbers <= few) return std::async(std::launch::deferred, pack);
    try {
        return std::async(std::launch::async, pack);
    } catch (const std::system_error&) {  // no thread is left
        return std::async(std::launch::deferred, pack);
    }
}

/// `corner`: of the chunk.
void write_chunk(hid_t dataset, const std::vector<hsize_t>& corner, std::span<const unsigned char> bytes,
                 const Hdf5Errors& errors) {
    constexpr std::uint32_t skipped_filters = 0;
    errors.check(H5Dwrite_chunk(dataset, H5P_DEFAULT, skipped_filters, corner.data(), bytes.size(), bytes.data()),
                 "writing a chunk");
}

[[noreturn]] void fail_locked(const std::filesystem::path& file) {
    throw Error(Fault::unavailable, {file.string()},
                "another process is writing this file; wait for it, or choose another file for this run");
}

/// The Error for a file that cannot be created or opened.
Error opening_failure(const std::filesystem::path& file, const std::system_error& cause) {
    return access_failure(file, cause, "cannot be written", "expected a file in a writable folder");
}

/// Locks the file that is about to be replaced, if there is one.
Descriptor lock_old(const std::filesystem::path& file, bool overwrite) {
    if (!std::filesystem::exists(std::filesystem::symlink_status(file))) return {};
    require(std::filesystem::is_regular_file(file), {file.string()},
            "is not a file; expected the name of a file to create");
    require(overwrite, {file.string()}, "exists already; choose another name, or give --overwrite");
    Descriptor old = open_file(file, O_RDWR);
    if (!lock_for_writing(old)) fail_locked(file);
    return old;
}

/// Creates the file under its temporary name, locked.
Descriptor lock_new(const std::filesystem::path& file, bool overwrite) {
    const std::filesystem::path partial = partial_name(file);
    Descriptor created = create_file(partial);
    const auto is_locked = [&] {
        try {
            return lock_for_writing(created);
        } catch (const Error&) {  // a file system without locks
            remove_if_exists(partial);
            throw;
        }
    };
    if (!is_locked() || !is_at(created, partial)) fail_locked(file);
    if (!overwrite && std::filesystem::exists(file)) {
        remove_if_exists(partial);
        fail_locked(file);  // another process has just created it
    }
    return created;
}

std::string shape_text(const std::vector<std::size_t>& shape) {
    return "(" + joined(mapped(shape, [](std::size_t size) { return std::to_string(size); })) + ")";
}

/// Throws an input Error unless the dataset has these sizes, apart from rows, and at least `rows` rows.  Returns the
/// last of these, whose chunk HDF5 will cut: it must be intact.
std::vector<double> check_recorded(const ArchiveReader& reader, const std::string& file, const std::string& dataset,
                                   std::vector<std::size_t> expected, std::size_t rows) {
    require(reader.has(dataset), {file}, "has no {}; expected an archive of the same scene", dataset);
    const std::vector<std::size_t> found = reader.shape(dataset);
    expected.insert(expected.begin(), found.empty() ? rows : found[0]);
    require(found == expected, {file}, "{} has the shape {}; expected {}: the archive of another scene", dataset,
            shape_text(found), shape_text(expected));
    require(found[0] >= rows, {file}, "{} has {} rows; expected at least the {} of the checkpoint", dataset, found[0],
            rows);
    return rows > 0 ? reader.read_row(dataset, rows - 1).values : std::vector<double>();
}

void check_same_values(const ArchiveReader& reader, const std::string& file, const std::string& path,
                       const std::vector<double>& expected, const char* what) {
    require(reader.has(path), {file}, "has no {}; expected an archive of the same scene", path);
    const auto is_same = [](double a, double b) { return a == b || (a != a && b != b); };  // shells may be empty
    require(std::ranges::equal(reader.read(path).values, expected, is_same), {file},
            "{} has other {} than this scene; expected an archive of the same scene", path, what);
}

/// Returns the checksum of the last of the rows of each recording.
std::vector<std::uint64_t> check_same(const ArchiveReader& reader, const std::filesystem::path& file,
                                      const std::vector<Recording>& recordings, std::span<const std::size_t> rows) {
    std::vector<std::uint64_t> checksums;
    for (std::size_t r = 0; r < recordings.size(); ++r) {
        const Recording& recording = recordings[r];
        const std::vector<double> time = check_recorded(reader, file.string(), time_path(recording), {}, rows[r]);
        if (recording.trajectory) {
            for (const FixedArray& array : recording.trajectory->fixed)
                check_same_values(reader, file.string(), path_in(recording.group, array.name), array.values, "numbers");
        } else {
            for (const Axis& axis : recording.axes)
                check_same_values(reader, file.string(), path_in(recording.group, axis.name), axis.values,
                                  "coordinates");
        }
        std::vector<std::vector<double>> row;
        for (const Quantity& quantity : recording.quantities) {
            const std::string path = value_path(recording, quantity);
            row.push_back(check_recorded(reader, file.string(), path, shape_of(recording, quantity), rows[r]));
            const std::string unit = reader.text_attribute(path, "units");
            require(unit == quantity.unit, {file.string()},
                    "{} has the unit {}; expected {}: the archive of another scene", path, unit, quantity.unit);
        }
        const std::vector<std::span<const double>> arrays(row.begin(), row.end());
        checksums.push_back(time.empty() ? 0 : row_checksum(recording, time.front(), arrays));
    }
    return checksums;
}

void check_types(const OpenRecording& recording, const Hdf5Errors& errors) {
    for (std::size_t i = 0; i < recording.about.quantities.size(); ++i) {
        const Quantity& quantity = recording.about.quantities[i];
        const Handle type =
            errors.own(H5Dget_type(recording.datasets.quantities[i]), H5Tclose, "reading the type of " + quantity.name);
        require(H5Tequal(type, quantity.is_integer ? H5T_STD_I64LE : H5T_IEEE_F64LE) > 0, {errors.file},
                "{} does not hold {} numbers; expected an archive that drover wrote",
                value_path(recording.about, quantity), quantity.is_integer ? "int64" : "float64");
    }
}

}  // namespace

struct Archive::File {
    explicit File(std::unique_ptr<Hdf5File> opened) : hdf5(std::move(opened)) {}
    ~File() {
        const QuietErrors quiet;  // closing flushes uncommitted rows, which are discarded
        recordings.clear();
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;

    /// Writes the frame that is being compressed, if there is one.
    void write_pending();

    std::unique_ptr<Hdf5File> hdf5;
    std::vector<OpenRecording> recordings;  // their datasets are closed before the file
    std::optional<PendingFrame> pending;
};

Archive::Archive(std::unique_ptr<File> file) : file_(std::move(file)) {}
Archive::Archive(Archive&&) noexcept = default;
Archive& Archive::operator=(Archive&&) noexcept = default;
Archive::~Archive() = default;

Archive Archive::create(const std::filesystem::path& name, const std::vector<Recording>& recordings,
                        const std::vector<Attribute>& attributes, bool overwrite) try {
    const std::filesystem::path file = behind_links(name);
    const QuietErrors quiet;
    for (const Recording& recording : recordings) files::check(recording, file.string());
    const Descriptor old = lock_old(file, overwrite);
    Descriptor created = lock_new(file, overwrite);
    Cleanup cleanup{partial_name(file)};
    const Hdf5Errors errors{file.string(), Fault::environment};
    auto archive = std::make_unique<File>(
        create_hdf5(std::move(created), partial_name(file), file.string(), creation_list(H5P_FILE_CREATE, errors)));
    const QuietErrors watched(&archive->hdf5->failure);
    write_root_attributes(archive->hdf5->file, attributes, errors);
    for (const Recording& recording : recordings)
        archive->recordings.push_back({recording, make_group(archive->hdf5->file, recording, errors)});
    files::commit(*archive->hdf5);
    for (const auto& [name_of_attribute, value] : attributes)
        if (name_of_attribute == run_id_name) find_run_id(*archive->hdf5->overlay, std::get<std::string>(value));
    // The journal of the replaced file must not be applied to the new one.
    if (old.is_open()) recover(old, file);
    else remove_if_exists(journal_of(file));
    sync_folder_of(file);
    rename_over(partial_name(file), file);
    cleanup.is_needed = false;
    archive->hdf5->overlay->path = file;
    sync_folder_of(file);
    return Archive(std::move(archive));
} catch (const std::system_error& cause) {
    throw opening_failure(name, cause);
}

Archive Archive::resume(const std::filesystem::path& name, const std::vector<Recording>& recordings,
                        const std::vector<Attribute>& attributes, std::span<const std::size_t> rows,
                        const std::function<void(const ArchiveReader&)>& check) try {
    const std::filesystem::path file = behind_links(name);
    const QuietErrors quiet;
    for (const Recording& recording : recordings) files::check(recording, file.string());
    require(rows.size() == recordings.size(), {file.string()}, "{} row counts for {} recordings; expected one each",
            rows.size(), recordings.size());
    if (!std::filesystem::is_regular_file(file)) ArchiveReader{file};  // which reports what is wrong with it
    Descriptor open = open_file(file, O_RDWR);
    if (!lock_for_writing(open)) fail_locked(file);
    recover(open, file);
    std::string run_id;
    const std::vector<std::uint64_t> checksums = [&] {
        const ArchiveReader reader(file);
        if (check) check(reader);
        run_id = run_id_of(reader);
        return check_same(reader, file, recordings, rows);
    }();

    auto archive = std::make_unique<File>(open_for_writing(std::move(open), file));
    if (!run_id.empty()) find_run_id(*archive->hdf5->overlay, run_id);
    const QuietErrors watched(&archive->hdf5->failure);
    const Hdf5Errors& errors = archive->hdf5->errors;
    const hid_t hdf5 = archive->hdf5->file;
    for (std::size_t r = 0; r < recordings.size(); ++r) {
        archive->recordings.push_back({recordings[r], open_group(hdf5, recordings[r], errors), rows[r], checksums[r]});
        check_types(archive->recordings.back(), errors);
        set_rows(archive->recordings.back(), rows[r], errors);
    }
    for (const std::string& group : result_groups(hdf5, archive->recordings, errors))
        errors.check(H5Ldelete(hdf5, group.c_str(), H5P_DEFAULT), "removing " + group);
    replace_root_attributes(hdf5, attributes, errors);
    return Archive(std::move(archive));
} catch (const std::system_error& cause) {
    throw opening_failure(name, cause);
}

std::vector<std::size_t> Archive::rows() const { return mapped(file_->recordings, &OpenRecording::rows); }

std::vector<std::uint64_t> Archive::row_checksums() const {
    return mapped(file_->recordings, &OpenRecording::checksum);
}

void Archive::File::write_pending() {
    if (!pending) return;
    PendingFrame frame = std::move(*pending);
    pending.reset();
    const OpenRecording& recording = recordings[frame.recording];
    const Chunks chunks = frame.chunks.get();
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        std::vector<hsize_t> corner(recording.about.quantities[i].axes.size() + 1, 0);
        corner[0] = frame.row;
        write_chunk(recording.datasets.quantities[i], corner, chunks[i], hdf5->errors);
    }
}

void Archive::append(std::size_t recording, double time, std::span<const std::span<const double>> arrays,
                     std::int64_t step) {
    const QuietErrors quiet(&file_->hdf5->failure);
    const Hdf5Errors& errors = file_->hdf5->errors;
    OpenRecording& into = file_->recordings[recording];
    const Recording& about = into.about;
    if (is_frame(about)) file_->write_pending();
    set_rows(into, into.rows + 1, errors);
    write_row(into.datasets.time, into.rows, {}, {&time, 1}, errors);
    const auto steps = static_cast<double>(step);  // exact: far below 2^53
    if (about.trajectory) write_row(into.datasets.step, into.rows, {}, {&steps, 1}, errors);
    if (is_frame(about))
        file_->pending.emplace(PendingFrame{.recording = recording, .row = into.rows, .chunks = packed(arrays)});
    else
        for (std::size_t i = 0; i < arrays.size(); ++i)
            write_row(into.datasets.quantities[i], into.rows, shape_of(about, about.quantities[i]), arrays[i], errors);
    ++into.rows;
    into.checksum = row_checksum(about, time, arrays);
}

void Archive::replace(const ResultTable& table) {
    const QuietErrors quiet(&file_->hdf5->failure);
    const Hdf5Errors& errors = file_->hdf5->errors;
    const Recording about{.group = table.group,
                          .axes = table.axes,
                          .quantities = table.quantities,
                          .rows_per_chunk = 0};
    check(about, errors.file);
    // At the root, of an archive without recordings, there is nothing to replace.
    if (table.group != "/" &&
        errors.check(H5Lexists(file_->hdf5->file, table.group.c_str(), H5P_DEFAULT), "looking up " + table.group) > 0)
        errors.check(H5Ldelete(file_->hdf5->file, table.group.c_str(), H5P_DEFAULT), "removing " + table.group);
    const GroupDatasets created = make_group(file_->hdf5->file, about, errors);
    for (std::size_t i = 0; i < table.values.size(); ++i)
        if (!is_compact(extent_of(shape_of(about, about.quantities[i]), 0)) && !about.quantities[i].is_integer)
            write_chunk(created.quantities[i], std::vector<hsize_t>(about.quantities[i].axes.size(), 0),
                        packed_chunk(table.values[i]), errors);
        else
            errors.check(H5Dwrite(created.quantities[i], H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                                  table.values[i].data()),
                         "writing results");
    if (table.warnings.empty()) return;
    write_list(group_handle(file_->hdf5->file, table.group, false, errors), "warnings", table.warnings, errors);
}

bool Archive::is_compressing() const {
    return file_->pending && file_->pending->chunks.wait_for(std::chrono::seconds(0)) == std::future_status::timeout;
}

void Archive::commit() {
    const QuietErrors quiet(&file_->hdf5->failure);
    file_->write_pending();
    files::commit(*file_->hdf5);
}

void Archive::remove() {
    const Overlay& overlay = *file_->hdf5->overlay;
    if (named(overlay.file, overlay.path) == Named::this_file) remove_if_exists(overlay.path);
}

void leave_hdf5_open() { H5dont_atexit(); }

std::string archive_library() {
    unsigned major = 0, minor = 0, release = 0;
    H5get_libversion(&major, &minor, &release);
    return text("HDF5 {}.{}.{}", major, minor, release);
}

void write_archive(const std::filesystem::path& name, const std::vector<Recording>& recordings,
                   const std::vector<Attribute>& attributes, const std::function<void(Archive&)>& fill) {
    const std::filesystem::path file = behind_links(name), beside = file.string() + ".new";
    std::error_code ignored;
    if (std::filesystem::is_symlink(beside, ignored)) std::filesystem::remove(beside, ignored);  // never followed
    Archive archive = Archive::create(beside, recordings, attributes, true);
    Cleanup cleanup{beside};
    const Cleanup journal{beside.string() + ".journal"};  // of a commit that failed
    fill(archive);
    archive.commit();
    replace_archive(beside, file);  // the lock is held: no other process takes the name meanwhile
    cleanup.is_needed = false;
}

}  // namespace drover::files
