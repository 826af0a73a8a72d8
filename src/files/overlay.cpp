// files/overlay.cpp: changed pages, their commit, and the driver functions that HDF5 calls.
#include "files/overlay.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <new>
#include <vector>

#include "files/bytes.hpp"

namespace drover::files {
namespace {

/// Reads from the disk; zeros beyond the end of the file.
void read_disk(const Overlay& overlay, std::uint64_t offset, std::span<std::byte> bytes) {
    const std::size_t got = read_at(overlay.file, offset, bytes);
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(got), bytes.end(), std::byte{0});
}

struct Changes {
    std::vector<Patch> fresh;  ///< beyond the committed length: no committed byte refers to them
    Journal overwriting;
};

Changes changes_of(const Overlay& overlay) {
    Changes changes;
    changes.overwriting.length = overlay.end;
    std::vector<std::byte> on_disk(page_bytes);
    for (const auto& [offset, page] : overlay.pages) {
        if (offset >= overlay.end) break;
        const std::size_t size = static_cast<std::size_t>(std::min<std::uint64_t>(page_bytes, overlay.end - offset));
        const bool is_fresh = offset >= overlay.committed;
        if (!is_fresh) {
            read_disk(overlay, offset, on_disk);
            if (std::memcmp(on_disk.data(), page.data(), size) == 0 && offset + size <= overlay.committed) continue;
        }
        std::vector<Patch>& patches = is_fresh ? changes.fresh : changes.overwriting.patches;
        patches.push_back({offset, {page.begin(), page.begin() + static_cast<std::ptrdiff_t>(size)}});
    }
    return changes;
}

std::uint64_t head_of(const Overlay& overlay) {
    const std::string head = text_at(overlay, 0, std::min<std::uint64_t>(sector_bytes, overlay.end));
    return checksum(std::as_bytes(std::span(head)));
}

Changes changes_to_commit(const Overlay& overlay) try {
    Changes changes = changes_of(overlay);
    changes.overwriting.before = overlay.mark;
    changes.overwriting.head_after = head_of(overlay);
    // The run id will be where it was, unless HDF5 moved the attribute.
    std::string& run_id = changes.overwriting.before.run_id;
    if (text_at(overlay, overlay.mark.offset, run_id.size()) != run_id) run_id.clear();
    return changes;
} catch (const std::system_error& cause) {
    throw disk_failure(overlay.path, cause);
}

/// Frees the disk space of a commit that failed before its journal was complete.  Best effort.  Each step needs the one
/// before it to be durable: a complete journal beside a truncated file would destroy the file.
void release(const Overlay& overlay) noexcept {
    try {
        remove_if_exists(journal_of(overlay.path));
        sync_folder_of(overlay.path);
        truncate_to(overlay.file, overlay.committed);
    } catch (const std::exception&) {
        return;  // the file is longer than necessary, but valid
    }
}

/// Another program may cut the file while it is written: a later commit would fill up what is missing.  is_applied: it
/// is no longer as of the last commit.
void require_whole(Overlay& overlay, bool is_applied) {
    const std::uint64_t length = length_of(overlay.file);
    if (length >= overlay.end) return;
    remove_if_exists(journal_of(overlay.path));
    overlay.failure = std::make_exception_ptr(
        Error(Fault::environment, {overlay.path.string()},
              text("another program cut the archive to {} of {} bytes while the run wrote it; {}", length, overlay.end,
                   length >= overlay.committed && overlay.committed > 0 && !is_applied
                       ? "it is as of its last commit: resume the run by drover restart"
                       : "the run cannot be resumed: run the scene again")));
    throw_failure(overlay);
}

const char* consequence_of_failure(const Overlay& overlay) {
    if (overlay.is_stuck)
        return "the complete commit is in the journal beside the file; drover applies it when it next opens the file";
    if (overlay.committed == 0) return "the new file is not kept";
    return "the file stays as it was at the last commit";
}

/// HDF5's handle of an open file; HDF5 requires its own part to be the first member.
struct DriverFile {
    H5FD_t base{};
    std::shared_ptr<Overlay> overlay;
};

Overlay& overlay_in(const H5FD_t* file) { return *reinterpret_cast<const DriverFile*>(file)->overlay; }

/// Exceptions must not cross HDF5's C frames: keeps the first one and returns HDF5's failure code.
template <class Work>
herr_t guarded(Overlay& overlay, Work work) noexcept {
    try {
        work(overlay);
        return 0;
    } catch (...) {
        if (overlay.is_closing) return 0;
        if (!overlay.failure) overlay.failure = std::current_exception();
        return -1;
    }
}

extern "C" {
H5FD_t* driver_open(const char*, unsigned, hid_t access, haddr_t) noexcept {
    const auto* info = static_cast<const std::shared_ptr<Overlay>* const*>(H5Pget_driver_info(access));
    auto* file = info == nullptr ? nullptr : new (std::nothrow) DriverFile;
    if (file == nullptr) return nullptr;
    file->overlay = **info;
    file->overlay->end = 0;
    return &file->base;
}

herr_t driver_close(H5FD_t* file) noexcept {
    delete reinterpret_cast<DriverFile*>(file);
    return 0;
}

int driver_compare(const H5FD_t* a, const H5FD_t* b) noexcept {
    const std::less<const Overlay*> before;
    if (before(&overlay_in(a), &overlay_in(b))) return -1;
    return before(&overlay_in(b), &overlay_in(a)) ? 1 : 0;
}

herr_t driver_query(const H5FD_t*, unsigned long* flags) noexcept {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
}

haddr_t driver_end_of_allocation(const H5FD_t* file, H5FD_mem_t) noexcept { return overlay_in(file).end; }

herr_t driver_set_end_of_allocation(H5FD_t* file, H5FD_mem_t, haddr_t end) noexcept {
    overlay_in(file).end = end;
    return 0;
}

haddr_t driver_length(const H5FD_t* file, H5FD_mem_t) noexcept { return overlay_in(file).length; }

herr_t driver_read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, size_t size, void* to) noexcept {
    const std::span<std::byte> bytes{static_cast<std::byte*>(to), size};
    if (overlay_in(file).is_closing) std::ranges::fill(bytes, std::byte{0});  // should the disk fail
    return guarded(overlay_in(file), [&](const Overlay& overlay) { read_overlay(overlay, offset, bytes); });
}

herr_t driver_write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t offset, size_t size, const void* from) noexcept {
    guarded(overlay_in(file), [&](Overlay& overlay) {
        write_overlay(overlay, offset, {static_cast<const std::byte*>(from), size});
    });
    return 0;  // HDF5 1.10 cannot close a file whose flush has failed; the next commit throws the failure
}

