// run/trade_start.cpp: the scene and the duration of the first trials.
#include "run/trade_start.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "drover/run/cost.hpp"
#include "drover/run/step_choice.hpp"
#include "run/trade_axes.hpp"
#include "run/trade_bench.hpp"

namespace drover::run {

io::Scene trial_scene(const io::Scene& scene) {
    require(scene.output.sample_every > 0.0, io::location_of(scene, "output.sample_every"),
            "output.sample_every = 0; expected samples, from which the wanted numbers follow: give an interval");
    io::Scene result = with_chosen_step(scene, true);
    result.time.chosen.clear();
    result.time.pilot.clear();
    if (io::has_grid(scene.kind)) result.output.frame_every = 0.0;
    if (io::has_grid(scene.kind)) result.accuracy.effort = 0.0;  // the trials themselves measure it
    return result;
}

io::Scene affordable_scene(const io::Scene& scene, double budget) {
    constexpr double part = 0.2;  // of the budget, for the first trial
    const auto is_affordable = [&](const io::Scene& one) {
        const std::optional<ExpectedTime> expected = expected_time(one);
        return !expected || expected->total <= part * budget;
    };
    if (is_affordable(scene)) return scene;
    const std::vector<Level> levels = grid_levels(scene, false);
    for (std::size_t k = levels.size(); k-- > 0;) {
        if (is_given(levels[k])) continue;
        const io::Scene coarser = changed(scene, levels[k].overrides);
        if (size_of(coarser) <= size_of(scene) && is_affordable(coarser)) return coarser;
    }
    fail_run(
        "a run of the scene takes {} of a core, and its trials as long each; the budget of {} is too small: give a "
        "larger --budget",
        duration_text(expected_time(scene)->total), duration_text(budget));
}

double unit_of_time(const io::Scene& scene) {
    return scene.kind == io::SceneKind::particles && scene.output.frame_every > 0.0 ? scene.output.frame_every
                                                                                    : scene.output.sample_every;
}

double first_duration(const io::Scene& scene, double budget) {
    constexpr double part = 1.0 / 40.0, least_samples = 64.0;
    const std::optional<ExpectedTime> expected = expected_time(scene);
    const double affordable =
        expected ? part * budget * scene.time.end / std::max(expected->total, 1e-9) : scene.time.end;
    const double unit = unit_of_time(scene);
    double duration = unit * std::ceil(least_samples * scene.output.sample_every / unit);
    while (2.0 * duration <= std::min(affordable, scene.time.end)) duration *= 2.0;
    return duration;
}

}  // namespace drover::run
