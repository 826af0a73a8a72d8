// jobs/boundary_shares.cpp: the loops of make_boundary as a campaign.
#include "jobs/boundary_shares.hpp"

#include <algorithm>

#include "files/input_file.hpp"
#include "files/record_folder.hpp"
#include "jobs/campaign/campaign.hpp"
#include "run/loop/provenance.hpp"

namespace drover::jobs {

namespace {
constexpr const char* plane_manifest = "boundary.toml";

/// The version too, which decides what the loops are.
std::string plane_manifest_of(io::Scene scene) {
    scene.run.threads = 0;
    scene.output.file.clear();
    return text("# drover {}\n", run::this_program()) + io::resolved_text(scene);
}

files::RecordIdentity plane_identity(const std::string& manifest) { return files::identity_of("boundary", manifest); }
}  // namespace

std::optional<run::Result> make_boundary_in_shares(const io::Scene& scene, const JobOptions& job, Threads& threads) {
    analysis::check_boundary(scene);
    if (job.collect) require_folder(job.folder, "boundary");
    const std::string manifest = plane_manifest_of(scene);
    files::join_folder(job.folder, plane_manifest, "", manifest);
    const ComputeAll compute =
        shared_compute({.job = with_workers(job, threads.count()), .identity = plane_identity(manifest)});
    const bool is_share = !job.share.is_plain();
    try {
        run::Result result = analysis::make_boundary(scene, threads, {.compute = compute, .lines_alone = is_share});
        if (is_share) return std::nullopt;
        return result;
    } catch (const Interrupted&) {
        if (job.collect)
            throw Error(Fault::run, {job.folder.string()},
                        "points of the plane are missing: run the same command without --collect, or more shares");
        return std::nullopt;
    }
}

bool has_shares(const io::Scene& scene, const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / plane_manifest;
    return std::filesystem::exists(file) && files::read_text(file, "the plane of shares") == plane_manifest_of(scene);
}

std::string boundary_status(const io::Scene& scene, const std::filesystem::path& folder) {
    require_folder(folder, "boundary");
    const std::vector<UnitRecord> records = campaign_records(folder, plane_identity(plane_manifest_of(scene)));
    const auto done =
        std::ranges::count_if(records, [](const UnitRecord& record) { return record.state == UnitState::done; });
    const Working now = working_in(folder);
    return text("{} groups of points done, {} failed, {} running in {} processes; how many follow depends on the lines",
                done, static_cast<std::ptrdiff_t>(records.size()) - done, now.units, now.processes);
}

}  // namespace drover::jobs
