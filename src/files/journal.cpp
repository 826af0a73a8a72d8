// files/journal.cpp: "drvjrnl2", the length after the commit, the file it is for (run id, its offset, the checksums of
// the first sector before and after the commit), the number of patches, each as offset and bytes, checksum.
#include "files/journal.hpp"

#include "files/bytes.hpp"

namespace drover::files {
namespace {

constexpr std::uint64_t journal_magic = 0x326c6e726a767264;  // "drvjrnl2"

}  // namespace

std::string text_at(const Descriptor& file, std::uint64_t offset, std::size_t size) {
    std::string found(size, '\0');
    found.resize(read_at(file, offset, std::as_writable_bytes(std::span(found))));
    return found;
}

std::uint64_t head_of(const Descriptor& file) {
    const std::string head = text_at(file, 0, sector_bytes);
    return checksum(std::as_bytes(std::span(head)));
}

namespace {

/// The file holds the commit before the journal's, that commit, or a part of it.
void require_for(const Journal& journal, const Descriptor& open, const std::filesystem::path& file) {
    const SourceLocation where{journal_of(file).string()};
    const FileMark& before = journal.before;
    require(text_at(open, before.offset, before.run_id.size()) == before.run_id, where,
            "holds the last commit of another file, with run_id = {}; expected none, or that of {}: put back the file "
            "that was replaced, or remove the journal",
            before.run_id, file.string());
    const std::uint64_t head = head_of(open);
    require((head == before.head || head == journal.head_after) && journal.length <= length_of(open), where,
            "holds a commit that does not follow the last one of {}; expected none, or the next one: put back the "
            "file that was replaced, or remove the journal",
            file.string());
}

}  // namespace

std::filesystem::path journal_of(const std::filesystem::path& file) { return file.string() + ".journal"; }

std::vector<std::byte> encoded(const Journal& journal) {
    std::vector<std::byte> bytes;
    put(bytes, journal_magic);
    put(bytes, journal.length);
    put_text(bytes, journal.before.run_id);
    put(bytes, journal.before.offset);
    put(bytes, journal.before.head);
    put(bytes, journal.head_after);
    put(bytes, static_cast<std::uint64_t>(journal.patches.size()));
    for (const Patch& patch : journal.patches) {
        put(bytes, patch.offset);
        put_list(bytes, Bytes(patch.bytes));
    }
    put(bytes, checksum(bytes));
    return bytes;
}

std::optional<Journal> decoded(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    ByteReader reader{*content};
    if (reader.take<std::uint64_t>() != journal_magic) return std::nullopt;
    Journal journal;
    journal.length = reader.take<std::uint64_t>();
    journal.before.run_id = reader.take_list<std::string>();
    journal.before.offset = reader.take<std::uint64_t>();
    journal.before.head = reader.take<std::uint64_t>();
    journal.head_after = reader.take<std::uint64_t>();
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
    const auto journal = decoded(*bytes);
    if (journal) require_for(*journal, open, file);
    return journal;
}

void recover(const Descriptor& open, const std::filesystem::path& file) {
    if (const auto journal = read_journal(open, file)) apply(*journal, open);
    remove_if_exists(journal_of(file));
}

}  // namespace drover::files
