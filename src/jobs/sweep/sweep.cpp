// jobs/sweep/sweep.cpp: the runs of a sweep as a campaign, and what comes of them.
#include "jobs/sweep/sweep.hpp"

#include <algorithm>
#include <set>
#include <unordered_set>

#include "base/log.hpp"
#include "base/mapped.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"
#include "io/scene.hpp"
#include "jobs/campaign/campaign.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "jobs/sweep/sweep_plan.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/provenance.hpp"
#include "run/simulation_type.hpp"

namespace drover::jobs {

namespace {
namespace fs = std::filesystem;
constexpr const char* sweep_manifest = "sweep.toml";

fs::path archive_of(const fs::path& folder, const SweepRun& run) { return folder / (run.name + ".h5"); }

std::string without_workers(io::Scene scene) {
    scene.sweep.workers = 0;
    return io::resolved_text(scene);
}

/// Of a ramp all; else what all points have in common: other values and seeds make more runs in a folder.
std::string common_text(io::Scene scene) {
    if (!is_ramp(scene)) scene.sweep = {.vary = {}, .refine = {}, .keep = scene.sweep.keep};
    return without_workers(std::move(scene));
}

/// Ends the text that claims a folder: the checksum of the archive from which runs start, if there is one.  Scenes hold
/// only its name.
constexpr const char* start_heading = "\n# Checksum of the archive from which runs start: ";

std::string start_text(const io::Scene& scene) {
    const std::string& named = io::has_grid(scene.kind) ? scene.initial.file : scene.particles.packing.file;
    const fs::path file = io::beside(scene.file, named);
    if (named.empty() || !fs::exists(file)) return "";
    return text("{}{:016x}\n", start_heading, files::file_checksum(file, "an archive"));
}

/// That of `scene` must be the one of the folder; earlier versions wrote none, and a table needs none.
void check_start(const std::string& there, const std::string& here, const io::Scene& scene, const fs::path& folder) {
    const std::size_t begin = there.rfind(start_heading);
    require(begin == std::string::npos || here.empty() || there.substr(begin) == here, {.file = folder.string()},
            "{}.file is not the archive from which the runs there started: its checksum differs; expected the same "
            "content: put it back, or choose another folder with --output",
            run::simulation_type_of(scene).start);
}

/// The text that claims a folder, that of its first sweep, and the points that this one numbered.
struct Manifest {
    std::string content;
    NumberedPoints numbered = {};
};

Manifest manifest_of(const io::Scene& scene, const fs::path& folder) {
    const std::string start = start_text(scene);
    const Manifest fresh{without_workers(scene) + start, numbered_points(scene)};
    const fs::path file = folder / sweep_manifest;
    if (!fs::exists(file)) return fresh;
    const std::string there = files::read_text(file, "the scene of a sweep");
    check_start(there, start, scene, folder);
    try {
        const io::Scene first = io::archived_scene(there, file.string());
        if (common_text(first) == common_text(scene)) return {there, numbered_points(first)};
        if (is_ramp(scene) || fresh.content.starts_with(there)) return fresh;  // the latter: its writer was killed
        io::Scene other = scene;  // with what may differ as it is there, for the message that it is another scene
        other.sweep = first.sweep;
        other.sweep.ramp = scene.sweep.ramp;
        other.sweep.keep = scene.sweep.keep;
        return {without_workers(other), {}};
    } catch (const Error& error) {
        if (error.fault() != Fault::input) throw;
        return fresh;
    }
}

/// One sweep in its folder.
struct Sweep {
    const io::Scene& scene;
    const fs::path& folder;
    Manifest manifest;
    files::RecordIdentity identity;
    SweepLayout layout = {};
    std::map<std::string, std::size_t> runs = {};  ///< by name
    std::set<std::string> damaged = {};            ///< runs whose archives cannot be read

