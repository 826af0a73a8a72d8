// run/run_scene.cpp: start and restart of one run, a run in memory, and the time that a run takes.
#include "run/run_scene.hpp"

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <functional>
#include <utility>

#include "base/duration.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"
#include "base/memory.hpp"
#include "files/checkpoint.hpp"
#include "files/new_file.hpp"
#include "io/scene.hpp"
#include "io/units.hpp"
#include "run/fields/field_problem.hpp"
#include "run/loop/provenance.hpp"
#include "run/loop/scene_support.hpp"
#include "run/loop/signals.hpp"
#include "run/simulation_type.hpp"
#include "run/step_choice.hpp"

namespace drover::run {

namespace {
std::vector<files::Recording> recordings_of(const Simulation& simulation) {
    return mapped(simulation.recordings, &ScheduledRecording::recording);
}

Needs needs_for(const io::Scene& scene, const RunBytes& bytes) {
    std::error_code problem;
    const std::filesystem::space_info space = std::filesystem::space(files::folder_of(archive_path(scene)), problem);
    return {.memory_bytes = bytes.memory,
            .disk_bytes = bytes.disk,
            .memory_free = static_cast<double>(memory_available()),
            .disk_free = problem ? 0.0 : static_cast<double>(space.available)};
}

/// Returns the warnings that it logged.
std::vector<std::string> log_start(const io::Scene& scene, const Simulation& simulation, std::int64_t first) {
    const Needs needs = needs_for(scene, simulation.bytes);
    const std::vector<std::string> warnings = simulation_type_of(scene).warnings(scene);
    for (const std::string& warning : warnings) log_warning("{}", warning);
    log_information("{}, {} steps of dt = {} from step {}, {} thread{}", simulation_type_of(scene).size(scene),
                    simulation.steps, io::in_unit("{}", simulation.dt, "s", scene.units), first, simulation.threads,
                    simulation.threads == 1 ? "" : "s");
    if (const auto& [by, pilot] = scene.found.step; by != io::ChosenBy::given)
        log_information("time.dt = {} was chosen: {}", io::in_unit("{}", scene.time.dt, "s", scene.units),
                        pilot.empty() ? "the model is linear, and every step exact" : pilot);
    log_information("memory {}, at most {} on disk ({} free)", bytes_text(needs.memory_bytes),
                    bytes_text(needs.disk_bytes), bytes_text(needs.disk_free));
    if (const std::optional<std::string> warning = disk_warning(needs)) log_warning("{}", *warning);
    return warnings;
}

RunOutcome finish(const io::Scene& scene, const LoopOutcome& loop, const std::filesystem::path& path, double dt,
                  files::Archive& archive, bool quiet, const std::vector<std::string>& logged) {
    std::optional<Report> report;
    if (loop.signal == 0) {
        archive.commit();  // throws if another program has removed the file
        report = make_report(files::ArchiveReader(path, files::ArchiveReader::Writer::this_process), scene,
                             Theory::included);
        archive.replace(result_table(*report));
        archive.commit();
        if (!quiet)
            for (const std::string& warning : report->warnings)
                if (std::ranges::find(logged, warning) == logged.end()) log_warning("{}", warning);
    }
    std::error_code problem;
    return {.loop = loop,
            .archive = path,
            .archive_megabytes = static_cast<double>(std::filesystem::file_size(path, problem)) / 1e6,
            .checkpoint_time = static_cast<double>(loop.step) * dt,
            .report = std::move(report)};
}

/// The rounding of floating-point operations while it lives.
class Rounding {
public:
    explicit Rounding(bool up) : before_(std::fegetround()) {
        if (up) std::fesetround(FE_UPWARD);
    }
    ~Rounding() { std::fesetround(before_); }
    Rounding(const Rounding&) = delete;
    Rounding& operator=(const Rounding&) = delete;

private:
    int before_;
};

/// Keys that a restart may change.
constexpr std::array changeable{"time.end", "output.checkpoint_minutes", "run.threads"};

/// The scene in an archive, `stored`, with changes.
io::Scene changed_scene(const std::string& stored, const std::filesystem::path& archive,
                        std::span<const std::string> overrides, const RunOptions& options) {
    const std::string name = archive.string() + " (its scene)";
    for (const std::string& setting : overrides)
        if (std::ranges::find(changeable, setting.substr(0, setting.find('='))) == changeable.end())
            fail_input({.file = "--set " + setting},
                       "a restart can change only time.end, output.checkpoint_minutes and run.threads; for another "
                       "scene start a new run with {}.kind = \"file\"",
                       simulation_type_of(io::parse_scene(stored, name, {}, options.functions)).start);
    return io::parse_scene(stored, name, overrides, options.functions);
}

/// From step `first`, at which the simulation is, in its archive.  Stops at the signals, which it releases at the end.
RunOutcome run_and_finish(const io::Scene& scene, Simulation& simulation, std::int64_t first, files::Archive& archive,
                          const std::string& run_id, std::optional<StopSignals>& signals, const RunOptions& options) {
    std::vector<std::string> logged;
    if (!options.quiet) logged = log_start(scene, simulation, first);
    const LoopFiles files{.archive = archive_path(scene),
                          .scene = io::resolved_text(scene),
                          .checkpoint_minutes = scene.output.checkpoint_minutes,
                          .run_id = run_id,
                          .program = this_program()};
    const LoopOutcome loop = [&] {
        const Rounding rounding(options.rounds_up);
        return run_loop(simulation, first, archive, files, options.quiet);
    }();
    signals.reset();  // what follows can be repeated by a restart
    return finish(scene, loop, files.archive, simulation.dt, archive, options.quiet, logged);
}

RunOutcome run_from_start(const io::Scene& scene, const RunOptions& options) {
    Threads threads(simulation_type_of(scene).threads(scene));
    const std::unique_ptr<Simulation> made = simulation_type_of(scene).make(scene, threads, {});
    const std::filesystem::path path = archive_path(scene);
    std::optional<StopSignals> signals(std::in_place);
    std::vector<files::Attribute> attributes = provenance(scene, threads.count());
    const std::string run_id = files::draw_run_id();
    attributes.emplace_back(files::run_id_name, run_id);
    files::Archive archive = files::Archive::create(path, recordings_of(*made), attributes, options.overwrite);
    files::remove_checkpoints(path);  // of an archive that was replaced
    try {
        return run_and_finish(scene, *made, 0, archive, run_id, signals, options);
    } catch (...) {
        if (!files::has_checkpoint(path)) archive.remove();  // not started: leave no files
        throw;
    }
}

/// The scene of an archive that was created and holds at most the first rows: its run was killed before it had a
/// checkpoint.
std::optional<io::Scene> scene_not_begun(const std::filesystem::path& path, std::span<const std::string> overrides,
                                         const RunOptions& options) {
    if (!files::is_hdf5(path) || files::has_checkpoint(path)) return std::nullopt;
    const files::ArchiveReader archive(path);
    if (files::run_id_of(archive).empty() || archive.has("/summary/warm_up")) return std::nullopt;
    for (const files::StoredArray& array : archive.contents().arrays)
        if (array.path.ends_with("/time") && array.shape.at(0) > 1) return std::nullopt;
    io::Scene scene = changed_scene(archive.text_attribute("scene"), path, overrides, options);
    scene.file = (files::folder_of(path) / archive.text_attribute("scene_file")).string();
    scene.output.file = path.string();
    return scene;
}

/// What `read` returns.  Files that another version of drover wrote may differ from what this one expects: then an
/// input Error says so.
template <class Read>
auto read_of_version(const std::string& program, const std::filesystem::path& path, Read read) try {
    return read();
} catch (const MixedFiles&) {
    throw;
} catch (const Error& error) {
    if (error.fault() != Fault::input || program.empty() || program == this_program()) throw;
    fail_input({.file = path.string()},
               "the run was written by another version of drover, {}, and {} cannot resume it: {}; restart with that "
               "version, or run the scene again",
               program, this_program(), error.message());
}

/// As run_loop().  False when a signal stopped it.
bool run_to_end(Simulation& simulation, Arrays& arrays) {
    // The rows that are due, or the others; without frames of fields, of which reports use none.
    const auto append = [&](std::int64_t step, bool due) {
        for (const ScheduledRecording& scheduled : simulation.recordings)
            if (is_due(scheduled, step) == due && (scheduled.recording.group != "/" || scheduled.recording.trajectory))
                append_row(scheduled, static_cast<double>(step) * simulation.dt, arrays);
    };
    simulation.check_health(0);
    append(0, true);
    for (std::int64_t step = 0; step < simulation.steps;) {
        if (stop_signal() != 0) return false;
        simulation.advance(step++);
        if (is_checked(simulation, step)) simulation.check_health(step);
        append(step, true);
    }
    append(simulation.steps, false);
    return true;
}

// ---- Timing

constexpr double seconds_of_steps = 0.2;
constexpr int max_steps = 50;

double seconds_of(const std::function<void()>& action) {
    const auto start = Clock::now();
    action();
    return seconds_since(start);
}

/// Rows of a recording in the whole run.
double rows(const ScheduledRecording& recording, std::int64_t steps) {
    return recording.every == 0 ? 2.0
                                : 1.0 + std::floor(static_cast<double>(steps) / static_cast<double>(recording.every));
}
}  // namespace

std::filesystem::path archive_path(const io::Scene& scene) {
    if (!scene.output.file.empty()) return scene.output.file;
    return std::filesystem::path(scene.file).stem().concat(".h5");
}

Needs needs_of(const io::Scene& given) {
    const io::Scene scene = io::with_step(given);
    return needs_for(scene, simulation_type_of(scene).bytes(scene));
}

std::optional<std::string> disk_warning(const Needs& needs) {
    if (needs.disk_bytes <= needs.disk_free) return std::nullopt;
    return text(
        "the archive may need {}, but only {} are free: the run will stop when the disk is full; write to another "
        "disk or less often",
        bytes_text(needs.disk_bytes), bytes_text(needs.disk_free));
}

std::optional<ExpectedTime> expected_time(const io::Scene& scene) {
    const SimulationType& kind = simulation_type_of(scene);
    const auto [timed, larger] = kind.timed(scene);
    try {
        Threads threads(kind.threads(scene));
        const std::unique_ptr<Simulation> made = kind.make(timed, threads, {});
        Simulation& simulation = *made;
        std::int64_t step = 0;
        const auto advance = [&] { simulation.advance(step++); };
        const auto last = std::min<std::int64_t>(simulation.steps, max_steps);
        if (last > 1) advance();  // the first step touches all memory
        std::vector<double> times;
        double spent = 0.0;
        while (times.empty() || (step < last && spent < seconds_of_steps)) {
            times.push_back(seconds_of(advance));
            spent += times.back();
        }
        std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
        ExpectedTime result{.step = larger * times[times.size() / 2], .scaled = larger > 1.0};
        result.total = result.step * static_cast<double>(simulation.steps);
        for (const ScheduledRecording& recording : simulation.recordings)
            result.total += larger * rows(recording, simulation.steps) * seconds_of([&] { recording.observe(); });
        return result;
    } catch (const Error&) {
        return std::nullopt;  // the run itself reports the error
    }
}

void check_memory(const io::Scene& scene) {
    const Needs needs = needs_of(scene);
    const SimulationType& kind = simulation_type_of(scene);
    if (needs.memory_bytes > needs.memory_free)
        throw Error(Fault::unavailable, io::locate(scene, kind.size_key),
                    text("{} {} needs {} of memory, and {} are free; choose a smaller {}", kind.body, kind.size(scene),
                         bytes_text(needs.memory_bytes), bytes_text(needs.memory_free),
                         io::has_grid(scene.kind) ? "grid" : "cell"));
}

void check_needs(const io::Scene& scene, const RunOptions& options) {
    check_memory(scene);
    check_result_names(scene);
    const std::filesystem::path path = archive_path(scene);
    check_output({.path = path,
                  .where = io::locate(scene, "output.file"),
                  .name = text("output.file = \"{}\"", path.string()),
                  .overwrite = options.overwrite},
                 inputs_of(scene));
    files::require_checkpoint_names(path, io::locate(scene, "output.file"));
}

RunOutcome run_scene(const io::Scene& given, const RunOptions& options) {
    check_needs(given, options);
    const io::Scene scene = [&] {
        const StopSignals signals;
        return with_chosen_step(given, options.quiet);
    }();
    RunOptions attempt = options;
    return with_halved_steps(scene, options.quiet, [&](const io::Scene& halved) {
        const RunOptions now = attempt;
        attempt.overwrite = true;
        return run_from_start(halved, now);
    });
}

RunOutcome restart_run(const std::filesystem::path& path, std::span<const std::string> overrides,
                       const RunOptions& options) {
    if (const auto scene = scene_not_begun(path, overrides, options)) {
        if (!options.quiet) log_information("{} has no checkpoint yet: the run starts anew", path.string());
        RunOptions anew = options;
        anew.overwrite = true;
        return run_scene(*scene, anew);
    }
    const files::Checkpoint checkpoint = files::read_newest_checkpoint(path);
    io::Scene scene = changed_scene(checkpoint.scene, path, overrides, options);
    scene.output.file = path.string();
    Threads threads(simulation_type_of(scene).threads(scene));
    files::ArchiveReader{path};  // throws what is wrong with the file itself
    const std::unique_ptr<Simulation> made = read_of_version(checkpoint.program, path, [&] {
        return simulation_type_of(scene).make(scene, threads, checkpoint.state);
    });
    require(checkpoint.step <= made->steps, {.file = path.string()},
            "the run has reached t = {}, beyond time.end = {}; to continue, give a later end: --set time.end=...",
            io::in_unit("{:.10g}", checkpoint.time, "s", scene.units), scene.time.end);
    const std::vector<std::size_t> rows(checkpoint.rows.begin(), checkpoint.rows.end());
    std::optional<StopSignals> signals(std::in_place);
    std::vector<files::Attribute> attributes = provenance(scene, threads.count());
    const auto check_and_keep_names = [&](const files::ArchiveReader& reader) {
        require_same_run(reader, path, checkpoint);
        for (auto& [name_of, value] : attributes)  // the archive knows the file of its scene
            if (name_of == "title" || name_of == "scene_file") value = reader.text_attribute(name_of);
    };
    files::Archive archive = read_of_version(checkpoint.program, path, [&] {
        return files::Archive::resume(path, recordings_of(*made), attributes, rows, check_and_keep_names);
    });
    if (archive.row_checksums() != checkpoint.row_checksums)
        throw MixedFiles(path, text("the frames and samples up to t = {} are not those that the run had when it "
                                    "wrote its checkpoint; expected the archive as the run left it: put it back, or "
                                    "run the scene again",
                                    io::in_unit("{}", checkpoint.time, "s", scene.units)));
    return run_and_finish(scene, *made, checkpoint.step, archive, checkpoint.run_id, signals, options);
}

std::optional<Report> run_in_memory(const io::Scene& given) {
    check_memory(given);
    return with_halved_steps(with_chosen_step(given, true), true, [](const io::Scene& scene) -> std::optional<Report> {
        Threads threads(simulation_type_of(scene).threads(scene));
        const std::unique_ptr<Simulation> simulation = simulation_type_of(scene).make(scene, threads, {});
        Arrays arrays;
        if (!run_to_end(*simulation, arrays)) return std::nullopt;
        return simulation_type_of(scene).report(files::ArchiveReader(std::move(arrays)), scene, Theory::omitted);
    });
}

}  // namespace drover::run
