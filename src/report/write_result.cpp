// report/write_result.cpp: a result as an archive, and such an archive as text.
#include "report/write_result.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/text.hpp"
#include "run/provenance.hpp"
#include "run/scene_support.hpp"

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

bool is_result(const files::ArchiveReader& archive) {
    const std::string title = files::text_in(archive.attributes(), "title");
    for (const char* what : {"boundary", "onset", "stability", "states", "sweep"})
        if (title.starts_with(text("drover {} of ", what))) return true;
    return false;
}

std::vector<files::StoredArray> arrays_by_path(const files::ArchiveReader& archive) {
    std::vector<files::StoredArray> arrays = archive.contents().arrays;
    std::ranges::sort(arrays, {}, &files::StoredArray::path);
    return arrays;
}

namespace {
/// "0.5", "16 by 9: 0 to 2.5, 3 not finite".
std::string content_text(const files::Array& array) {
    std::vector<double> finite;
    for (const double value : array.values)
        if (std::isfinite(value)) finite.push_back(value);
    if (array.shape.empty() && array.values.size() == 1) return text("{:.6g}", array.values.front());
    std::vector<std::string> sizes;
    for (const std::size_t size : array.shape) sizes.push_back(text("{}", size));
    std::string out = joined(sizes, " by ");
    if (!finite.empty()) {
        const auto [min, max] = std::minmax_element(finite.begin(), finite.end());
        out += text(": {:.6g} to {:.6g}", *min, *max);
    }
    if (finite.size() < array.values.size()) out += text(", {} not finite", array.values.size() - finite.size());
    return out;
}
}  // namespace

std::string stored_text(const files::ArchiveReader& archive) {
    std::string out;
    for (const files::StoredArray& array : arrays_by_path(archive)) {
        const std::string unit = files::text_in(array.attributes, "units"),
                          meaning = files::text_in(array.attributes, "comment");
        out += text("{:<40} {}{}\n", array.path, content_text(archive.read(array.path)),
                    unit == "1" || unit.empty() ? "" : " " + unit);
        if (!meaning.empty()) out += text("    {}\n", meaning);
    }
    return out;
}

}  // namespace drover::report
