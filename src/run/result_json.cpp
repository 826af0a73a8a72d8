// run/result_json.cpp: results as JSON.
#include "run/result_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace drover::run {

nlohmann::json number_json(double value) {
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

namespace {
struct ValueJson {
    nlohmann::json operator()(double value) const { return number_json(value); }
    nlohmann::json operator()(const std::vector<double>& values) const {
        nlohmann::json result = nlohmann::json::array();
        for (const double value : values) result.push_back(number_json(value));
        return result;
    }
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
    for (const List& list : record.lists) {
        nlohmann::json rows = nlohmann::json::array();
        for (const Record& row : list.rows) rows.push_back(record_json(row));
        result[list.name] = std::move(rows);
    }
    return result;
}
}  // namespace

nlohmann::json result_json(const Result& result) { return record_json(result.root); }

}  // namespace drover::run
