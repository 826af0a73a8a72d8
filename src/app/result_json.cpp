// app/result_json.cpp: a result as JSON.
#include <cstdio>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/run/provenance.hpp"

namespace drover::app {

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

nlohmann::json record_json(const run::Record& record) {
    nlohmann::json result = nlohmann::json::object();
    for (const run::Entry& entry : record.entries) result[entry.name] = std::visit(ValueJson{}, entry.value);
    for (const auto& [name, part] : record.parts)
        if (nlohmann::json inner = record_json(part); !inner.empty()) result[name] = std::move(inner);
    for (const run::List& list : record.lists) {
        nlohmann::json rows = nlohmann::json::array();
        for (const run::Record& row : list.rows) rows.push_back(record_json(row));
        result[list.name] = std::move(rows);
    }
    return result;
}
}  // namespace

nlohmann::json result_json(const run::Result& result) { return record_json(result.root); }

int print_result(const run::Result& result, const ResultOutput& output, const io::Scene& scene, int threads) {
    if (!output.file.empty()) {
        std::vector<files::Attribute> attributes = run::provenance(scene, threads, output.what);
        const std::vector<files::Attribute> more = run::result_attributes(result);
        attributes.insert(attributes.end(), more.begin(), more.end());
        std::vector<files::Recording> recordings;
        if (result.frames) recordings.push_back(result.frames->recording);
        files::Archive archive = files::Archive::create(output.file, recordings, attributes, output.overwrite);
        for (std::size_t i = 0; result.frames && i < result.frames->rows.size(); ++i) {
            const std::vector<std::vector<double>>& frame = result.frames->rows[i];
            archive.append(0, static_cast<double>(i), std::vector<std::span<const double>>(frame.begin(), frame.end()));
        }
        for (const files::ResultTable& table : run::result_tables(result)) archive.replace(table);
        archive.commit();
    }
    if (output.json) {
        print_json(result_json(result));
        return run::exit_done;
    }
    std::fputs(run::result_text(result).c_str(), stdout);
    if (!output.file.empty()) std::printf("\n%s: %s\n", output.file.c_str(), output.contents.c_str());
    return run::exit_done;
}

}  // namespace drover::app
