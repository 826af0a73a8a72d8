// io/trial_file.cpp: "drvtrls1", the identity, then records: length, number, numbers, failure, checksum.
#include "drover/io/trial_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <sstream>
#include <thread>

#include "io/durable.hpp"
#include "io/durable_bytes.hpp"

namespace drover::io {

namespace {
constexpr std::uint64_t magic = 0x31736c7274767264;  // "drvtrls1"
constexpr std::size_t head_bytes = 2 * sizeof(std::uint64_t);

std::vector<std::byte> encoded(const calibrate::Attempt& attempt) {
    std::vector<std::byte> bytes;
    put(bytes, attempt.number);
    put_list(bytes, std::span<const double>(attempt.numbers));
    put_list(bytes, std::span<const char>(attempt.failure));
    put(bytes, checksum(bytes));
    return bytes;
}

std::optional<calibrate::Attempt> decoded(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    ByteReader reader{*content};
    calibrate::Attempt attempt{.number = reader.take<std::uint64_t>(), .numbers = {}, .failure = {}};
    attempt.numbers = reader.take_list<std::vector<double>>();
    attempt.failure = reader.take_list<std::string>();
    if (!reader.is_whole || !reader.rest.empty()) return std::nullopt;
    return attempt;
}

std::vector<std::byte> head_of(std::uint64_t identity) {
    std::vector<std::byte> bytes;
    put(bytes, magic);
    put(bytes, identity);
    return bytes;
}

struct Content {
    std::vector<calibrate::Attempt> attempts;
    std::uint64_t whole = 0;  ///< bytes of the head and of whole records
};

/// A head that is cut short is that of a file which a kill met in its making.
Content content_of(Bytes bytes, std::uint64_t identity, const std::string& file) {
    const std::vector<std::byte> head = head_of(identity);
    const std::size_t magic_bytes = std::min(bytes.size(), sizeof magic), found = std::min(bytes.size(), head_bytes);
    require(std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(magic_bytes), head.begin()), {file},
            "is not a file of trials; expected a folder that drover calibrate made");
    require(std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(found), head.begin()), {file},
            "holds the trials of another scene or point; expected its own: name another folder with --output");
    Content content;
    if (found < head_bytes) return content;
    content.whole = head_bytes;
    ByteReader reader{bytes.subspan(head_bytes)};
    for (;;) {
        const auto length = reader.take<std::uint64_t>();
        auto attempt = decoded(reader.take_bytes(length));
        if (!reader.is_whole || !attempt) return content;
        content.whole += sizeof length + length;
        content.attempts.push_back(std::move(*attempt));
    }
}

/// A writer that was killed lets go when its last worker has ended, a moment later.
bool lock_within_moments(const Descriptor& file) {
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

/// What a file cannot be used for; a disk that is full is told as such.
[[noreturn]] void fail_opening(const std::filesystem::path& file, const std::system_error& cause) {
    const int error = cause.code().value();
    if (error == ENOSPC || error == EDQUOT || error == EIO)
        throw write_failure(file, cause, head_bytes, "no trial was begun");
    if (error == EMFILE || error == ENFILE)
        fail_input(
            {file.string()},
            "cannot be opened: {}; expected a file for each measurement at a time: raise the limit (ulimit -n), or "
            "give shares of the work with --share",
            std::string(cause.what()));
    fail_input({file.string()}, "cannot be opened: {}; check the permissions of the folder, or name another",
               std::string(cause.what()));
}
}  // namespace

struct TrialFile::File {
    std::filesystem::path path;
    Descriptor open;
    std::vector<calibrate::Attempt> attempts;
    std::uint64_t cut = 0, end = 0;
};

TrialFile::TrialFile(const std::filesystem::path& file, std::uint64_t identity) try : file_(std::make_unique<File>()) {
    file_->path = file;
    file_->open = open_file(file, O_RDWR | O_CREAT);
    require(
        lock_within_moments(file_->open), {file.string()},
        "another drover calibrate is at work on it; expected one at a time: wait for it, or give shares of the work "
        "with --share");
    const std::vector<std::byte> bytes = bytes_of(file_->open);
    Content content = content_of(bytes, identity, file.string());
    file_->attempts = std::move(content.attempts);
    file_->cut = bytes.size() - content.whole;
    file_->end = content.whole;
    if (content.whole == 0) {
        write_at(file_->open, 0, head_of(identity));
        file_->end = head_bytes;
    }
    if (file_->end < bytes.size()) truncate_to(file_->open, file_->end);
    if (content.whole != bytes.size() || bytes.empty()) {
        sync(file_->open);
        sync_folder_of(file);
    }
} catch (const std::system_error& cause) {
    fail_opening(file, cause);
}

