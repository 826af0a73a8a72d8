// base/schema.hpp: what a scene may say: each key with its type, unit, range, default and documentation, beside the struct
// that it fills.
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

/// A value as it stands in a scene.
using Value = std::variant<bool, std::int64_t, double, std::string, std::vector<double>, std::vector<std::string>>;

/// "true or false", "an integer", "a number", ... : the type for people.
std::string type_text(const Value& value);

/// The value as TOML writes it, such that it reads back as the same value.
std::string toml_text(const Value& value);

struct LocatedValue {
    Value value;
    SourceLocation where;  ///< of the key
};

/// One table of a scene text: its keys in the order of their names.
struct LocatedTable {
    SourceLocation where;
    std::map<std::string, LocatedValue> values;
};

/// The numbers that are allowed: the ends belong to it unless open.
struct Range {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    bool min_open = false;
};
inline constexpr Range any_number{};
inline constexpr Range positive{.min = 0.0, .min_open = true};
inline constexpr Range not_negative{.min = 0.0};

template <class Struct>
using Member = std::variant<bool Struct::*, int Struct::*, std::int64_t Struct::*, double Struct::*,
                            std::string Struct::*, std::vector<double> Struct::*, std::vector<std::string> Struct::*>;

/// One key.  Its default is what a default-constructed Struct holds.
template <class Struct>
struct Row {
    std::string name = {};
    Member<Struct> member = {};
    std::string unit = {};                  ///< "" for a pure number or a word
    Range range = any_number;               ///< of a number, or of each number of a list
    std::vector<std::string> choices = {};  ///< of a word; empty: any
    std::string doc = {};                   ///< what it means, with its symbol and source
};

/// A row without its struct: for lists, for help, for reading a value.
struct Description {
    std::string name;
    Value default_value;
    std::string unit;
    Range range;
    std::vector<std::string> choices;
    std::string doc;
};

/// Rows of a struct give: template<> const std::vector<Row<T>>& schema<T>();
template <class Struct>
const std::vector<Row<Struct>>& schema();

/// The value found, as the type and in the range and choices the description asks; an integer serves as a number.
/// Throws an input Error that names section.key, what was found and what was expected.
Value checked_value(const Description& row, const std::string& section, const LocatedValue& found);

/// Throws an input Error, with "did you mean", at the first key of the table that no row knows.
void reject_unknown_keys(const LocatedTable& table, const std::string& section, const std::vector<Description>& rows);

namespace schema_detail {
template <class Struct>
Value get(const Struct& from, const Row<Struct>& row) {
    return std::visit(
        [&](auto member) -> Value {
            using Held = std::remove_cvref_t<decltype(from.*member)>;
            if constexpr (std::is_same_v<Held, int>) return static_cast<std::int64_t>(from.*member);
            else return from.*member;
        },
        row.member);
}

template <class Struct>
void set(Struct& to, const Row<Struct>& row, const Value& value) {
    std::visit(
        [&](auto member) {
            using Held = std::remove_cvref_t<decltype(to.*member)>;
            if constexpr (std::is_same_v<Held, int>) to.*member = static_cast<int>(std::get<std::int64_t>(value));
            else to.*member = std::get<Held>(value);
        },
        row.member);
}
}  // namespace schema_detail

template <class Struct>
std::vector<Description> descriptions() {
    std::vector<Description> result;
    const Struct standard{};
    for (const Row<Struct>& row : schema<Struct>()) {
        Range range = row.range;
        if (std::holds_alternative<int Struct::*>(row.member)) {
            range.min = std::max(range.min, static_cast<double>(std::numeric_limits<int>::min()));
            range.max = std::min(range.max, static_cast<double>(std::numeric_limits<int>::max()));
        }
        result.push_back({row.name, schema_detail::get(standard, row), row.unit, range, row.choices, row.doc});
    }
    return result;
}

/// Fills `into` from one table of a scene.  Keys that are absent keep what `into` holds.
template <class Struct>
void read_table(const LocatedTable& table, const std::string& section, Struct& into) {
    const std::vector<Description> rows = descriptions<Struct>();
    reject_unknown_keys(table, section, rows);
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (const auto found = table.values.find(rows[i].name); found != table.values.end())
            schema_detail::set(into, schema<Struct>()[i], checked_value(rows[i], section, found->second));
}

/// The keys of a struct with the values it holds, in the order of its rows.
template <class Struct>
std::vector<std::pair<std::string, Value>> values_of(const Struct& from) {
    std::vector<std::pair<std::string, Value>> result;
    for (const Row<Struct>& row : schema<Struct>()) result.emplace_back(row.name, schema_detail::get(from, row));
    return result;
}

}  // namespace drover
