// run/provenance.cpp: versions, host and time.
#include "run/provenance.hpp"

#include <unistd.h>

#include <chrono>
#include <ctime>

#include "drover/base/version.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/steppers/sundials_stepper.hpp"

namespace drover::run {

namespace {
std::string host_name() {
    char name[256] = {};
    return gethostname(name, sizeof(name) - 1) == 0 ? name : "unknown";
}

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
    std::string version, commit;
    std::int64_t is_changed = 0;
    for (const auto& [name, value] : archive.attributes()) {
        if (const auto* words = std::get_if<std::string>(&value)) {
            if (name == "drover_version") version = *words;
            if (name == "drover_commit") commit = *words;
        } else if (const auto* number = std::get_if<std::int64_t>(&value)) {
            if (name == "drover_commit_dirty") is_changed = *number;
        }
    }
    return program_text(version, commit, is_changed != 0);
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
            {"host", host_name()},
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
