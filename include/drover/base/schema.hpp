// base/schema.hpp: the keys of a scene: type, unit, range, default and documentation, defined beside the struct that
// they fill.
#pragma once
#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

/// A std::variant that is copied by assignment: libstdc++ 12 assumes that a variant of numbers, texts and vectors is
/// never valueless, so if its copy constructor runs out of memory it destroys a value that was never constructed.
template <class... Types>
struct Variant : std::variant<Types...> {
    using std::variant<Types...>::variant;
    Variant() = default;
    Variant(const Variant& other) : std::variant<Types...>() { std::variant<Types...>::operator=(other); }
    Variant(Variant&&) noexcept = default;
    Variant& operator=(const Variant&) = default;
    Variant& operator=(Variant&&) noexcept = default;
    ~Variant() = default;
};

/// A value of a scene.
using Value = Variant<bool, std::int64_t, double, std::string, std::vector<double>, std::vector<std::string>>;

/// The type in words: "true or false", "an integer", "a number", ...
std::string type_text(const Value& value);

/// The value as TOML, which reads back as the same value.
std::string toml_text(const Value& value);

struct LocatedValue {
    Value value;
    SourceLocation where;                    ///< of the key
    std::vector<SourceLocation> items = {};  ///< of the first character of each text in the value
};

/// One table of a scene text: its keys, sorted by name.
struct LocatedTable {
    SourceLocation where;
    std::map<std::string, LocatedValue> values;
};

/// The tables of a scene text by name: "grid", "calibrate.drag".
using LocatedTables = std::map<std::string, LocatedTable>;

/// The allowed numbers: a closed interval, or open at its lower end.
struct Range {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_open = false;
};
inline constexpr Range any_number{};
inline constexpr Range positive{.min = 0.0, .min_open = true};
inline constexpr Range not_negative{.min = 0.0};
constexpr Range within(double min, double max) { return {.min = min, .max = max}; }
constexpr Range at_least(double min) { return {.min = min}; }

template <NamedEnum Enum>
std::vector<std::string> all_names() {
    const auto names = names_of(Enum{});
    return {names.begin(), names.end()};
}

/// The value of this name, if there is one.
template <NamedEnum Enum>
std::optional<Enum> value_named(std::string_view name) {
    const auto names = names_of(Enum{});
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? std::nullopt : std::optional(static_cast<Enum>(found - names.begin()));
}

/// A member that is an enum: a scene has its name.
template <class Struct>
struct NamedMember {
    template <NamedEnum Enum>
    NamedMember(Enum Struct::*member)
        : names(all_names<Enum>),
          get([member](const Struct& from) { return name_of(from.*member); }),
          set([member](Struct& to, const std::string& name) { to.*member = value_named<Enum>(name).value(); }) {}
    std::vector<std::string> (*names)();
    std::function<std::string(const Struct&)> get;
    std::function<void(Struct&, const std::string&)> set;
};

template <class Struct>
using Member =
    std::variant<bool Struct::*, int Struct::*, std::int64_t Struct::*, double Struct::*, std::string Struct::*,
                 std::vector<double> Struct::*, std::vector<std::string> Struct::*, NamedMember<Struct>>;

/// One key.  Its default is the value in a default-constructed Struct.
template <class Struct>
struct Row {
    std::string name;
    Member<Struct> member;
    std::string doc;                        ///< meaning, with its symbol and source
    std::string unit = {};                  ///< "" for a dimensionless number or a word
    Range range = any_number;               ///< of a number, or of each item of a list
    std::vector<std::string> choices = {};  ///< of a word; empty: any, or of an enum all names
};

template <class Struct>
using Rows = std::vector<Row<Struct>>;

/// A row without its struct: for listings, help, and reading a value.
struct Description {
    std::string name;
    Value default_value;
    std::string unit;
    Range range;
    std::vector<std::string> choices;
    std::string doc;
};

/// The rows of a struct, which makes them in a static function.
template <class Struct>
const Rows<Struct>& schema() {
    static const Rows<Struct> rows = Struct::rows();
    return rows;
}

/// The value found, converted to the type of the description (an integer is a valid number) and checked against its
/// range and choices.  Throws an input Error that names section.key, the value found and the value expected.
Value checked_value(const Description& row, const std::string& section, const LocatedValue& found);

/// Throws an input Error, with "did you mean", at the first key of the table without a row.
void reject_unknown_keys(const LocatedTable& table, const std::string& section, const std::vector<Description>& rows);

namespace schema_detail {
template <class Struct>
Value get(const Struct& from, const Row<Struct>& row) {
    return std::visit(
        [&](const auto& member) -> Value {
            if constexpr (requires { member.get(from); }) return member.get(from);
            else if constexpr (std::is_same_v<decltype(member), int Struct::*const&>)
                return static_cast<std::int64_t>(from.*member);
            else return from.*member;
        },
        row.member);
}

template <class Struct>
void set(Struct& to, const Row<Struct>& row, const Value& value) {
    std::visit(
        [&](const auto& member) {
            if constexpr (requires { member.names(); }) member.set(to, std::get<std::string>(value));
            else if constexpr (std::is_same_v<decltype(member), int Struct::*const&>)
                to.*member = static_cast<int>(std::get<std::int64_t>(value));
            else to.*member = std::get<std::remove_cvref_t<decltype(to.*member)>>(value);
        },
        row.member);
}
}  // namespace schema_detail

template <class Struct>
std::vector<Description> descriptions() {
    std::vector<Description> result;
    const Struct defaults{};
    for (const Row<Struct>& row : schema<Struct>()) {
        Range range = row.range;
        if (std::holds_alternative<int Struct::*>(row.member)) {
            range.min = std::max(range.min, static_cast<double>(std::numeric_limits<int>::min()));
            range.max = std::min(range.max, static_cast<double>(std::numeric_limits<int>::max()));
        }
        std::vector<std::string> choices = row.choices;
        if (const auto* named = std::get_if<NamedMember<Struct>>(&row.member); named && choices.empty())
            choices = named->names();
        result.push_back({row.name, schema_detail::get(defaults, row), row.unit, range, choices, row.doc});
    }
    return result;
}

/// Sets members of `into` from one table of a scene.  Absent keys leave members unchanged.
template <class Struct>
void read_table(const LocatedTable& table, const std::string& section, Struct& into) {
    const std::vector<Description> rows = descriptions<Struct>();
    reject_unknown_keys(table, section, rows);
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (const auto found = table.values.find(rows[i].name); found != table.values.end())
            schema_detail::set(into, schema<Struct>()[i], checked_value(rows[i], section, found->second));
}

/// The keys and values of a struct, in the order of its rows.
template <class Struct>
std::vector<std::pair<std::string, Value>> values_of(const Struct& from) {
    std::vector<std::pair<std::string, Value>> result;
    for (const Row<Struct>& row : schema<Struct>()) result.emplace_back(row.name, schema_detail::get(from, row));
    return result;
}

}  // namespace drover