TrialFile::TrialFile(TrialFile&&) noexcept = default;
TrialFile::~TrialFile() = default;
const std::vector<calibrate::Attempt>& TrialFile::attempts() const { return file_->attempts; }
std::uint64_t TrialFile::cut() const { return file_->cut; }

void TrialFile::append(const calibrate::Attempt& attempt) {
    const std::vector<std::byte> record = encoded(attempt);
    std::vector<std::byte> bytes;
    put_list(bytes, Bytes(record));
    try {
        write_at(file_->open, file_->end, bytes);
        sync(file_->open);
    } catch (const std::system_error& cause) {
        throw write_failure(file_->path, cause, bytes.size(), "the trials before are kept");
    }
    file_->end += bytes.size();
}

std::vector<calibrate::Attempt> read_trials(const std::filesystem::path& file, std::uint64_t identity) try {
    const auto bytes = read_whole(file);
    if (!bytes) return {};
    return content_of(*bytes, identity, file.string()).attempts;
} catch (const std::system_error& cause) {
    fail_opening(file, cause);
}

std::string attempt_bytes(const calibrate::Attempt& attempt) {
    const std::vector<std::byte> bytes = encoded(attempt);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

calibrate::Attempt attempt_of(const std::string& bytes) {
    auto attempt = decoded(std::as_bytes(std::span(bytes)));
    if (!attempt) fail_run("a worker gave {} bytes that are no trial; try again", bytes.size());
    return std::move(*attempt);
}

std::uint64_t fingerprint(const std::string& words) { return checksum(std::as_bytes(std::span(words))); }

void replace_file(const std::filesystem::path& file, const std::string& content) {
    const std::filesystem::path beside = file.string() + ".partial";
    try {
        const Descriptor to = open_file(beside, O_RDWR | O_CREAT | O_TRUNC);
        write_at(to, 0, std::as_bytes(std::span(content)));
        sync(to);
        rename_over(beside, file);
        sync_folder_of(file);
    } catch (const std::system_error& cause) {
        throw write_failure(file, cause, content.size(), "the file stays as it was");
    }
}

namespace {
/// Where two texts of a scene first differ: "kick.strength = 0.02 there, 0.015 here".
std::string difference(const std::string& there, const std::string& here) {
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
    const auto a = keys_of(there), b = keys_of(here);
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
        if (a[i] != b[i] && a[i].first == b[i].first)
            return text("{} = {} there, {} here", a[i].first, a[i].second, b[i].second);
    return "they have other keys";
}

std::string first_line(const std::string& words) { return words.substr(0, words.find('\n')); }
}  // namespace

std::string claim_folder(const std::filesystem::path& folder, const std::string& name, const std::string& factory,
                         const std::string& content) try {
    const SourceLocation where{.file = folder.string()};
    const std::filesystem::path file = folder / name;
    std::error_code problem;
    std::filesystem::create_directories(folder, problem);
    require(!problem && std::filesystem::is_directory(folder), where,
            "cannot be made a folder ({}); name another with --output", problem.message());
    // Others may claim it at the same moment: what makes it not empty is then that file, and it is there.
    require(std::filesystem::is_empty(folder) || std::filesystem::exists(file), where,
            "the folder is not empty and holds no {}; name another with --output", name);
    const Descriptor open = open_file(file, O_RDWR | O_CREAT);
    require(lock_within_moments(open), where,
            "another drover is making this folder; expected one at a time: try again");
    const std::vector<std::byte> bytes = bytes_of(open);
    const std::string found(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string there = found.substr(std::min(found.size(), first_line(found).size() + 1));
    if (there == content) return first_line(found);
    // Cut short by a crash, before there was anything else.
    const bool alone = std::next(std::filesystem::directory_iterator(folder)) == std::filesystem::directory_iterator{};
    require(alone && (factory + "\n" + content).starts_with(found), where,
            "the folder holds the trials of another scene (see {} there): {}; name another folder with --output", name,
            difference(there, content));
    const std::string whole = factory + "\n" + content;
    write_at(open, 0, std::as_bytes(std::span(whole)));
    sync(open);
    sync_folder_of(file);
    return factory;
} catch (const std::system_error& cause) {
    fail_opening(folder, cause);
}

}  // namespace drover::io
