// report/json.cpp: reports, tables and files as JSON.
#include "report/json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "io/calibration.hpp"
#include "io/export.hpp"
#include "report/write_result.hpp"
#include "run/simulation_type.hpp"

namespace drover::report {

using run::number_json;

namespace {
nlohmann::json estimate_json(const measure::Estimate& estimate) {
    nlohmann::json result{{"mean", number_json(estimate.mean)},
                          {"error", estimate.error ? number_json(*estimate.error) : nlohmann::json(nullptr)},
                          {"autocorrelation_time", number_json(estimate.autocorrelation_time)},
                          {"warm_up", number_json(estimate.warm_up)},
                          {"samples", estimate.samples}};
    if (!estimate.why_no_error.empty()) result["refusal"] = estimate.why_no_error;
    return result;
}
}  // namespace

nlohmann::json report_json(const run::Report& report) {
    nlohmann::json rows = nlohmann::json::object();
    for (const measure::SummaryRow& row : report.summary.rows) {
        nlohmann::json entry{{"unit", row.unit}, {"formula", row.formula}};
        const auto estimate_of = [&](std::size_t component) {
            nlohmann::json estimate = estimate_json(row.estimates[component]);
            if (const run::StepBiasEstimate* bias = report.step_bias.find(row.name, component)) {
                estimate["step_bias"] = number_json(bias->bias);
                estimate["step_bias_error"] = number_json(bias->error);
            }
            return estimate;
        };
        if (row.axes.empty()) {
            entry.update(estimate_of(0));
        } else {
            for (std::size_t i = 0; i < row.estimates.size(); ++i) entry["values"].push_back(estimate_of(i));
        }
        if (const run::Prediction* prediction = run::find_prediction(report, row.name))
            for (const double value : prediction->values) entry["linear"].push_back(number_json(value));
        rows[row.name] = std::move(entry);
    }
    return {{"time", report.time},
            {"samples", report.summary.samples},
            {"warm_up_samples", report.summary.warm_up},
            {"note", report.summary.note},
            {"warnings", report.warnings},
            {"no_prediction", report.no_prediction},
            {"linear_about", report.about},
            {"no_step_bias", report.step_bias.missing},
            {"results", std::move(rows)}};
}

nlohmann::json table_json(const calibrate::Table& table) {
    nlohmann::json coefficients = nlohmann::json::object();
    for (const calibrate::TableRow& row : table.rows) {
        nlohmann::json points = nlohmann::json::array();
        const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1, beads = table.bead_fractions.size();
        for (std::size_t place = 0; place < row.entries.size(); ++place) {
            const calibrate::TableEntry& known = row.entries[place];
            nlohmann::json point{{"bead_area_fraction", table.bead_fractions[place / rods % beads]},
                                 {"value", number_json(known.value)},
                                 {"error", number_json(known.error)},
                                 {"trials", known.trials},
                                 {"origin", calibrate::origin_name(known.origin)},
                                 {"remark", known.remark}};
            if (row.by_rods) point["rod_area_fraction"] = table.rod_fractions[place % rods];
            if (!table.varied_key.empty()) point[table.varied_key] = table.varied[place / rods / beads];
            points.push_back(std::move(point));
        }
        coefficients[row.name] = {{"unit", row.unit}, {"formula", row.formula}, {"points", std::move(points)}};
    }
    return coefficients;
}

nlohmann::json table_json(const jobs::SweepTable& table) {
    nlohmann::json rows = nlohmann::json::array();
    for (const jobs::SweepRow& row : table.rows) {
        nlohmann::json entry{{"seeds", row.seeds}};
        if (!row.point.branch.empty()) entry["branch"] = row.point.branch;
        for (std::size_t k = 0; k < table.keys.size(); ++k) entry[table.keys[k]] = row.point.values[k];
        for (std::size_t i = 0; i < row.results.size(); ++i) {
            const measure::Estimate& estimate = row.results[i].mean;
            nlohmann::json result{{"mean", estimate.mean}, {"error", nullptr}, {"unit", table.units[i]}};
            if (!std::isfinite(estimate.mean)) result["mean"] = nullptr;
            if (estimate.error) result["error"] = *estimate.error;
            else result["refusal"] = estimate.why_no_error;
            if (row.results[i].own_error) result["own_error"] = *row.results[i].own_error;
            entry[table.names[i]] = std::move(result);
        }
        rows.push_back(std::move(entry));
    }
    return rows;
}

namespace {
nlohmann::json value_json(const Value& value) {
    return std::visit([](const auto& held) { return nlohmann::json(held); }, value);
}

nlohmann::json row_json(const Description& row) {
    nlohmann::json result{{"name", row.name},
                          {"type", type_text(row.default_value)},
                          {"default", value_json(row.default_value)},
                          {"doc", row.doc}};
    if (!row.unit.empty()) result["unit"] = row.unit;
    if (std::isfinite(row.range.min)) result[row.range.min_open ? "more_than" : "min"] = row.range.min;
    if (std::isfinite(row.range.max)) result["max"] = row.range.max;
    if (!row.choices.empty()) result["choices"] = row.choices;
    return result;
}
}  // namespace

nlohmann::json schema_json(const std::vector<io::SectionDescription>& sections) {
    nlohmann::json result = nlohmann::json::array();
    for (const io::SectionDescription& section : sections) {
        nlohmann::json rows = nlohmann::json::array();
        for (const Description& row : section.rows) rows.push_back(row_json(row));
        result.push_back({{"name", section.name}, {"doc", section.doc}, {"rows", rows}});
        if (section.kinds.empty()) continue;
        result.back()["kind"] = io::kind_name(section.kinds.front());
        for (const io::SceneKind kind : section.kinds) result.back()["kinds"].push_back(io::kind_name(kind));
    }
    return result;
}

namespace {
/// The provenance of an archive.
nlohmann::json attributes_json(const files::ArchiveReader& archive) {
    nlohmann::json result = nlohmann::json::object();
    for (const auto& [name, value] : archive.attributes())
        std::visit([&](const auto& held) { result[name] = held; }, value);
    return result;
}

nlohmann::json arrays_json(const files::ArchiveReader& archive) {
    nlohmann::json result = nlohmann::json::array();
    for (const files::StoredArray& array : arrays_by_path(archive))
        result.push_back({{"name", array.path},
                          {"unit", files::text_in(array.attributes, "units")},
                          {"meaning", files::text_in(array.attributes, "comment")},
                          {"shape", array.shape},
                          {"values", archive.read(array.path).values}});
    return result;
}

nlohmann::json xyz_json(const std::filesystem::path& file) {
    const io::XyzInfo info = io::read_xyz_info(file);
    return {{"frames", info.frames},           {"min_particles", info.min_lines},
            {"max_particles", info.max_lines}, {"lattice", info.lattice},
            {"origin", info.origin},           {"pbc", info.periodic},
            {"properties", info.properties},   {"times", info.times}};
}
}  // namespace

nlohmann::json info_json(const std::filesystem::path& file) {
    if (io::is_xyz(file)) return xyz_json(file);
    const files::ArchiveReader archive(file);
    if (io::is_calibration(archive))
        return {{"attributes", attributes_json(archive)},
                {"coefficients", table_json(io::read_calibration(archive, file.string()))}};
    if (is_result(archive)) return {{"attributes", attributes_json(archive)}, {"arrays", arrays_json(archive)}};
    nlohmann::json result = run::is_start(archive) ? nlohmann::json{{"results", nlohmann::json::object()}}
                                                   : report_json(run::make_report(archive));
    result["attributes"] = attributes_json(archive);
    return result;
}

}  // namespace drover::report
