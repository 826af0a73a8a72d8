// jobs/tradeoff/trade_study.cpp: the trials of a study, axis by axis.
#include <algorithm>
#include <utility>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "io/scene.hpp"
#include "jobs/tradeoff/trade_front.hpp"

namespace drover::jobs {

namespace {
class Study {
public:
    Study(const io::Scene& scene, const TargetOptions& options)
        : bench_(trial_scene(scene), io::resolved_text(scene), options), options_(options) {
        found_.targets = options.targets;
        bench_.statistical = !io::has_grid(scene.kind) || io::has_noise(scene);
    }

    Findings find() {
        found_.stopped = !fit_into_budget();
        while (!found_.stopped) {
            found_.stopped = !measure_axes();
            if (found_.stopped) break;
            double longer = bench_.statistical && wants_longer() ? 2.0 * bench_.duration : 0.0;
            if (longer == 0.0) {
                found_.stopped = !check_recommended();
                if (found_.stopped || !bench_.statistical || (longer = drifts_by()) == 0.0) break;
                bench_.warm_up = 0.0;  // that of the longer trials
                found_.checked.clear();
            }
            bench_.duration = longer;
        }
        return findings();
    }

private:
    const Findings& findings() {
        static_cast<BenchFacts&>(found_) = bench_;
        return found_;
    }

    /// Where the trials are made on a coarser grid, its errors stand for those of the given one.  False when a signal
    /// came.
    bool fit_into_budget() {
        const std::optional<TrialStart> start = trial_start(bench_);
        if (!start) return false;
        refinement_ = size_of(bench_.scene) / size_of(start->scene);
        if (refinement_ > 1.0) given_grid_ = grid_level(bench_.scene, bench_.scene.grid.nx, bench_.scene.grid.ny);
        bench_.scene = start->scene;
        bench_.duration = start->duration;
        return true;
    }

    bool measure_axes() {
        if (!bench_.run({bench_.trial_of({})})) return false;
        const TrialMeasurement base = bench_.measured({});
        if (!base.outcome.was_run() && bench_.is_collecting)
            fail_run("the trial of the scene as given has not ended; run the same command without --collect");
        if (!base.is_measured())
            fail_run(
                "the scene as given fails, so nothing can be compared with it: {}; give a shorter time.dt or "
                "a larger --budget",
                text_of(base.outcome));
        bench_.duration = std::max(bench_.duration, base.end);  // at least twice the warm-up, which is that of the base
        if (found_.sample_every == 0.0 && bench_.statistical && io::has_grid(bench_.scene.kind)) {
            found_.sample_every = bench_.sparse_sampling(base);
            if (found_.sample_every > bench_.scene.output.sample_every) {
                // The trials to come last a whole number of these intervals.
                bench_.scene.output.sample_every = found_.sample_every;
                bench_.duration = found_.sample_every * std::ceil(bench_.duration / found_.sample_every - 1e-9);
                return measure_axes();
            }
        }
        bench_.set_rate(base);
        if (bench_.may_be_longer(base)) {
            bench_.duration *= 2.0;
            return measure_axes();
        }
        found_.given_seconds = refinement_ * (base.start_seconds + base.step_seconds * bench_.scene.time.end);
        set_references(base);
        return measure_grids(base) && measure_steps() && measure_models() && measure_rounding_and_cell();
    }

    void set_references(const TrialMeasurement& base) {
        found_.units.clear();
        found_.references.clear();
        bench_.allowed.clear();
        for (std::size_t w = 0; w < found_.targets.size(); ++w) {
            found_.units.push_back(base.numbers[w].unit);
            found_.references.push_back(bench_.mean_of(base.numbers[w]));
            const AccuracyTarget& target = found_.targets[w];
            require_relative(target, base.numbers[w].unit, found_.references[w]);
            require_unit(target, base.numbers[w].unit, found_.references[w].value);
            bench_.allowed.push_back(target.allowed(found_.references[w].value));
        }
    }

