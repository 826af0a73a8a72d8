// files/input_file.cpp: input files through checked system calls.
#include "files/input_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "files/bytes.hpp"

namespace drover::files {

namespace {
constexpr std::size_t block_bytes = 1 << 16;
constexpr std::size_t max_line = 1 << 20;

Descriptor open_input(const std::filesystem::path& file, const std::string& expected) {
    Descriptor from = try_open(file, O_RDONLY);
    if (from.is_open()) return from;
    const std::system_error cause(errno, std::generic_category(), "open");
    const int error = cause.code().value();
    require(error != ENOENT && error != ENOTDIR, {file.string()}, "no such file; expected {}", expected);
    throw access_failure(file, cause, "cannot be read", "check its permissions; expected " + expected);
}

/// The next bytes of a file, "" at its end.
std::string read_block(const Descriptor& from, std::uint64_t offset, const std::filesystem::path& file,
                       std::size_t max_bytes = block_bytes) {
    std::string block(max_bytes, '\0');
    try {
        block.resize(read_at(from, offset, std::as_writable_bytes(std::span(block))));
    } catch (const std::system_error& cause) {
        throw disk_failure(file, cause);
    }
    return block;
}
}  // namespace

std::string read_text(const std::filesystem::path& file, const std::string& expected, std::uint64_t max_bytes) {
    const SourceLocation where{.file = file.string()};
    const Descriptor from = open_input(file, expected);
    std::string content;
    for (;;) {  // to the end: files of the kernel have the length 0
        const std::string block = read_block(from, content.size(), file);
        if (block.empty()) break;
        content += block;
        require(content.size() <= max_bytes, where, "larger than {}; expected {}",
                bytes_text(static_cast<double>(max_bytes)), expected);
    }
    if (content.size() < length_of(from))
        throw Error(Fault::environment, where, "changed while it was read; run the same command again");
    return content;
}

std::string read_start(const std::filesystem::path& file, std::size_t count) {
    const auto throw_unless_unavailable = [&](const std::system_error& cause) {
        if (fault_of(cause) != Fault::unavailable) throw disk_failure(file, cause);
    };
    std::error_code problem;
    if (!std::filesystem::is_regular_file(file, problem)) {
        if (problem) throw_unless_unavailable(std::system_error(problem, "stat"));
        return "";
    }
    const Descriptor from = try_open(file, O_RDONLY);
    if (from.is_open()) return read_block(from, 0, file, count);
    throw_unless_unavailable(std::system_error(errno, std::generic_category(), "open"));
    return "";
}

std::uint64_t file_checksum(const std::filesystem::path& file, const std::string& expected) {
    constexpr std::size_t max_bytes = 1 << 24;
    const Descriptor from = open_input(file, expected);
    std::vector<std::uint64_t> parts;
    for (std::uint64_t offset = 0;;) {
        const std::string block = read_block(from, offset, file, max_bytes);
        if (block.empty()) return checksum(std::as_bytes(std::span(parts)));
        parts.push_back(checksum(std::as_bytes(std::span(block))));
        offset += block.size();
    }
}

LineReader::LineReader(const std::filesystem::path& file, const std::string& expected)
    : file_(file), from_(open_input(file, expected)) {}

bool LineReader::fill() {
    block_ = read_block(from_, offset_, file_);
    offset_ += block_.size();
    done_ = 0;
    return !block_.empty();
}

bool LineReader::next(std::string& line) {
    line.clear();
    if (done_ == block_.size() && !fill()) return false;
    ++number_;
    for (;;) {
        const std::size_t end = std::min(block_.find('\n', done_), block_.size());
        line.append(block_, done_, end - done_);
        done_ = std::min(end + 1, block_.size());
        require(line.size() <= max_line, {file_.string(), number_},
                "a line of more than 1 MiB; expected shorter lines");
        if (end < block_.size() || !fill()) return true;
    }
}

}  // namespace drover::files
