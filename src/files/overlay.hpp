// files/overlay.hpp: an HDF5 file driver that keeps changes in memory until a commit makes them durable atomically.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <span>

#include "files/hdf5_handle.hpp"
#include "files/journal.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

inline constexpr std::size_t page_bytes = 4096;

/// A file on the disk, and the pages that have changed since the last commit.
struct Overlay {
    std::filesystem::path path;
    Descriptor file;
    std::uint64_t committed = 0;  ///< length of the file at the last commit
    std::uint64_t length = 0;     ///< length as HDF5 sees it
    std::uint64_t end = 0;        ///< end of the space that HDF5 has allocated
    bool is_stuck = false;        ///< a commit failed while it applied its journal
    bool is_closing = false;      ///< changes are discarded, and nothing fails any more
    std::exception_ptr failure;   ///< the first one of a read or write for HDF5, which may pass over it in silence
    bool is_written = false;      ///< by this process, which has locked it
    FileMark mark;                ///< at the last commit, of a file that is written
    std::map<std::uint64_t, std::array<std::byte, page_bytes>> pages;
};

/// The overlay of an open file, without changes.
Overlay overlay_of(Descriptor file, const std::filesystem::path& path);

/// The same of a file that is locked for writing.
Overlay written_overlay(Descriptor locked, const std::filesystem::path& path);

/// Looks for the run id, an attribute of the committed file.
void find_run_id(Overlay& overlay, const std::string& run_id);

/// Zeros beyond the end of the file.
void read_overlay(const Overlay& overlay, std::uint64_t offset, std::span<std::byte> bytes);
std::string text_at(const Overlay& overlay, std::uint64_t offset, std::size_t size);
void write_overlay(Overlay& overlay, std::uint64_t offset, Bytes bytes);

/// Makes the changes durable, all or none.  Flush HDF5 first.  Throws the run Error of write_failure, or of
/// disk_failure when an earlier read failed: what HDF5 then holds in memory is not known.
void commit_overlay(Overlay& overlay);

/// Registers the driver; close the result after the file.
Handle register_driver(const Hdf5Errors& errors);

/// A file access list with which HDF5 opens the overlay.  The pointer must stay where it is while the list is open.
/// HDF5 shares the overlay: when the closing of a damaged file fails, HDF5 tries again as the process ends.
Handle file_access(const Handle& driver, const std::shared_ptr<Overlay>& overlay, const Hdf5Errors& errors);

/// Throws the failure of an overlay, if it has one.
void throw_failure(const Overlay& overlay);

}  // namespace drover::files
