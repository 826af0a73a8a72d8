// run/result_text.cpp: a result as text, aligned values and tables, and as JSON.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/mapped.hpp"
#include "drover/base/text.hpp"
#include "run/result.hpp"

namespace drover::run {

namespace {
std::string words_of(std::string name) {
    std::ranges::replace(name, '_', ' ');
    return name;
}

std::string number_text(double value, int digits) {
    return std::isfinite(value) ? text("{:.{}g}", value + 0.0, digits) : "-";  // + 0.0: -0 becomes 0
}

std::string value_text(const Entry& entry) {
    struct {
        int digits;
        double rounding;
        std::string operator()(double value) const {
            return number_text(std::abs(value) <= rounding ? 0.0 : value, digits);
        }
        std::string operator()(std::int64_t value) const { return text("{}", value); }
        std::string operator()(bool value) const { return value ? "yes" : "no"; }
        std::string operator()(const std::string& value) const { return value; }
        std::string operator()(const std::vector<std::string>& values) const { return joined(values); }
        std::string operator()(const std::vector<double>& values) const {
            return "(" + joined(mapped(values, [&](double value) { return number_text(value, digits); })) + ")";
        }
    } writer{entry.digits, entry.rounding};
    return std::visit(writer, entry.value);
}

bool is_words(const Entry& entry) { return entry.unit.empty(); }

/// Numbers that do not exist for this result are left out.
bool is_printed(const Entry& entry) {
    if (!entry.shown.text) return false;
    if (const auto* words = std::get_if<std::string>(&entry.value)) return !words->empty();
    const auto* number = std::get_if<double>(&entry.value);
    return number == nullptr || std::isfinite(*number);
}

void add_entries(const std::vector<Entry>& entries, const std::string& indent, std::string& out) {
    std::size_t name = 0, value = 0, unit = 0;
    for (const Entry& entry : entries) {
        if (!is_printed(entry) || is_words(entry)) continue;
        name = std::max(name, entry.name.size());
        value = std::max(value, value_text(entry).size());
        unit = std::max(unit, entry.unit == "1" ? 0 : entry.unit.size());
    }
    for (const Entry& entry : entries) {
        if (!is_printed(entry)) continue;
        if (const auto* several = std::get_if<std::vector<std::string>>(&entry.value)) {
            for (const std::string& one : *several) out += text("{}{}: {}\n", indent, words_of(entry.name), one);
        } else if (is_words(entry)) {
            out += text("{}{}: {}\n", indent, words_of(entry.name), value_text(entry));
        } else {
            out += text("{}{:<{}}  {:>{}} {:<{}}  {}\n", indent, words_of(entry.name), name, value_text(entry), value,
                        entry.unit == "1" ? "" : entry.unit, unit, entry.meaning);
        }
    }
}

/// Entries of a row, those of its parts with the part's name.
std::vector<Entry> flat_entries(const Record& row) {
    std::vector<Entry> result;
    for (const Entry& entry : row.entries)
        if (entry.shown.text) result.push_back(entry);
    for (const auto& [name, part] : row.parts)
        for (Entry entry : flat_entries(part)) {
            entry.name = name + " " + entry.name;
            result.push_back(std::move(entry));
        }
    return result;
}

/// Numbers of a column that are rounding errors of the largest one become 0.
void clear_rounding(std::vector<std::vector<Entry>>& rows, std::size_t column) {
    double largest = 0.0;
    for (const auto& row : rows)
        if (const auto* value = std::get_if<double>(&row[column].value); value && std::isfinite(*value))
            largest = std::max(largest, std::abs(*value));
    for (auto& row : rows)
        if (auto* value = std::get_if<double>(&row[column].value); value && std::abs(*value) < 1e-12 * largest)
            *value = 0.0;
}

std::vector<std::vector<Entry>> table_rows(const List& list) {
    std::vector<const Record*> shown;
    for (const Record& row : list.rows)
        if (row.shown.text) shown.push_back(&row);
    const std::size_t count = std::min(shown.size(), list.max_rows);
    std::vector<std::vector<Entry>> rows;
    for (std::size_t i = 0; i < count; ++i)
        rows.push_back(flat_entries(*shown[count == 1 ? 0 : i * (shown.size() - 1) / (count - 1)]));
    return rows;
}

void add_table(const List& list, const std::string& indent, std::string& out) {
    std::vector<std::vector<Entry>> rows = table_rows(list);
    if (rows.empty()) return;
    std::vector<std::string> lines(rows.size() + 1, indent);
    for (std::size_t column = 0; column < rows.front().size(); ++column) {
        if (list.has_like_rows) clear_rounding(rows, column);
        const Entry& first = rows.front()[column];
        std::vector<std::string> cells{words_of(first.name) +
                                       (first.unit.empty() || first.unit == "1" ? "" : " [" + first.unit + "]")};
        for (const auto& row : rows) cells.push_back(value_text(row[column]));
        std::size_t width = 0;
        for (const std::string& cell : cells) width = std::max(width, cell.size());
        for (std::size_t i = 0; i < cells.size(); ++i)
            lines[i] += is_words(first) ? text("  {:<{}}", cells[i], width) : text("  {:>{}}", cells[i], width);
    }
    for (std::string& line : lines) {
        line.erase(line.find_last_not_of(' ') + 1);
        out += line + "\n";
    }
}

void add_record(const Record& record, const std::string& indent, std::string& out);

void add_list(const List& list, const std::string& indent, std::string& out) {
    if (!list.shown.text) return;
    if (list.rows.empty()) {
        if (!list.empty.empty()) out += indent + list.empty + "\n";
        return;
    }
    if (!list.heading.empty()) out += indent + list.heading + "\n";
    const bool is_innermost =
        std::ranges::all_of(list.rows, [](const Record& row) { return row.lists.empty() && row.heading.empty(); });
    if (is_innermost) return add_table(list, indent, out);
    for (const Record& row : list.rows)
        if (row.shown.text) add_record(row, indent, out);
}

void add_record(const Record& record, const std::string& indent, std::string& out) {
    if (!record.heading.empty()) out += (indent.empty() && !out.empty() ? "\n" : "") + indent + record.heading + "\n";
    const std::string inner = record.heading.empty() ? indent : indent + "  ";
    for (const std::string& line : record.header) out += inner + line + "\n";
    add_entries(record.entries, inner, out);
    for (const auto& [name, part] : record.parts)
        if (part.shown.text) add_record(part, inner, out);
    for (const List& list : record.lists) add_list(list, inner, out);
    for (const std::string& line : record.footer) out += inner + line + "\n";
}

struct ValueJson {
    nlohmann::json operator()(double value) const { return number_json(value); }
    nlohmann::json operator()(const std::vector<double>& values) const { return mapped(values, number_json); }
    template <class Value>
    nlohmann::json operator()(const Value& value) const {
        return value;
    }
};

nlohmann::json record_json(const Record& record) {
    nlohmann::json result = nlohmann::json::object();
    for (const Entry& entry : record.entries) result[entry.name] = std::visit(ValueJson{}, entry.value);
    for (const auto& [name, part] : record.parts)
        if (nlohmann::json inner = record_json(part); !inner.empty()) result[name] = std::move(inner);
    for (const List& list : record.lists) result[list.name] = mapped(list.rows, record_json);
    return result;
}
}  // namespace

std::string result_text(const Result& result) {
    std::string out;
    add_record(result.root, "", out);
    return out;
}

nlohmann::json number_json(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

nlohmann::json result_json(const Result& result) { return record_json(result.root); }

}  // namespace drover::run
