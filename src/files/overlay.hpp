// files/overlay.hpp: an HDF5 file driver that keeps changes in memory until a commit makes them durable atomically.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>

#include "files/hdf5_handle.hpp"
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
    std::map<std::uint64_t, std::array<std::byte, page_bytes>> pages;
};

/// The overlay of an open file, without changes.
Overlay overlay_of(Descriptor file, const std::filesystem::path& path);

void read_overlay(const Overlay& overlay, std::uint64_t offset, std::span<std::byte> bytes);
void write_overlay(Overlay& overlay, std::uint64_t offset, Bytes bytes);

/// Makes the changes durable, all or none.  Flush HDF5 first.  Throws the run Error of write_failure.
void commit_overlay(Overlay& overlay);

/// Registers the driver; close the result after the file.
Handle register_driver(const Hdf5Errors& errors);

/// A file access list with which HDF5 opens the overlay, whose address must not change while the file is open.
Handle file_access(const Handle& driver, Overlay& overlay, const Hdf5Errors& errors);

}  // namespace drover::files
