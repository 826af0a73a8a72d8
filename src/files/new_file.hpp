// files/new_file.hpp: files that appear under their name only when they are complete and durable.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "files/system_calls.hpp"

namespace drover::files {

/// The file that a name leads to through symbolic links, which need not exist; the name itself if it is no link.  What
/// drover keeps beside a file is beside that one.
std::filesystem::path behind_links(std::filesystem::path name);

/// A file written in parts to a temporary name and renamed by finish(); removed if finish() is not reached.
class NewFile {
public:
    /// Throws an input Error when the file cannot be created.
    explicit NewFile(const std::filesystem::path& file);
    ~NewFile();

    /// Both throw an Error, with the bytes needed and free, when the disk is full; finish() also where another process
    /// wrote the same file meanwhile.
    void write(const std::string& part);
    void finish();

private:
    template <class Work>
    void guarded(std::uint64_t bytes, Work work);

    std::filesystem::path file_, partial_;
    Descriptor to_;
    std::uint64_t offset_ = 0;
    bool is_new_ = true, is_finished_ = false;
};

/// Writes a file beside the old one and renames it over that.  Throws as NewFile, and leaves the old one then.
void replace_file(const std::filesystem::path& file, const std::string& content);

/// Renames a complete archive over `file`, durably.  Throws a run Error, leaving the old file, when that fails.
void replace_archive(const std::filesystem::path& complete, const std::filesystem::path& file);

}  // namespace drover::files
