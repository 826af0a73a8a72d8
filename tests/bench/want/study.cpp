// tests/bench/want/study.cpp: core seconds to a wanted error of the onset, by wanted numbers and by equal targets.
//
//     ninja drover_want_study
//     drover_want_study costs SCENE [POINT...]       core seconds of one trial of every unit, or of those that end so
//     drover_want_study stored FOLDER COSTS WISH REPEATS [in-order]
//     drover_want_study synthetic WORLD WISH REPEATS   WORLD: rods, flow or particles
//
// A world is a pool of trials of every unit: the stored trials of models/calibrate-matched.toml; normal numbers with
// a known onset, whose error comes from a and lambda (rods) or from alpha/Gamma (flow); or trials of the synthetic
// particles of the tests.  A repeat draws trials with replacement, the same for all ways ("in-order": first the
// stored trials as they are).  The true onset is that of the pool.  Equal targets: calibrate.relative_error falls
// until the onset has the wanted error, with the margin of wanted numbers or without it; only the assays that the
// onset needs run.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <random>

#include "calibrate/synthetic.hpp"
#include "io/calibration.hpp"
#include "io/scene.hpp"
#include "jobs/calibration/target_plan.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "jobs/normal_world.hpp"
#include "run/loop/simulation.hpp"

namespace drover::jobs {
namespace {
using calibrate::Attempt;
using calibrate::TrialSet;

struct World {
    CalibrationLayout layout;
    calibrate::Goal equal;                             ///< of equal targets
    std::vector<std::vector<calibrate::Trial>> pools;  ///< by unit
    std::vector<double> seconds;                       ///< of one trial, by unit
    std::string target;
};

/// The trials of one repeat, in the order of their numbers.
class Draw {
public:
    Draw(const World& world, std::uint64_t repeat, bool in_order)
        : world_(world), repeat_(repeat), in_order_(in_order) {}
    Attempt trial(std::size_t unit, std::uint64_t number) const {
        std::uint64_t index = number;
        if (!in_order_ || number >= world_.pools[unit].size()) {
            std::seed_seq seed{repeat_, static_cast<std::uint64_t>(unit), number};
            std::mt19937_64 random(seed);
            index = random() % world_.pools[unit].size();
        }
        return {.number = number,
                .numbers = world_.pools[unit].at(index),
                .failure = {},
                .core_seconds = world_.seconds[unit]};
    }

private:
    const World& world_;
    std::uint64_t repeat_;
    bool in_order_;
};

struct Outcome {
    double seconds = 0.0, value = 0.0, error = 0.0;
    bool reached = false;
};

std::vector<UnitProgress> progress_of(const std::vector<TrialSet>& sets) {
    std::vector<UnitProgress> progress;
    for (const TrialSet& set : sets) progress.push_back({.trials = &set, .given = set.count()});
    return progress;
}

Outcome outcome_of(const TargetPlan& plan, const std::vector<TrialSet>& sets) {
    const TargetProgress& value = plan.values().front();
    Outcome outcome{.value = value.result.value, .error = value.cautious_error, .reached = value.reached};
    for (const TrialSet& set : sets) outcome.seconds += set.core_seconds();
    return outcome;
}

std::vector<TrialSet> empty_sets(const World& world) {
    std::vector<TrialSet> sets;
    for (const CalibrationUnit& unit : world.layout.units)
        sets.emplace_back(world.layout.assays[unit.assay], TrialSet::no_goal(), 0.0);
    return sets;
}

Outcome by_want(const World& world, const Draw& draw) {
    TargetPlan plan(world.layout, {parse_accuracy_target(world.target)},
                    {.max_trials = world.equal.max_trials, .workers = 2});
    std::vector<TrialSet> sets = empty_sets(world);
    for (bool goes_on = true; goes_on;) {
        const std::vector<std::uint64_t> needed = plan.next(progress_of(sets));
        goes_on = false;
        for (std::size_t u = 0; u < sets.size(); ++u)
            while (sets[u].count() < needed[u]) sets[u].add(draw.trial(u, sets[u].count())), goes_on = true;
    }
    return outcome_of(plan, sets);
}

/// The trials of one unit under equal targets.
struct EqualUnit {
    std::vector<calibrate::Trial> trials;
    std::map<std::size_t, double> excess;  ///< by rounds: the largest relative error of a wanted quantity
};

double excess_after(const calibrate::Assay& assay, const Draw& draw, std::size_t u, std::size_t rounds,
                    std::size_t round, EqualUnit& unit) {
    if (const auto known = unit.excess.find(rounds); known != unit.excess.end()) return known->second;
    while (unit.trials.size() < rounds * round) unit.trials.push_back(draw.trial(u, unit.trials.size()).numbers);
    double& excess = unit.excess[rounds];
    const std::vector<measure::Estimate> found = calibrate::measurement_of(assay, unit.trials).estimates;
    for (std::size_t q = 0; q < found.size(); ++q)
        if (assay.quantities[q].wanted)
            excess = std::max(excess, found[q].error.value_or(INFINITY) / std::abs(found[q].mean));
    return excess;
}

/// Two outcomes: where the error of the resampled tables is the wanted one, and where it is so with its margin.
std::array<Outcome, 2> by_equal_targets(const World& world, const Draw& draw) {
    std::optional<Outcome> plain;
    TargetPlan plan(world.layout, {parse_accuracy_target(world.target)}, {.max_trials = world.equal.max_trials});
    std::vector<EqualUnit> units(world.layout.units.size());
    std::vector<TrialSet> sets = empty_sets(world);
    for (double target = 0.5;;) {
        bool is_last = true;
        for (std::size_t u = 0; u < units.size(); ++u) {
            const calibrate::Assay& assay = world.layout.assays[world.layout.units[u].assay];
            const std::size_t round = world.equal.round;
            std::size_t rounds = world.equal.min_rounds;
            bool is_last_round = false;
            for (;; rounds += 1 + rounds / 16) {  // not after every round of many, for speed
                is_last_round = (rounds + 1 + rounds / 16) * round > world.equal.max_trials;
                if (excess_after(assay, draw, u, rounds, round, units[u]) <= target || is_last_round) break;
            }
            is_last = is_last && is_last_round;
            while (sets[u].count() < rounds * round) sets[u].add(draw.trial(u, sets[u].count()));
        }
        plan.next(progress_of(sets));
        const TargetProgress& value = plan.values().front();
        if (!plain && value.result.error <= value.result.allowed) {
            plain = outcome_of(plan, sets);
            plain->error = value.result.error;
            plain->reached = true;
        }
        if (value.reached || is_last) return {plain.value_or(outcome_of(plan, sets)), outcome_of(plan, sets)};
        const double ratio = value.result.allowed / value.result.error;
        target *= std::isfinite(ratio) ? std::clamp(ratio, 0.6, 0.97) : 0.8;
    }
}

double true_onset(const World& world) {
    std::vector<TrialSet> sets = empty_sets(world);
    for (std::size_t u = 0; u < sets.size(); ++u)
        for (const calibrate::Trial& trial : world.pools[u])
            sets[u].add({.number = sets[u].count(), .numbers = trial, .failure = {}});
    TargetPlan plan(world.layout, {parse_accuracy_target(world.target)}, {});
    plan.next(progress_of(sets));
    const TargetProgress& value = plan.values().front();
    std::printf("# true %s: %.4f (the pool has %.2g); %s\n", value.text.c_str(), value.result.value, value.result.error,
                world.target.c_str());
    return value.result.value;
}

void study(const World& world, int repeats, bool in_order) {
    const double truth = true_onset(world);
    constexpr int ways = 3;
    const char* names[] = {"equal targets without margin", "equal targets", "want"};
    double seconds[ways] = {}, covered[ways] = {}, reached[ways] = {}, errors[ways] = {}, off[ways] = {};
    for (int r = 0; r < repeats; ++r) {
        const Draw draw(world, static_cast<std::uint64_t>(r), in_order);
        const auto [plain, equal] = by_equal_targets(world, draw);
        const Outcome outcomes[] = {plain, equal, by_want(world, draw)};
        for (int way = 0; way < ways; ++way) {
            const Outcome& one = outcomes[way];
            seconds[way] += one.seconds / repeats;
            covered[way] += std::abs(one.value - truth) <= one.error ? 1.0 / repeats : 0.0;
            reached[way] += one.reached ? 1.0 / repeats : 0.0;
            errors[way] += one.error / repeats;
            std::fprintf(stderr, "%s %.0f %.4f %.4f %d\n", names[way], one.seconds, one.value, one.error, one.reached);
            off[way] += std::pow(one.value - truth, 2) / repeats;
        }
    }
    std::printf("way,core_seconds,ratio,coverage,reached,mean_error,rms_error\n");
    for (int way = 0; way < ways; ++way)
        std::printf("%s,%.0f,%.3f,%.3f,%.3f,%.4f,%.4f\n", names[way], seconds[way], seconds[way] / seconds[1],
                    covered[way], reached[way], errors[way], std::sqrt(off[way]));
}

/// Of the assays that the onset needs alone: equal targets of all assays would cost more.
World world_of(io::Scene scene, const std::string& target) {
    World world{.target = target};
    scene.calibration.assays = {"relaxation", "weathercock", "drag"};
    world.layout = plan_calibration(scene);
    world.equal = world.layout.goal;
    world.layout.goal = TrialSet::no_goal();
    return world;
}

void costs(const std::string& file, const std::vector<std::string>& points) {
    const io::Scene scene = io::read_scene(file);
    const CalibrationLayout layout = world_of(scene, "").layout;
    const calibrate::SystemFactory factory = calibrate::system_factory(scene.time.dt);
    std::printf("unit,core_seconds\n");
    for (const CalibrationUnit& unit : layout.units) {
        const bool is_given = std::any_of(points.begin(), points.end(),
                                          [&](const std::string& point) { return unit.name.ends_with(point); });
        if (!points.empty() && !is_given) continue;
        const double start = run::core_seconds();
        calibrate::run_trial(layout.assays[unit.assay], factory, unit.conditions, 0);
        std::printf("%s,%.3g\n", unit.name.c_str(), run::core_seconds() - start);
        std::fflush(stdout);
    }
}

World stored_world(const std::string& scene, const std::string& folder, const std::string& cost_file,
                   const std::string& target) {
    World world = world_of(io::read_scene(scene), target);
    const std::string& manifest = world.layout.manifest;
    const std::vector<UnitRecord> records =
        campaign_records(folder, {.hash = files::fingerprint("calibrate\n" + manifest), .content = manifest});
    for (const CalibrationUnit& unit : world.layout.units) {
        world.pools.emplace_back();
        for (const UnitRecord& record : records) {
            if (record.state != UnitState::done || !record.key.starts_with(unit.name + "-trial-")) continue;
            const Attempt attempt = io::attempt_of(record.result.content, record.key);
            if (!attempt.failure) world.pools.back().push_back(attempt.numbers);
        }
        std::ifstream lines(cost_file);
        for (std::string line; std::getline(lines, line);)
            if (line.starts_with(unit.name + ","))
                world.seconds.push_back(std::stod(line.substr(unit.name.size() + 1)));
    }
    return world;
}

/// The scene of synthetic worlds: only the axes and the plans of its assays matter.
constexpr const char* synthetic_scene = R"(
[cell]
lx = 30.0
ly = 30.0
[rods]
area_fraction = 0.05
[calibrate]
bead_area_fractions = [0.2, 0.3, 0.4, 0.5, 0.6]
rod_area_fractions = [0.08]
relative_error = 0.1
round = 5
max_trials = 2000
single_rods = 4
[calibrate.weathercock]
speeds = [2.0, 4.0, 8.0]
[calibrate.drag]
torques = [200.0, 1000.0, 5000.0]
time = 3.0
bend = false
)";

/// Rods turn little in the flow, with much noise; alpha/Gamma and lambda_s grow with the area fraction of beads, and
/// rods do not align by contacts.
calibrate::Truth truth_at(const dem::Setup& setup) {
    const double bead = setup.beads.area_fraction, rod = setup.rods.area_fraction;
    return {.turning = 0.08 + 0.6 * bead,
            .diffusion = 0.4,
            .drag = 0.4 + 3.0 * bead + 6.0 * rod,
            .agitation = 0.3,
            .step = 0.02};
}

World synthetic_world(const std::string& target) {
    World world = world_of(io::parse_scene(synthetic_scene, "synthetic.toml", {}), target);
    constexpr std::uint64_t trials = 200;
    for (const CalibrationUnit& unit : world.layout.units) {
        calibrate::Conditions conditions = unit.conditions;
        dem::Setup& setup = conditions.setup;
        const calibrate::Truth truth = truth_at(setup);
        constexpr double rod_area = 4.118, bead_area = 0.503;
        if (setup.rods.area_fraction > 0.0)
            setup.rods.count = static_cast<int>(setup.cell.lx * setup.cell.ly * setup.rods.area_fraction / rod_area);
        const double bodies =
            13.0 * setup.rods.count + setup.cell.lx * setup.cell.ly * setup.beads.area_fraction / bead_area;
        const calibrate::Assay& assay = world.layout.assays[unit.assay];
        world.pools.emplace_back();
        for (std::uint64_t t = 0; t < trials; ++t)
            world.pools.back().push_back(
                calibrate::run_trial(assay, calibrate::synthetic_factory(truth), conditions, t));
        const double time = assay.name == "relaxation" ? 7.0 : assay.name == "weathercock" ? 9.0 : 9.5;
        world.seconds.push_back(bodies * time * 5e-4);  // of the particle program at these numbers of bodies
    }
    return world;
}

World normal_world(const NormalScatter& scatter, const std::string& target) {
    World world{.layout = normal_layout(), .target = target};
    world.equal = {.relative_error = 0.1, .round = 5, .max_trials = 20000};
    constexpr std::uint64_t trials = 4000;
    for (std::size_t u = 0; u < world.layout.units.size(); ++u) {
        world.pools.emplace_back();
        for (std::uint64_t t = 0; t < trials; ++t) {
            const Attempt one = trial_of(world.layout, u, t, 0, scatter);
            world.pools.back().push_back(one.numbers);
            if (t == 0) world.seconds.push_back(one.core_seconds);
        }
    }
    return world;
}

int main_of(const std::vector<std::string>& words) {
    const std::string what = words.at(0);
    if (what == "costs") costs(words.at(1), {words.begin() + 2, words.end()});
    else if (what == "stored")
        study(stored_world("models/calibrate-matched.toml", words.at(1), words.at(2), words.at(3)),
              std::stoi(words.at(4)), words.size() > 5);
    else if (words.at(1) == "rods") study(normal_world({}, words.at(2)), std::stoi(words.at(3)), false);
    else if (words.at(1) == "flow")
        study(normal_world({.rods = 0.03, .drag = 0.3}, words.at(2)), std::stoi(words.at(3)), false);
    else study(synthetic_world(words.at(2)), std::stoi(words.at(3)), false);
    return 0;
}
}  // namespace
}  // namespace drover::jobs

int main(int count, char** words) {
    try {
        return drover::jobs::main_of({words + 1, words + count});
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return 2;
    }
}
