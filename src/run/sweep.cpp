// run/sweep.cpp: the runs of a sweep as a campaign, and what comes of them.
#include "drover/run/sweep.hpp"

#include <algorithm>

#include "drover/base/log.hpp"
#include "drover/base/threads.hpp"
#include "drover/files/input_file.hpp"
#include "drover/files/new_file.hpp"
#include "drover/io/scene_text.hpp"
#include "drover/run/kind.hpp"
#include "drover/run/provenance.hpp"
#include "drover/run/run_scene.hpp"
#include "run/campaign.hpp"
#include "run/memory_run.hpp"
#include "run/run_record.hpp"
#include "run/same_run.hpp"
#include "run/sweep_dataset.hpp"
#include "run/sweep_results.hpp"

namespace drover::run {

namespace {
namespace fs = std::filesystem;
constexpr const char* sweep_manifest = "sweep.toml";

fs::path archive_of(const fs::path& folder, const SweepRun& run) { return folder / (run.name + ".h5"); }

bool is_finished(const fs::path& path) {
    return fs::exists(path) && files::ArchiveReader(path).has("/summary/warm_up");
}

/// One sweep in its folder.
struct Sweep {
    const io::Scene& scene;
    const fs::path& folder;
    SweepLayout layout = {};
    std::map<std::string, std::size_t> runs = {};  ///< by name

