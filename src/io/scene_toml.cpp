// io/scene_toml.cpp: TOML text as the tables of a scene, and settings of its keys.
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

#include "base/mapped.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"

namespace drover::io {

namespace {
SourceLocation where_of(const toml::source_region& source, const std::string& file) {
    return {.file = file, .line = static_cast<int>(source.begin.line), .column = static_cast<int>(source.begin.column)};
}

Value list_value(const toml::array& array, const std::string& key, const SourceLocation& where) {
    std::vector<double> numbers;
    std::vector<std::string> texts;
    for (const toml::node& item : array) {
        if (const auto number = item.value<double>(); number && item.is_number()) numbers.push_back(*number);
        else if (const auto word = item.value<std::string>()) texts.push_back(*word);
        else fail_input(where, "{} is a list with other items than numbers or texts; expected a list of either", key);
    }
    require(numbers.empty() || texts.empty(), where, "{} is a list of numbers and texts; expected one type", key);
    if (!texts.empty()) return texts;
    return numbers;
}

Value value_of(const toml::node& node, const std::string& key, const SourceLocation& where) {
    if (const auto* held = node.as_boolean()) return held->get();
    if (const auto* held = node.as_integer()) return std::int64_t{held->get()};
    if (const auto* held = node.as_floating_point()) return held->get();
    if (const auto* held = node.as_string()) return held->get();
    if (const auto* held = node.as_array()) return list_value(*held, key, where);
    fail_input(where, "{} is a table or a date; expected a number, a text, true or false, or a list", key);
}

/// toml++ recurses into dotted keys without a limit.  Counts dots outside texts and comments; a number has one.
void check_nesting(const std::string& toml, const SourceLocation& where) {
    constexpr int max_dots = 32;
    int dots = 0, line = 1;
    for (std::size_t at = 0; at < toml.size(); ++at) {
        const char letter = toml[at];
        if (letter == '\n') ++line;
        if (letter == '#') at = std::min(toml.find('\n', at), toml.size()) - 1;
        if (letter == '"' || letter == '\'') {
            const std::string three(3, letter);
            const bool is_long = toml.compare(at, 3, three) == 0;
            std::size_t end = at + (is_long ? 3 : 1);
            while (end < toml.size() && (is_long ? toml.compare(end, 3, three) != 0 : toml[end] != letter)) {
                if (letter == '"' && toml[end] == '\\') ++end;
                if (end < toml.size() && toml[end] == '\n') ++line;
                ++end;
            }
            at = end + (is_long ? 2 : 0);
        }
        if (letter == '.') ++dots;
        else if (std::string_view("=,[]{}\n").find(letter) != std::string_view::npos) dots = 0;
        require(dots <= max_dots, {.file = where.file, .line = where.line == 0 ? line : where.line},
                "a key of more than {} parts; expected keys such as relaxation.rate", max_dots);
    }
}

/// What is expected at a place that is not TOML: a value behind the "=" of its line, or else a line.
const char* expected_at(const std::string& toml, const toml::source_position& place) {
    std::istringstream lines(toml);
    std::string line;
    for (toml::source_index number = 0; number < place.line && std::getline(lines, line);) ++number;
    const std::size_t equals = line.find('=');
    return equals != std::string::npos && equals + 1 < place.column
               ? "a number such as 0.6, a text in quotes, true or false, or a list in brackets, alone on its line"
               : "lines such as [grid] and nx = 256";
}

toml::table parsed(const std::string& text, const std::string& name) {
    constexpr std::size_t max_bytes = std::size_t{4} << 20;  // of a resolved scene; a scene file has less
    require(text.size() <= max_bytes, {.file = name}, "a scene of {}; expected at most {}",
            bytes_text(static_cast<double>(text.size())), bytes_text(static_cast<double>(max_bytes)));
    check_nesting(text, {.file = name});
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& error) {
        fail_input(where_of(error.source(), name), "not TOML: {}; expected {}", std::string(error.description()),
                   expected_at(text, error.source().begin));
    }
}

/// Where the texts of a value begin, behind their quotes.
std::vector<SourceLocation> items_of(const toml::node& node, const std::string& file) {
    std::vector<SourceLocation> items;
    const auto add = [&](const toml::node& one) {
        items.push_back(where_of(one.source(), file));
        if (one.is_string()) ++items.back().column;
    };
    if (const auto* list = node.as_array())
        for (const toml::node& one : *list) add(one);
    else add(node);
    return items;
}

/// The keys of one section.  A table inside [calibrate] is the section calibrate.<name>.
void add_table(const std::string& section, const toml::table& table, const SourceLocation& where,
               const std::string& file, LocatedTables& tables) {
    LocatedTable located{.where = where, .values = {}};
    for (const auto& [key, value] : table) {
        const SourceLocation location = where_of(key.source(), file);
        const std::string name = section + "." + std::string(key.str());
        if (section.starts_with("terms[") && key.str() == "parameters") continue;  // a section of their own
        if (const toml::table* inner = value.as_table(); inner != nullptr && section == "calibrate")
            add_table(name, *inner, location, file, tables);
        else
            located.values.emplace(std::string(key.str()),
                                   LocatedValue{value_of(value, name, location), location, items_of(value, file)});
    }
    tables.emplace(section, std::move(located));
}

/// Calls read(table, section, where) for each table of a list: [[field]] number n is the section field[n].
template <class Read>
void for_items(const std::string& list, const toml::array& items, const std::string& file, Read read) {
    std::size_t number = 0;
    for (const toml::node& node : items) {
        const toml::table* item = node.as_table();
        const SourceLocation where = where_of(node.source(), file);
        require(item != nullptr, where, "{} is not a list of tables; expected [[{}]]", list, list);
        read(*item, text("{}[{}]", list, ++number), where);
    }
}

/// [[terms]] number n is the section terms[n]; the numbers in its parameters are keys of the section terms.
void add_terms(const toml::array& terms, const std::string& file, LocatedTables& tables) {
    LocatedTable parameters{.where = where_of(terms.source(), file), .values = {}};
    for_items("terms", terms, file, [&](const toml::table& term, const std::string& section, const auto& term_where) {
        std::vector<std::string> names;
        for (const auto& [key, value] : term) {
            if (key.str() != "parameters") continue;
            const toml::table* numbers = value.as_table();
            require(numbers != nullptr, where_of(key.source(), file),
                    "terms.parameters is not a table; expected numbers by name, such as {{ W = 0.7 }}");
            for (const auto& [name, held] : *numbers) {
                const SourceLocation where = where_of(name.source(), file);
                names.emplace_back(name.str());
                require(!parameters.values.contains(names.back()), where,
                        "the parameter {} is given twice; expected each once, for all terms", names.back());
                parameters.values.emplace(names.back(),
                                          LocatedValue{value_of(held, "terms." + names.back(), where), where});
            }
        }
        add_table(section, term, term_where, file, tables);
        if (!names.empty()) tables.at(section).values.emplace(parameter_names, LocatedValue{names, {}});
    });
    if (!parameters.values.empty()) tables.emplace("terms", std::move(parameters));
}

/// "section.key=value", without blanks around its parts.
struct Setting {
    SourceLocation where;
    std::string section, key, written;
    std::string name() const { return section + "." + key; }
};

Setting read_setting(const std::string& setting) {
    const SourceLocation where{.file = "--set " + setting};
    const std::size_t equals = setting.find('='), dot = setting.rfind('.', equals);
    require(equals != std::string::npos && dot != std::string::npos && dot > 0 && dot + 1 < equals, where,
            "expected section.key=value, such as grid.nx=128");
    return {.where = where,
            .section = trimmed(setting.substr(0, dot)),
            .key = trimmed(setting.substr(dot + 1, equals - dot - 1)),
            .written = trimmed(setting.substr(equals + 1))};
}

/// A misspelt coefficient or field of a declared model would be one more, which no equation names.
void require_declared(const Setting& setting, const LocatedTables& tables) {
    if (setting.section != "coefficients" && !is_in_declared_list(setting.section)) return;
    const auto table = tables.find(setting.section);
    require(table != tables.end(), setting.where, "the scene has no [{}]; expected one of its own sections",
            setting.section);
    if (setting.section != "coefficients" || table->second.values.contains(setting.key)) return;
    const std::vector<std::string> names = mapped(table->second.values, [](const auto& one) { return one.first; });
    require(!names.empty(), setting.where, "the scene has no coefficient {}, nor any other; add it to [coefficients]",
            setting.key);
    fail_input(setting.where, "the scene has no coefficient {}; {}", setting.key,
               suggestion(setting.key, names, text("expected one of {}", joined(names))));
}

/// Sets the value, read as TOML if it is valid TOML, else as a text.
void apply_setting(const Setting& setting, LocatedTables& tables) {
    const auto& [where, section, key, written] = setting;
    Value value = written;
    check_nesting(written, where);
    try {
        const toml::table table = toml::parse("value = " + written);
        require(table.size() == 1, where, "more than one key; expected section.key=value: use one --set for each");
        value = value_of(*table.get("value"), setting.name(), where);
    } catch (const toml::parse_error&) {
        // A bare word: a text.
    }
    require_declared(setting, tables);
    LocatedTable& table = tables.try_emplace(section, LocatedTable{.where = where, .values = {}}).first->second;
    table.values.insert_or_assign(key, LocatedValue{std::move(value), where});
}

/// Whether a setting changes which numbers the calibrated table has to provide.
bool invalidates_filled(const Setting& setting) {
    return setting.section == "calibrated" || setting.section == "fields" || setting.name() == "current.kind" ||
           setting.name() == "weathercock.convention";
}

/// Removes the numbers that the table filled in earlier, so that they are filled in for another state.
void remove_filled(LocatedTables& tables) {
    for (const calibrate::FilledNumber& one : found_in(tables).filled) {
        const std::size_t dot = one.key.find('.');  // no dot in "table", which is filled as one
        const auto table = tables.find(one.key.substr(0, dot));
        if (table == tables.end()) continue;
        if (dot == std::string::npos) tables.erase(table);
        else table->second.values.erase(one.key.substr(dot + 1));
    }
    if (const auto table = tables.find("calibrated"); table != tables.end())
        for (const char* own : {"filled", "expected"}) table->second.values.erase(own);
}
}  // namespace

