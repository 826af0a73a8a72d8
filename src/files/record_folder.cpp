// files/record_folder.cpp: files of records, each with one writer, and the text that claims their folder.
#include "files/record_folder.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <sstream>

#include "drover/base/text.hpp"
#include "files/bytes.hpp"

namespace drover::files {

namespace {
/// Keys with their sections and values.  Those of lists are numbered: "field[2].symbol".
std::vector<std::pair<std::string, std::string>> keys_of(const std::string& words) {
    std::vector<std::pair<std::string, std::string>> keys;
    std::map<std::string, int> items;
    std::string section, line;
    std::istringstream stream(words);
    while (std::getline(stream, line)) {
        if (line.starts_with("[[")) {
            section = line.substr(2, line.find(']') - 2);
            section += text("[{}]", ++items[section]);
        } else if (line.starts_with('[')) {
            section = line.substr(1, line.find(']') - 1);
        }
        if (const std::size_t equals = line.find(" = "); equals != std::string::npos)
            keys.emplace_back(section + "." + line.substr(0, equals), line.substr(equals + 3));
    }
    return keys;
}

namespace fs = std::filesystem;
constexpr const char* ending = ".records";
constexpr std::uint64_t records_magic = 0x31736c7274767264;  // "drvtrls1"
constexpr std::string_view content_sign = "trials of\n";     // begins the record of the content, and no other

std::vector<std::byte> head_of(const RecordIdentity& identity) {
    ByteWriter to;
    to(records_magic, identity.hash);
    return to.bytes;
}

[[noreturn]] void fail_reading(const fs::path& file, const std::system_error& cause) {
    throw access_failure(file, cause, "cannot be used",
                         "check the permissions of the folder, or choose another with --output");
}

/// Whether the folder holds nothing but texts that processes which start now are about to give this name.
bool is_unused(const fs::path& folder, const std::string& beginning) {
    return std::all_of(fs::directory_iterator(folder), fs::directory_iterator(),
                       [&](const auto& entry) { return entry.path().filename().string().starts_with(beginning); });
}

/// A new file that has all of its content when it has its name.  False where another process gives it the name first.
bool appear(const fs::path& file, const fs::path& beside, const std::string& content) {
    const Descriptor open = open_file(beside, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW);
    Cleanup cleanup{beside};
    write_at(open, 0, std::as_bytes(std::span(content)));
    sync(open);
    const bool is_first = link_to(open, beside, file);
    remove_if_exists(beside);
    cleanup.is_needed = false;
    sync_folder_of(file);
    return is_first;
}

/// A record with its length and its checksum.
std::vector<std::byte> record_bytes(const std::string& record) {
    const Bytes content = std::as_bytes(std::span(record));
    ByteWriter to;
    to(static_cast<std::uint64_t>(content.size() + sizeof(std::uint64_t)));
    to.add_bytes(content);
    to(checksum(content));
    return to.bytes;
}
}  // namespace

std::uint64_t fingerprint(const std::string& content) { return checksum(std::as_bytes(std::span(content))); }

RecordIdentity identity_of(const std::string& job, const std::string& content) {
    return {.hash = fingerprint(job + "\n" + content), .content = content};
}

std::vector<TextDifference> differences(const std::string& one, const std::string& other) {
    const auto a = keys_of(one), b = keys_of(other);
    const std::map<std::string, std::string> in_one(a.begin(), a.end()), in_other(b.begin(), b.end());
    std::vector<TextDifference> result;
    for (const auto& [key, value] : a) {
        const auto found = in_other.find(key);
        if (found == in_other.end()) result.push_back({key, value, {}});
        else if (found->second != value) result.push_back({key, value, found->second});
    }
    for (const auto& [key, value] : b)
        if (!in_one.contains(key)) result.push_back({key, {}, value});
    return result;
}

std::optional<TextDifference> first_difference(const std::string& one, const std::string& other) {
    const std::vector<TextDifference> all = differences(one, other);
    return all.empty() ? std::nullopt : std::optional(all.front());
}

bool are_same(const std::string& one, const std::string& other, const std::string& defaults) {
    const std::vector<TextDifference> found = differences(one, other);
    if (found.empty()) return true;
    const auto keys = keys_of(defaults);
    const std::map<std::string, std::string> default_values(keys.begin(), keys.end());
    return std::ranges::all_of(found, [&](const TextDifference& row) {
        if (row.one && row.other) return false;
        const auto value = default_values.find(row.key);
        return value != default_values.end() && value->second == (row.one ? *row.one : *row.other);
    });
}

std::vector<std::byte> start_of(const RecordIdentity& identity) {
    std::vector<std::byte> bytes = head_of(identity);
    const std::vector<std::byte> first = record_bytes(std::string(content_sign) + identity.content);
    bytes.insert(bytes.end(), first.begin(), first.end());
    return bytes;
}

std::string first_line(const std::string& words) { return words.substr(0, words.find('\n')); }

std::string difference(const std::string& there, const std::string& here) {
    const std::optional<TextDifference> found = first_difference(there, here);
    return found ? text("{} = {} there, {} here", found->key, shown(found->one), shown(found->other)) : "";
}

RecordContent records_in(Bytes bytes) {
    RecordContent content;
    ByteReader reader{bytes};
    for (;;) {
        const auto length = reader.take<std::uint64_t>();
        const auto bytes_of_record = without_checksum(reader.take_bytes(length));
        if (!reader.is_complete || !bytes_of_record) return content;
        content.valid_bytes += sizeof length + length;
        std::string record = text_of(*bytes_of_record);
        if (record.starts_with(content_sign)) content.of = record.substr(content_sign.size());
        else content.records.push_back(std::move(record));
    }
}

RecordContent content_of(Bytes bytes, const RecordIdentity& identity, const std::string& file) {
    const std::string head = text_of(head_of(identity)),
                      found = text_of(bytes.first(std::min(bytes.size(), head.size())));
    require(head.starts_with(found.substr(0, sizeof records_magic)), {file},
            "is not a file of records; expected one that drover wrote: put it back, or choose another folder with "
            "--output");
    RecordContent content;
    if (found.size() == head.size()) {
        content = records_in(bytes.subspan(head.size()));
        content.valid_bytes += head.size();
    }
    const std::string other = content.of.empty() ? "" : difference(content.of, identity.content);
    require(
        head.starts_with(found) && other.empty(), {file},
        "holds the records of another scene or measurement{}; expected those that were written here: put them back, "
        "or choose another folder with --output",
        other.empty() ? "" : ": " + other);
    return content;
}

RecordFolder::RecordFolder(const fs::path& folder, const RecordIdentity& identity, const std::string& name) try
    : folder_(folder),
      identity_(identity),
      own_file_(folder / text("{}-{}{}", name, draw_run_id().substr(0, 12), ending)) {
    fs::create_directories(folder);
} catch (const std::system_error& cause) {
    fail_reading(folder, cause);
}

void RecordFolder::read_file_from(const fs::path& file, std::uint64_t& done, std::vector<std::string>& records) {
    const Descriptor open = try_open(file, O_RDONLY | O_NOFOLLOW);
    if (!open.is_open() && errno == ENOENT) return;
    if (!open.is_open()) fail_reading(file, std::system_error(errno, std::generic_category(), "open"));
    const std::uint64_t length = length_of(open);
    if (length < done) done = 0;  // another file has the name now
    if (length <= done) return;
    std::vector<std::byte> bytes(static_cast<std::size_t>(length - done));
    bytes.resize(read_at(open, done, bytes));
    RecordContent content = done == 0 ? content_of(bytes, identity_, file.string()) : records_in(bytes);
    done += content.valid_bytes;
    std::move(content.records.begin(), content.records.end(), std::back_inserter(records));
}

std::vector<std::string> RecordFolder::read_new() try {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_))
        if (entry.path().extension() == ending && entry.path() != own_file_) files.push_back(entry.path());
    std::ranges::sort(files);
    std::vector<std::string> records;
    for (const fs::path& file : files) read_file_from(file, read_[file], records);
    return records;
} catch (const std::system_error& cause) {
    fail_reading(folder_, cause);
}