    bool measure_grids(const TrialMeasurement& base) {
        std::vector<AxisLevel> levels = grid_levels(bench_.scene, !bench_.statistical);
        if (refinement_ > 1.0 && levels.size() > 1) levels.pop_back();
        std::vector<TrialRun> trials;
        constexpr double small = 0.25;  // of what is allowed: the given grid is fine enough to be the reference
        for (const AxisLevel& level : levels)
            if (TrialRun trial = bench_.trial_of(level.overrides); trial.scene.grid.nx <= bench_.scene.grid.nx)
                trials.push_back(std::move(trial));
        if (!bench_.run(trials)) return false;
        if (levels.size() > 1 && io::has_grid(bench_.scene.kind) && trials.size() < levels.size()) {
            const auto given = static_cast<std::size_t>(
                std::ranges::find_if(levels, [](const AxisLevel& one) { return is_given(one); }) - levels.begin());
            const auto is_near = [&](const TrialMeasurement& coarser) {
                return coarser.is_measured() && bench_.ratio(bench_.differences(coarser, base)) < small;
            };
            if (given > 0 && is_near(bench_.measured(levels[given - 1].overrides))) levels.pop_back();
            else if (!bench_.run({bench_.trial_of(levels.back().overrides)})) return false;
        }
        collect(levels, found_.grids);
        found_.notes.clear();
        if (io::has_grid(bench_.scene.kind) && levels.size() == 1)
            found_.notes.push_back("the start differs from grid to grid: the error of the grid was not measured");
        const LevelFound& last = found_.grids.back();
        if (bench_.statistical && !is_given(last.level) && last.is_measured() &&
            !converges(grid_steps_, bench_.allowed)) {
            // Noise reaches the shortest waves: the grid is part of the model, as given.
            collect({levels.begin(), levels.end() - 1}, found_.grids);
            grid_is_model_ = true;
            for (LevelFound& grid : found_.grids) {
                grid.outcome = {is_given(grid.level) ? LevelState::alone : LevelState::grid_of_model};
                grid.biases.assign(found_.targets.size(), {});
            }
            found_.notes.push_back(
                "the wanted numbers do not visibly converge as the grid is refined, since noise acts on its shortest "
                "waves: the given grid is taken as part of the model, and its bias is not measured");
        }
        // The coarsest grid that is right serves for the other axes.
        std::size_t given = 0;
        for (std::size_t g = 0; g < found_.grids.size(); ++g)
            if (is_given(found_.grids[g].level)) given = g;
        found_.pilot_grid = given;
        for (std::size_t g = given; g-- > 0;)
            if (found_.grids[g].is_measured() && bench_.ratio(found_.grids[g].biases) < 1.0) found_.pilot_grid = g;
        found_.pilot_start = found_.grids[found_.pilot_grid].start_seconds;
        found_.pilot_step = found_.grids[found_.pilot_grid].step_seconds;
        if (refinement_ > 1.0) {
            found_.grids[given].start_seconds *= refinement_;
            found_.grids[given].step_seconds *= refinement_;
            std::ranges::move(coarser_notes(bench_.scene, given_grid_.name, found_.grids[given].level.name),
                              std::back_inserter(found_.notes));
            found_.grids[given].level = given_grid_;
        }
        return true;
    }

