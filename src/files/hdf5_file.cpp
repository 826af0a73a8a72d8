// files/hdf5_file.cpp: the HDF5 handles of an open file over its pages.
#include "files/hdf5_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <array>

#include "files/journal.hpp"
#include "files/lost_file.hpp"
#include "files/overlay.hpp"

namespace drover::files {

// Members are closed from last to first: file, access list, driver, then the pages that they use.
struct Hdf5File::Parts {
    Parts(Overlay opened, const std::string& name, Fault fault)
        : overlay(std::make_shared<Overlay>(std::move(opened))), errors(errors_of(name, fault)) {
        driver = register_driver(errors);
        access = file_access(driver, overlay, errors);
    }
    ~Parts() {
        const QuietErrors quiet;
        // Closing flushes what is then discarded: nothing reaches the disk.  HDF5 1.10 keeps the identifier of a file
        // that it could not close, and crashes when it comes upon it.
        overlay->is_closing = true;
        file = {};
    }
    Parts(const Parts&) = delete;
    Parts& operator=(const Parts&) = delete;

    Hdf5Errors errors_of(const std::string& name, Fault fault) const {
        return {name, fault, [overlay = overlay] {
                    require_in_place(*overlay);
                    throw_failure(*overlay);
                }};
    }

    std::shared_ptr<Overlay> overlay;
    Hdf5Errors errors;
    Hdf5Failure failure;
    Handle driver, access, file;
};

namespace {

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
    constexpr std::array<unsigned char, 8> signature{0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    for (std::uint64_t offset = 0; offset < overlay.length; offset = std::max<std::uint64_t>(512, 2 * offset)) {
        std::array<std::byte, 8> found{};
        read_overlay(overlay, offset, found);
        const auto same = [](unsigned char a, std::byte b) { return std::byte{a} == b; };
        if (std::equal(signature.begin(), signature.end(), found.begin(), same)) return true;
    }
    return false;
}

}  // namespace

Hdf5File::Hdf5File(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

Hdf5File Hdf5File::create(Descriptor empty, const std::filesystem::path& path, const std::string& name,
                          const Handle& creation) {
    auto parts = std::make_unique<Parts>(written_overlay(std::move(empty), path), name, Fault::environment);
    allow_writing(parts->access, parts->errors);
    parts->file = parts->errors.own(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, creation, parts->access), H5Fclose,
                                    "creating the file");
    return Hdf5File(std::move(parts));
}

void Hdf5File::rename(const std::filesystem::path& path) { parts_->overlay->path = path; }
void Hdf5File::know_by(const std::string& run_id) { find_run_id(*parts_->overlay, run_id); }
void Hdf5File::remove() { remove_in_place(*parts_->overlay); }

Hdf5File Hdf5File::open_for_writing(Descriptor locked, const std::filesystem::path& path) {
    auto parts = std::make_unique<Parts>(written_overlay(std::move(locked), path), path.string(), Fault::input);
    allow_writing(parts->access, parts->errors);
    parts->file = parts->errors.own(H5Fopen(path.c_str(), H5F_ACC_RDWR, parts->access), H5Fclose, "opening the file");
    return Hdf5File(std::move(parts));
}

Hdf5File Hdf5File::open_for_reading(const std::filesystem::path& path) {
    auto parts = std::make_unique<Parts>(recovered_overlay(path), path.string(), Fault::input);
    require(has_signature(*parts->overlay), {path.string()}, "is not an HDF5 file; expected an archive of drover");
    parts->file = parts->errors.own(H5Fopen(path.c_str(), H5F_ACC_RDONLY, parts->access), H5Fclose, "opening the file");
    return Hdf5File(std::move(parts));
}

hid_t Hdf5File::id() const { return parts_->file; }
std::uint64_t Hdf5File::length() const { return parts_->overlay->length; }
Hdf5Errors Hdf5File::errors(Fault fault) const { return parts_->errors_of(parts_->errors.file, fault); }
Hdf5Failure& Hdf5File::failure() { return parts_->failure; }
void Hdf5File::require_disk() const { throw_failure(*parts_->overlay); }

void Hdf5File::commit() {
    require_in_place(*parts_->overlay);  // first: HDF5 may fail because the file is gone
    parts_->errors.check(H5Fflush(parts_->file, H5F_SCOPE_GLOBAL), "flushing the file");
    require_disk();
    // In an existing file without a failure of the disk, it is the file that is damaged.
    if (parts_->failure.happened)
        throw Error(parts_->errors.fault, {parts_->errors.file},
                    text("HDF5 failed ({}); the last changes may be incomplete and are not written: the file stays as "
                         "it was at the last commit; restart",
                         std::string(parts_->failure.message.data())));
    commit_overlay(*parts_->overlay);
}

void recover_file(const Descriptor& locked, const std::filesystem::path& file) { recover(locked, file); }

void discard_journal(const std::filesystem::path& file) { remove_if_exists(journal_of(file)); }

}  // namespace drover::files