void RecordFolder::append(const std::string& record) {
    std::vector<std::byte> bytes = record_bytes(record);
    try {
        if (end_ == 0) {
            const std::vector<std::byte> start = start_of(identity_);
            bytes.insert(bytes.begin(), start.begin(), start.end());
        }
        if (!own_.is_open()) {
            own_ = open_file(own_file_, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW);
            sync_folder_of(own_file_);
        }
        write_at(own_, end_, bytes);
    } catch (const std::system_error& cause) {
        throw write_failure(own_file_, cause, bytes.size(), "earlier records are kept");
    }
    end_ += bytes.size();
    is_durable_ = false;
}

void RecordFolder::sync() {
    if (is_durable_) return;
    try {
        files::sync(own_);
    } catch (const std::system_error& cause) {
        throw write_failure(own_file_, cause, 0, "earlier records are kept");
    }
    is_durable_ = true;
}

std::string join_folder(const fs::path& folder, const std::string& name, const std::string& factory,
                        const std::string& content) try {
    const SourceLocation where{.file = folder.string()};
    const fs::path file = folder / name;
    const std::string beginning = "." + name + ".", whole = (factory.empty() ? "" : factory + "\n") + content;
    std::error_code problem;
    fs::create_directories(folder, problem);
    require(!problem && fs::is_directory(folder), where,
            "the folder cannot be created ({}); choose another with "
            "--output",
            problem.message());
    auto bytes = read_file(file);
    if (!bytes) {
        // Another process may give it the name at the same moment: then the folder is not empty, and holds this file.
        require(is_unused(folder, beginning) || fs::exists(file), where,
                "the folder is not empty and holds no {}; choose another with --output", name);
        if (appear(file, folder / (beginning + draw_run_id()), whole)) return factory;
        bytes = read_file(file);
    }
    const std::string found = bytes ? text_of(*bytes) : "";
    const std::size_t head = factory.empty() ? 0 : first_line(found).size() + 1;
    const std::string there = found.substr(std::min(found.size(), head));
    if (there == content) return factory.empty() ? "" : first_line(found);
    const std::string other = difference(there, content);
    fail_input(where,
               "the folder holds the results of another scene (see {} there): {}; choose another folder with --output",
               name, other.empty() ? "their texts differ" : other);
} catch (const std::system_error& cause) {
    if (cause.code().value() == ENOSPC || cause.code().value() == EDQUOT)
        throw write_failure(folder, cause, content.size(), "nothing was started");
    fail_reading(folder, cause);
}

void require_locks(const fs::path& file_in_it) try {
    lock_for_writing(open_file(file_in_it, O_RDWR));  // that another process has it does not matter
} catch (const std::system_error& cause) {
    fail_reading(file_in_it, cause);
}

}  // namespace drover::files
