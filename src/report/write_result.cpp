// report/write_result.cpp: a result as an archive.
#include "report/shown.hpp"

#include "run/loop/provenance.hpp"
#include "run/loop/scene_support.hpp"

namespace drover::report {

void check_result_file(const std::filesystem::path& file, std::vector<std::filesystem::path> inputs,
                       const io::Scene& scene, bool overwrite) {
    const std::vector<std::filesystem::path> more = run::inputs_of(scene);
    inputs.insert(inputs.end(), more.begin(), more.end());
    run::check_output({.path = file, .where = {}, .name = file.string(), .overwrite = overwrite}, inputs);
}

void write_result(const run::Result& result, const std::filesystem::path& file, const std::string& what,
                  const io::Scene& scene, int threads, bool overwrite) {
    std::vector<files::Attribute> attributes = run::provenance(scene, threads, what);
    const std::vector<files::Attribute> more = run::result_attributes(result);
    attributes.insert(attributes.end(), more.begin(), more.end());
    std::vector<std::filesystem::path> inputs;
    if (const std::string table = files::text_in(result.attributes, "table"); !table.empty())
        inputs.emplace_back(table);
    check_result_file(file, inputs, scene, overwrite);
    std::vector<files::Recording> recordings;
    if (result.frames) recordings.push_back(result.frames->recording);
    files::write_archive(file, recordings, attributes, [&](files::Archive& archive) {
        for (std::size_t i = 0; result.frames && i < result.frames->rows.size(); ++i) {
            const std::vector<std::vector<double>>& frame = result.frames->rows[i];
            archive.append(0, static_cast<double>(i), std::vector<std::span<const double>>(frame.begin(), frame.end()));
        }
        for (const files::ResultTable& table : run::result_tables(result)) archive.replace(table);
    });
}

}  // namespace drover::report
