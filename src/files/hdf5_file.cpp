// files/hdf5_file.cpp: the HDF5 handles of an open file over its pages; what became of a file that a run writes.
#include "files/hdf5_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "files/checkpoint.hpp"

namespace drover::files {

namespace {

constexpr const char* hopeless = "the run cannot be resumed; run the scene again";

/// NFS keeps a file that was removed, under such a name, until it is closed.
bool has_no_name(const Overlay& overlay) {
    return link_count(overlay.file) == 0 || name_of(overlay.file).filename().string().starts_with(".nfs");
}

/// Writes the last commit to a name that nothing has.
void copy_to(const Overlay& overlay, const std::filesystem::path& name) {
    if (std::filesystem::exists(name)) throw std::system_error(EEXIST, std::generic_category(), name.string());
    const std::filesystem::path partial = partial_name(name);
    const Descriptor to = create_file(partial);
    std::vector<std::byte> part(1 << 20);
    for (std::uint64_t offset = 0; offset < overlay.committed; offset += part.size()) {
        part.resize(static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), overlay.committed - offset)));
        if (read_at(overlay.file, offset, part) < part.size())
            throw std::system_error(EIO, std::generic_category(), "read");
        write_at(to, offset, part);
    }
    sync(to);
    rename_over(partial, name);
    sync_folder_of(name);
}

/// What becomes of a file without a name.
std::string rescued(const Overlay& overlay, bool is_replaced) {
    const std::string path = overlay.path.string();
    const std::string what = is_replaced ? "was replaced by another file" : "was deleted";
    if (!has_checkpoint(overlay.path))
        return text("the archive {} while the run wrote it, and no checkpoint is left: {}", what, hopeless);
    const std::string name = is_replaced ? path + ".rescued" : path;
    try {
        copy_to(overlay, name);
    } catch (const std::exception& cause) {
        return text("the archive {} while the run wrote it, and cannot be written again ({}): {}", what,
                    std::string(cause.what()), hopeless);
    }
    if (is_replaced)
        return text(
            "the archive {} while the run wrote it; as of its last commit it is now {}; to resume, move that "
            "to {}, then: drover restart {}",
            what, name, path, path);
    return text(
        "the archive {} while the run wrote it; it was written again as of its last commit; to resume: drover "
        "restart {}",
        what, path);
}

/// The file is still open and has its data: what a person can do about its name.
std::string renamed(const Overlay& overlay) {
    const std::string path = overlay.path.string(), now = name_of(overlay.file).string();
    if (!has_checkpoint(overlay.path))
        return text("the archive was moved while the run wrote it, and no checkpoint is left: {}", hopeless);
    return text(
        "the archive was moved to {} while the run wrote it; to resume, move it back to {}, then: drover "
        "restart {}",
        now.empty() ? "another name" : now, path, path);
}

/// What happened to the file; "" if nothing did.
std::string loss_of(const Overlay& overlay) {
    const Named name = named(overlay.file, overlay.path);
    if (name != Named::this_file)
        return has_no_name(overlay) ? rescued(overlay, name == Named::another_file) : renamed(overlay);
    if (const std::uint64_t length = length_of(overlay.file); length < overlay.committed)
        return text("another program cut the archive to {} of {} bytes while the run wrote it: {}", length,
                    overlay.committed, hopeless);
    const FileMark& mark = overlay.mark;
    if (head_of(overlay.file) == mark.head && text_at(overlay.file, mark.offset, mark.run_id.size()) == mark.run_id)
        return "";
    return text("another program overwrote the archive while the run wrote it: {}", hopeless);
}

/// See commit().
void require_in_place(Overlay& overlay) {
    if (!overlay.is_written || overlay.committed == 0 || overlay.is_stuck || overlay.failure) return;
    try {
        const std::string loss = loss_of(overlay);
        if (loss.empty()) return;
        overlay.failure = std::make_exception_ptr(Error(Fault::environment, {overlay.path.string()}, loss));
    } catch (const std::system_error& cause) {
        throw disk_failure(overlay.path, cause);
    }
    std::rethrow_exception(overlay.failure);
}

