// run/result.hpp: a result as named values, lists and maps, from which text, JSON and archive all follow.
#pragma once
#include <concepts>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drover/base/schema.hpp"
#include "files/archive.hpp"
#include "io/units.hpp"

namespace drover::run {

/// A number, a flag, text, the components of a vector, or several texts.
using EntryValue = Variant<double, std::int64_t, bool, std::string, std::vector<double>, std::vector<std::string>>;

/// Where an entry or a row appears.  JSON has all of them.
struct Display {
    bool text = true;
    bool archive = true;
};

/// One named value.
struct Entry {
    std::string name;     ///< key in JSON; name in an archive and, with spaces for underscores, in text
    std::string unit;     ///< UDUNITS text; "1" for a pure number, "" for words
    std::string meaning;  ///< with its formula
    EntryValue value;
    std::vector<std::string> choices = {};              ///< all values of a text: an archive stores its index
    std::optional<std::string> dataset = std::nullopt;  ///< name in an archive, where it is not `name`
    int digits = 6;                                     ///< significant digits in text
    double rounding = 0.0;                              ///< text shows 0 for a number no larger than this
    Display shown = {};
};

inline Entry number(std::string name, std::string unit, std::string meaning, double value, int digits = 6) {
    return {.name = std::move(name),
            .unit = std::move(unit),
            .meaning = std::move(meaning),
            .value = value,
            .digits = digits};
}
inline Entry count(std::string name, std::string meaning, std::integral auto value) {
    return {.name = std::move(name),
            .unit = "1",
            .meaning = std::move(meaning),
            .value = static_cast<std::int64_t>(value)};
}
inline Entry flag(std::string name, std::string meaning, bool value) {
    return {.name = std::move(name), .unit = "1", .meaning = std::move(meaning), .value = value};
}
/// A text, or several.
inline Entry words(std::string name, std::string meaning, EntryValue value) {
    return {.name = std::move(name), .unit = "", .meaning = std::move(meaning), .value = std::move(value)};
}
/// A text that is one of `choices`.
inline Entry choice(std::string name, std::string meaning, std::string value, std::vector<std::string> choices) {
    return {.name = std::move(name),
            .unit = "",
            .meaning = std::move(meaning),
            .value = std::move(value),
            .choices = std::move(choices)};
}

inline Entry shown_as(Entry entry, Display shown) {
    entry.shown = shown;
    return entry;
}
/// Not in text.
inline Entry data_only(Entry entry) { return shown_as(std::move(entry), {.text = false}); }
/// Neither in text nor in an archive.
inline Entry json_only(Entry entry) { return shown_as(std::move(entry), {.text = false, .archive = false}); }
inline Entry stored_as(std::string dataset, Entry entry) {
    entry.dataset = std::move(dataset);
    return entry;
}

/// The number by which an archive stores a value that is neither a vector nor several texts: of a text its index among
/// the choices.
double stored_value(const Entry& entry);
/// The meaning of that number: with the choices.
std::string stored_meaning(const Entry& entry);

struct List;

/// An object of JSON.  In an archive its entries are datasets of `group`, those of a part with the part's name before
/// them.
struct Record {
    std::string heading = {};              ///< of text
    std::vector<std::string> header = {};  ///< lines of text alone, before the entries
    /// Of an archive, "/ordered"; "": that of the record or list around it, none for the root.
    std::string group = {};
    std::vector<Entry> entries = {};
    std::vector<std::pair<std::string, Record>> parts = {};  ///< named records within
    std::vector<List> lists = {};
    files::ResultTable maps = {};          ///< arrays over several axes: in archives alone
    std::vector<std::string> footer = {};  ///< lines of text alone, after everything else
    Display shown = {};
};

/// An array of objects in JSON; a table in text.  In an archive every innermost list gives arrays over its rows, in
/// which the entries of the lists around it are repeated; where all these lists have a coordinate, the arrays are over
/// the coordinates instead.
struct List {
    std::string name = {};     ///< key in JSON
    std::string heading = {};  ///< of text
    /// In an archive: the axis of an innermost list without a coordinate, "vertex"; of a list around others the dataset
    /// that holds the index of its row, "" for none.
    std::string row = {};
    std::string meaning = {};     ///< of that axis
    std::string prefix = {};      ///< of the datasets of an innermost list
    std::string group = {};       ///< of an innermost list in an archive; "": that of the record around the lists
    std::string coordinate = {};  ///< entry that is an axis of archives
    std::vector<Record> rows = {};
    std::string empty = {};      ///< text in place of a table without rows
    std::size_t max_rows = 200;  ///< of text: an evenly spaced selection of a longer list
    /// Of text: whether numbers far below the largest of their column are its rounding errors, shown as 0.  False where
    /// rows are different quantities.
    bool has_like_rows = true;
    Display shown = {};
};

/// Fields in the layout of a run.
struct Frames {
    files::Recording recording;
    std::vector<std::vector<std::vector<double>>> rows;  ///< of each frame, the array of each quantity
};

struct Result {
    Record root;
    std::vector<files::Attribute> attributes = {};  ///< of the archive, beside its provenance
    std::optional<Frames> frames = std::nullopt;    ///< of the archive alone; their times are 0, 1, 2, ...
};

/// With the names of units that a scene gives them.
Result with_units(Result result, const io::Units& units);

/// For people.
std::string result_text(const Result& result);

/// Numbers that are not finite become null.
nlohmann::json result_json(const Result& result);

/// A number, or null when it is not finite.
nlohmann::json number_json(double value);

/// One table for each group.
std::vector<files::ResultTable> result_tables(const Result& result);

/// Root attributes: `attributes`, and the entries of a root without group, with those of its parts.
std::vector<files::Attribute> result_attributes(const Result& result);

}  // namespace drover::run
