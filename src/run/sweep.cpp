// run/sweep.cpp: runs of a sweep on local workers, resumable, and their table.
#include "drover/run/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "drover/base/log.hpp"
#include "drover/base/threads.hpp"
#include "drover/files/new_file.hpp"
#include "drover/files/record_file.hpp"
#include "drover/io/scene_text.hpp"
#include "drover/measure/trajectories.hpp"
#include "drover/run/exit_status.hpp"
#include "drover/run/kind.hpp"
#include "drover/run/provenance.hpp"
#include "drover/run/run_scene.hpp"
#include "drover/run/worker_pool.hpp"
#include "run/same_run.hpp"

namespace drover::run {

namespace {
namespace fs = std::filesystem;

fs::path archive_of(const fs::path& folder, const SweepRun& run) { return folder / (run.name + ".h5"); }

bool is_done(const fs::path& folder, const SweepRun& run) {
    const fs::path path = archive_of(folder, run);
    return fs::exists(path) && files::ArchiveReader(path).has("/summary/warm_up");
}

/// The scene of one run; on a ramp it starts from the last frame of the run before.
io::Scene scene_of(const io::Scene& scene, const fs::path& folder, const SweepRun& run, const SweepRun* before) {
    std::vector<std::string> overrides = run.overrides;
    if (scene.run.threads == 0) overrides.push_back("run.threads=1");
    io::Scene base = scene;
    if (before != nullptr) {
        base.initial = {};  // its formulas belong to the first point only
        const std::string start = kind_of(scene).start;
        overrides.push_back(start + ".kind=file");
        overrides.push_back(start + ".file=set-below");
        overrides.push_back(start + ".frame=-1");
    }
    io::Scene result = io::parse_scene(io::resolved_text(base), scene.file, overrides);
    // No overrides, which are TOML: the name of a file may have any bytes.
    result.output.file = archive_of(folder, run).string();
    std::string& first_state = io::has_grid(scene.kind) ? result.initial.file : result.particles.packing.file;
    if (before != nullptr) first_state = fs::absolute(archive_of(folder, *before)).string();
    return result;
}

/// Throws an input Error for an archive in the folder that is of another run than its name says.  Returns a warning for
/// each other version of drover that made some of them: on purpose, a sweep may be resumed by another.
std::vector<std::string> check_archives(const io::Scene& scene, const fs::path& folder, const SweepLayout& layout) {
    std::map<std::string, std::vector<std::string>> runs_of;  // by version
    for (const auto& chain : layout.chains)
        for (std::size_t i = 0; i < chain.size(); ++i)
            if (const fs::path path = archive_of(folder, chain[i]); fs::exists(path)) {
                require_archive_of(scene_of(scene, folder, chain[i], i == 0 ? nullptr : &chain[i - 1]), path);
                runs_of[program_of(files::ArchiveReader(path))].push_back(chain[i].name);
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

/// `at`: the name of the run that it is at.
int run_chain(const io::Scene& scene, const fs::path& folder, const std::vector<SweepRun>& chain, std::string& at) {
    for (std::size_t i = 0; i < chain.size(); ++i) {
        if (is_done(folder, chain[i])) continue;
        at = chain[i].name;
        const fs::path path = archive_of(folder, chain[i]);
        const RunOptions options{.overwrite = true, .quiet = true};
        const bool resumable = fs::exists(path) && has_checkpoint(path);
        const RunOutcome outcome =
            resumable ? restart_run(path, {}, options)
                      : run_scene(scene_of(scene, folder, chain[i], i == 0 ? nullptr : &chain[i - 1]), options);
        if (outcome.loop.signal != 0) return exit_stopped;
    }
    return exit_done;
}

/// Mean over the seeds of a point.  The runs are independent: their errors add in quadrature; from eight seeds on, the
/// spread between them is the better estimate.
measure::Estimate over_seeds(const std::vector<measure::Estimate>& runs) {
    if (runs.empty())
        return {.mean = std::numeric_limits<double>::quiet_NaN(),
                .refusal = "no run of this point has this observable"};
    measure::Estimate result;
    const double count = static_cast<double>(runs.size());
    double squares = 0.0;
    bool all_errors = true;
    for (const measure::Estimate& run : runs) {
        result.mean += run.mean / count;
        result.autocorrelation_time += run.autocorrelation_time / count;
        result.warm_up = std::max(result.warm_up, run.warm_up);
        result.samples += run.samples;
        if (run.error) squares += *run.error * *run.error;
        all_errors = all_errors && run.error.has_value();
        if (!run.refusal.empty()) result.refusal = run.refusal;
    }
    if (runs.size() >= measure::min_blocks) {
        squares = 0.0;
        for (const measure::Estimate& run : runs) squares += (run.mean - result.mean) * (run.mean - result.mean);
        result.error = std::sqrt(squares / (count * (count - 1.0)));
        result.refusal.clear();
    } else if (all_errors) {
        result.error = std::sqrt(squares) / count;
    }
    result.blocks = runs.size();
    return result;
}

/// The relaxation time of a point is the inverse of its mean rotational diffusion: the inverse of a single short run is
/// too noisy.
void invert_diffusion(const std::vector<std::string>& names, std::vector<measure::Estimate>& estimates) {
    const auto column = [&](const char* name) {
        return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    };
    const std::size_t from = column("rotational_diffusion"), to = column("relaxation_time");
    if (from >= estimates.size() || to >= estimates.size()) return;
    estimates[to] = measure::relaxation_time_of(estimates[from]);
}

/// Whether the scatter of seeds contradicts their errors: chi square far beyond its mean.  The limit is that of one in
/// two thousand for two seeds.
bool contradicts_errors(const std::vector<measure::Estimate>& runs) {
    double weights = 0.0, mean = 0.0, square = 0.0;
    for (const measure::Estimate& run : runs) {
        if (!run.error || !(*run.error > 0.0)) return false;
        const double weight = 1.0 / (*run.error * *run.error);
        weights += weight;
        mean += weight * run.mean;
    }
    mean /= weights;
    for (const measure::Estimate& run : runs) square += std::pow((run.mean - mean) / *run.error, 2);
    const double freedom = static_cast<double>(runs.size()) - 1.0;
    constexpr double limit = 8.0;  // deviations of chi square
    return freedom > 0.0 && square > freedom + limit * std::sqrt(2.0 * freedom);
}

void add_contradictions(const std::vector<std::vector<measure::Estimate>>& found, const SweepPoint& point,
                        SweepTable& table) {
    std::vector<std::string> names;
    for (std::size_t column = 0; column < found.size(); ++column)
        if (contradicts_errors(found[column])) names.push_back(table.names[column]);
    if (names.empty()) return;
    std::string at;
    for (std::size_t k = 0; k < point.values.size(); ++k)
        at += text("{}{} = {:.6g}", k == 0 ? "" : ", ", table.keys[k], point.values[k]);
    table.warnings.push_back(
        text("at {}: the seeds differ by far more than their errors in {}; the runs are shorter than their slowest "
             "change, or end in different states: give longer runs, or 8 seeds or more, whose scatter is then the "
             "error",
             at, joined(names)));
}

SweepTable collect(const SweepLayout& layout, const fs::path& folder) {
    SweepTable table{.keys = layout.keys, .names = {}, .units = {}, .rows = {}};
    std::vector<std::vector<std::vector<measure::Estimate>>> found(layout.points.size());  // [point][observable][seed]
    std::vector<int> seeds(layout.points.size(), 0);
    for (const auto& chain : layout.chains)
        for (const SweepRun& run : chain) {
            if (!is_done(folder, run)) continue;
            ++seeds[run.point];
            const Report report = make_report(files::ArchiveReader(archive_of(folder, run)), Theory::omitted);
            for (const std::string& warning : report.warnings) table.warnings.push_back(run.name + ": " + warning);
            for (const measure::SummaryRow& row : report.summary.rows) {
                if (!row.axes.empty()) continue;
                // By name: runs may differ in their observables, such as those of beads.
                const auto named = std::find(table.names.begin(), table.names.end(), row.name);
                const auto column = static_cast<std::size_t>(named - table.names.begin());
                if (named == table.names.end()) {
                    table.names.push_back(row.name);
                    table.units.push_back(row.unit);
                }
                if (found[run.point].size() <= column) found[run.point].resize(column + 1);
                found[run.point][column].push_back(row.estimates.front());
            }
        }
    for (std::size_t point = 0; point < layout.points.size(); ++point) {
        SweepRow row{.point = layout.points[point], .seeds = seeds[point], .estimates = {}};
        if (row.seeds > 0) found[point].resize(table.names.size());
        for (const auto& runs : found[point]) row.estimates.push_back(over_seeds(runs));
        add_contradictions(found[point], row.point, table);
        invert_diffusion(table.names, row.estimates);
        table.rows.push_back(std::move(row));
    }
    return table;
}
}  // namespace

SweepOutcome run_sweep(const io::Scene& scene, const fs::path& folder, bool quiet) {
    const SweepLayout layout = plan_sweep(scene);
    SweepOutcome outcome;
    for (const auto& chain : layout.chains)
        for (const SweepRun& run : chain) {
            scene_of(scene, folder, run, nullptr);  // all values are checked before anything runs
            ++outcome.runs;
        }
    // To resume, the scene must be the same, or different runs would be mixed.  Workers keep the lock.
    const files::ClaimedFolder claimed = files::claim_folder(folder, "sweep.toml", "", io::resolved_text(scene));
    const std::vector<std::string> versions = check_archives(scene, folder, layout);
    for (const auto& chain : layout.chains)
        outcome.already_done += static_cast<std::size_t>(
            std::count_if(chain.begin(), chain.end(), [&](const SweepRun& run) { return is_done(folder, run); }));
    const int workers = scene.sweep.workers > 0 ? scene.sweep.workers : usable_cores();
    if (outcome.already_done < outcome.runs)  // else with the table, at once
        for (const std::string& warning : versions) log_warning("{}", warning);
    if (!quiet)
        log_information("{} points, {} runs ({} already finished), {} simultaneous, in {}", layout.points.size(),
                        outcome.runs, outcome.already_done, workers, folder.string());
    std::size_t started = 0, ended = 0;
    const Jobs jobs{.next = [&]() -> std::optional<std::size_t> {
                        if (started == layout.chains.size()) return std::nullopt;
                        return started++;
                    },
                    .work =
                        [&](std::size_t job, std::string& reason) {
                            std::string at;
                            try {
                                return run_chain(scene, folder, layout.chains[job], at);
                            } catch (const Error& error) {
                                reason = text("{}: {}", at, error.what());
                                throw;
                            }
                        },
                    .ended =
                        [&](std::size_t job, int status, const std::string& reason) {
                            const std::string& name = layout.chains[job].back().name;
                            ++ended;
                            if (status != exit_done && status != exit_stopped)
                                outcome.failures.push_back(
                                    reason.empty() ? text("{}: its process ended with status {}", name, status)
                                                   : reason);
                            if (!quiet)
                                log_information("{} of {} jobs finished: {}{}", ended, layout.chains.size(), name,
                                                status == 0 ? "" : text(" with status {}", status));
                        }};
    const PoolOutcome pool = run_jobs(jobs, {.workers = workers});
    outcome.stopped = pool.stopped;
    outcome.failed = pool.stopped ? 0 : pool.failed;
    outcome.table = collect(layout, folder);
    outcome.table.warnings.insert(outcome.table.warnings.begin(), versions.begin(), versions.end());
    files::replace_file(folder / "table.csv", table_csv(outcome.table));
    return outcome;
}

std::string table_text(const SweepTable& table) {
    // The columns of a phase diagram; table.csv has all of them.
    std::vector<std::size_t> chosen;
    for (const char* name : {"polar_order", "polar_order_susceptibility", "polar_order_binder"})
        for (std::size_t i = 0; i < table.names.size(); ++i)
            if (table.names[i] == name) chosen.push_back(i);
    if (chosen.empty())  // a model of its own: the order and the pattern of each field
        for (std::size_t i = 0; i < table.names.size(); ++i)
            if (table.names[i].starts_with("size_mean_") || table.names[i].starts_with("variance_"))
                chosen.push_back(i);
    std::string out;
    for (const std::string& warning : table.warnings) out += "warning: " + warning + "\n";
    for (const std::string& key : table.keys) out += text("{:>20} ", key);
    out += text("{:>6} {:>5}", "branch", "seeds");
    for (const std::size_t i : chosen) out += text(" {:>26} {:>9}", table.names[i], "error");
    out += '\n';
    for (const SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{:>20.6g} ", value);
        out += text("{:>6} {:>5}", row.point.branch.empty() ? "-" : row.point.branch, row.seeds);
        for (const std::size_t i : chosen) {
            if (i >= row.estimates.size()) out += text(" {:>26} {:>9}", "-", "-");
            else
                out += text(" {:>26} {:>9}", measured_text(row.estimates[i].mean, row.estimates[i].error.value_or(0.0)),
                            row.estimates[i].error ? text("{:.2g}", *row.estimates[i].error) : "-");
        }
        out += '\n';
    }
    return out;
}

std::string table_csv(const SweepTable& table) {
    std::string out;
    for (const std::string& key : table.keys) out += key + ",";
    out += "branch,seeds";
    for (std::size_t i = 0; i < table.names.size(); ++i)
        out += text(",{} [{}],{} error", table.names[i], table.units[i], table.names[i]);
    out += '\n';
    for (const SweepRow& row : table.rows) {
        for (const double value : row.point.values) out += text("{},", value);
        out += text("{},{}", row.point.branch, row.seeds);
        for (const measure::Estimate& estimate : row.estimates)
            out += text(",{},{}", estimate.mean, estimate.error ? text("{}", *estimate.error) : "");
        out += '\n';
    }
    return out;
}

}  // namespace drover::run
