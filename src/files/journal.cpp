// files/journal.cpp: "drvjrnl1", the length after the commit, the number of patches, each as offset and bytes,
// checksum.
#include "files/journal.hpp"

#include "drover/files/bytes.hpp"

namespace drover::files {
namespace {

constexpr std::uint64_t magic = 0x316c6e726a767264;  // "drvjrnl1"

}  // namespace

std::filesystem::path journal_of(const std::filesystem::path& file) { return file.string() + ".journal"; }

std::vector<std::byte> encoded(const Journal& journal) {
    std::vector<std::byte> bytes;
    put(bytes, magic);
    put(bytes, journal.length);
    put(bytes, static_cast<std::uint64_t>(journal.patches.size()));
    for (const Patch& patch : journal.patches) {
        put(bytes, patch.offset);
        put_list(bytes, Bytes(patch.bytes));
    }
    put(bytes, checksum(bytes));
    return bytes;
}

std::optional<Journal> decoded(Bytes bytes, std::uint64_t file_length) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    ByteReader reader{*content};
    const auto found = reader.take<std::uint64_t>();
    Journal journal{.length = reader.take<std::uint64_t>(), .patches = {}};
    if (found != magic || journal.length > file_length) return std::nullopt;
    const auto count = reader.take<std::uint64_t>();
    for (std::uint64_t i = 0; i < count && reader.is_complete; ++i) {
        Patch patch{.offset = reader.take<std::uint64_t>(), .bytes = {}};
        patch.bytes = reader.take_list<std::vector<std::byte>>();
        if (patch.offset > journal.length || patch.bytes.size() > journal.length - patch.offset) return std::nullopt;
        journal.patches.push_back(std::move(patch));
    }
    if (!reader.is_complete || !reader.rest.empty()) return std::nullopt;
    return journal;
}

void write_journal(const std::filesystem::path& file, Bytes journal) {
    const Descriptor to = create_file(journal_of(file));
    write_at(to, 0, journal);
    sync(to);
    sync_folder_of(file);
}

void apply(const Journal& journal, const Descriptor& file) {
    for (const Patch& patch : journal.patches) write_at(file, patch.offset, patch.bytes);
    if (length_of(file) != journal.length) truncate_to(file, journal.length);
    sync(file);
}

std::optional<Journal> read_journal(const Descriptor& open, const std::filesystem::path& file) {
    const auto bytes = read_file(journal_of(file));
    if (!bytes) return std::nullopt;
    return decoded(*bytes, length_of(open));
}

void recover(const Descriptor& open, const std::filesystem::path& file) {
    if (const auto journal = read_journal(open, file)) apply(*journal, open);
    remove_if_exists(journal_of(file));
}

}  // namespace drover::files