    /// Biases against the limit by bias_of_finest(), without noise known in size alone; costs over those as given.
    void collect(const std::vector<AxisLevel>& levels, std::vector<LevelFound>& into) {
        into.clear();
        std::vector<TrialMeasurement> runs;
        std::optional<std::size_t> last, before, earlier, given;
        for (std::size_t k = 0; k < levels.size(); ++k) {
            runs.push_back(bench_.measured(levels[k].overrides));
            if (is_given(levels[k])) given = k;
            if (!runs[k].is_measured()) continue;
            earlier = before;
            before = last;
            last = k;
        }
        if (!last) fail_run("no grid was measured: {}: {}", levels.front().name, text_of(runs.front().outcome));
        const bool is_noisy = io::has_grid(bench_.scene.kind) && bench_.statistical;
        std::vector<Bias> finest(found_.targets.size());
        grid_steps_ = {finest, finest};
        if (before) grid_steps_.last = bench_.differences(runs[*before], runs[*last]);
        if (earlier) grid_steps_.longer = bench_.differences(runs[*earlier], runs[*before]);
        for (std::size_t w = 0; w < finest.size(); ++w)
            finest[w] = bias_of_finest(grid_steps_.longer[w], grid_steps_.last[w], is_noisy);
        for (std::size_t k = 0; k < levels.size(); ++k) {
            LevelFound found{.level = levels[k], .outcome = runs[k].outcome, .biases = {}};
            if (found.is_measured()) {
                found.biases = k != *last ? bench_.differences(runs[k], runs[*last]) : finest;
                for (std::size_t w = 0; w < finest.size() && k != *last; ++w) {
                    Bias& bias = found.biases[w];
                    if (is_noisy) bias.value += finest[w].value;
                    bias.error = std::hypot(bias.error, is_noisy ? finest[w].error : 0.5 * finest[w].value);
                }
                if (k == *last && !before) found.outcome = {LevelState::alone};
                found.start_seconds = given ? runs[k].start_seconds / std::max(runs[*given].start_seconds, 1e-3) : 1.0;
                found.step_seconds = given ? runs[k].step_seconds / std::max(runs[*given].step_seconds, 1e-9) : 1.0;
            }
            into.push_back(std::move(found));
        }
    }

    std::vector<std::string> on_pilot_grid(const std::vector<std::string>& overrides) const {
        std::vector<std::string> all = found_.grids[found_.pilot_grid].level.overrides;
        all.insert(all.end(), overrides.begin(), overrides.end());
        return all;
    }

    io::Scene pilot() const { return io::changed(bench_.scene, on_pilot_grid({})); }
    TrialRun trial_of(const AxisLevel& level) const { return bench_.trial_of(on_pilot_grid(level.overrides)); }
    TrialMeasurement measured(const AxisLevel& level) { return bench_.measured(on_pilot_grid(level.overrides)); }

    bool measure_steps() {
        if (ladders_.empty()) ladders_ = step_ladders(bench_.scene);
        constexpr int max_extensions = 4;
        for (int extension = 0;; ++extension) {
            std::vector<TrialRun> trials;
            for (const StepLadder& ladder : ladders_)
                for (const AxisLevel& level : ladder.levels) trials.push_back(trial_of(level));
            if (!bench_.run(trials)) return false;
            collect_steps();
            if (extension == max_extensions || !extend_ladders()) break;
        }
        is_settled_ = true;
        add_unsettled(bench_.drift_notes(bench_.measured(reference_)));
        return true;
    }

    /// Two shorter steps of each method whose finest two still differ; false when there is none.
    bool extend_ladders() {
        constexpr double small = 0.05;  // of what is allowed
        bool any = false;
        const bool is_known = bench_.is_resolved(reference_bias_, 2.0 * small);
        for (std::size_t l = 0; l < ladders_.size(); ++l) {
            const std::vector<LevelFound>& levels = found_.ladders[l];
            if (!levels.back().outcome.was_run()) continue;
            const bool converged = is_known && levels.size() > 1 && levels.back().is_measured() &&
                                   bench_.is_resolved(levels.back().biases, small);
            if (converged) continue;
            const std::size_t before = ladders_[l].levels.size();
            add_shorter(bench_.scene, ladders_[l], 2);
            any = any || ladders_[l].levels.size() > before;
        }
        return any;
    }

    /// The finest run of each ladder.
    struct Finest {
        std::size_t ladder = 0, level = 0;
        TrialMeasurement run;
    };

    std::vector<Finest> finest_runs(const std::vector<std::vector<TrialMeasurement>>& runs) const {
        std::vector<Finest> finest;
        for (std::size_t l = 0; l < runs.size(); ++l)
            for (std::size_t k = runs[l].size(); k-- > 0;)
                if (runs[l][k].is_measured()) {
                    finest.push_back({l, k, runs[l][k]});
                    break;
                }
        return finest;
    }