herr_t driver_truncate(H5FD_t* file, hid_t, hbool_t) noexcept {
    overlay_in(file).length = overlay_in(file).end;
    return 0;
}
}

H5FD_class_t driver_class() {
    H5FD_class_t driver{};
    driver.name = "drover_overlay";
    driver.maxaddr = static_cast<haddr_t>(INT64_MAX);
    driver.fc_degree = H5F_CLOSE_WEAK;
    driver.fapl_size = sizeof(const std::shared_ptr<Overlay>*);
    driver.open = driver_open;
    driver.close = driver_close;
    driver.cmp = driver_compare;
    driver.query = driver_query;
    driver.get_eoa = driver_end_of_allocation;
    driver.set_eoa = driver_set_end_of_allocation;
    driver.get_eof = driver_length;
    driver.read = driver_read;
    driver.write = driver_write;
    driver.truncate = driver_truncate;
    constexpr H5FD_mem_t separate_data_and_metadata[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(separate_data_and_metadata), std::end(separate_data_and_metadata), std::begin(driver.fl_map));
    return driver;
}

}  // namespace

Overlay overlay_of(Descriptor file, const std::filesystem::path& path) {
    Overlay overlay;
    overlay.path = path;
    overlay.committed = overlay.length = length_of(file);
    overlay.file = std::move(file);
    return overlay;
}

Overlay written_overlay(Descriptor locked, const std::filesystem::path& path) {
    Overlay overlay = overlay_of(std::move(locked), path);
    overlay.is_written = true;
    overlay.end = overlay.length;
    overlay.mark.head = head_of(overlay);
    return overlay;
}

void find_run_id(Overlay& overlay, const std::string& run_id) {
    constexpr std::uint64_t max_bytes = 1 << 20;  // attributes are written first
    const std::size_t found = text_at(overlay, 0, std::min(max_bytes, overlay.committed)).find(run_id);
    const bool is_found = found != std::string::npos;
    overlay.mark.run_id = is_found ? run_id : "";
    overlay.mark.offset = is_found ? found : 0;
}

