// jobs/trade_start.cpp: the scene and the duration of the first trials.
#include "jobs/trade_start.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "io/scene_text.hpp"
#include "jobs/trade_axes.hpp"
#include "jobs/trade_bench.hpp"
#include "run/cost.hpp"
#include "run/step_choice.hpp"

namespace drover::jobs {

io::Scene trial_scene(const io::Scene& scene) {
    require(scene.output.sample_every > 0.0, io::location_of(scene, "output.sample_every"),
            "output.sample_every = 0; expected samples, from which the wanted numbers follow: give an interval");
    io::Scene result = run::with_chosen_step(scene, true);
    result.time.chosen.clear();
    result.time.pilot.clear();
    if (io::has_grid(scene.kind)) result.output.frame_every = 0.0;
    if (io::has_grid(scene.kind)) result.accuracy.effort = 0.0;  // the trials themselves measure it
    return result;
}

double unit_of_time(const io::Scene& scene) {
    return scene.kind == io::SceneKind::particles && scene.output.frame_every > 0.0 ? scene.output.frame_every
                                                                                    : scene.output.sample_every;
}

namespace {
/// On the finest grid on which one trial takes at most a fifth of the budget [core seconds]; none where there is none.
std::optional<io::Scene> affordable_scene(const io::Scene& scene, double budget) {
    constexpr double part = 0.2;  // of the budget, for the first trial
    const auto is_affordable = [&](const io::Scene& one) {
        const std::optional<run::ExpectedTime> expected = run::expected_time(one);
        return !expected || expected->total <= part * budget;
    };
    if (is_affordable(scene)) return scene;
    const std::vector<Level> levels = grid_levels(scene, false);
    for (std::size_t k = levels.size(); k-- > 0;) {
        if (is_given(levels[k])) continue;
        const io::Scene coarser = io::changed(scene, levels[k].overrides);
        if (size_of(coarser) <= size_of(scene) && is_affordable(coarser)) return coarser;
    }
    return std::nullopt;
}

/// Of affordable_scene().
[[noreturn]] void fail_too_small(const io::Scene& scene, double budget) {
    const std::optional<run::ExpectedTime> expected = run::expected_time(scene);
    fail_run(
        "a run of the scene takes {} of a core, and its trials as long each; the budget of {} is too small: give a "
        "larger --budget",
        duration_text(expected ? expected->total : 0.0), duration_text(budget));
}

/// Of a run that takes a fortieth of the budget, and makes 64 samples at least [s].
double first_duration(const io::Scene& scene, double budget) {
    constexpr double part = 1.0 / 40.0, least_samples = 64.0;
    const std::optional<run::ExpectedTime> expected = run::expected_time(scene);
    const double affordable =
        expected ? part * budget * scene.time.end / std::max(expected->total, 1e-9) : scene.time.end;
    const double unit = unit_of_time(scene);
    double duration = unit * std::ceil(least_samples * scene.output.sample_every / unit);
    while (2.0 * duration <= std::min(affordable, scene.time.end)) duration *= 2.0;
    return duration;
}
}  // namespace

std::optional<TrialStart> trial_start(TradeBench& bench) {
    const io::Scene& scene = bench.scene;
    const std::string of = text("-{:.17g}", bench.budget);
    TrialStart start{.scene = scene, .duration = scene.time.end};
    if (bench.statistical) {
        const auto found =
            bench.agreed("duration" + of, [&] { return std::vector{first_duration(scene, bench.budget)}; });
        if (!found) return std::nullopt;
        start.duration = found->front();
        return start;
    }
    const auto found = bench.agreed("grid" + of, [&]() -> std::vector<double> {
        const std::optional<io::Scene> one = affordable_scene(scene, bench.budget);
        if (!one) return {};
        return {static_cast<double>(one->grid.nx), static_cast<double>(one->grid.ny)};
    });
    if (!found) return std::nullopt;
    if (found->empty()) fail_too_small(scene, bench.budget);
    const auto nx = static_cast<int>((*found)[0]), ny = static_cast<int>((*found)[1]);
    if (nx != scene.grid.nx || ny != scene.grid.ny)
        start.scene = io::changed(scene, {text("grid.nx={}", nx), text("grid.ny={}", ny)});
    return start;
}

}  // namespace drover::jobs