    /// The reference is the finest run that agrees best with those of the other methods; its own error is the distance
    /// to the nearest of them.  (A tolerance that is not yet binding makes one method agree with itself alone.)
    void find_reference(const std::vector<std::vector<TrialMeasurement>>& runs) {
        const std::vector<Finest> finest = finest_runs(runs);
        if (finest.empty())
            fail_run("no step of any method runs on {}; give a shorter time.dt",
                     found_.grids[found_.pilot_grid].level.name);
        if (finest.size() == 1 &&
            (finest.front().level == 0 || !runs[finest.front().ladder][finest.front().level - 1].is_measured())) {
            // Nothing to compare it with: its own bias is not known.
            const Finest& one = finest.front();
            reference_ = on_pilot_grid(ladders_[one.ladder].levels[one.level].overrides);
            reference_bias_.assign(found_.targets.size(), {INFINITY, 0.0});
            return;
        }
        double min_distance = INFINITY;
        for (const Finest& one : finest) {
            double distance = 0.0, nearest = INFINITY;
            std::vector<Bias> own(found_.targets.size());
            for (const Finest& other : finest) {
                if (other.ladder == one.ladder) continue;
                const std::vector<Bias> apart = bench_.differences(one.run, other.run);
                distance += std::min(bench_.ratio(apart), 1e6);
                if (bench_.ratio(apart) < nearest) own = apart;
                nearest = std::min(nearest, bench_.ratio(apart));
            }
            if (distance >= min_distance) continue;
            min_distance = distance;
            const StepLadder& ladder = ladders_[one.ladder];
            // Two methods may agree by chance: the error is at least that which the ladder itself shows.
            if (one.level > 0 && runs[one.ladder][one.level - 1].is_measured()) {
                const std::vector<Bias> last = bench_.differences(runs[one.ladder][one.level - 1], one.run);
                const double part = 1.0 / (std::pow(ladder.shorter, ladder.order) - 1.0);
                for (std::size_t w = 0; w < own.size(); ++w)
                    if (std::abs(part * last[w].value) > std::abs(own[w].value))
                        own[w] = {part * last[w].value, part * last[w].error};
            }
            reference_ = on_pilot_grid(ladder.levels[one.level].overrides);
            reference_bias_ = own;
        }
    }

    void collect_steps() {
        found_.ladders.clear();
        auto runs = mapped(ladders_, [this](const StepLadder& ladder) {
            return mapped(ladder.levels, [this](const AxisLevel& level) { return measured(level); });
        });
        reject_wrong_steps(runs);
        find_reference(runs);
        const TrialMeasurement reference = bench_.measured(reference_);
        if (!bench_.statistical && is_chaotic(runs, reference)) {
            bench_.statistical = true;
            find_reference(runs);
        }
        for (std::size_t l = 0; l < ladders_.size(); ++l) {
            std::vector<LevelFound>& found = found_.ladders.emplace_back();
            for (std::size_t k = 0; k < runs[l].size(); ++k) {
                const TrialMeasurement& run = runs[l][k];
                LevelFound level{.level = ladders_[l].levels[k], .outcome = run.outcome};
                if (level.is_measured()) {
                    level.biases = bench_.differences(run, reference);
                    // The reference has an error too: known in size, added in quadrature.
                    for (std::size_t w = 0; w < found_.targets.size(); ++w)
                        level.biases[w].error = std::hypot(level.biases[w].error, reference_bias_[w].value);
                    level.start_seconds = run.start_seconds;
                    level.step_seconds = run.step_seconds;
                }
                found.push_back(std::move(level));
            }
        }
        for (std::size_t w = 0; w < found_.targets.size(); ++w) {
            found_.references[w] =
                less(bench_.mean_of(reference.numbers[w]), found_.grids[found_.pilot_grid].biases[w]);
            bench_.allowed[w] = found_.targets[w].allowed(found_.references[w].value);
        }
        if (std::ranges::any_of(reference_bias_, [](const Bias& bias) { return !std::isfinite(bias.value); }))
            found_.notes.push_back(
                "the bias of the step was not measured: no other step and no other method ran; give a larger --budget");
        find_pairing();
    }

    void add_unsettled(std::vector<std::string> notes) {
        is_settled_ = is_settled_ && notes.empty();
        for (std::string& note : notes) found_.notes.push_back(std::move(note));
    }

