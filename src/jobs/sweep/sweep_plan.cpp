// jobs/sweep/sweep_plan.cpp: from the texts of sweep.vary and sweep.refine to runs.
#include "jobs/sweep/sweep_plan.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/constants.hpp"
#include "base/mapped.hpp"
#include "files/record_folder.hpp"
#include "jobs/campaign/accuracy_target.hpp"
#include "measure/replicates.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/number_lists.hpp"

namespace drover::jobs {

namespace {
struct Varied {
    std::string key;
    std::vector<double> values;
};

constexpr const char* sweep_key = "sweep.vary";

std::string sweep_example(const io::Scene& scene) {
    const run::SceneNumber one = run::example_number(scene);
    return text("\"{0} = {1}, {2}, {3}\" or \"{0} = {1}:{3}:11\"", one.key, 0.5 * one.value, one.value,
                2.0 * one.value);
}

Varied varied_of(const io::Scene& scene, const std::string& written, const SourceLocation& where) {
    const std::string example = sweep_example(scene);
    const auto [key, values] = run::read_assignment(written, sweep_key, example, where);
    require(key.find('.') != std::string::npos, where, "{} has \"{}\"; expected \"section.key = values\", as in {}",
            sweep_key, written, example);
    const auto number_of = [&](const std::string& word) {
        return run::read_number(word, written, sweep_key, example, where);
    };
    Varied varied{.key = key, .values = {}};
    if (values.find(':') == std::string::npos) {
        varied.values = mapped(run::split(values, ','), number_of);
    } else {
        const std::vector<std::string> parts = run::split(values, ':');
        require(parts.size() == 3, where, "sweep.vary has \"{}\"; expected first:last:count", written);
        const double first = number_of(parts[0]), last = number_of(parts[1]);
        const double count = number_of(parts[2]);
        require(count >= 2.0 && count <= 1e6 && count == std::floor(count), where,
                "sweep.vary has \"{}\"; expected an integer number of values, 2 to 1e6, after the second colon",
                written);
        for (int i = 0; i < static_cast<int>(count); ++i)  // the same for twice as many steps, to the bit
            varied.values.push_back(i + 1 == static_cast<int>(count) ? last
                                                                     : run::between(first, last, i, count - 1.0));
    }
    require(!varied.values.empty(), where, "sweep.vary has \"{}\" without a value; expected at least one", written);
    return varied;
}

std::vector<SweepPoint> grid_points(const std::vector<Varied>& varied) {
    std::vector<SweepPoint> points{SweepPoint{}};
    for (const Varied& one : varied) {
        std::vector<SweepPoint> longer;
        for (const SweepPoint& point : points)
            for (const double value : one.values) {
                longer.push_back(point);
                longer.back().values.push_back(value);
            }
        points = std::move(longer);
    }
    return points;
}

std::string numbered_name(std::size_t point, std::int64_t seed) { return text("point-{:04}-seed-{}", point, seed); }

std::string name_of(const std::vector<std::string>& keys, const std::vector<double>& values, std::int64_t seed,
                    const NumberedPoints& numbered) {
    const auto found = numbered.points.find(values);
    if (numbered.keys == keys && found != numbered.points.end()) return numbered_name(found->second, seed);
    std::string name;
    for (std::size_t k = 0; k < keys.size(); ++k) name += text("{}={},", keys[k], values[k]);
    constexpr std::size_t max_length = 200;  // of a file's name, with what stands beside an archive
    if (name.size() > max_length) name = text("point-{:016x},", files::fingerprint(name));
    return name + text("seed={}", seed);
}

/// A ramp of the last key for each combination of the others.
std::vector<SweepPoint> ramp_points(std::vector<Varied> varied, bool down_again) {
    const std::vector<double> ramp = varied.back().values;
    varied.pop_back();
    std::vector<SweepPoint> points;
    for (const SweepPoint& others : grid_points(varied)) {
        const auto add = [&](double value, Branch branch) {
            points.push_back({.values = others.values, .branch = branch});
            points.back().values.push_back(value);
        };
        for (const double value : ramp) add(value, Branch::up);
        if (down_again)
            for (std::size_t i = ramp.size() - 1; i-- > 0;) add(ramp[i], Branch::down);
    }
    return points;
}

/// Each point of a ramp has its own noise: repeated noise would correlate the two branches.
SweepRun run_at(const SweepLayout& layout, std::size_t point, const io::Scene& scene, int seed,
                const NumberedPoints& numbered) {
    const bool on_ramp = is_ramp(scene);
    const std::int64_t step = on_ramp ? static_cast<std::int64_t>(point) * scene.sweep.seeds : 0,
                       named = scene.run.seed + seed;
    const std::vector<double>& values = layout.points[point].values;
    SweepRun run{.name = on_ramp ? numbered_name(point, named) : name_of(layout.keys, values, named, numbered),
                 .point = point,
                 .seed = seed};
    for (std::size_t k = 0; k < layout.keys.size(); ++k)
        run.overrides.push_back(text("{}={}", layout.keys[k], values[k]));
    run.overrides.push_back(text("run.seed={}", named + step));
    return run;
}

void require_ramp(const io::Scene& scene, const std::vector<Varied>& varied) {
    const SourceLocation where = io::locate(scene, "sweep.vary");
    require(!varied.empty(), where,
            "sweep.ramp = \"{}\" without a varied key; expected one, or several of which the "
            "last is ramped",
            scene.sweep.ramp);
    require(scene.sweep.refine.empty(), io::locate(scene, "sweep.refine"),
            "sweep.refine on a ramp, whose points follow one another; expected ramp = \"none\"");
    for (const char* own : {"grid.", "cell.", "beads.", "rods."})
        require(!varied.back().key.starts_with(own), where,
                "sweep.ramp = \"{}\" of {}; a ramp passes on the state {}: choose another key, or ramp = \"none\"",
                scene.sweep.ramp, varied.back().key,
                io::has_grid(scene.kind) ? "on one grid" : "of the same bodies in one cell");
    require(io::has_grid(scene.kind) || scene.particles.rods.size_tolerance == 0.0,
            io::locate(scene, "rods.size_tolerance"),
            "rods.size_tolerance = {} on a ramp, whose points have different seeds and so rods of different sizes; "
            "expected 0, or ramp = \"none\"",
            scene.particles.rods.size_tolerance);
}

constexpr double max_runs = 1e6;

std::vector<Varied> read_varied(const io::Scene& scene) {
    const SourceLocation where = io::locate(scene, "sweep.vary");
    std::vector<Varied> varied;
    double runs = scene.sweep.seeds;
    for (const std::string& written : scene.sweep.vary) {
        Varied one = varied_of(scene, written, where);
        require(std::ranges::none_of(varied, [&](const Varied& other) { return other.key == one.key; }), where,
                "sweep.vary names {} twice; expected each key once", one.key);
        for (const char* own : {"run.", "output.", "sweep.", "initial.file", "packing.file"})
            require(!one.key.starts_with(own), where, "sweep.vary names {}, which the sweep sets itself; {}", one.key,
                    one.key == "run.seed" ? "give sweep.seeds" : "choose a key of the model, the grid or the time");
        runs *= static_cast<double>(one.values.size());
        varied.push_back(std::move(one));
    }
    const io::SweepPlan standard;
    require(scene.sweep.max_seeds == standard.max_seeds || !scene.sweep.want.empty(),
            io::locate(scene, "sweep.max_seeds"),
            "sweep.max_seeds = {} has no effect without sweep.want; give both, or omit it", scene.sweep.max_seeds);
    require(scene.sweep.refine_levels == standard.refine_levels || !scene.sweep.refine.empty(),
            io::locate(scene, "sweep.refine_levels"),
            "sweep.refine_levels = {} has no effect without sweep.refine; give both, or omit it",
            scene.sweep.refine_levels);
    require(!varied.empty() || scene.sweep.seeds > 1 || !scene.sweep.want.empty(), where,
            "nothing to sweep: give sweep.vary, as in --vary {}, or sweep.seeds > 1", sweep_example(scene));
    require(runs <= max_runs, where, "a sweep of {:.3g} runs; expected at most {:.0e}: choose fewer values or seeds",
            runs, max_runs);
    return varied;
}

/// Of each the error is the change between neighbours from which on points are added between them.
std::vector<AccuracyTarget> read_refined(const io::Scene& scene) {
    if (scene.sweep.refine.empty()) return {};
    const std::string list = "sweep.refine", example = text("\"{} = 0.1\"", run::example_observable(scene));
    const SourceLocation where = io::locate(scene, list);
    return mapped(scene.sweep.refine, [&](const std::string& written) {
        const auto [name, value] = run::read_assignment(written, list, example, where);
        const double change = run::read_number(value, written, list, example, where);
        require(change > 0.0, where, "{} has \"{}\"; expected a change > 0, in units of the observable, as in {}", list,
                written, example);
        return AccuracyTarget{.text = written, .observable = name, .ranges = {}, .error = change, .is_relative = false};
    });
}

/// The errors that seeds are added for: of numbers, not of parts of arrays.
std::vector<AccuracyTarget> read_targets(const io::Scene& scene) {
    const std::vector<AccuracyTarget> targets = mapped(scene.sweep.want, [&](const std::string& written) {
        AccuracyTarget target = parse_accuracy_target(written);
        require(target.ranges.empty(), io::locate(scene, "sweep.want"),
                "sweep.want has \"{}\", a part of an array; expected a single number, such as {}=2%", written,
                run::example_observable(scene));
        return target;
    });
    require(targets.empty() || !is_ramp(scene), io::locate(scene, "sweep.want"),
            "sweep.want on a ramp, whose points follow one another; expected ramp = \"none\"");
    require(targets.empty() || scene.sweep.max_seeds >= scene.sweep.seeds, io::locate(scene, "sweep.max_seeds"),
            "sweep.max_seeds = {} is less than sweep.seeds = {}", scene.sweep.max_seeds, scene.sweep.seeds);
    return targets;
}

/// An error of n runs is itself known to one part in sqrt(2 (n - 1)); those that came out small by chance would stop
/// too early, and are enlarged by as much.
bool is_met(const AccuracyTarget& target, const measure::Estimate& mean, int runs) {
    return mean.error && *mean.error * (1.0 + 1.0 / std::sqrt(2.0 * (runs - 1))) <= target.allowed(mean.mean);
}

/// A sweep as far as it is known.
struct Known {
    const io::Scene& scene;
    const std::vector<std::string>& keys;
    const NumberedPoints& numbered;
    const Marks& marks;

