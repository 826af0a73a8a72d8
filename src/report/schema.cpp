// report/schema.cpp: the schema of scenes as JSON.
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/mapped.hpp"
#include "report/shown.hpp"

namespace drover::report {

namespace {
nlohmann::json row_json(const Description& row) {
    nlohmann::json result{{"name", row.name},
                          {"type", type_text(row.default_value)},
                          {"default",
                           std::visit([](const auto& held) { return nlohmann::json(held); }, row.default_value)},
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
        result.push_back({{"name", section.name}, {"doc", section.doc}, {"rows", mapped(section.rows, row_json)}});
        if (section.kinds.empty()) continue;
        result.back()["kind"] = name_of(section.kinds.front());
        for (const io::SceneKind kind : section.kinds) result.back()["kinds"].push_back(name_of(kind));
    }
    return result;
}

}  // namespace drover::report
