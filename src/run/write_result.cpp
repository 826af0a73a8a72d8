// run/write_result.cpp: a result as an archive.
#include "drover/run/write_result.hpp"

#include "drover/run/provenance.hpp"

namespace drover::run {

void write_result(const Result& result, const std::filesystem::path& file, const std::string& what,
                  const io::Scene& scene, int threads, bool overwrite) {
    std::vector<files::Attribute> attributes = provenance(scene, threads, what);
    const std::vector<files::Attribute> more = result_attributes(result);
    attributes.insert(attributes.end(), more.begin(), more.end());
    std::vector<files::Recording> recordings;
    if (result.frames) recordings.push_back(result.frames->recording);
    files::Archive archive = files::Archive::create(file, recordings, attributes, overwrite);
    for (std::size_t i = 0; result.frames && i < result.frames->rows.size(); ++i) {
        const std::vector<std::vector<double>>& frame = result.frames->rows[i];
        archive.append(0, static_cast<double>(i), std::vector<std::span<const double>>(frame.begin(), frame.end()));
    }
    for (const files::ResultTable& table : result_tables(result)) archive.replace(table);
    archive.commit();
}

}  // namespace drover::run
