// files/journal.cpp: "drvjrnl2", the length after the commit, the file it is for (run id, its offset, the checksums of
// the first sector before and after the commit), the number of patches, each as offset and bytes, checksum.
#include "files/journal.hpp"

#include "files/bytes.hpp"

namespace drover::files {

std::filesystem::path journal_of(const std::filesystem::path& file) { return file.string() + ".journal"; }

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

constexpr std::uint64_t journal_magic = 0x326c6e726a767264;  // "drvjrnl2"

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

/// The members in their order in a file, without the patches, for a ByteWriter and a ByteReader.
template <class Order, class Of>
void members(Order& order, Of& journal) {
    order(journal.length, journal.before.run_id, journal.before.offset, journal.before.head, journal.head_after);
}
}  // namespace

std::vector<std::byte> encoded(const Journal& journal) {
    ByteWriter to;
    to(journal_magic);
    members(to, journal);
    to(static_cast<std::uint64_t>(journal.patches.size()));
    for (const Patch& patch : journal.patches) to(patch.offset, patch.bytes);
    return with_checksum(std::move(to.bytes));
}

std::optional<Journal> decoded(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    ByteReader reader{*content};
    if (reader.take<std::uint64_t>() != journal_magic) return std::nullopt;
    Journal journal;
    members(reader, journal);
    const auto count = reader.take<std::uint64_t>();
    for (std::uint64_t i = 0; i < count && reader.is_complete; ++i) {
        Patch patch;
        reader(patch.offset, patch.bytes);
        if (patch.offset > journal.length || patch.bytes.size() > journal.length - patch.offset) return std::nullopt;
        journal.patches.push_back(std::move(patch));
    }
    if (!reader.has_ended()) return std::nullopt;
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
    if (length_of(file) > journal.length) truncate_to(file, journal.length);
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
