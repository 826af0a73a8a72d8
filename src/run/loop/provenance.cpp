// run/loop/provenance.cpp: versions, host and time; compares run ids, resolved scenes and versions.
#include "run/loop/provenance.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>

#include "drover/base/version.hpp"
#include "drover/numerics/transform.hpp"
#include "files/archive_reader.hpp"
#include "files/claims.hpp"
#include "io/scene.hpp"
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

/// Without what differs between the parts of one run, the place of its archive, and the other runs of its sweep.
io::Scene comparable(io::Scene scene, End end) {
    if (end == End::any) scene.time.end = 0.0;
    scene.output.checkpoint_minutes = 0.0;
    scene.run.threads = 0;
    scene.output.file.clear();
    scene.sweep = {};
    return scene;
}

io::Scene scene_in(const files::ArchiveReader& archive, const std::filesystem::path& file) {
    return io::archived_scene(archive.text_attribute("scene"), file.string() + " (its scene)");
}

std::string difference(const std::string& key, const std::string& in_archive, const std::string& other,
                       const char* where) {
    return text("{} = {} in the archive, {} in {}", key, in_archive.empty() ? "none" : in_archive,
                other.empty() ? "none" : other, where);
}

/// "" if there is none.
std::string difference_of_scenes(const io::Scene& in_archive, const io::Scene& other, End end, const char* where) {
    const std::optional<files::TextDifference> found =
        files::first_difference(io::resolved_text(comparable(in_archive, end)),
                                io::resolved_text(comparable(other, end)));
    return found ? difference(found->key, files::shown(found->one), files::shown(found->other), where) : "";
}

std::string difference_of_runs(const files::ArchiveReader& archive, const std::filesystem::path& file,
                               const files::Checkpoint& checkpoint) {
    constexpr const char* there = "the checkpoint";
    if (archive.text_attribute("scene") != checkpoint.scene) {
        const io::Scene saved = io::archived_scene(checkpoint.scene, file.string() + " (the scene of its checkpoint)");
        const std::string found = difference_of_scenes(scene_in(archive, file), saved, End::any, there);
        if (!found.empty()) return found;
    }
    const std::string id = files::run_id_of(archive);
    if (id == checkpoint.run_id) return "";
    const std::string made_by = program_of(archive);
    if (made_by != checkpoint.program) return difference("the version of drover", made_by, checkpoint.program, there);
    return difference(files::run_id_name, id, checkpoint.run_id, there);
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

void require_same_run(const files::ArchiveReader& archive, const std::filesystem::path& file,
                      const files::Checkpoint& checkpoint) {
    const std::string found = difference_of_runs(archive, file, checkpoint);
    if (found.empty()) return;
    throw MixedFiles(file,
                     text("the archive and the checkpoint beside it belong to different runs: {}; expected both of "
                          "one run: put back the file that was replaced, or run the scene again",
                          found));
}

void require_archive_of(const io::Scene& scene, const std::filesystem::path& file, End end) {
    const files::ArchiveReader archive(file);
    const io::Scene found = scene_in(archive, file);
    io::Scene expected = scene;
    if (expected.time.dt == 0.0) {
        if (!expected.places.contains("time.stepper")) expected.time.stepper = found.time.stepper;
        if (expected.time.tolerance == 0.0) expected.time.tolerance = found.time.tolerance;
        expected.time.dt = found.time.dt;
        expected.found.step = found.found.step;
    }
    // The archive that a run starts from may have moved, with the folder.
    if (!expected.initial.file.empty() && !found.initial.file.empty()) expected.initial.file = found.initial.file;
    if (!expected.particles.packing.file.empty() && !found.particles.packing.file.empty())
        expected.particles.packing.file = found.particles.packing.file;
    const std::string difference = difference_of_scenes(found, expected, end, "the run of this name");
    if (difference.empty()) return;
    throw MixedFiles(file, text("the archive belongs to another run: {}; expected the one that was written here: put "
                                "it back, or remove this file and the files beside it to repeat the run",
                                difference));
}

std::vector<files::TextDifference> scene_differences(const std::filesystem::path& one,
                                                     const std::filesystem::path& other) {
    const auto resolved = [](const std::filesystem::path& file) {
        std::error_code unknown;
        require(!std::filesystem::is_empty(file, unknown), {.file = file.string()},
                "is empty; expected a scene or an archive");
        return io::resolved_text(files::is_hdf5(file) ? scene_in(files::ArchiveReader(file), file)
                                                      : io::read_scene(file));
    };
    return files::differences(resolved(one), resolved(other));
}

}  // namespace drover::run
