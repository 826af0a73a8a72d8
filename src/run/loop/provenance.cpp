// run/loop/provenance.cpp: versions, host and time.
#include "run/loop/provenance.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>

#include "drover/base/version.hpp"
#include "drover/numerics/transform.hpp"
#include "files/claims.hpp"
#include "numerics/steppers/sundials_stepper.hpp"

namespace drover::run {

namespace {
std::string utc_now() {
    const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
    std::tm parts = {};
    gmtime_r(&now, &parts);
    char written[32] = {};
    std::strftime(written, sizeof(written), "%Y-%m-%dT%H:%M:%SZ", &parts);
    return written;
}

std::string program_text(const std::string& version, const std::string& commit, bool is_changed) {
    return text("{} ({}{})", version, commit, is_changed ? ", changed" : "");
}
}  // namespace

std::string this_program() {
    const Version built = version();
    return program_text(built.version, built.git_hash, built.dirty);
}

std::string program_of(const files::ArchiveReader& archive) {
    const std::vector<files::Attribute> attributes = archive.attributes();
    const files::Attribute changed{"drover_commit_dirty", std::int64_t{1}};
    return program_text(files::text_in(attributes, "drover_version"), files::text_in(attributes, "drover_commit"),
                        std::ranges::find(attributes, changed) != attributes.end());
}

std::vector<files::Attribute> provenance(const io::Scene& scene, int threads, const std::string& what) {
    const Version built = version();
    return {{"title", text("drover {} of {}", what, std::filesystem::path(scene.file).filename().string())},
            {"drover_version", built.version},
            {"drover_commit", built.git_hash},
            {"drover_commit_dirty", std::int64_t{built.dirty ? 1 : 0}},
            {"library_versions", text("{}; {}; {}; GCC {}", numerics::transform_library(), files::archive_library(),
                                      numerics::sundials_library(), __VERSION__)},
            {"scene", io::resolved_text(scene)},
            {"scene_file", std::filesystem::path(scene.file).filename().string()},
            {"seed", scene.run.seed},
            {"threads", std::int64_t{threads}},
            {"host", files::host_name()},
            {"start_time", utc_now()}};
}

std::vector<files::Attribute> shared_provenance(const io::Scene& scene, const std::string& what) {
    std::vector<files::Attribute> attributes = provenance(scene, 1, what);
    std::erase_if(attributes, [](const files::Attribute& one) {
        return one.first == "host" || one.first == "start_time" || one.first == "threads";
    });
    return attributes;
}

}  // namespace drover::run