    /// Whether fine runs without noise have all become independent of each other, although each fluctuates.  Where two
    /// of them agree, a third that does not is only less accurate.
    bool is_chaotic(const std::vector<std::vector<TrialMeasurement>>& runs, const TrialMeasurement& reference) const {
        if (!io::has_grid(bench_.scene.kind)) return false;
        bool any = false;
        for (const Finest& one : finest_runs(runs)) {
            if (bench_.ratio(bench_.differences(one.run, reference)) == 0.0) continue;  // the reference itself
            if (!bench_.are_independent(one.run, reference)) return false;
            any = true;
        }
        return any;
    }

    /// What pairing gains: the variance of the difference of two independent runs over that of paired ones, of the
    /// first target and the given step.
    void find_pairing() {
        if (!bench_.statistical || !io::has_grid(bench_.scene.kind)) return;
        const TrialMeasurement base = bench_.measured(on_pilot_grid({}));
        for (const std::vector<LevelFound>& ladder : found_.ladders)
            for (const LevelFound& level : ladder) {
                if (!level.is_measured() || !base.is_measured()) continue;
                const TrialMeasurement other = measured(level.level);
                const Bias paired = bench_.difference(other.numbers[0], base.numbers[0]);
                if (!(paired.error > 0.0)) continue;
                const double apart =
                    std::hypot(bench_.mean_of(other.numbers[0]).error, bench_.mean_of(base.numbers[0]).error);
                found_.pairing = std::pow(apart / paired.error, 2);
                return;
            }
    }

    bool measure_models() {
        const io::Scene on_pilot = pilot();
        const std::vector<AxisLevel> levels = model_levels(on_pilot);
        std::vector<TrialRun> trials;
        for (const AxisLevel& level : levels)
            if (!level.reason) trials.push_back(trial_of(level));
        for (const auto& changes : bench_.reseeded(on_pilot_grid({}))) trials.push_back(bench_.trial_of(changes));
        if (!bench_.run(trials)) return false;
        const TrialMeasurement full = bench_.measured(on_pilot_grid({}));
        if (!full.is_measured())
            fail_run("the full model was not run: {}; give a larger --budget", text_of(full.outcome));
        add_unsettled(bench_.widen(on_pilot_grid({})));
        found_.models.clear();
        for (const AxisLevel& level : levels) {
            const TrialMeasurement run =
                level.reason ? TrialMeasurement{.outcome = {LevelState::impossible, *level.reason}} : measured(level);
            LevelFound found{.level = level, .outcome = run.outcome, .biases = {}};
            if (found.is_measured()) {
                found.biases =
                    is_given(level) ? std::vector<Bias>(found_.targets.size()) : bench_.differences(run, full);
                found.start_seconds = run.start_seconds / std::max(full.start_seconds, 1e-3);
                found.step_seconds = run.step_seconds / std::max(full.step_seconds, 1e-9);
                if (level.saves_no_time) found.step_seconds = std::max(found.step_seconds, 1.0);
                found.fluctuations = bench_.fluctuations(run);
            }
            if (grid_is_model_ && level.has_one_row) found.outcome = {LevelState::grid_of_model};
            found_.models.push_back(std::move(found));
        }
        found_.linear_theory.reset();
        std::vector<Bias> linear;
        for (std::size_t w = 0; w < found_.targets.size(); ++w)
            if (const std::optional<double> value = full.numbers[w].linear_theory; value && std::isfinite(*value))
                linear.push_back({*value - found_.references[w].value, found_.references[w].error});
        if (linear.size() == found_.targets.size()) found_.linear_theory = linear;
        return true;
    }

    bool measure_rounding_and_cell() {
        std::optional<AxisLevel> cell = larger_cell(pilot());
        // The waves of a larger cell are others: the mean over a range of them is another number.
        const auto has_range = [](const AccuracyTarget& target) { return !target.ranges.empty(); };
        const bool is_other = io::has_grid(bench_.scene.kind) && std::ranges::any_of(found_.targets, has_range);
        if (is_other || !bench_.statistical || (cell && reason_against(bench_.scene, on_pilot_grid(cell->overrides))))
            cell.reset();
        std::vector<TrialRun> trials{bench_.trial_of(on_pilot_grid({}), true)};
        if (cell) trials.push_back(trial_of(*cell));
        if (!bench_.run(trials)) return false;
        const TrialMeasurement full = bench_.measured(on_pilot_grid({}));
        const TrialMeasurement up = bench_.measured(on_pilot_grid({}), true);
        found_.rounding = up.is_measured() ? bench_.differences(up, full) : std::vector<Bias>{};
        found_.cell.clear();
        if (!cell) return true;
        if (const TrialMeasurement large = measured(*cell); large.is_measured())
            for (std::size_t w = 0; w < found_.targets.size(); ++w)
                found_.cell.push_back(less(bench_.mean_of(full.numbers[w]), bench_.mean_of(large.numbers[w])));
        return true;
    }