    /// The means over the first `seeds` seeds of a point; empty: not known yet, or a run of it failed.
    RunMarks means_at(const std::vector<double>& values, int seeds) const {
        std::map<std::string, std::vector<measure::Estimate>> runs;
        for (int seed = 0; seed < seeds; ++seed) {
            const auto found = marks.find(name_of(keys, values, scene.run.seed + seed, numbered));
            if (found == marks.end()) return {};
            for (const auto& [observable, estimate] : found->second) runs[observable].push_back(estimate);
        }
        RunMarks means;
        for (const auto& [observable, of_seeds] : runs) means[observable] = measure::combine(of_seeds).mean;
        return means;
    }
};

/// The points of a sweep, and the number of seeds of each.
struct Wanted {
    std::vector<SweepPoint> points;
    std::vector<int> seeds;
};

/// Half as many more seeds of a point each time that those known do not suffice, so that their number does not depend
/// on the order in which runs end.
void add_seeds(const Known& known, const std::vector<AccuracyTarget>& targets, Wanted& wanted) {
    constexpr int min_seeds = 4;
    const int max_seeds = known.scene.sweep.max_seeds;
    for (std::size_t point = 0; point < wanted.points.size(); ++point) {
        int& seeds = wanted.seeds[point];
        for (seeds = std::min(std::max(seeds, min_seeds), max_seeds); seeds < max_seeds;
             seeds = std::min(seeds + std::max(seeds / 2, 1), max_seeds)) {
            const RunMarks means = known.means_at(wanted.points[point].values, seeds);
            const auto suffices = [&](const AccuracyTarget& one) {
                return is_met(one, means.at(one.observable), seeds);
            };
            if (means.empty() || std::ranges::all_of(targets, suffices)) break;
        }
    }
}

/// More than asked for, and beyond twice the standard error, so that noise alone adds no points; a single run without
/// an error counts as exact.
bool has_changed(const measure::Estimate& a, const measure::Estimate& b, double change) {
    const double by = std::abs(a.mean - b.mean);
    return by > change && by > 2.0 * std::hypot(a.error.value_or(0.0), b.error.value_or(0.0));
}

/// Points between those that differ.
void add_points(const Known& known, const std::vector<Varied>& varied, const std::vector<AccuracyTarget>& refined,
                Wanted& wanted) {
    const io::Scene& scene = known.scene;
    const SourceLocation where = io::locate(scene, "sweep.refine");
    constexpr std::size_t max_keys = 3;
    require(!varied.empty() && varied.size() <= max_keys, where, "sweep.refine with {} varied keys; expected one to {}",
            varied.size(), max_keys);
    Axes axes;
    for (const Varied& one : varied) {
        require(one.values.size() > 1, where, "sweep.refine with one value of {}; expected at least two", one.key);
        axes.push_back(one.values);
        std::ranges::sort(axes.back());
    }
    std::map<std::vector<double>, RunMarks> means;
    const auto at = [&](const std::vector<double>& values) -> const RunMarks& {
        const auto [found, is_new] = means.try_emplace(values);
        if (is_new) found->second = known.means_at(values, scene.sweep.seeds);
        return found->second;
    };
    const auto differs = [&](const std::vector<double>& a, const std::vector<double>& b) {
        const RunMarks &here = at(a), &there = at(b);
        return !here.empty() && !there.empty() && std::ranges::any_of(refined, [&](const AccuracyTarget& one) {
            return has_changed(here.at(one.observable), there.at(one.observable), one.error);
        });
    };
    wanted.points.clear();
    for (std::vector<double>& values : refined_points(axes, scene.sweep.refine_levels, differs))
        wanted.points.push_back({.values = std::move(values), .branch = Branch::none});
    wanted.seeds.assign(wanted.points.size(), scene.sweep.seeds);
}

/// A value that is listed twice has one point.
void remove_repeated(std::vector<Varied>& varied) {
    for (Varied& one : varied) {
        std::set<double> known;
        std::erase_if(one.values, [&](double value) { return !known.insert(value).second; });
    }
}
}  // namespace

bool is_ramp(const io::Scene& scene) { return scene.sweep.ramp != io::Ramp::none; }

SweepLayout plan_sweep(const io::Scene& scene, const Marks& marks, const NumberedPoints& numbered) {
    std::vector<Varied> varied = read_varied(scene);
    const bool on_ramp = is_ramp(scene), down_again = scene.sweep.ramp == io::Ramp::up_down;
    if (on_ramp) require_ramp(scene, varied);
    else remove_repeated(varied);
    SweepLayout layout{.keys = mapped(varied, &Varied::key),
                       .points = {},
                       .runs = {},
                       .finds_warm_up = scene.analysis.warm_up < 0.0,
                       .is_adaptive = !scene.sweep.refine.empty() || !scene.sweep.want.empty()};
    const Known known{.scene = scene, .keys = layout.keys, .numbered = numbered, .marks = marks};
    Wanted wanted{.points = on_ramp ? ramp_points(varied, down_again) : grid_points(varied), .seeds = {}};
    wanted.seeds.assign(wanted.points.size(), scene.sweep.seeds);
    if (!scene.sweep.refine.empty()) add_points(known, varied, read_refined(scene), wanted);
    if (!scene.sweep.want.empty()) add_seeds(known, read_targets(scene), wanted);
    layout.points = std::move(wanted.points);
    require(static_cast<double>(layout.points.size()) * scene.sweep.seeds <= max_runs,
            io::locate(scene, "sweep.refine"),
            "a sweep of {} runs; expected at most {:.0e}: give a larger change or fewer levels",
            layout.points.size() * static_cast<std::size_t>(scene.sweep.seeds), max_runs);
    const std::size_t of_ramp = on_ramp ? (down_again ? 2 : 1) * varied.back().values.size() - (down_again ? 1 : 0) : 1;
    layout.seeds = *std::ranges::max_element(wanted.seeds);
    for (int seed = 0; seed < layout.seeds; ++seed)
        for (std::size_t point = 0; point < layout.points.size(); ++point) {
            if (seed >= wanted.seeds[point]) continue;
            layout.runs.push_back(run_at(layout, point, scene, seed, numbered));
            if (point % of_ramp > 0) layout.runs.back().before = layout.runs.size() - 2;
        }
    return layout;
}

NumberedPoints numbered_points(const io::Scene& scene) {
    if (is_ramp(scene)) return {};
    const std::vector<Varied> varied = read_varied(scene);
    NumberedPoints numbered{.keys = mapped(varied, &Varied::key)};
    const std::vector<SweepPoint> points = grid_points(varied);
    for (std::size_t number = 0; number < points.size(); ++number)
        numbered.points.try_emplace(points[number].values, number);
    return numbered;
}

RunMarks marks_of(const io::Scene& scene, const RunResults& results) {
    RunMarks marks;
    const auto add = [&](const char* key, const AccuracyTarget& one) {
        const measure::SummaryRow* row = measure::find_row(results.rows, one.observable);
        if (row == nullptr || !row->axes.empty()) {
            std::vector<std::string> single;
            for (const measure::SummaryRow& other : results.rows)
                if (other.axes.empty()) single.push_back(other.name);
            fail_input(io::locate(scene, key), "{} names {}, which is no single number of the runs; expected one of {}",
                       key, one.observable, joined(single));
        }
        marks[row->name] = row->estimates.front();
        return *row;
    };
    for (const AccuracyTarget& one : read_refined(scene)) add("sweep.refine", one);
    for (const AccuracyTarget& one : read_targets(scene)) {
        const measure::SummaryRow row = add("sweep.want", one);
        require_unit(one, row.unit, row.estimates.front().mean);
    }
    return marks;
}

std::vector<std::string> unmet_targets(const io::Scene& scene, const SweepLayout& layout, const SweepTable& table) {
    std::vector<std::string> unmet;
    for (const AccuracyTarget& target : read_targets(scene)) {
        const auto named = std::ranges::find(table.names, target.observable);
        for (const SweepRow& row : table.rows) {
            if (named == table.names.end()) continue;
            std::string at;
            for (std::size_t k = 0; k < layout.keys.size(); ++k)
                at += text("{}{} = {}", at.empty() ? "at " : ", ", layout.keys[k], row.point.values[k]);
            if (!at.empty()) at += ": ";
            if (row.seeds < 2) {
                unmet.push_back(text("{}{} has no error of the seeds, since {} run ended; see which runs failed", at,
                                     target.observable, row.seeds == 0 ? "no" : "only one"));
                continue;
            }
            const measure::Replicates& found = row.results[static_cast<std::size_t>(named - table.names.begin())];
            const measure::Estimate& mean = found.mean;
            const bool is_small = is_met(target, mean, row.seeds);
            if (is_small && (!layout.finds_warm_up || found.without_error == 0)) continue;
            if (is_small) {
                unmet.push_back(
                    text("{}{} = {:.4g} comes from runs of which {} of {} are too short for an error estimate, so it "
                         "may still depend on their start: make the runs longer, or set analysis.warm_up",
                         at, target.observable, mean.mean, found.without_error, row.seeds));
                continue;
            }
            const bool is_uncertain = mean.error && *mean.error <= target.allowed(mean.mean);
            unmet.push_back(text("{}{} = {:.4g} has an error of {:.2g} after {} seeds{}, {:.2g} was wanted: {}", at,
                                 target.observable, mean.mean, mean.error.value_or(nan), row.seeds,
                                 is_uncertain ? " that ended, too few to know this error" : "",
                                 target.allowed(mean.mean),
                                 is_uncertain ? "see which runs failed, or raise sweep.max_seeds"
                                              : "raise sweep.max_seeds, or make the runs longer"));
        }
    }
    return unmet;
}

std::vector<std::string> finest_overrides(const io::Scene& scene) {
    std::vector<std::string> overrides;
    if (!scene.sweep.refine.empty())
        for (const Varied& one : read_varied(scene)) {
            const double by = (one.values.back() - one.values.front()) / std::exp2(scene.sweep.refine_levels) /
                              static_cast<double>(one.values.size());
            overrides.push_back(text("{}={}", one.key, one.values.front() + by));
        }
    return overrides;
}

}  // namespace drover::jobs
