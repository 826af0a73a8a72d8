// jobs/run_record.cpp: means and errors as they are, all else deflated.
#include "jobs/run_record.hpp"

#include <algorithm>

#include "drover/base/error.hpp"
#include "files/bytes.hpp"

namespace drover::jobs {

namespace {
using Bytes = std::vector<std::byte>;

void put_texts(Bytes& to, const std::vector<std::string>& all) {
    files::put(to, static_cast<std::uint32_t>(all.size()));
    for (const std::string& words : all) files::put_text(to, words);
}

std::vector<std::string> take_texts(files::ByteReader& reader) {
    std::vector<std::string> all;
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t i = 0; i < count && reader.is_complete; ++i) all.push_back(reader.take_list<std::string>());
    return all;
}

constexpr unsigned has_error = 1, is_angle = 2;  // bits

/// Numbers of an estimate that most estimates of a run have in common.
struct Extent {
    double warm_up = 0.0;
    std::uint64_t samples = 0, blocks = 0;
    bool operator==(const Extent&) const = default;
};

template <class Item>
std::uint16_t index_in(std::vector<Item>& items, const Item& item) {
    const auto found = std::find(items.begin(), items.end(), item);
    const auto index = static_cast<std::uint16_t>(found - items.begin());
    if (found == items.end()) items.push_back(item);
    return index;
}

/// The schema of the rows.
std::string shared_part(const std::vector<measure::SummaryRow>& rows) {
    Bytes bytes;
    files::put(bytes, static_cast<std::uint32_t>(rows.size()));
    for (const measure::SummaryRow& row : rows) {
        put_texts(bytes, {row.name, row.unit, row.formula});
        files::put(bytes, static_cast<std::uint32_t>(row.axes.size()));
        for (const measure::Axis& axis : row.axes) {
            put_texts(bytes, {axis.name, axis.unit, axis.meaning});
            files::put_list(bytes, std::span<const double>(axis.values));
        }
    }
    return files::text_of(bytes);
}

std::vector<measure::SummaryRow> rows_of(const std::string& shared) {
    files::ByteReader reader{std::as_bytes(std::span(shared))};
    std::vector<measure::SummaryRow> rows;
    const auto count = reader.take<std::uint32_t>();
    for (std::uint32_t r = 0; r < count && reader.is_complete; ++r) {
        std::vector<std::string> words = take_texts(reader);
        words.resize(3);
        measure::SummaryRow row{.name = words[0], .unit = words[1], .formula = words[2], .axes = {}, .estimates = {}};
        const auto axes = reader.take<std::uint32_t>();
        for (std::uint32_t a = 0; a < axes && reader.is_complete; ++a) {
            words = take_texts(reader);
            words.resize(3);
            row.axes.push_back({words[0], words[1], words[2], reader.take_list<std::vector<double>>()});
        }
        rows.push_back(std::move(row));
    }
    require(reader.is_complete && reader.rest.empty(), {},
            "a record of a run is damaged; expected that of this drover");
    return rows;
}
}  // namespace

UnitResult encode(const RunResults& results) {
    Bytes numbers, marks;
    std::vector<Extent> extents;
    std::vector<std::string> reasons{""};
    for (const measure::SummaryRow& row : results.rows)
        for (const measure::Estimate& estimate : row.estimates) {
            const bool is_single = row.axes.empty();
            files::put(numbers, estimate.mean);
            if (estimate.error) files::put(numbers, *estimate.error);
            files::put(marks, static_cast<std::uint8_t>((estimate.error ? has_error : 0) |
                                                        (estimate.is_direction ? is_angle : 0)));
            files::put(marks, index_in(extents, {estimate.warm_up, estimate.samples, estimate.blocks}));
            if (!is_single) continue;
            files::put(marks, index_in(reasons, estimate.why_no_error));
            files::put(marks, estimate.autocorrelation_time);
        }
    Bytes rest;
    put_texts(rest, results.warnings);
    put_texts(rest, reasons);
    files::put(rest, static_cast<std::uint32_t>(extents.size()));
    for (const Extent& extent : extents) {
        files::put(rest, extent.warm_up);
        files::put(rest, extent.samples);
        files::put(rest, extent.blocks);
    }
    rest.insert(rest.end(), marks.begin(), marks.end());
    Bytes bytes;
    files::put_list(bytes, std::span<const std::byte>(numbers));
    files::put_list(bytes, std::span<const std::byte>(files::deflated(rest)));
    return {.content = files::text_of(bytes), .shared = shared_part(results.rows)};
}

RunResults decode(const UnitResult& result) {
    RunResults results{.rows = rows_of(result.shared), .warnings = {}};
    files::ByteReader whole{std::as_bytes(std::span(result.content))};
    const auto number_bytes = whole.take_list<Bytes>();
    const auto rest = files::inflated(whole.take_list<Bytes>());
    require(rest.has_value(), {}, "a record of a run is damaged; expected that of this drover");
    files::ByteReader numbers{number_bytes}, marks{*rest};
    results.warnings = take_texts(marks);
    const std::vector<std::string> reasons = take_texts(marks);
    std::vector<Extent> extents(std::min<std::size_t>(marks.take<std::uint32_t>(), 1 << 20));
    for (Extent& extent : extents) {
        extent.warm_up = marks.take<double>();
        extent.samples = marks.take<std::uint64_t>();
        extent.blocks = marks.take<std::uint64_t>();
    }
    for (measure::SummaryRow& row : results.rows)
        for (std::size_t k = 0; k < measure::size_of(row.axes) && marks.is_complete; ++k) {
            measure::Estimate estimate{.mean = numbers.take<double>()};
            const auto kind = marks.take<std::uint8_t>();
            if ((kind & has_error) != 0) estimate.error = numbers.take<double>();
            estimate.is_direction = (kind & is_angle) != 0;
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
    require(numbers.is_complete && marks.is_complete && numbers.rest.empty() && marks.rest.empty(), {},
            "a record of a run is damaged; expected that of this drover");
    return results;
}

}  // namespace drover::jobs
