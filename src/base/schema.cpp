// base/schema.cpp: values of a scene: as text, and checked against their descriptions.
#include "drover/base/schema.hpp"

#include <cmath>

#include "base/mapped.hpp"

namespace drover {

namespace {
template <class... Cases>
struct Match : Cases... {
    using Cases::operator()...;
};

std::string number_text(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value < 0 ? "-inf" : "inf";
    std::string result = text("{}", value);
    if (result.find_first_of(".e") == std::string::npos) result += ".0";
    return result;
}

/// TOML is UTF-8: other bytes, as in the name of a file, become \xff in the text.
std::string quoted(const std::string& word) {
    std::string result = "\"";
    for (std::size_t at = 0; at < word.size();) {
        const char letter = word[at];
        const std::size_t size = utf8_bytes(std::string_view(word).substr(at));
        if (letter == '"' || letter == '\\') result += '\\';
        if (letter == '\n') result += "\\n";
        else if (letter == '\t') result += "\\t";
        else if (size == 0) result += text("\\\\x{:02x}", static_cast<unsigned char>(letter));
        else if (size == 1 && (letter < 0x20 || letter == 0x7f)) result += text("\\u{:04x}", static_cast<int>(letter));
        else if (printable(word.substr(at, size)).size() > size)  // U+0080 to U+009F
            result += text("\\u{:04x}", static_cast<unsigned char>(word[at + 1]));
        else result += word.substr(at, size);
        at += std::max<std::size_t>(1, size);
    }
    return result + '"';
}

template <class Items, class Write>
std::string list_text(const Items& items, Write write) {
    return "[" + joined(mapped(items, write)) + "]";
}

std::string expected_text(const Description& row) {
    if (!row.choices.empty())
        return list_text(row.choices, quoted)
            .insert(0, row.default_value.index() == Value(std::string()).index() ? "one of " : "words of ");
    std::string result = type_text(row.default_value);
    const bool has_min = std::isfinite(row.range.min), has_max = std::isfinite(row.range.max);
    if (has_min) result += text(" {} {}", row.range.min_open ? ">" : ">=", row.range.min);
    if (has_max) result += text("{} <= {}", has_min ? " and" : "", row.range.max);
    if (!row.unit.empty()) result += text(" [{}]", row.unit);
    return result;
}

bool in_range(const Range& range, double value) {
    return std::isfinite(value) && (range.min_open ? value > range.min : value >= range.min) && value <= range.max;
}

/// The value converted to the type of the default, if that is lossless.
Value converted(const Value& value, const Value& default_value) {
    if (std::holds_alternative<double>(default_value))
        if (const auto* whole = std::get_if<std::int64_t>(&value)) return static_cast<double>(*whole);
    // An empty list has no item type.
    if (const auto* list = std::get_if<std::vector<double>>(&value); list && list->empty())
        if (std::holds_alternative<std::vector<std::string>>(default_value)) return std::vector<std::string>{};
    return value;
}
}  // namespace

std::string type_text(const Value& value) {
    return std::visit(Match{[](bool) { return "true or false"; }, [](std::int64_t) { return "an integer"; },
                            [](double) { return "a number"; }, [](const std::string&) { return "a text in quotes"; },
                            [](const std::vector<double>&) { return "a list of numbers"; },
                            [](const std::vector<std::string>&) { return "a list of texts"; }},
                      value);
}

std::string toml_text(const Value& value) {
    return std::visit(Match{[](bool held) -> std::string { return held ? "true" : "false"; },
                            [](std::int64_t held) { return text("{}", held); },
                            [](double held) { return number_text(held); },
                            [](const std::string& held) { return quoted(held); },
                            [](const std::vector<double>& held) { return list_text(held, number_text); },
                            [](const std::vector<std::string>& held) { return list_text(held, quoted); }},
                      value);
}

Value checked_value(const Description& row, const std::string& section, const LocatedValue& found) {
    const std::string key = section + "." + row.name;
    const Value value = converted(found.value, row.default_value);
    const auto reject = [&] {
        fail_input(found.where, "{} = {}; expected {}: {}", key, toml_text(found.value), expected_text(row), row.doc);
    };
    if (value.index() != row.default_value.index()) reject();
    const auto check_number = [&](double number) {
        if (!in_range(row.range, number)) reject();
    };
    const auto check_word = [&](const std::string& word) {
        if (row.choices.empty() || std::ranges::find(row.choices, word) != row.choices.end()) return;
        fail_input(found.where, "{} = {}; expected {}{}", key, toml_text(value), expected_text(row),
                   suggestion(word, row.choices, "", "; did you mean \"{}\"?"));
    };
    std::visit(Match{[](bool) {}, [&](std::int64_t held) { check_number(static_cast<double>(held)); }, check_number,
                     check_word, [&](const std::vector<double>& held) { std::ranges::for_each(held, check_number); },
                     [&](const std::vector<std::string>& held) { std::ranges::for_each(held, check_word); }},
               value);
    return value;
}

void reject_unknown_keys(const LocatedTable& table, const std::string& section, const std::vector<Description>& rows) {
    const std::vector<std::string> names = mapped(rows, &Description::name);
    for (const auto& [key, value] : table.values) {
        if (std::ranges::find(names, key) != names.end()) continue;
        fail_input(value.where, "unknown key {}.{}; {}", section, key,
                   suggestion(key, names, text("expected one of {}", joined(names)),
                              text("did you mean {}.{{}}?", section)));
    }
}

}  // namespace drover