LocatedTables read_tables(const std::string& toml, const std::string& file) {
    const toml::table root = parsed(toml, file);
    LocatedTables tables;
    for (const auto& [name, node] : root) {
        const std::string section(name.str());
        const SourceLocation where = where_of(name.source(), file);
        if (const toml::array* items = node.as_array(); items != nullptr && is_in_declared_list(section + "[")) {
            for_items(section, *items, file, [&](const auto& item, const auto& item_section, const auto& item_where) {
                add_table(item_section, item, item_where, file, tables);
            });
            continue;
        }
        if (const toml::array* terms = node.as_array(); terms != nullptr && section == "terms") {
            add_terms(*terms, file, tables);
            continue;
        }
        require(
            !node.is_array_of_tables(), where,
            "[[{}]] is not known; expected [[field]], [[white_noise]], [[tabulated]] or [[terms]]; the equation of a "
            "field is a text of its own, such as phi = \"lap phi\", below [equations]",
            section);
        const toml::table* table = node.as_table();
        require(table != nullptr, where, "{} is outside a table; expected it below a line such as [grid]", section);
        add_table(section, *table, where, file, tables);
    }
    return tables;
}

Scene scene_of(LocatedTables tables, const std::string& name, std::span<const std::string> overrides) {
    const std::vector<Setting> settings = mapped(overrides, read_setting);
    if (std::ranges::any_of(settings, invalidates_filled)) remove_filled(tables);
    for (const Setting& setting : settings) apply_setting(setting, tables);
    Scene scene = scene_of(tables, name);
    std::erase_if(scene.found.filled, [&](const calibrate::FilledNumber& one) {
        return std::ranges::find(settings, one.key, &Setting::name) != settings.end();
    });
    return scene;
}

}  // namespace drover::io
