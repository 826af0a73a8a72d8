// run/result.cpp: a result as the tables of an archive, in which nested lists become arrays; as text, aligned values
// and tables, and as JSON.
#include "run/result.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "base/mapped.hpp"
#include "drover/base/text.hpp"

namespace drover::run {

namespace {
/// Values of one dataset, with the depth of the list that it belongs to.
struct Column {
    Entry entry;
    std::string name;
    std::size_t depth = 0;
    std::vector<double> values;
};

/// What is stored of a value: text without choices is not.
bool is_stored(const Entry& entry) {
    if (!entry.shown.archive || std::holds_alternative<std::vector<std::string>>(entry.value)) return false;
    return !std::holds_alternative<std::string>(entry.value) || !entry.choices.empty();
}

std::string unit_of(const Entry& entry) { return entry.unit.empty() ? "1" : entry.unit; }

/// "mean" and "error" make mean_error, "mean" and "" mean.
std::string name_in(const std::string& record, const std::string& name) {
    std::string joint = record.empty() ? name : name.empty() ? record : record + "_" + name;
    std::ranges::replace(joint, '-', '_');
    return joint;
}

/// The stored numbers of a record; a vector is stored by its components.
void add_columns(const Record& record, const std::string& before, std::size_t depth, std::vector<Column>& columns) {
    for (const Entry& entry : record.entries) {
        if (!is_stored(entry)) continue;
        const std::string name = name_in(before, entry.dataset.value_or(entry.name));
        if (const auto* vector = std::get_if<std::vector<double>>(&entry.value)) {
            const char* const axes[]{"x", "y", "z"};
            for (std::size_t i = 0; i < vector->size() && i < 3; ++i)
                columns.push_back({entry, name + "_" + axes[i], depth, {(*vector)[i]}});
        } else {
            columns.push_back({entry, name, depth, {stored_value(entry)}});
        }
    }
    for (const auto& [name, part] : record.parts)
        if (part.shown.archive && part.group.empty()) add_columns(part, name_in(before, name), depth, columns);
}

/// The lists from the outermost to an innermost one, and the arrays over its rows.
struct Flattened {
    std::vector<const List*> path;
    std::vector<Column> columns;
    std::size_t rows = 0;
};

using Counters = std::map<std::string, double>;

void flatten(const List& list, std::vector<const List*> path, std::vector<Column> outer, Counters& counters,
             std::map<std::string, Flattened>& found) {
    const std::size_t depth = path.size();
    path.push_back(&list);
    for (const Record& row : list.rows) {
        std::vector<Column> columns = outer;
        if (!list.row.empty() && !row.lists.empty()) {
            const Entry index{.name = list.row, .unit = "1", .meaning = "index of the " + list.row, .value = 0.0};
            columns.push_back({index, list.row, depth, {counters[list.row]}});
            counters[list.row] += 1.0;
        }
        add_columns(row, "", depth, columns);
        if (row.lists.empty()) {
            Flattened& table = found[list.name];
            table.path = path;
            if (table.rows++ == 0) table.columns = columns;  // the same in every row
            else
                for (std::size_t c = 0; c < columns.size(); ++c)
                    table.columns[c].values.push_back(columns[c].values.front());
        }
        for (const List& inner : row.lists)
            if (inner.shown.archive) flatten(inner, path, columns, counters, found);
    }
}

void add_array(const std::string& name, const Entry& entry, std::vector<std::string> axes, std::vector<double> values,
               files::ResultTable& table) {
    table.quantities.push_back({name, unit_of(entry), stored_meaning(entry), std::move(axes)});
    table.values.push_back(std::move(values));
}

/// Arrays over the index of the row.
void add_long_table(const Flattened& flat, files::ResultTable& table) {
    const List& inner = *flat.path.back();
    std::vector<double> index(flat.rows);
    std::iota(index.begin(), index.end(), 0.0);
    table.axes.push_back({inner.row, "1", inner.meaning, index});
    for (const Column& column : flat.columns)
        add_array(inner.prefix + column.name, column.entry, {inner.row}, column.values, table);
}

bool is_coordinate(const Column& column, const Flattened& flat) {
    return column.entry.name == flat.path[column.depth]->coordinate;
}

/// Arrays over the coordinates of all lists, which must be the same in every row of the list around them.
void add_grid(const Flattened& flat, files::ResultTable& table) {
    const std::vector<std::size_t> sizes = mapped(flat.path, [](const List* one) { return one->rows.size(); });
    std::vector<std::size_t> strides(sizes.size(), 1);
    for (std::size_t depth = sizes.size() - 1; depth-- > 0;) strides[depth] = strides[depth + 1] * sizes[depth + 1];
    std::vector<std::string> axes;
    for (const Column& column : flat.columns)
        if (is_coordinate(column, flat)) {
            std::vector<double> values;
            for (std::size_t i = 0; i < sizes[column.depth]; ++i)
                values.push_back(column.values[i * strides[column.depth]]);
            axes.push_back(column.name);
            table.axes.push_back({column.name, unit_of(column.entry), column.entry.meaning, values});
        }
    for (const Column& column : flat.columns) {
        if (is_coordinate(column, flat)) continue;
        std::vector<double> values;
        for (std::size_t i = 0; i < flat.rows; i += strides[column.depth]) values.push_back(column.values[i]);
        const auto last = axes.begin() + static_cast<std::ptrdiff_t>(column.depth) + 1;
        add_array(flat.path.back()->prefix + column.name, column.entry, {axes.begin(), last}, std::move(values), table);
    }
}

using Tables = std::map<std::string, files::ResultTable>;

void add_list(const List& list, const std::string& group, Tables& tables);

void add_record(const Record& record, const std::string& around, Tables& tables) {
    const std::string group = record.group.empty() ? around : record.group;
    std::vector<Column> columns;
    add_columns(record, "", 0, columns);
    if (!group.empty()) {
        files::ResultTable& table = tables[group];
        for (const Column& column : columns) add_array(column.name, column.entry, {}, column.values, table);
        std::ranges::copy(record.maps.axes, std::back_inserter(table.axes));
        std::ranges::copy(record.maps.quantities, std::back_inserter(table.quantities));
        std::ranges::copy(record.maps.values, std::back_inserter(table.values));
    }
    for (const auto& [name, part] : record.parts)
        if (!part.group.empty()) add_record(part, group, tables);
    for (const List& list : record.lists) add_list(list, group, tables);
}

void add_list(const List& list, const std::string& group, Tables& tables) {
    if (!list.shown.archive) return;
    const bool has_groups = std::ranges::any_of(list.rows, [](const Record& row) { return !row.group.empty(); });
    if (has_groups) {
        for (const Record& row : list.rows) add_record(row, group, tables);
        return;
    }
    Counters counters;
    std::map<std::string, Flattened> found;
    flatten(list, {}, {}, counters, found);
    for (const auto& [name, flat] : found) {
        const bool is_grid = std::ranges::all_of(flat.path, [](const List* one) { return !one->coordinate.empty(); });
        const std::string own = flat.path.back()->group;
        files::ResultTable& table = tables[own.empty() ? group : own];
        if (is_grid) add_grid(flat, table);
        else add_long_table(flat, table);
    }
}

void rename(Record& record, const io::Units& units) {
    io::rename_units(record.entries, units);
    for (auto& [name, part] : record.parts) rename(part, units);
    for (List& list : record.lists)
        for (Record& row : list.rows) rename(row, units);
    io::rename_units(record.maps.axes, units);
    io::rename_units(record.maps.quantities, units);
}

void add_attributes(const Record& record, const std::string& before, std::vector<files::Attribute>& attributes) {
    for (const Entry& entry : record.entries) {
        const std::string name = name_in(before, entry.dataset.value_or(entry.name));
        if (const auto* words = std::get_if<std::string>(&entry.value)) {
            if (!words->empty()) attributes.emplace_back(name, *words);
        } else if (is_stored(entry) && !std::holds_alternative<std::vector<double>>(entry.value)) {
            if (const double value = stored_value(entry); std::isfinite(value)) attributes.emplace_back(name, value);
        }
    }
    for (const auto& [name, part] : record.parts)
        if (part.group.empty()) add_attributes(part, name_in(before, name), attributes);
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
        const bool is_of_one_unit =
            std::ranges::all_of(rows, [&](const auto& row) { return row[column].unit == first.unit; });
        const auto unit = [&](const Entry& entry, const char* format) {
            return entry.unit.empty() || entry.unit == "1" ? std::string() : text(format, entry.unit);
        };
        std::vector<std::string> cells{words_of(first.name) + (is_of_one_unit ? unit(first, " [{}]") : "")};
        for (const auto& row : rows)
            cells.push_back(value_text(row[column]) +
                            (is_of_one_unit || !is_printed(row[column]) ? "" : unit(row[column], " {}")));
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

double stored_value(const Entry& entry) {
    if (const auto* number = std::get_if<double>(&entry.value)) return *number;
    if (const auto* count = std::get_if<std::int64_t>(&entry.value)) return static_cast<double>(*count);
    if (const auto* flag = std::get_if<bool>(&entry.value)) return *flag ? 1.0 : 0.0;
    const auto& words = std::get<std::string>(entry.value);
    return static_cast<double>(std::ranges::find(entry.choices, words) - entry.choices.begin());
}

std::string stored_meaning(const Entry& entry) {
    std::string codes;
    for (std::size_t i = 0; i < entry.choices.size(); ++i)
        codes += text("{}{} {}", i > 0 ? ", " : "", i, entry.choices[i]);
    if (codes.empty()) return entry.meaning;
    return entry.meaning + ": " + codes;
}

Result with_units(Result result, const io::Units& units) {
    rename(result.root, units);
    if (result.frames) {
        io::rename_units(result.frames->recording.axes, units);
        io::rename_units(result.frames->recording.quantities, units);
    }
    return result;
}

std::vector<files::ResultTable> result_tables(const Result& result) {
    Tables tables;
    add_record(result.root, "", tables);
    std::vector<files::ResultTable> list;
    for (auto& [group, table] : tables) {
        table.group = group;
        list.push_back(std::move(table));
    }
    return list;
}

std::vector<files::Attribute> result_attributes(const Result& result) {
    std::vector<files::Attribute> attributes = result.attributes;
    if (result.root.group.empty()) add_attributes(result.root, "", attributes);
    return attributes;
}

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