    /// Trials of twice the duration: when they have not settled, no combination meets the targets yet, or they cost a
    /// small part of the run.
    bool wants_longer() {
        if (bench_.is_short || 3.0 * bench_.spent > bench_.budget) return false;
        TrialRun longer = bench_.trial_of({});
        longer.scene.time.end = 2.0 * bench_.duration;
        if (bench_.is_collecting && bench_.trials.find(longer) == nullptr) return false;
        if (!is_settled_) return true;
        const std::vector<Candidate> front = front_of(findings(), bench_.scene);
        const auto good = std::ranges::find_if(front, [](const Candidate& one) { return one.ratio <= 1.0; });
        constexpr double part = 0.1;  // of the recommended run, for the trials
        return good == front.end() || 2.0 * bench_.spent < part * good->seconds;
    }

    /// Axes may not be independent: the recommended combination is run for the duration of the trials, and replaced by
    /// the next when it fails.  False when a signal came.
    bool check_recommended() {
        constexpr int max_checks = 6;
        for (int n = 0; n < max_checks; ++n) {
            const std::vector<Candidate> front = front_of(findings(), bench_.scene);
            const Candidate* best = recommended(front, options_.run_budget);
            if (best == nullptr || best->parts.front().whole) return true;
            const std::vector<std::string> overrides = overrides_of(*best);
            if (!bench_.run({bench_.trial_of(overrides)})) return false;
            const TrialMeasurement run = bench_.measured(overrides), reference = bench_.measured(reference_);
            if (!run.outcome.was_run()) return true;
            Checked checked{.overrides = overrides, .outcome = run.outcome, .biases = {}, .fluctuations = {}};
            if (run.is_measured()) {
                checked.fluctuations = bench_.fluctuations(run);
                checked.biases = bench_.differences(run, reference);
                for (std::size_t w = 0; w < found_.targets.size(); ++w) {
                    const Bias grid = found_.grids[found_.pilot_grid].biases[w];
                    checked.biases[w] = {checked.biases[w].value + grid.value,
                                         std::hypot(checked.biases[w].error, grid.error, reference_bias_[w].value)};
                }
            }
            found_.checked.push_back(std::move(checked));
        }
        return true;
    }

    /// The duration at which the recommended run leaves the means of the trials, where these may last as long; else 0.
    double drifts_by() {
        const std::vector<Candidate> front = front_of(findings(), bench_.scene);
        const Candidate* best = recommended(front, options_.run_budget);
        if (best == nullptr || best->step == nullptr) return 0.0;
        const LaterDrift drift = later_drift(bench_, *best, found_.references);
        found_.stopped = drift.stopped;
        if (drift.affordable == 0.0) add_unsettled(drift.notes);
        return drift.affordable;
    }

    TradeBench bench_;
    TargetOptions options_;
    Findings found_;
    std::vector<StepLadder> ladders_;
    std::vector<std::string> reference_;  ///< changes of the reference of the steps
    std::vector<Bias> reference_bias_;    ///< of that reference, estimated
    GridSteps grid_steps_;                ///< of the last grids that were collected
    double refinement_ = 1.0;             ///< points of the scene's grid over those of the trials'
    bool is_settled_ = true;              ///< the trials are longer than the slowest fluctuation of a wanted number
    bool grid_is_model_ = false;          ///< wanted numbers do not converge with the grid
    AxisLevel given_grid_;                ///< the scene's, where it is finer
};
}  // namespace

Findings find_tradeoff(const io::Scene& scene, const TargetOptions& options) { return Study(scene, options).find(); }

}  // namespace drover::jobs
