// files/record_file.cpp: "drvtrls1", the hash of the identity, then records: length, bytes, checksum.  The first may be
// the content of the identity.
#include "drover/files/record_file.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <sstream>
#include <thread>

#include "drover/files/bytes.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

namespace {
constexpr std::uint64_t magic = 0x31736c7274767264;  // "drvtrls1"
constexpr std::size_t head_bytes = 2 * sizeof(std::uint64_t);
constexpr std::string_view content_sign = "trials of\n";  // begins the record of the content, and no other

/// The record without its checksum; nothing if the checksum is wrong.
std::optional<std::string> decoded(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    return std::string(reinterpret_cast<const char*>(content->data()), content->size());
}

std::vector<std::byte> encoded(const std::string& record) {
    const Bytes content = std::as_bytes(std::span(record));
    std::vector<std::byte> bytes;
    put(bytes, static_cast<std::uint64_t>(content.size() + sizeof(std::uint64_t)));
    bytes.insert(bytes.end(), content.begin(), content.end());
    put(bytes, checksum(content));
    return bytes;
}

std::vector<std::byte> head_of(const RecordIdentity& identity) {
    std::vector<std::byte> bytes;
    put(bytes, magic);
    put(bytes, identity.hash);
    return bytes;
}

/// A file without records.
std::vector<std::byte> start_of(const RecordIdentity& identity) {
    std::vector<std::byte> bytes = head_of(identity);
    if (identity.content.empty()) return bytes;
    const std::vector<std::byte> first = encoded(std::string(content_sign) + identity.content);
    bytes.insert(bytes.end(), first.begin(), first.end());
    return bytes;
}

struct Content {
    std::string of;  ///< the content of the identity; "" if the file has none
    std::vector<std::string> records;
    std::uint64_t valid_bytes = 0;  ///< of the head and of complete records
};

std::string difference(const std::string& there, const std::string& here) {
    const TextDifference found = first_difference(there, here);
    if (found.key.empty()) return "";
    return text("{} = {} there, {} here", found.key, found.one, found.other);
}

Content records_in(Bytes bytes) {
    Content content{.of = {}, .records = {}, .valid_bytes = head_bytes};
    ByteReader reader{bytes.subspan(head_bytes)};
    for (;;) {
        const auto length = reader.take<std::uint64_t>();
        auto record = decoded(reader.take_bytes(length));
        if (!reader.is_complete || !record) return content;
        content.valid_bytes += sizeof length + length;
        if (record->starts_with(content_sign)) content.of = record->substr(content_sign.size());
        else content.records.push_back(std::move(*record));
    }
}

/// A truncated head is valid: a kill interrupted the creation of the file.
Content content_of(Bytes bytes, const RecordIdentity& identity, const std::string& file) {
    const std::vector<std::byte> head = head_of(identity);
    const std::size_t magic_bytes = std::min(bytes.size(), sizeof magic), found = std::min(bytes.size(), head_bytes);
    require(std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(magic_bytes), head.begin()), {file},
            "is not a file of trials; expected a folder that drover calibrate created");
    const Content content = found < head_bytes ? Content{} : records_in(bytes);
    const std::string other =
        content.of.empty() || identity.content.empty() ? "" : difference(content.of, identity.content);
    const bool has_hash = std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(found), head.begin());
    require(has_hash && other.empty(), {file},
            "holds the trials of another scene or measurement{}; expected those that were written here: put them back, "
            "or choose another folder with --output",
            other.empty() ? "" : ": " + other);
    return content;
}

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
        throw write_failure(file, cause, head_bytes, "nothing was started");
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
    Content content = content_of(bytes, identity, file.string());
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
    const std::vector<std::byte> bytes = encoded(record);
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

std::uint64_t fingerprint(const std::string& content) { return checksum(std::as_bytes(std::span(content))); }

TextDifference first_difference(const std::string& one, const std::string& other) {
    const auto keys_of = [](const std::string& words) {
        std::vector<std::pair<std::string, std::string>> keys;
        std::string section, line;
        std::istringstream stream(words);
        while (std::getline(stream, line)) {
            if (line.starts_with('[')) section = line.substr(1, line.find(']') - 1);
            const std::size_t equals = line.find(" = ");
            if (equals != std::string::npos)
                keys.emplace_back(section + "." + line.substr(0, equals), line.substr(equals + 3));
        }
        return keys;
    };
    const auto a = keys_of(one), b = keys_of(other);
    const auto has = [](const auto& keys, const std::string& name) {
        return std::any_of(keys.begin(), keys.end(), [&](const auto& key) { return key.first == name; });
    };
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        if (i < a.size() && i < b.size() && a[i] == b[i]) continue;
        if (i < a.size() && i < b.size() && a[i].first == b[i].first) return {a[i].first, a[i].second, b[i].second};
        const bool is_in_one = i < a.size() && (i >= b.size() || !has(b, a[i].first));
        if (is_in_one || i >= b.size()) return {a[i].first, a[i].second, "absent"};
        return {b[i].first, "absent", b[i].second};
    }
    return {};
}

namespace {
std::string first_line(const std::string& words) { return words.substr(0, words.find('\n')); }
}  // namespace

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
    const std::string found(reinterpret_cast<const char*>(bytes.data()), bytes.size());
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
