// jobs/campaign/campaign_records.cpp: encoding, and the one copy of what records have in common; means and errors as
// they are, all else deflated.
#include "jobs/campaign/campaign_records.hpp"

#include <algorithm>

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

using Bytes = std::vector<std::byte>;

void put_texts(files::ByteWriter& to, const std::vector<std::string>& all) {
    to(static_cast<std::uint32_t>(all.size()));
    for (const std::string& words : all) to(words);
}

std::vector<std::string> take_texts(files::ByteReader& reader) {
    std::vector<std::string> all;
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < count && reader.is_complete; ++i) all.push_back(reader.take<std::string>());
    return all;
}

constexpr unsigned has_error = 1, is_angle = 2, is_largest = 4;  // bits

/// Numbers of an estimate that most estimates of a run have in common.
struct Extent {
    double warm_up = 0.0;
    std::uint64_t samples = 0, blocks = 0;
    bool operator==(const Extent&) const = default;
};

template <class Item>
std::uint16_t index_in(std::vector<Item>& items, const Item& item) {
    const auto found = std::ranges::find(items, item);
    const auto index = static_cast<std::uint16_t>(found - items.begin());
    if (found == items.end()) items.push_back(item);
    return index;
}

/// The schema of the rows.
std::string shared_part(const std::vector<measure::SummaryRow>& rows) {
    constexpr std::uint32_t words = 3;  // of a row and of an axis
    files::ByteWriter to;
    to(static_cast<std::uint32_t>(rows.size()));
    for (const measure::SummaryRow& row : rows) {
        to(words, row.name, row.unit, row.formula, static_cast<std::uint32_t>(row.axes.size()));
        for (const measure::Axis& axis : row.axes) to(words, axis.name, axis.unit, axis.meaning, axis.values);
    }
    return files::text_of(to.bytes);
}

std::vector<measure::SummaryRow> rows_of(const std::string& shared) {
    files::ByteReader reader{std::as_bytes(std::span(shared))};
    std::vector<measure::SummaryRow> rows;
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t r = 0; r < count && reader.is_complete; ++r) {
        measure::SummaryRow& row = rows.emplace_back();
        std::uint32_t words = 0, axes = 0;
        reader(words, row.name, row.unit, row.formula, axes);
        for (std::uint32_t a = 0; a < axes && reader.is_complete; ++a) {
            measure::Axis& axis = row.axes.emplace_back();
            reader(words, axis.name, axis.unit, axis.meaning, axis.values);
        }
    }
    require(reader.has_ended(), {}, "a record of a run is damaged; expected that of this drover");
    return rows;
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

UnitResult encode(const RunResults& results) {
    files::ByteWriter numbers, marks, rest, whole;
    std::vector<Extent> extents;
    std::vector<std::string> reasons{""};
    for (const measure::SummaryRow& row : results.rows)
        for (const measure::Estimate& estimate : row.estimates) {
            numbers(estimate.mean);
            if (estimate.error) numbers(*estimate.error);
            const auto is = [&](measure::Averaging one) { return estimate.averaging == one; };
            marks(static_cast<std::uint8_t>((estimate.error ? has_error : 0) |
                                            (is(measure::Averaging::direction) ? is_angle : 0) |
                                            (is(measure::Averaging::maximum) ? is_largest : 0)),
                  index_in(extents, {estimate.warm_up, estimate.samples, estimate.blocks}));
            if (row.axes.empty()) marks(index_in(reasons, estimate.why_no_error), estimate.autocorrelation_time);
        }
    put_texts(rest, results.warnings);
    put_texts(rest, reasons);
    rest(static_cast<std::uint32_t>(extents.size()));
    for (const Extent& extent : extents) rest(extent.warm_up, extent.samples, extent.blocks);
    rest.add_bytes(marks.bytes);
    whole(numbers.bytes, files::deflated(rest.bytes));
    return {.content = files::text_of(whole.bytes), .shared = shared_part(results.rows)};
}

RunResults decode(const UnitResult& result) {
    RunResults results{.rows = rows_of(result.shared), .warnings = {}};
    files::ByteReader whole{std::as_bytes(std::span(result.content))};
    const auto number_bytes = whole.take<Bytes>();
    const auto rest = files::inflated(whole.take<Bytes>());
    require(rest.has_value(), {}, "a record of a run is damaged; expected that of this drover");
    files::ByteReader numbers{number_bytes}, marks{*rest};
    results.warnings = take_texts(marks);
    const std::vector<std::string> reasons = take_texts(marks);
    std::vector<Extent> extents(std::min<std::size_t>(marks.take<std::uint32_t>(), 1 << 20));
    for (Extent& extent : extents) marks(extent.warm_up, extent.samples, extent.blocks);
    for (measure::SummaryRow& row : results.rows)
        for (std::size_t k = 0; k < measure::size_of(row.axes) && marks.is_complete; ++k) {
            measure::Estimate estimate{.mean = numbers.take<double>()};
            const auto kind = marks.take<std::uint8_t>();
            if ((kind & has_error) != 0) estimate.error = numbers.take<double>();
            if ((kind & is_angle) != 0) estimate.averaging = measure::Averaging::direction;
            if ((kind & is_largest) != 0) estimate.averaging = measure::Averaging::maximum;
            const auto extent = marks.take<std::uint16_t>();
            const auto reason = row.axes.empty() ? marks.take<std::uint16_t>() : std::uint16_t{0};
            if (row.axes.empty()) estimate.autocorrelation_time = marks.take<double>();
            if (extent >= extents.size() || reason >= reasons.size()) marks.is_complete = false;
            if (!marks.is_complete) break;
            estimate.warm_up = extents[extent].warm_up;
            estimate.samples = static_cast<std::size_t>(extents[extent].samples);
            estimate.blocks = static_cast<std::size_t>(extents[extent].blocks);
            estimate.why_no_error = reasons[reason];
            row.estimates.push_back(std::move(estimate));
        }
    require(numbers.has_ended() && marks.has_ended(), {}, "a record of a run is damaged; expected that of this drover");
    return results;
}

}  // namespace drover::jobs
