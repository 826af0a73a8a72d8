// tests/jobs/normal_world.hpp: a calibration whose trials are normal numbers, with a known onset.
#pragma once
#include "drover/base/random.hpp"
#include "io/scene.hpp"
#include "jobs/calibration/calibration_layout.hpp"

namespace drover::jobs {

/// One result, the mean of the trials.
inline calibrate::Assay mean_assay(const char* name, const char* quantity, calibrate::Population population) {
    return {.name = name,
            .population = population,
            .quantities = {{quantity, "x", "mean"}},
            .trial = {},
            .estimator =
                [](std::span<const calibrate::Trial>) {
                    return [](std::span<const double> means) -> std::vector<double> { return {means[0]}; };
                },
            .conclude = {}};
}

/// Flocks from Phi_b = 0.45: alpha/Gamma = 1 + 4 Phi_b, a = 0.28, lambda = 0.1.
inline jobs::CalibrationLayout normal_layout() {
    const io::Scene scene = io::parse_scene(R"(
[cell]
lx = 20.0
ly = 20.0
[rods]
area_fraction = 0.05
[calibrate]
bead_area_fractions = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7]
rod_area_fractions = [0.05]
assays = ["relaxation", "weathercock", "drag"]
)",
                                            "normal.toml", {});
    jobs::CalibrationLayout layout = jobs::plan_calibration(scene);
    layout.goal = calibrate::TrialSet::no_goal();
    layout.assays = {mean_assay("relaxation", "relaxation_rate", calibrate::Population::single_rods),
                     mean_assay("weathercock", "weathercock", calibrate::Population::single_rods),
                     mean_assay("drag", "drag", calibrate::Population::all)};
    return layout;
}

/// Relative standard deviations over trials.
struct NormalScatter {
    double rods = 0.3;   ///< of a and lambda
    double drag = 0.02;  ///< of alpha/Gamma, which costs ten times as much
};

inline calibrate::Attempt trial_of(const jobs::CalibrationLayout& layout, std::size_t u, std::uint64_t number,
                                   std::uint64_t seed, const NormalScatter& scatter = {}) {
    const jobs::CalibrationUnit& unit = layout.units[u];
    const double bead = layout.axes.bead_fractions[unit.bead];
    const double mean = unit.assay == 0 ? 0.28 : unit.assay == 1 ? 0.1 : 1.0 + 4.0 * bead;
    std::vector<double> normal(1);
    fill_normal({.seed = seed, .stream = Stream::test, .step = u}, number, 1, normal);
    return {.number = number,
            .numbers = {mean * (1.0 + (unit.assay == 2 ? scatter.drag : scatter.rods) * normal[0])},
            .failure = {},
            .core_seconds = unit.assay == 2 ? 10.0 : 1.0};
}

}  // namespace drover::jobs