    Sweep(const io::Scene& given, const fs::path& in) : scene(given), folder(in), layout(plan_sweep(given)) {
        for (std::size_t r = 0; r < layout.runs.size(); ++r) runs[layout.runs[r].name] = r;
    }
    /// A ramp passes states on by archives, which are removed at the end where only the table is kept.
    bool has_archives() const { return keeps_archives() || layout.runs.back().before.has_value(); }
    bool keeps_archives() const { return scene.sweep.keep == "archives"; }
};

/// The scene of one run; on a ramp it starts from the last frame of the run before.
io::Scene scene_of(const Sweep& sweep, const SweepRun& run) {
    std::vector<std::string> overrides = run.overrides;
    if (sweep.scene.run.threads == 0) overrides.push_back("run.threads=1");
    io::Scene base = sweep.scene;
    if (run.before) {
        base.initial = {};  // its formulas belong to the first point only
        const std::string start = kind_of(base).start;
        overrides.push_back(start + ".kind=file");
        overrides.push_back(start + ".file=set-below");
        overrides.push_back(start + ".frame=-1");
    }
    io::Scene result = io::parse_scene(io::resolved_text(base), base.file, overrides);
    // No overrides, which are TOML: the name of a file may have any bytes.
    result.output.file = archive_of(sweep.folder, run).string();
    std::string& first_state = io::has_grid(base.kind) ? result.initial.file : result.particles.packing.file;
    if (run.before) first_state = fs::absolute(archive_of(sweep.folder, sweep.layout.runs[*run.before])).string();
    return result;
}

/// Throws an input Error for an archive in the folder that is of another run than its name says.  Returns a warning for
/// each other version of drover that made some of them: on purpose, a sweep may be resumed by another.
std::vector<std::string> check_archives(const Sweep& sweep) {
    std::map<std::string, std::vector<std::string>> runs_of;  // by version
    for (const SweepRun& run : sweep.layout.runs)
        if (const fs::path path = archive_of(sweep.folder, run); fs::exists(path)) {
            require_archive_of(scene_of(sweep, run), path);
            runs_of[program_of(files::ArchiveReader(path))].push_back(run.name);
        }
    runs_of.erase(this_program());
    std::vector<std::string> warnings;
    for (const auto& [version, runs] : runs_of)
        warnings.push_back(
            text("{}{} made by drover {}, and this is drover {}: if a change between them affects "
                 "results, repeat the sweep in another folder",
                 runs.front(), runs.size() == 1 ? " was" : text(" and {} more were", runs.size() - 1), version,
                 this_program()));
    return warnings;
}

RunResults results_of(Report report) {
    return {.rows = std::move(report.summary.rows), .warnings = std::move(report.warnings)};
}

std::optional<UnitResult> run_one(const Sweep& sweep, const SweepRun& run) {
    const io::Scene scene = scene_of(sweep, run);
    if (!sweep.has_archives()) {
        auto report = run_in_memory(scene);
        if (!report) return std::nullopt;
        return encode(results_of(std::move(*report)));
    }
    const fs::path path = archive_of(sweep.folder, run);
    wait_for_writer(path);
    if (fs::exists(path)) require_archive_of(scene, path);
    if (is_finished(path)) return encode(results_of(make_report(files::ArchiveReader(path), Theory::omitted)));
    const RunOptions options{.overwrite = true, .quiet = true};
    RunOutcome outcome =
        fs::exists(path) && has_checkpoint(path) ? restart_run(path, {}, options) : run_scene(scene, options);
    if (outcome.loop.signal != 0) return std::nullopt;
    return encode(results_of(std::move(*outcome.report)));
}

/// The text that claims the folder: one of an earlier version stays, if it means the same.
std::string manifest_of(io::Scene scene, const fs::path& folder) {
    scene.sweep.workers = 0;
    const std::string words = io::resolved_text(scene);
    const fs::path file = folder / sweep_manifest;
    if (!fs::exists(file)) return words;
    try {
        constexpr std::uint64_t max_bytes = 1 << 24;
        const std::string there = files::read_text(file, max_bytes, "the scene of a sweep");
        io::Scene before = io::archived_scene(there, file.string());
        before.sweep.workers = 0;
        return io::resolved_text(before) == words ? there : words;
    } catch (const Error& error) {
        if (error.fault() != Fault::input) throw;
        return words;
    }
}

files::RecordIdentity identity_of(const std::string& manifest) {
    return {.hash = files::fingerprint("sweep\n" + manifest), .content = manifest};
}

/// What is known of all runs.
struct Ended {
    std::map<std::string, RunResults> results;
    std::map<std::string, std::string> failures;
};

Ended ended_runs(const Sweep& sweep, const files::RecordIdentity& identity) {
    Ended ended;
    for (const UnitRecord& record : campaign_records(sweep.folder, identity)) {
        const auto run = sweep.runs.find(record.key);
        if (run == sweep.runs.end()) continue;
        if (record.state != UnitState::done) ended.failures[record.key] = record.reason;
        else if (!sweep.keeps_archives() || fs::exists(archive_of(sweep.folder, sweep.layout.runs[run->second])))
            ended.results[record.key] = decode(record.result);
    }
    return ended;
}

void remove_archives(const Sweep& sweep) {
    std::error_code ignored;
    for (const SweepRun& run : sweep.layout.runs) {
        const fs::path path = archive_of(sweep.folder, run);
        for (const char* beside : {"", ".checkpoint-a", ".checkpoint-b"}) fs::remove(path.string() + beside, ignored);
    }
}

/// Runs what this process gets of it.
bool run_campaign_of(const Sweep& sweep, const SweepOptions& options, const files::RecordIdentity& identity) {
    const std::vector<SweepRun>& runs = sweep.layout.runs;
    std::vector<bool> is_done(runs.size(), false);
    std::size_t ended = 0;
    const std::size_t first = runs.size() * static_cast<std::size_t>(options.share.number - 1) /
                              static_cast<std::size_t>(options.share.count);
    const auto wanted = [&](const Offer& offer) {
        for (std::size_t i = 0; i < runs.size(); ++i) {
            const std::size_t r = (first + i) % runs.size();
            if (is_done[r] || (runs[r].before && !is_done[*runs[r].before])) continue;
            if (!offer(runs[r].name)) return;
        }
    };
    const auto take = [&](const UnitRecord& record) {
        const auto found = sweep.runs.find(record.key);
        if (found == sweep.runs.end()) return;
        ++ended;
        if (record.state == UnitState::done) is_done[found->second] = true;
        if (record.is_new && record.state != UnitState::done) log_warning("{}: {}", record.key, record.reason);
        if (record.is_new && !options.quiet)
            log_information("{} of {} jobs finished: {}{}", std::count(is_done.begin(), is_done.end(), true),
                            runs.size(), record.key, record.state == UnitState::done ? "" : ", which failed");
    };
    const auto holds = [&](const UnitRecord& record) {
        const auto found = sweep.runs.find(record.key);
        return !sweep.keeps_archives() || found == sweep.runs.end() ||
               fs::exists(archive_of(sweep.folder, runs[found->second]));
    };
    const UnitPlan plan{.wanted = wanted,
                        .run = [&](const std::string& key) { return run_one(sweep, runs[sweep.runs.at(key)]); },
                        .take = take,
                        .holds = holds};
    const int workers = sweep.scene.sweep.workers > 0 ? sweep.scene.sweep.workers : usable_cores();
    return Campaign(plan, {.folder = sweep.folder,
                           .identity = identity,
                           .share = options.share,
                           .workers = workers,
                           .quiet = options.quiet})
        .run()
        .stopped;
}

/// From the records of all processes.
void conclude(const Sweep& sweep, const SweepOptions& options, const files::RecordIdentity& identity,
              const std::vector<std::string>& versions, SweepOutcome& outcome) {
    const Ended ended = ended_runs(sweep, identity);
    for (const auto& [name, reason] : ended.failures) outcome.failures.push_back(name + ": " + reason);
    outcome.failed = outcome.failures.size();
    outcome.missing = outcome.runs - ended.results.size() - outcome.failed;
    const bool is_last = outcome.missing == 0 && !outcome.stopped;
    if (!options.share.is_plain() && !is_last) return;
    outcome.table = sweep_table(sweep.layout, ended.results);
    alone(sweep.folder, is_last, [&] {
        files::replace_file(sweep.folder / "table.csv", table_csv(*outcome.table));
        write_sweep_dataset(sweep.folder / "table.nc", sweep.scene, sweep.layout, ended.results, *outcome.table);
        if (is_last && !sweep.keeps_archives()) remove_archives(sweep);
    });
    outcome.table->warnings.insert(outcome.table->warnings.begin(), versions.begin(), versions.end());
}
}  // namespace

SweepOutcome run_sweep(const io::Scene& scene, const SweepOptions& options) {
    const Sweep sweep(scene, options.folder);
    SweepOutcome outcome{.table = {}, .runs = sweep.layout.runs.size()};
    const fs::path& folder = options.folder;
    if (options.collect) require_folder(folder, "sweep");
    if (!options.collect && options.share.is_plain())  // all values are checked before anything runs
        for (const SweepRun& run : sweep.layout.runs) {
            SweepRun single = run;
            single.before.reset();
            scene_of(sweep, single);
        }
    // To resume, the scene must be the same, or different runs would be mixed.
    const std::string manifest = manifest_of(scene, folder);
    const files::RecordIdentity identity = identity_of(manifest);
    files::join_folder(folder, sweep_manifest, "", manifest);
    if (sweep.has_archives() && !options.collect) files::require_locks(folder / sweep_manifest);
    std::vector<std::string> versions;
    if (options.share.is_plain() && sweep.keeps_archives()) versions = check_archives(sweep);
    outcome.already_done = ended_runs(sweep, identity).results.size();
    if (outcome.already_done < outcome.runs && !options.collect)  // else with the table, at once
        for (const std::string& warning : versions) log_warning("{}", warning);
    if (!options.quiet && !options.collect)
        log_information("{} points, {} runs ({} already finished) in {}", sweep.layout.points.size(), outcome.runs,
                        outcome.already_done, folder.string());
    if (!options.collect) outcome.stopped = run_campaign_of(sweep, options, identity);
    conclude(sweep, options, identity, versions, outcome);
    return outcome;
}

std::string sweep_status(const io::Scene& scene, const fs::path& folder) {
    const Sweep sweep(scene, folder);
    require_folder(folder, "sweep");
    std::vector<std::string> keys;
    for (const SweepRun& run : sweep.layout.runs) keys.push_back(run.name);
    return campaign_status(folder, campaign_records(folder, identity_of(manifest_of(scene, folder))), keys);
}

}  // namespace drover::run