void read_overlay(const Overlay& overlay, std::uint64_t offset, std::span<std::byte> bytes) {
    read_disk(overlay, offset, bytes);
    const std::uint64_t end = offset + bytes.size();
    for (auto page = overlay.pages.lower_bound(offset - offset % page_bytes); page != overlay.pages.end(); ++page) {
        if (page->first >= end) break;
        const std::uint64_t from = std::max(offset, page->first), to = std::min(end, page->first + page_bytes);
        std::memcpy(bytes.data() + (from - offset), page->second.data() + (from - page->first), to - from);
    }
}

std::string text_at(const Overlay& overlay, std::uint64_t offset, std::size_t size) {
    std::string found(size, '\0');
    read_overlay(overlay, offset, std::as_writable_bytes(std::span(found)));
    return found;
}

void write_overlay(Overlay& overlay, std::uint64_t offset, Bytes bytes) {
    overlay.length = std::max(overlay.length, offset + bytes.size());
    while (!bytes.empty()) {
        const std::size_t within = static_cast<std::size_t>(offset % page_bytes);
        const std::size_t size = std::min(page_bytes - within, bytes.size());
        auto page = overlay.pages.find(offset - within);
        if (page == overlay.pages.end()) {
            std::array<std::byte, page_bytes> on_disk{};
            if (size < page_bytes && offset - within < overlay.committed) read_disk(overlay, offset - within, on_disk);
            page = overlay.pages.emplace(offset - within, on_disk).first;
        }
        std::memcpy(page->second.data() + within, bytes.data(), size);
        offset += size;
        bytes = bytes.subspan(size);
    }
}

void commit_overlay(Overlay& overlay) {
    if (overlay.is_stuck)
        fail_environment("{}: an earlier commit is still in {}; restart the run to complete it", overlay.path.string(),
                         journal_of(overlay.path).string());
    throw_failure(overlay);
    const Changes changes = changes_to_commit(overlay);
    const bool needs_journal = overlay.committed > 0;
    if (changes.fresh.empty() && changes.overwriting.patches.empty() && overlay.end == overlay.committed) return;

    const std::vector<std::byte> journal = needs_journal ? encoded(changes.overwriting) : std::vector<std::byte>{};
    const std::uint64_t growth = overlay.end - std::min(overlay.end, overlay.committed);
    bool is_journal_complete = false;
    try {
        allocate(overlay.file, overlay.committed, overlay.end);
        for (const Patch& patch : changes.fresh) write_at(overlay.file, patch.offset, patch.bytes);
        sync(overlay.file);
        require_whole(overlay, false);
        if (needs_journal) {
            write_journal(overlay.path, journal);
            is_journal_complete = true;
            const CommitLock alone(overlay.file, CommitLock::Side::commit, patience_with_readers);
            require_whole(overlay, false);
            apply(changes.overwriting, overlay.file);
            require_whole(overlay, true);
            remove_if_exists(journal_of(overlay.path));
        }
    } catch (const std::system_error& cause) {
        overlay.is_stuck = is_journal_complete;
        if (!is_journal_complete) release(overlay);
        throw write_failure(overlay.path, cause, growth + journal.size(), consequence_of_failure(overlay));
    }
    overlay.committed = overlay.end;
    overlay.pages.clear();
    overlay.mark.head = changes.overwriting.head_after;
    if (changes.overwriting.before.run_id != overlay.mark.run_id) find_run_id(overlay, overlay.mark.run_id);
}

Handle register_driver(const Hdf5Errors& errors) {
    const H5FD_class_t driver = driver_class();
    return errors.own(H5FDregister(&driver), H5FDunregister, "registering the file driver");
}

Handle file_access(const Handle& driver, const std::shared_ptr<Overlay>& overlay, const Hdf5Errors& errors) {
    Handle access = errors.own(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "creating a file access list");
    const std::shared_ptr<Overlay>* const info = &overlay;
    errors.check(H5Pset_driver(access, driver, &info), "choosing the file driver");
    return access;
}

void throw_failure(const Overlay& overlay) {
    if (!overlay.failure) return;
    try {
        std::rethrow_exception(overlay.failure);
    } catch (const std::system_error& cause) {
        throw disk_failure(overlay.path, cause);
    }
}

}  // namespace drover::files