    Sweep(const io::Scene& given, const fs::path& in)
        : scene(given),
          folder(in),
          manifest(manifest_of(given, in)),
          identity(files::identity_of("sweep", manifest.content)) {
        plan({});
    }
    /// Takes part in the folder.  Where another process has just claimed it, with other points, as it is now.
    void join() {
        const auto join_as_is = [&] { files::join_folder(folder, sweep_manifest, "", manifest.content); };
        try {
            join_as_is();
        } catch (const Error& error) {
            if (error.fault() != Fault::input) throw;
            manifest = manifest_of(scene, folder);
            identity = files::identity_of("sweep", manifest.content);
            plan({});
            join_as_is();
        }
    }
    /// With the points that results ask for.
    void plan(const Marks& marks) {
        layout = plan_sweep(scene, marks, manifest.numbered);
        runs.clear();
        for (std::size_t r = 0; r < layout.runs.size(); ++r) runs[layout.runs[r].name] = r;
    }
    /// The run of a name; nullptr: of another sweep in the folder.
    const SweepRun* find(const std::string& name) const {
        const auto found = runs.find(name);
        return found == runs.end() ? nullptr : &layout.runs[found->second];
    }
    /// A ramp passes states on by archives, which are removed at the end where only the table is kept.
    bool has_archives() const { return keeps_archives() || layout.runs.back().before.has_value(); }
    bool keeps_archives() const { return scene.sweep.keep == io::Kept::archives; }
    /// Whether a run that has ended counts: where archives are kept, with its own.
    bool holds(const SweepRun& run) const {
        return !keeps_archives() || (fs::exists(archive_of(folder, run)) && !damaged.contains(run.name));
    }
};

/// The scene of one run; on a ramp it starts from the last frame of the run before.
io::Scene scene_of(const Sweep& sweep, const SweepRun& run) {
    std::vector<std::string> overrides = run.overrides;
    if (sweep.scene.run.threads == 0) overrides.push_back("run.threads=1");
    io::Scene base = sweep.scene;
    if (run.before) {
        base.initial = io::default_start(base.kind);  // its formulas belong to the first point only
        const std::string start = run::simulation_type_of(base).start;
        overrides.push_back(start + ".kind=file");
        overrides.push_back(start + ".file=set-below");
        overrides.push_back(start + ".frame=-1");
    }
    io::Scene result = io::changed(base, overrides);
    // No overrides, which are TOML: the name of a file may have any bytes.
    result.output.file = archive_of(sweep.folder, run).string();
    std::string& first_state = io::has_grid(base.kind) ? result.initial.file : result.particles.packing.file;
    if (run.before) first_state = fs::absolute(archive_of(sweep.folder, sweep.layout.runs[*run.before])).string();
    return result;
}

/// Throws an input Error for an archive that is damaged, so that the run can be repeated; MixedFiles for another file,
/// or the archive of another run than its name says.
void require_archive(const Sweep& sweep, const SweepRun& run) {
    const fs::path path = archive_of(sweep.folder, run);
    const SourceLocation where{.file = path.string()};
    require(fs::exists(path), where, "is missing");
    const bool is_file = fs::is_regular_file(path);
    require(!is_file || fs::file_size(path) > 0, where, "is empty");
    if (!is_file || !files::is_hdf5(path))
        throw run::MixedFiles(path, text("is not the archive of {}; expected that: move this elsewhere", run.name));
    run::require_archive_of(scene_of(sweep, run), path, run::End::same);
}

/// What is wrong with an archive, in which case the run can be repeated; else "".  Throws MixedFiles.
std::string damage_of(const Sweep& sweep, const SweepRun& run) {
    try {
        require_archive(sweep, run);
    } catch (const run::MixedFiles&) {
        throw;
    } catch (const Error& error) {
        if (error.fault() != Fault::input) throw;
        return error.what();
    }
    return "";
}

/// Runs by the version of drover that made them.
using MadeBy = std::map<std::string, std::vector<std::string>>;

/// Finds those that are damaged, too.  Throws as damage_of().
MadeBy check_archives(Sweep& sweep) {
    MadeBy runs_of;
    for (const SweepRun& run : sweep.layout.runs) {
        const fs::path path = archive_of(sweep.folder, run);
        if (!fs::exists(path)) continue;
        if (damage_of(sweep, run).empty()) runs_of[run::program_of(files::ArchiveReader(path))].push_back(run.name);
        else sweep.damaged.insert(run.name);
    }
    return runs_of;
}

MadeBy recorded_versions(const Sweep& sweep, const std::vector<UnitRecord>& records) {
    MadeBy runs_of;
    for (const UnitRecord& record : records)
        if (record.state == UnitState::done && sweep.runs.contains(record.key))
            runs_of[record.program].push_back(record.key);
    return runs_of;
}

/// One for each other version that made some of the runs: on purpose, a sweep may be resumed by another.
std::vector<std::string> version_warnings(MadeBy runs_of) {
    runs_of.erase(run::this_program());
    return mapped(runs_of, [](const auto& made) {
        const auto& [version, runs] = made;
        const std::string were = runs.size() == 1 ? " was" : text(" and {} more were", runs.size() - 1);
        return other_program_text(text("{}{} made by drover {}", runs.front(), were, version), "the sweep");
    });
}

/// A warning where points differ in the modes that they keep.
std::vector<std::string> check_kept_modes(const Sweep& sweep) {
    if (!io::has_grid(sweep.scene.kind)) return {};
    std::map<int, std::string> point_of;  // by the degree
    for (SweepRun run : sweep.layout.runs) {
        run.before.reset();
        if (run.seed == 0) point_of.emplace(run::integrated_of(scene_of(sweep, run)).kept_degree, run.name);
    }
    if (point_of.size() < 2) return {};
    const auto [lowest, one] = *point_of.begin();
    const auto [highest, other] = *point_of.rbegin();
    return {
        text("{} keeps modes |k| < N/{}, {} |k| < N/{}, since the degree of their equations differs: what depends on "
             "the grid, such as a variance of white noise, changes with it; set dealiasing.degree = {} for all points",
             one, lowest + 1, other, highest + 1, highest)};
}

RunResults results_of(run::Report report) {
    if (!report.summary.note.empty()) report.warnings.push_back(report.summary.note);
    return {.rows = std::move(report.summary.rows), .warnings = std::move(report.warnings)};
}

/// Throws MixedFiles unless the archive is there from which a run of a ramp starts.
void require_start(const Sweep& sweep, const SweepRun& before) {
    const std::string damage = damage_of(sweep, before);
    if (!damage.empty())
        throw run::MixedFiles(sweep.folder, text("the next run of the ramp cannot start from {}: {}; expected its "
                                                 "archive: put it back, or repeat the sweep in another folder",
                                                 before.name, damage));
}

std::optional<UnitResult> run_one(const Sweep& sweep, const SweepRun& run) {
    const io::Scene scene = scene_of(sweep, run);
    if (!sweep.has_archives()) {
        auto report = run::run_in_memory(scene);
        if (!report) return std::nullopt;
        return encode(results_of(std::move(*report)));
    }
    if (run.before) require_start(sweep, sweep.layout.runs[*run.before]);
    std::optional<run::Report> report;
    const auto has_ended = [&](const fs::path& path) {
        require_archive(sweep, run);
        const files::ArchiveReader archive(path);
        if (archive.has("/summary/warm_up")) report = run::make_report(archive, run::Theory::omitted);
        return report.has_value();
    };
    EndedRun ran = run_or_resume(scene, false, has_ended);
    if (ran.end == RunEnd::stopped) return std::nullopt;
    return encode(results_of(std::move(ran.end == RunEnd::found ? *report : *ran.outcome.report)));
}

/// What is known of all runs.
struct Ended {
    std::map<std::string, RunResults> results;
    std::map<std::string, std::string> failures;
};

/// Plans the points that they ask for.
Ended ended_runs(Sweep& sweep, const std::vector<UnitRecord>& records) {
    if (sweep.layout.is_adaptive) {
        Marks marks;
        for (const UnitRecord& record : records)
            if (record.state == UnitState::done) marks[record.key] = marks_of(sweep.scene, decode(record.result));
        sweep.plan(marks);
    }
    Ended ended;
    for (const UnitRecord& record : records) {
        const SweepRun* run = sweep.find(record.key);
        if (run == nullptr) continue;
        if (record.state != UnitState::done) ended.failures[record.key] = record.reason;
        else if (sweep.holds(*run)) ended.results[record.key] = decode(record.result);
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

/// The part of this process in it.
class SweepWork {
public:
    SweepWork(Sweep& sweep, const JobOptions& options) : sweep_(sweep), options_(options) {}

    /// Whether a signal stopped it.
    bool run() {
        const UnitPlan plan{.wanted = [this](const Offer& offer) { want(offer); },
                            .run = [this](const std::string& key) { return run_one(sweep_, *sweep_.find(key)); },
                            .take = [this](const UnitRecord& record) { take(record); },
                            .holds =
                                [this](const UnitRecord& record) {
                                    const SweepRun* run = sweep_.find(record.key);
                                    return run == nullptr || sweep_.holds(*run);
                                }};
        return Campaign(plan, {.job = with_workers(options_, sweep_.scene.sweep.workers),
                               .identity = sweep_.identity,
                               .shares_wait = sweep_.layout.is_adaptive})
            .run()
            .stopped;
    }

private:
    bool offer_all(const Offer& offer) const {
        const std::vector<SweepRun>& runs = sweep_.layout.runs;
        for (std::size_t i = 0; i < runs.size(); ++i) {
            const SweepRun& run = runs[options_.share.nth(i, runs.size())];
            if (done_.contains(run.name) || (run.before && !done_.contains(runs[*run.before].name))) continue;
            if (!offer(run.name)) return false;
        }
        return true;
    }

    void want(const Offer& offer) {
        while (offer_all(offer) && marks_.size() > planned_marks_) {
            planned_marks_ = marks_.size();
            sweep_.plan(marks_);
            planned_done_ = static_cast<std::size_t>(
                std::ranges::count_if(done_, [this](const auto& name) { return sweep_.runs.contains(name); }));
        }
    }

    void take(const UnitRecord& record) {
        const bool is_done = record.state == UnitState::done;
        if (is_done && done_.insert(record.key).second && sweep_.runs.contains(record.key)) ++planned_done_;
        if (is_done && sweep_.layout.is_adaptive) marks_[record.key] = marks_of(sweep_.scene, decode(record.result));
        if (!record.is_new) return;
        sweep_.damaged.erase(record.key);
        if (!is_done) log_warning("{}: {}", record.key, record.reason);
        if (options_.quiet) return;
        log_information("{} of {} jobs finished: {}{}", planned_done_, sweep_.runs.size(), record.key,
                        is_done ? "" : ", which failed");
    }

    Sweep& sweep_;
    const JobOptions& options_;
    std::unordered_set<std::string> done_;
    Marks marks_;
    std::size_t planned_marks_ = 0, planned_done_ = 0;  ///< in the layout
};

void conclude_sweep(Sweep& sweep, const JobOptions& options, const std::vector<std::string>& remarks,
                    SweepOutcome& outcome) {
    Ended ended;
    const auto read = [&] {  // the records of all processes
        ended = ended_runs(sweep, campaign_records(sweep.folder, sweep.identity));
        outcome.runs = sweep.layout.runs.size();
        outcome.failures = mapped(ended.failures, [](const auto& one) { return one.first + ": " + one.second; });
        outcome.failed = outcome.failures.size();
        outcome.missing = outcome.runs - ended.results.size() - outcome.failed;
        return outcome.missing == 0 && !outcome.stopped;
    };
    conclude(options, read, [&](bool is_last) {
        outcome.table = sweep_table(sweep.layout, ended.results);
        const std::vector<std::string> unmet = unmet_targets(sweep.scene, sweep.layout, *outcome.table);
        outcome.table->warnings.insert(outcome.table->warnings.begin(), unmet.begin(), unmet.end());
        files::replace_file(sweep.folder / "table.csv", table_csv(*outcome.table));
        write_sweep_dataset(sweep.folder / "table.nc", sweep.scene, sweep.layout, ended.results, *outcome.table);
        // The command that tries failed points of a ramp again needs their starts.
        if (is_last && outcome.failed == 0 && !sweep.keeps_archives()) remove_archives(sweep);
    });
    if (outcome.table) outcome.table->warnings.insert(outcome.table->warnings.begin(), remarks.begin(), remarks.end());
}

/// All values are checked before anything runs.
void check_values(const Sweep& sweep) {
    for (SweepRun run : sweep.layout.runs) {
        run.before.reset();
        scene_of(sweep, run);
    }
    if (!sweep.scene.sweep.refine.empty())
        scene_of(sweep, {.name = "between", .overrides = finest_overrides(sweep.scene), .before = {}});
}
}  // namespace

SweepLayout plan_sweep(const io::Scene& scene) { return plan_sweep(scene, {}, numbered_points(scene)); }

SweepOutcome run_sweep(const io::Scene& scene, const JobOptions& options) {
    const fs::path& folder = options.folder;
    Sweep sweep(scene, folder);
    if (options.collect) require_folder(folder, "sweep");
    if (!options.collect && options.share.is_plain()) check_values(sweep);
    // To resume, the scene must be the same, or different runs would be mixed.
    sweep.join();
    if (sweep.has_archives() && !options.collect) files::require_locks(folder / sweep_manifest);
    SweepOutcome outcome{.table = {}};
    const std::vector<UnitRecord> records = campaign_records(folder, sweep.identity);
    if (sweep.layout.is_adaptive) ended_runs(sweep, records);  // plans what they ask for
    std::vector<std::string> remarks;
    if (options.share.is_plain())
        remarks = version_warnings(sweep.keeps_archives() ? check_archives(sweep) : recorded_versions(sweep, records));
    outcome.already_done = ended_runs(sweep, records).results.size();
    outcome.runs = sweep.layout.runs.size();
    if (options.share.is_plain()) std::ranges::move(check_kept_modes(sweep), std::back_inserter(remarks));
    if (outcome.already_done < outcome.runs && !options.collect)  // else with the table, at once
        for (const std::string& warning : remarks) log_warning("{}", warning);
    if (!options.quiet && !options.collect)
        log_information("{} points, {} runs ({} already finished) in {}", sweep.layout.points.size(), outcome.runs,
                        outcome.already_done, folder.string());
    if (!options.collect) outcome.stopped = SweepWork(sweep, options).run();
    conclude_sweep(sweep, options, remarks, outcome);
    return outcome;
}

std::string sweep_status(const io::Scene& scene, const fs::path& folder) {
    Sweep sweep(scene, folder);
    require_folder(folder, "sweep");
    const std::vector<UnitRecord> records = campaign_records(folder, sweep.identity);
    ended_runs(sweep, records);  // plans what they ask for
    return campaign_status(folder, records, mapped(sweep.layout.runs, &SweepRun::name));
}

}  // namespace drover::jobs