void allow_writing(const Handle& access, const Hdf5Errors& errors) {
    // Version 1.8: netCDF's own choice; every HDF5 in use reads it, and attributes may exceed 64 kB.
    errors.check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "choosing the file format");
}

/// Applies the journal on the disk if the file is writable and has no writer, else in memory.
Overlay recovered_overlay(const std::filesystem::path& file) {
    if (std::filesystem::exists(journal_of(file))) {
        const Descriptor open = try_open(file, O_RDWR);
        if (open.is_open() && !has_writer(open) && lock_for_writing(open)) recover(open, file);
    }
    Overlay overlay = overlay_of(open_file(file, O_RDONLY), file);
    if (const auto journal = read_journal(overlay.file, file)) {
        for (const Patch& patch : journal->patches) write_overlay(overlay, patch.offset, patch.bytes);
        overlay.length = journal->length;
    }
    return overlay;
}

/// Whether HDF5's signature is at one of its allowed offsets: 0, 512, 1024, 2048, ...
bool has_signature(const Overlay& overlay) {
    for (std::uint64_t offset = 0; offset < overlay.length; offset = std::max<std::uint64_t>(512, 2 * offset))
        if (text_at(overlay, offset, hdf5_signature.size()) == hdf5_signature) return true;
    return false;
}

std::unique_ptr<Hdf5File> opened(std::unique_ptr<Hdf5File> hdf5, unsigned flags) {
    hdf5->file =
        hdf5->errors.own(H5Fopen(hdf5->errors.file.c_str(), flags, hdf5->access), H5Fclose, "opening the file");
    return hdf5;
}

}  // namespace

Hdf5File::Hdf5File(Overlay opened, const std::string& name, Fault fault)
    : overlay(std::make_shared<Overlay>(std::move(opened))), errors{name, fault, [overlay = overlay] {
                                                                        require_in_place(*overlay);
                                                                        throw_failure(*overlay);
                                                                    }} {
    driver = register_driver(errors);
    access = file_access(driver, overlay, errors);
}

Hdf5File::~Hdf5File() {
    const QuietErrors quiet;
    // Closing flushes what is then discarded: nothing reaches the disk.  HDF5 1.10 keeps the identifier of a file that
    // it could not close, and crashes when it comes upon it.
    overlay->is_closing = true;
    file = {};
}

std::unique_ptr<Hdf5File> create_hdf5(Descriptor empty, const std::filesystem::path& path, const std::string& name,
                                      const Handle& creation) {
    auto made = std::make_unique<Hdf5File>(written_overlay(std::move(empty), path), name, Fault::environment);
    allow_writing(made->access, made->errors);
    made->file =
        made->errors.own(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, made->access), H5Fclose, "creating the file");
    return made;
}

std::unique_ptr<Hdf5File> open_for_writing(Descriptor locked, const std::filesystem::path& path) {
    auto file = std::make_unique<Hdf5File>(written_overlay(std::move(locked), path), path.string(), Fault::input);
    allow_writing(file->access, file->errors);
    return opened(std::move(file), H5F_ACC_RDWR);
}

std::unique_ptr<Hdf5File> open_for_reading(const std::filesystem::path& path) {
    auto file = std::make_unique<Hdf5File>(recovered_overlay(path), path.string(), Fault::input);
    require(has_signature(*file->overlay), {path.string()}, "is not an HDF5 file; expected an archive of drover");
    return opened(std::move(file), H5F_ACC_RDONLY);
}

void commit(Hdf5File& hdf5) {
    require_in_place(*hdf5.overlay);  // first: HDF5 may fail because the file is gone
    hdf5.errors.check(H5Fflush(hdf5.file, H5F_SCOPE_GLOBAL), "flushing the file");
    throw_failure(*hdf5.overlay);
    // In an existing file without a failure of the disk, it is the file that is damaged.
    if (hdf5.failure.happened)
        throw Error(hdf5.errors.fault, {hdf5.errors.file},
                    text("HDF5 failed ({}); the last changes may be incomplete and are not written: the file stays as "
                         "it was at the last commit; restart",
                         std::string(hdf5.failure.message.data())));
    require_in_place(*hdf5.overlay);  // the flush may have taken long
    commit_overlay(*hdf5.overlay);
}

}  // namespace drover::files
