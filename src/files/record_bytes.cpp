// files/record_bytes.cpp: encoding and decoding of files of records.
#include "files/record_bytes.hpp"

#include <algorithm>
#include <optional>

#include "files/bytes.hpp"

namespace drover::files {

namespace {
constexpr std::uint64_t records_magic = 0x31736c7274767264;  // "drvtrls1"
constexpr std::size_t head_bytes = 2 * sizeof(std::uint64_t);
constexpr std::string_view content_sign = "trials of\n";  // begins the record of the content, and no other

/// The record without its checksum; nothing if the checksum is wrong.
std::optional<std::string> decoded_record(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    return text_of(*content);
}

std::vector<std::byte> head_of(const RecordIdentity& identity) {
    ByteWriter to;
    to(records_magic, identity.hash);
    return to.bytes;
}

}  // namespace

std::vector<std::byte> record_bytes(const std::string& record) {
    const Bytes content = std::as_bytes(std::span(record));
    ByteWriter to;
    to(static_cast<std::uint64_t>(content.size() + sizeof(std::uint64_t)));
    to.add_bytes(content);
    to(checksum(content));
    return to.bytes;
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
        auto record = decoded_record(reader.take_bytes(length));
        if (!reader.is_complete || !record) return content;
        content.valid_bytes += sizeof length + length;
        if (record->starts_with(content_sign)) content.of = record->substr(content_sign.size());
        else content.records.push_back(std::move(*record));
    }
}

RecordContent content_of(Bytes bytes, const RecordIdentity& identity, const std::string& file) {
    const std::vector<std::byte> head = head_of(identity);
    const std::size_t magic_bytes = std::min(bytes.size(), sizeof records_magic),
                      found = std::min(bytes.size(), head_bytes);
    require(std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(magic_bytes), head.begin()), {file},
            "is not a file of records; expected one that drover wrote: put it back, or choose another folder with "
            "--output");
    RecordContent content;
    if (found == head_bytes) {
        content = records_in(bytes.subspan(head_bytes));
        content.valid_bytes += head_bytes;
    }
    const std::string other = content.of.empty() ? "" : difference(content.of, identity.content);
    const bool has_hash = std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(found), head.begin());
    require(
        has_hash && other.empty(), {file},
        "holds the records of another scene or measurement{}; expected those that were written here: put them back, "
        "or choose another folder with --output",
        other.empty() ? "" : ": " + other);
    return content;
}

}  // namespace drover::files
