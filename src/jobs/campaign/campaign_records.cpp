// jobs/campaign/campaign_records.cpp: encoding, and the one copy of what records have in common.
#include "jobs/campaign/campaign_records.hpp"

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "files/bytes.hpp"

namespace drover::jobs {

namespace {
/// The first byte of a record.
enum class RecordKind : std::uint8_t { unit = 1, shared = 2 };

/// The members in their order, for a ByteWriter and a ByteReader.  `shared`: the hash of that part.
template <class Order, class Record, class Hash>
void members(Order& order, Record& record, Hash& shared) {
    order(record.state, record.key, record.result.content, shared, record.reason, record.seconds, record.program);
}

files::ByteWriter encoded(const UnitRecord& record, std::uint64_t shared) {
    files::ByteWriter to;
    to(RecordKind::unit);
    members(to, record, shared);
    return to;
}

[[noreturn]] void fail_format(const std::string& where) {
    fail_input({where},
               "holds a record that this version of drover does not know; expected one of its own, or of an "
               "earlier version");
}

struct Decoded {
    UnitRecord record;
    std::uint64_t shared = 0;  ///< hash
};

/// After the byte of the kind.
Decoded decoded(files::ByteReader& reader) {
    Decoded found;
    members(reader, found.record, found.shared);
    if (found.record.state > UnitState::lost) reader.is_complete = false;
    return found;
}
}  // namespace

std::string unit_bytes(const UnitRecord& record) {
    files::ByteWriter to = encoded(record, 0);
    to(record.result.shared, record.core_seconds);
    return files::text_of(to.bytes);
}

UnitRecord unit_of(const std::string& bytes) {
    files::ByteReader reader{std::as_bytes(std::span(bytes))};
    reader.take<RecordKind>();
    Decoded found = decoded(reader);
    reader(found.record.result.shared, found.record.core_seconds);
    if (!reader.is_complete) fail_environment("a worker returned {} bytes that are no record", bytes.size());
    return std::move(found.record);
}

UnitStore::UnitStore(const std::filesystem::path& folder, const files::RecordIdentity& identity, const Share& share)
    : folder_(folder / "records", identity, text("share-{:05}", share.number)) {}

std::vector<UnitRecord> UnitStore::read_new() {
    std::vector<UnitRecord> records;
    for (const std::string& bytes : folder_.read_new()) {
        files::ByteReader reader{std::as_bytes(std::span(bytes))};
        const auto kind = reader.take<RecordKind>();
        if (kind == RecordKind::shared) {
            const std::string words = reader.take<std::string>();
            shared_[files::fingerprint(words)] = words;
            continue;
        }
        Decoded found = decoded(reader);
        if (!reader.is_complete || kind != RecordKind::unit) fail_format("records");
        const auto shared = shared_.find(found.shared);
        if (found.shared != 0 && shared == shared_.end()) continue;  // its file was damaged: the unit runs again
        if (found.shared != 0) found.record.result.shared = shared->second;
        records.push_back(std::move(found.record));
    }
    return records;
}

void UnitStore::append(UnitRecord record) {
    const std::string& words = record.result.shared;
    const std::uint64_t hash = words.empty() ? 0 : files::fingerprint(words);
    if (hash != 0 && stored_.insert(hash).second) {
        files::ByteWriter to;
        to(RecordKind::shared, words);
        folder_.append(files::text_of(to.bytes));
    }
    folder_.append(files::text_of(encoded(record, hash).bytes));
}

std::vector<UnitRecord> campaign_records(const std::filesystem::path& folder, const files::RecordIdentity& identity) {
    if (!std::filesystem::is_directory(folder / "records")) return {};
    std::map<std::string, UnitRecord> best;
    // Of two that are done the one with the smaller bytes, so that the choice does not depend on who came first.
    const auto is_better = [](const UnitRecord& one, const UnitRecord& other) {
        const auto rank = [](const UnitRecord& record) {
            return std::tie(record.state, record.result.content, record.result.shared, record.reason, record.program);
        };
        return rank(one) < rank(other);
    };
    for (UnitRecord& record : UnitStore(folder, identity, {}).read_new()) {
        const auto [at, is_new] = best.try_emplace(record.key, record);
        if (!is_new && is_better(record, at->second)) at->second = std::move(record);
    }
    return mapped(best, [](auto& one) { return std::move(one.second); });
}

}  // namespace drover::jobs
