// io/calibration.cpp: reads and writes tables of coefficients in HDF5; a trial as bytes: its number, its results, the
// message of its failure, its time.
#include "io/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <sstream>

#include "base/mapped.hpp"
#include "files/bytes.hpp"
#include "io/scene.hpp"

namespace drover::io {

namespace {
constexpr const char* old_group = "/calibration";  // of tables that earlier versions wrote
constexpr const char *bead_axis = "bead_area_fraction", *rod_axis = "rod_area_fraction", *resample_axis = "resample";
constexpr double no_rank = -1.0;
constexpr const char *names_attribute = "coefficients", *varied_attribute = "varied", *remarks_attribute = "remarks";

std::string path_of(const files::ArchiveReader& archive, const std::string& name) {
    const std::string old = std::string(old_group) + "/";
    return (archive.has(old + bead_axis) ? old : "/") + name;
}

std::vector<std::string> axes_of(const calibrate::Table& table, bool by_rods) {
    std::vector<std::string> axes;
    if (!table.varied_key.empty()) axes.push_back(axis_of(table.varied_key));
    axes.emplace_back(bead_axis);
    if (by_rods) axes.emplace_back(rod_axis);
    return axes;
}

bool has_ranks(const calibrate::TableRow& row) {
    return std::ranges::any_of(row.entries, [](const calibrate::TableEntry& one) { return !one.ranks.empty(); });
}

void add_row(const calibrate::Table& table, const calibrate::TableRow& row, files::ResultTable& to) {
    std::vector<std::string> axes = axes_of(table, row.by_rods);
    to.quantities.push_back({row.name, row.unit, row.formula, axes});
    to.quantities.push_back({row.name + "_error", row.unit, "standard error of " + row.name, axes});
    to.quantities.push_back({row.name + "_trials", "1", "number of trials of " + row.name, axes, true});
    to.quantities.push_back({row.name + "_origin", "1",
                             "0 missing, 1 measured, 2 measured with a larger error than requested, 3 closure, 4 set",
                             axes, true});
    std::vector<double> values, errors, trials, origins;
    for (const calibrate::TableEntry& entry : row.entries) {
        values.push_back(entry.value);
        errors.push_back(entry.error);
        trials.push_back(entry.trials);
        origins.push_back(static_cast<double>(entry.origin));
    }
    for (std::vector<double>* one : {&values, &errors, &trials, &origins}) to.values.push_back(std::move(*one));
    if (!has_ranks(row)) return;
    axes.emplace_back(resample_axis);
    to.quantities.push_back({row.name + "_ranks", "1",
                             "order of " + row.name +
                                 " in resamples of the trials, the same ones for all numbers of "
                                 "an assay at a point; -1: not known",
                             axes, true});
    to.values.emplace_back();
    for (const calibrate::TableEntry& entry : row.entries)
        for (std::size_t k = 0; k < calibrate::resample_count; ++k)
            to.values.back().push_back(entry.ranks.empty() ? no_rank : entry.ranks[k]);
}

files::ResultTable results_of(const calibrate::Table& table) {
    files::ResultTable results{.group = "/", .axes = {}, .quantities = {}, .values = {}};
    if (!table.varied_key.empty())
        results.axes.push_back({axis_of(table.varied_key), unit_of(SceneKind::particles, table.varied_key),
                                table.varied_key, table.varied});
    results.axes.push_back({bead_axis, "1", "projected area of beads/area of the cell", table.bead_fractions});
    if (!table.rod_fractions.empty())
        results.axes.push_back({rod_axis, "1", "projected area of lying rods/area of the cell", table.rod_fractions});
    std::vector<double> resamples(calibrate::resample_count);
    std::iota(resamples.begin(), resamples.end(), 0.0);
    for (const calibrate::TableRow& row : table.rows) add_row(table, row, results);
    if (std::ranges::any_of(table.rows, has_ranks))
        results.axes.push_back({resample_axis, "1", "resample of the trials", resamples});
    return results;
}

files::Array read_dataset(const files::ArchiveReader& archive, const SourceLocation& where, const std::string& name) {
    const std::string path = path_of(archive, name);
    require(archive.has(path), where, "{} is missing; expected a complete table written by drover calibrate", path);
    return archive.read(path);
}

/// A dataset of this shape, flat.
std::vector<double> read_shaped(const files::ArchiveReader& archive, const SourceLocation& where,
                                const std::string& name, const std::vector<std::size_t>& shape) {
    files::Array array = read_dataset(archive, where, name);
    const auto sizes = [](const std::vector<std::size_t>& of) {
        return joined(mapped(of, [](std::size_t size) { return text("{}", size); }), " by ");
    };
    require(array.shape == shape, where, "{} has {} numbers; expected {}, the sizes of the axes",
            path_of(archive, name), sizes(array.shape), sizes(shape));
    return std::move(array.values);
}

std::vector<double> read_axis(const files::ArchiveReader& archive, const SourceLocation& where,
                              const std::string& name) {
    files::Array array = read_dataset(archive, where, name);
    require(array.shape.size() == 1 && !array.values.empty(), where, "{} is not a list; expected an axis with values",
            path_of(archive, name));
    return std::move(array.values);
}

calibrate::Origin origin_of(double stored, const std::string& name, const SourceLocation& where) {
    require(stored >= 0.0 && stored < calibrate::origin_count && stored == std::floor(stored), where,
            "{}_origin holds {}; expected 0 to {}", name, stored, calibrate::origin_count - 1);
    return static_cast<calibrate::Origin>(static_cast<int>(stored));
}

void read_row(const files::ArchiveReader& archive, const SourceLocation& where, const calibrate::Table& table,
              calibrate::TableRow& row) {
    require(archive.has(path_of(archive, row.name)), where, "{} is listed but missing; expected a complete table",
            path_of(archive, row.name));
    std::vector<std::size_t> shape;
    if (!table.varied_key.empty()) shape.push_back(table.varied.size());
    shape.push_back(table.bead_fractions.size());
    row.by_rods = archive.shape(path_of(archive, row.name)).size() > shape.size();
    if (row.by_rods) shape.push_back(table.rod_fractions.size());
    const auto read = [&](const char* part) { return read_shaped(archive, where, row.name + part, shape); };
    const std::vector<double> values = read(""), errors = read("_error"), trials = read("_trials"),
                              origins = read("_origin");
    constexpr double max_count = std::numeric_limits<int>::max();
    for (std::size_t i = 0; i < values.size(); ++i) {
        require(trials[i] >= 0.0 && trials[i] <= max_count, where, "{}_trials holds {}; expected 0 to {}", row.name,
                trials[i], max_count);
        row.entries.push_back({.value = values[i],
                               .error = errors[i],
                               .trials = static_cast<int>(trials[i]),
                               .origin = origin_of(origins[i], row.name, where)});
    }
    if (const std::string ranks = row.name + "_ranks"; archive.has(path_of(archive, ranks))) {
        shape.push_back(calibrate::resample_count);
        const std::vector<double> all = read_shaped(archive, where, ranks, shape);
        for (std::size_t i = 0; i < values.size(); ++i) {
            const auto first = all.begin() + static_cast<std::ptrdiff_t>(i * shape.back());
            if (*first == no_rank) continue;
            const auto last = first + static_cast<std::ptrdiff_t>(shape.back());
            for (auto rank = first; rank != last; ++rank)
                require(*rank >= 0.0 && *rank < static_cast<double>(calibrate::resample_count), where,
                        "{} holds {}; expected 0 to {}, or {} alone", ranks, *rank, calibrate::resample_count - 1,
                        no_rank);
            row.entries[i].ranks.assign(first, last);
        }
    }
    row.unit = archive.text_attribute(path_of(archive, row.name), "units");
    const bool is_old = !archive.has_attribute(path_of(archive, row.name), "comment");
    row.formula = archive.text_attribute(path_of(archive, row.name), is_old ? "long_name" : "comment");
}

/// Assigns "drag[3]: remark" to its entry; ignores other lines.
void add_remark(const std::string& line, calibrate::Table& table) {
    const std::size_t open = line.find('['), close = line.find("]: ");
    if (open == std::string::npos || close == std::string::npos || close < open) return;
    for (calibrate::TableRow& row : table.rows)
        if (row.name == line.substr(0, open))
            if (const std::size_t i = std::strtoull(line.c_str() + open + 1, nullptr, 10); i < row.entries.size())
                row.entries[i].remark = line.substr(close + 3);
}
}  // namespace

std::string axis_of(std::string key) {
    std::ranges::replace(key, '.', '_');
    return key;
}

void write_calibration(const std::filesystem::path& file, const calibrate::Table& table,
                       std::vector<files::Attribute> attributes) {
    calibrate::check(table, {.file = file.string()});
    std::string names, remarks;
    for (const calibrate::TableRow& row : table.rows) {
        names += (names.empty() ? "" : " ") + row.name;
        for (std::size_t i = 0; i < row.entries.size(); ++i)
            if (std::string remark = row.entries[i].remark; !remark.empty()) {
                std::ranges::replace(remark, '\n', ' ');
                remarks += text("{}[{}]: {}\n", row.name, i, remark);
            }
    }
    attributes.emplace_back(names_attribute, names);
    attributes.emplace_back(varied_attribute, table.varied_key);
    attributes.emplace_back(remarks_attribute, remarks);
    files::write_archive(file, {}, attributes, [&](files::Archive& archive) { archive.replace(results_of(table)); });
}

bool is_calibration(const files::ArchiveReader& archive) {
    const std::string axis = path_of(archive, bead_axis);
    return archive.has(axis) && archive.shape(axis).size() == 1;
}

calibrate::Table read_calibration(const files::ArchiveReader& archive, const std::filesystem::path& file) {
    const SourceLocation where{.file = file.string()};
    require(is_calibration(archive), where,
            "not a table of coefficients: {} is missing; expected a file written by drover calibrate",
            path_of(archive, bead_axis));
    calibrate::Table table{.varied_key = archive.text_attribute(varied_attribute),
                           .bead_fractions = read_axis(archive, where, bead_axis)};
    if (!table.varied_key.empty()) table.varied = read_axis(archive, where, axis_of(table.varied_key));
    if (archive.has(path_of(archive, rod_axis))) table.rod_fractions = read_axis(archive, where, rod_axis);
    std::istringstream names(archive.text_attribute(names_attribute)),
        remarks(archive.text_attribute(remarks_attribute));
    for (std::string name; names >> name;) {
        table.rows.push_back({.name = name, .unit = {}, .formula = {}, .entries = {}});
        read_row(archive, where, table, table.rows.back());
    }
    for (std::string line; std::getline(remarks, line);) add_remark(line, table);
    calibrate::check(table, where);
    return table;
}

calibrate::Table read_calibration(const std::filesystem::path& file) {
    return read_calibration(files::ArchiveReader(file), file);
}

std::string attempt_bytes(const calibrate::Attempt& attempt) {
    files::ByteWriter to;
    to(attempt.number, attempt.numbers, attempt.failure.value_or(""));
    if (attempt.core_seconds > 0.0) to(attempt.core_seconds);
    return files::text_of(to.bytes);
}

calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name) {
    files::ByteReader reader{std::as_bytes(std::span(bytes))};
    calibrate::Attempt attempt;
    std::string failure;  // of earlier versions, in which a failed trial was a unit that is done
    reader(attempt.number, attempt.numbers, failure);
    if (!failure.empty()) attempt.failure = failure;
    if (reader.is_complete && !reader.rest.empty()) reader(attempt.core_seconds);
    require(reader.has_ended(), {name}, "is not a trial; expected a record of this version of drover");
    return attempt;
}

}  // namespace drover::io
