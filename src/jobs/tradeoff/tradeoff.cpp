// jobs/tradeoff/tradeoff.cpp: what was found of a trade of speed for accuracy, for people and for programs.
#include "jobs/tradeoff/tradeoff.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/log.hpp"
#include "drover/base/error.hpp"
#include "files/new_file.hpp"
#include "files/record_folder.hpp"
#include "jobs/tradeoff/trade_front.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/loop/provenance.hpp"
#include "run/run_scene.hpp"
#include "run/step_choice.hpp"

namespace drover::jobs {

namespace {
namespace fs = std::filesystem;

constexpr double much_better = 0.1;     // of the error allowed
constexpr double little_to_save = 1.0;  // core seconds of the run as given

/// The parts of an error that have a name of their own, and what is said where one is the largest.
struct NamedPart {
    const char* name;
    double size;
    const char* advice;
};

std::vector<NamedPart> named_parts(const Parts& parts) {
    const auto size = [](const Bias& bias) { return std::abs(bias.value) + 2.0 * bias.error; };
    return {{"statistics", 2.0 * parts.statistics,
             "statistics limit it: a shorter step or a finer grid is wasted; four times the duration halves the error"},
            {"step", size(parts.step),
             "the step limits it: a longer run is wasted; a shorter step or a method of higher order helps"},
            {"grid", size(parts.grid),
             "the grid limits it: a longer run or a shorter step is wasted; trials have at most twice the points of "
             "the scene: give it a finer grid"},
            {"model", size(parts.model), "the simpler model limits it: only a fuller model is more accurate"}};
}

/// The target of a candidate with the largest error for what it allows.
std::size_t hardest_target(const Findings& found, const Candidate& one) {
    std::size_t hardest = 0;
    for (std::size_t w = 1; w < one.parts.size(); ++w)
        if (one.parts[w].bound() / found.allowed[w] > one.parts[hardest].bound() / found.allowed[hardest]) hardest = w;
    return hardest;
}

std::string advice_on(const Findings& found, const Candidate& one) {
    const std::vector<NamedPart> parts = named_parts(one.parts[hardest_target(found, one)]);
    return std::ranges::max_element(parts, {}, &NamedPart::size)->advice;
}

std::string unit_text(const Findings& found, std::size_t target) {
    return found.units[target] == "1" ? "" : " " + found.units[target];
}

/// A fraction of the number, or where the target is absolute the number of its unit.
std::string error_text(const Findings& found, std::size_t target, double error) {
    if (found.targets[target].is_relative)
        return text("{:.2g} %", 100.0 * error / std::abs(found.references[target].value));
    return text("{:.2g}{}", error, unit_text(found, target));
}

std::string grid_name(const Candidate& one) {
    return one.model->level.has_one_row ? one.grid->level.name_of_row : one.grid->level.name;
}

run::Record candidate_record(const Findings& found, const Candidate& one) {
    const std::size_t target = hardest_target(found, one);
    const Parts& parts = one.parts[target];
    const bool theory = one.step == nullptr;
    run::Record row{
        .entries = {run::number("cost", "s", "core time, predicted", one.seconds, 3),
                    run::number("error_of_allowed", "1",
                                "the largest error of a target, with a probability of 95 %, over what it allows",
                                one.ratio, 2),
                    run::words("model", "", theory ? "linear theory" : one.model->level.name),
                    run::words("grid", "", theory ? "-" : grid_name(one)),
                    run::words("step", "", theory ? "-" : one.step->level.name),
                    run::words("duration", "",
                               theory              ? "-"
                               : found.statistical ? time_text(found, one.end)
                                                   : "as given")}};
    for (const auto& [name, size, advice] : named_parts(parts))
        row.entries.push_back(run::number(std::string(name) + "_error", found.units[target],
                                          "part of the error, with twice its standard error", size, 2));
    row.entries.push_back(
        run::flag("checked", "1: the biases are those of a trial of this combination", parts.whole.has_value()));
    if (found.targets.size() > 1)
        row.entries.push_back(run::words("hardest", "the target of these parts", found.targets[target].text));
    return row;
}

/// The front of each model that saves time.
run::List model_fronts(const Findings& found, const io::Scene& scene) {
    run::List list{.name = "by_model",
                   .heading = "the front of each model",
                   .row = "model_setting",
                   .meaning = "settings of each model, cheapest first",
                   .shown = {.text = false}};
    for (const LevelFound& model : found.models)
        for (const Candidate& one : front_of(found, scene, &model)) list.rows.push_back(candidate_record(found, one));
    return list;
}

run::List front_list(const Findings& found, const std::vector<Candidate>& front) {
    run::List list{.name = "front",
                   .heading = "the cheapest settings for their error (parts: of the target that is hardest for them)",
                   .row = "setting",
                   .meaning = "settings, cheapest first"};
    for (const Candidate& one : front) {
        list.rows.push_back(candidate_record(found, one));
        if (one.ratio < much_better) break;  // the rest is among those of the models
    }
    return list;
}

/// As much of a sentence as a column of a table has room for.
std::string short_text(const std::string& sentence) {
    constexpr std::size_t max_length = 60;
    return sentence.size() <= max_length ? sentence : sentence.substr(0, sentence.rfind(' ', max_length)) + " ...";
}

void add_levels(const Findings& found, const std::string& axis, const std::vector<LevelFound>& levels,
                run::List& list) {
    for (const LevelFound& level : levels) {
        run::Record row{.entries = {run::words("axis", "", axis), run::words("level", "", level.level.name)}};
        for (std::size_t w = 0; w < found.targets.size(); ++w) {
            const std::string name = found.targets.size() == 1 ? "" : text("_{}", w + 1);
            const Bias bias = level.outcome.state == LevelState::measured ? level.biases[w] : Bias{NAN, NAN};
            row.entries.push_back(
                run::number("bias" + name, found.units[w], "of " + found.targets[w].text, bias.value, 3));
            row.entries.push_back(
                run::number("error" + name, found.units[w], "standard error of the bias", bias.error, 2));
        }
        row.entries.push_back(run::number("per_second", "1",
                                          "core seconds per second of the scene; of grids and models relative to the "
                                          "given one",
                                          level.is_measured() ? level.step_seconds : NAN, 3));
        row.entries.push_back(run::words("remark", "", short_text(text_of(level.outcome))));
        list.rows.push_back(std::move(row));
    }
}

run::List level_list(const Findings& found) {
    run::List list{.name = "levels",
                   .heading = text("what each level does alone, on {}", found.grids[found.pilot_grid].level.name),
                   .row = "level",
                   .meaning = "levels of each axis"};
    for (const std::vector<LevelFound>& ladder : found.ladders) add_levels(found, "step", ladder, list);
    add_levels(found, "grid", found.grids, list);
    add_levels(found, "model", found.models, list);
    if (found.linear_theory)
        add_levels(
            found, "model",
            {{.level = {.name = "linear theory", .overrides = {}}, .outcome = {}, .biases = *found.linear_theory}},
            list);
    return list;
}

run::List target_list(const Findings& found, const Candidate* best) {
    run::List list{
        .name = "wishes", .heading = "wanted", .row = "wish", .meaning = "wanted numbers", .has_like_rows = false};
    for (std::size_t w = 0; w < found.targets.size(); ++w) {
        const auto bias_or_nan = [&](const std::vector<Bias>& biases) {
            return biases.empty() ? NAN : biases[w].value;
        };
        const std::string& unit = found.units[w];
        list.rows.push_back(
            {.entries = {run::words("observable", "", found.targets[w].text),
                         {.name = "value",
                          .unit = unit,
                          .meaning = "best value of the trials",
                          .value = measured_text(found.references[w].value, found.references[w].error)},
                         run::data_only(run::number("error", unit, "its standard error", found.references[w].error)),
                         run::number("allowed", unit, "error", found.allowed[w], 2),
                         run::number("expected", unit, "error of the recommended run, with a probability of 95 %",
                                     best == nullptr ? NAN : best->parts[w].bound(), 2),
                         run::number("rounding", unit, "change of the value when all operations round up",
                                     bias_or_nan(found.rounding), 2),
                         run::number("cell", unit,
                                     "value less that in a cell of twice the sides: not an error of the run",
                                     bias_or_nan(found.cell), 2),
                         run::number("cell_error", unit, "its standard error",
                                     found.cell.empty() ? NAN : found.cell[w].error, 2)}});
    }
    return list;
}

std::string why_none(const Findings& found, const std::vector<Candidate>& front, double budget) {
    const Candidate *enough = nullptr, *affordable = nullptr;
    for (const Candidate& one : front) {
        if (one.step == nullptr) continue;
        if (enough == nullptr && one.ratio <= 1.0) enough = &one;
        if (one.seconds <= budget) affordable = &one;
    }
    const bool is_limited = std::isfinite(budget);
    std::string words = is_limited ? text("no setting meets the targets within {}", duration_text(budget))
                                   : "no setting that the trials could judge meets the targets";
    if (enough != nullptr) words += text(": it takes {} of a core", duration_text(enough->seconds));
    if (affordable != nullptr)
        words += text("; the best {}has {:.2g} times the error allowed ({}, {}, {}, {})",
                      is_limited ? "within it " : "", affordable->ratio, affordable->model->level.name,
                      grid_name(*affordable), affordable->step->level.name, time_text(found, affordable->end));
    if (affordable != nullptr) words += "; " + advice_on(found, *affordable);
    if (found.is_short) words += "; some trials were not made for want of budget: re-run the same command to resume";
    return words + (is_limited
                        ? "; give a larger --budget or a larger error"
                        : "; give a larger error, or look for settings by drover tradeoff with a larger --budget");
}

/// What is said of the recommended run.
std::vector<std::string> reasons(const Findings& found, const std::vector<Candidate>& front, const Candidate& best) {
    std::vector<std::string> words;
    for (std::size_t w = 0; w < found.targets.size(); ++w)
        words.push_back(
            text("{}: error {} of {} allowed, with a probability of 95 %; {}{} in trials", found.targets[w].text,
                 error_text(found, w, best.parts[w].bound()), error_text(found, w, found.allowed[w]),
                 measured_text_with_error(found.references[w].value, found.references[w].error), unit_text(found, w)));
    words.insert(words.end(), found.notes.begin(), found.notes.end());
    const std::size_t w = hardest_target(found, best);
    const Parts& parts = best.parts[w];
    const auto part = [&](const Bias& bias) {
        return text("{} +- {}", error_text(found, w, std::abs(bias.value)), error_text(found, w, bias.error));
    };
    words.push_back(is_given(best.model->level) ? text("model {}: as given", best.model->level.name)
                                                : text("model {}: bias {}", best.model->level.name, part(parts.model)));
    words.push_back(text("grid {}: bias {}", grid_name(best),
                         best.grid->outcome.state == LevelState::alone ? "not measured" : part(parts.grid)));
    words.push_back(text("{}: bias {}", best.step->level.name, part(parts.step)));
    if (parts.whole)
        words.push_back(text("all three together: bias {}, from a trial of this combination", part(*parts.whole)));
    if (found.statistical)
        words.push_back(
            text("{}: standard error {}", time_text(found, best.end), error_text(found, w, parts.statistics)));
    if (found.sample_every > 0.0)
        words.push_back(text("samples every {}: denser sampling does not reduce the error of the means",
                             time_text(found, std::max(found.sample_every, best.step->level.sample_every))));
    words.push_back(advice_on(found, best));
    if (const Candidate& theory = front.front(); theory.step == nullptr && theory.ratio <= 1.0) {
        const std::size_t hardest = hardest_target(found, theory);
        words.push_back(text("linear theory, which needs no run, has an error of {}",
                             error_text(found, hardest, theory.parts[hardest].bound())));
    }
    if (found.given_seconds < little_to_save)
        words.push_back(text("the run as given takes {} of a core: there is no time worth saving",
                             duration_text(found.given_seconds)));
    words.push_back(
        text("cost {} of a core; the trials took {}", duration_text(best.seconds), duration_text(found.spent)));
    const auto ten = std::ranges::find_if(front, [&](const Candidate& one) {
        return one.step != nullptr && one.ratio <= much_better;
    });
    words.push_back(ten == front.end()
                        ? "the trials cannot resolve a tenth of this error: give a larger --budget"
                        : text("a tenth of the error costs {} of a core ({}, {}, {}{})", duration_text(ten->seconds),
                               ten->model->level.name, grid_name(*ten), ten->step->level.name,
                               found.statistical ? ", " + time_text(found, ten->end) : ""));
    return words;
}
Tradeoff outcome_of(const Findings& found, const io::Scene& scene, const TargetOptions& options) {
    const std::vector<Candidate> front = front_of(found, scene);
    const Candidate* best = recommended(front, options.run_budget);
    Tradeoff outcome{.result = {}, .recommended = std::nullopt, .recommended_text = "", .seconds = found.spent};
    run::Record& root = outcome.result.root;
    root.heading = text("trade of speed for accuracy of {}", scene.file);
    root.lists = {level_list(found), front_list(found, front), model_fronts(found, scene), target_list(found, best)};
    root.footer.push_back("");
    if (found.pairing > 1.0)
        root.footer.push_back(
            text("runs on one noise path: variances of differences are {:.3g} times smaller than those "
                 "of independent runs",
                 found.pairing));
    if (found.is_short) root.footer.push_back("the budget was too small for some trials: see the remarks");
    for (std::size_t w = 0; w < found.cell.size(); ++w)
        if (std::abs(found.cell[w].value) > found.allowed[w] + 2.0 * found.cell[w].error)
            root.footer.push_back(
                text("{} depends on the size of the cell: it differs by {:.2g} +- {:.1g} from its value in a larger "
                     "cell, more than the {:.2g} allowed; these results hold for this cell only",
                     found.targets[w].text, found.cell[w].value, found.cell[w].error, found.allowed[w]));
    if (found.hosts.size() > 1)
        root.footer.push_back(text("the trials ran on {} machines ({}): their core times are compared as they are",
                                   found.hosts.size(), joined(std::vector(found.hosts.begin(), found.hosts.end()))));
    for (const std::string& program : found.programs)
        if (program != run::this_program())
            root.footer.push_back(other_program_text("trials were made by drover " + program, "them"));
    const auto add_words = [&](const char* name, const char* meaning, run::EntryValue value) {
        root.entries.push_back(run::data_only(run::words(name, meaning, std::move(value))));
    };
    if (best == nullptr) {
        root.footer.insert(root.footer.end(), found.notes.begin(), found.notes.end());
        root.footer.push_back(outcome.why_none = why_none(found, front, options.run_budget));
        add_words("why_none", "why no run is recommended", outcome.why_none);
        return outcome;
    }
    root.footer.push_back("recommended:");
    std::string comments = "# Recommended by drover tradeoff:\n";
    outcome.reasons = reasons(found, front, *best);
    for (const std::string& words : outcome.reasons) {
        root.footer.push_back("  " + words);
        comments += "# - " + words + "\n";
    }
    io::Scene chosen = scene_of(scene, found, *best);
    chosen.output.file.clear();
    outcome.recommended_text = comments + "\n" + io::resolved_text(chosen);
    add_words("recommended", "the recommended scene", outcome.recommended_text);
    add_words("reasons", "of the recommended run", outcome.reasons);
    outcome.recommended = std::move(chosen);
    outcome.expected_seconds = best->seconds;
    return outcome;
}

/// Rejects targets that no run of the scene answers, before there is a folder.  The first samples of fields have all
/// observables of a run.
void check_targets(const io::Scene& scene, const std::vector<AccuracyTarget>& targets) {
    require(scene.output.sample_every > 0.0, io::locate(scene, "output.sample_every"),
            "output.sample_every = 0; expected samples, from which the wanted numbers follow: give an interval");
    if (!io::has_grid(scene.kind)) return;
    io::Scene first = run::start_alone(scene);
    first.time.end = std::min(first.time.end, 2.0 * first.output.sample_every);
    first.output.powers = scene.output.powers;
    first.output.frame_every = 0.0;
    first.analysis.warm_up = -1.0;
    std::optional<run::Report> report;
    try {
        report = run::run_in_memory(first);
    } catch (const Error& error) {
        if (error.fault() != Fault::run) throw;  // its step is any: that of the trials may do
    }
    if (!report) return;
    for (const AccuracyTarget& target : targets) require_plausible(target, report->summary);
}
}  // namespace

Tradeoff study_tradeoff(const io::Scene& scene, const TargetOptions& options) {
    require(!options.targets.empty(), {.file = "--want"}, "no number is wanted; give at least one, such as {}=1%",
            run::example_observable(scene));
    if (options.collect) require_folder(options.folder, "tradeoff");
    else check_targets(scene, options.targets);
    files::join_folder(options.folder, "scene.toml", "", io::resolved_text(scene));
    if (!options.collect) files::require_locks(options.folder / "scene.toml");
    std::optional<Findings> found;
    if (!options.collect) found = find_tradeoff(scene, options);
    if (found && found->stopped) return {.result = {}, .seconds = found->spent, .stopped = true};
    Tradeoff outcome;
    conclude(
        options, [] { return true; },
        [&](bool) {
            if (!found) found = find_tradeoff(scene, options);  // now: not before the result of another process
            outcome = outcome_of(*found, scene, options);
            files::replace_file(options.folder / "tradeoff.json", run::result_json(outcome.result).dump(1) + "\n");
            const fs::path recommended = options.folder / "recommended.toml";
            if (outcome.recommended) files::replace_file(recommended, outcome.recommended_text);
            else fs::remove(recommended);  // of other targets
        });
    return outcome;
}

std::string tradeoff_status(const io::Scene& scene, const fs::path& folder) {
    require_folder(folder, "tradeoff");
    return trials_status(folder, io::resolved_text(scene));
}

std::optional<io::Scene> with_accuracy(const io::Scene& scene, const std::vector<AccuracyTarget>& targets, bool quiet) {
    const std::optional<run::ExpectedTime> expected = run::expected_time(run::with_chosen_step(scene, true));
    constexpr double part = 0.1, min_seconds = 5.0;  // of the run; seconds
    const double seconds = expected ? expected->total : 0.0;
    const fs::path folder = run::archive_path(scene).replace_extension(".tradeoff");
    if (!quiet)
        log_information("finding the cheapest run that is accurate enough, by trials of at most {} in {}",
                        duration_text(std::max(min_seconds, part * seconds)), folder.string());
    io::Scene given = scene;
    given.output.file.clear();
    const Tradeoff found =
        study_tradeoff(given,
                       {{.folder = folder, .quiet = quiet}, targets, std::max(min_seconds, part * seconds), INFINITY});
    if (found.stopped) return std::nullopt;
    if (!found.recommended) fail_run("{}", found.why_none);
    if (!quiet)
        for (const std::string& words : found.reasons) log_information("{}", words);
    io::Scene chosen = *found.recommended;
    chosen.output.file = scene.output.file;
    return chosen;
}

}  // namespace drover::jobs
