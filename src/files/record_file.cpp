// files/record_file.cpp: locked files of records, and folders that one process at a time uses.
#include "drover/files/record_file.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <thread>

#include "drover/files/bytes.hpp"
#include "files/record_bytes.hpp"

namespace drover::files {

namespace {
/// Waits up to two seconds: a killed writer holds its lock until its last worker exits.
bool lock_or_wait(const Descriptor& file) {
    constexpr int tries = 40;
    for (int i = 0; i < tries; ++i) {
        if (lock_for_writing(file)) return true;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
}

std::vector<std::byte> bytes_of(const Descriptor& file) {
    std::vector<std::byte> bytes(static_cast<std::size_t>(length_of(file)));
    bytes.resize(read_at(file, 0, bytes));
    return bytes;
}

/// Reports why a file cannot be used; reports a full disk explicitly.
[[noreturn]] void fail_opening(const std::filesystem::path& file, const std::system_error& cause) {
    const int error = cause.code().value();
    if (error == ENOSPC || error == EDQUOT || is_of_disk(cause))
        throw write_failure(file, cause, sizeof(std::uint64_t), "nothing was started");
    if (error == EMFILE || error == ENFILE)
        throw Error(fault_of(cause), {file.string()},
                    text("cannot be opened: {}; every running measurement needs an open file: raise the limit (ulimit "
                         "-n), or divide the work with --share",
                         std::string(cause.what())));
    throw Error(fault_of(cause), {file.string()},
                text("cannot be opened: {}; check the permissions of the folder, or choose another",
                     std::string(cause.what())));
}
}  // namespace

struct RecordFile::File {
    std::filesystem::path path;
    Descriptor open;
    std::vector<std::string> records;
    std::uint64_t cut = 0, end = 0;
};

RecordFile::RecordFile(const std::filesystem::path& file, const RecordIdentity& identity) try
    : file_(std::make_unique<File>()) {
    file_->path = file;
    file_->open = open_or_create(file);
    require(
        lock_or_wait(file_->open), {file.string()},
        "another drover calibrate is using it; expected one at a time: wait for it, or divide the work with --share");
    const std::vector<std::byte> bytes = bytes_of(file_->open);
    RecordContent content = content_of(bytes, identity, file.string());
    file_->records = std::move(content.records);
    const std::vector<std::byte> start = start_of(identity);
    const bool is_new = file_->records.empty() && content.valid_bytes < start.size();
    if (is_new) write_at(file_->open, 0, start);
    file_->cut = is_new ? 0 : bytes.size() - content.valid_bytes;
    file_->end = is_new ? start.size() : content.valid_bytes;
    if (file_->end < bytes.size()) truncate_to(file_->open, file_->end);
    if (is_new || file_->cut > 0) {
        sync(file_->open);
        sync_folder_of(file);
    }
} catch (const std::system_error& cause) {
    fail_opening(file, cause);
}

RecordFile::RecordFile(RecordFile&&) noexcept = default;
RecordFile::~RecordFile() = default;
const std::vector<std::string>& RecordFile::records() const { return file_->records; }
std::uint64_t RecordFile::cut() const { return file_->cut; }

void RecordFile::append(const std::string& record) {
    const std::vector<std::byte> bytes = record_bytes(record);
    try {
        write_at(file_->open, file_->end, bytes);
        sync(file_->open);
    } catch (const std::system_error& cause) {
        throw write_failure(file_->path, cause, bytes.size(), "earlier trials are kept");
    }
    file_->end += bytes.size();
}

std::vector<std::string> read_records(const std::filesystem::path& file, const RecordIdentity& identity) try {
    const auto bytes = read_file(file);
    if (!bytes) return {};
    return content_of(*bytes, identity, file.string()).records;
} catch (const std::system_error& cause) {
    fail_opening(file, cause);
}

ClaimedFolder claim_folder(const std::filesystem::path& folder, const std::string& name, const std::string& factory,
                           const std::string& content) try {
    const SourceLocation where{.file = folder.string()};
    const std::filesystem::path file = folder / name;
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    require(!problem && std::filesystem::is_directory(folder), where,
            "the folder cannot be created ({}); choose another with --output", problem.message());
    // Another process may claim it at the same moment: then the folder is not empty, and holds this file.
    require(std::filesystem::is_empty(folder) || std::filesystem::exists(file), where,
            "the folder is not empty and holds no {}; choose another with --output", name);
    const auto lock = std::make_shared<Descriptor>(open_or_create(file));
    const Descriptor& open = *lock;
    require(lock_or_wait(open), where, "another drover is using this folder; expected one at a time: wait for it");
    const std::vector<std::byte> bytes = bytes_of(open);
    const std::string found = text_of(bytes);
    const std::size_t head = factory.empty() ? 0 : first_line(found).size() + 1;
    const std::string there = found.substr(std::min(found.size(), head));
    if (there == content) return {first_line(found), lock};
    // A crash cut the file short before the folder held anything else.
    const bool is_only_file =
        std::next(std::filesystem::directory_iterator(folder)) == std::filesystem::directory_iterator{};
    const std::string other = difference(there, content);
    const std::string whole = (factory.empty() ? "" : factory + "\n") + content;
    require(is_only_file && whole.starts_with(found), where,
            "the folder holds the results of another scene (see {} there): {}; choose another folder with --output",
            name, other.empty() ? "their texts differ" : other);
    write_at(open, 0, std::as_bytes(std::span(whole)));
    sync(open);
    sync_folder_of(file);
    return {factory, lock};
} catch (const std::system_error& cause) {
    fail_opening(folder, cause);
}

}  // namespace drover::files
