// files/input_file.cpp: input files through checked system calls.
#include "files/input_file.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>

#include "files/bytes.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

namespace {
constexpr std::size_t block_bytes = 1 << 16;
constexpr std::size_t max_line = 1 << 20;

Descriptor open_input(const std::filesystem::path& file, const std::string& expected) {
    const SourceLocation where{.file = file.string()};
    Descriptor from = try_open(file, O_RDONLY);
    if (from.is_open()) return from;
    const std::system_error cause(errno, std::generic_category(), "open");
    const int error = cause.code().value();
    require(error != ENOENT && error != ENOTDIR, where, "no such file; expected {}", expected);
    if (is_of_disk(cause)) throw disk_failure(file, cause);
    throw Error(fault_of(cause), where,
                text("cannot be read: {}; check its permissions; expected {}", std::string(cause.what()), expected));
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

std::string read_text(const std::filesystem::path& file, std::uint64_t max_bytes, const std::string& expected) {
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

struct LineReader::File {
    std::filesystem::path path;
    Descriptor from;
    std::uint64_t offset = 0;  ///< of the next block
    std::string block = {};
    std::size_t done = 0;  ///< bytes of the block that were returned
    int number = 0;        ///< of the last line

    bool fill() {
        block = read_block(from, offset, path);
        offset += block.size();
        done = 0;
        return !block.empty();
    }
};

LineReader::LineReader(const std::filesystem::path& file, const std::string& expected)
    : file_(std::make_unique<File>(File{.path = file, .from = open_input(file, expected)})) {}
LineReader::LineReader(LineReader&&) noexcept = default;
LineReader::~LineReader() = default;

bool LineReader::next(std::string& line) {
    File& file = *file_;
    line.clear();
    if (file.done == file.block.size() && !file.fill()) return false;
    ++file.number;
    for (;;) {
        const std::size_t end = std::min(file.block.find('\n', file.done), file.block.size());
        line.append(file.block, file.done, end - file.done);
        file.done = std::min(end + 1, file.block.size());
        require(line.size() <= max_line, {file.path.string(), file.number},
                "a line of more than 1 MiB; expected shorter lines");
        if (end < file.block.size() || !file.fill()) return true;
    }
}

}  // namespace drover::files
