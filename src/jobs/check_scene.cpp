// jobs/check_scene.cpp: the checks of everything that a scene describes.
#include "jobs/check_scene.hpp"

#include "analysis/boundary.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "jobs/sweep/sweep.hpp"
#include "run/run_scene.hpp"
#include "run/simulation_type.hpp"

namespace drover::jobs {

std::vector<std::string> check_scene(const io::Scene& scene) {
    const run::SimulationType& type = run::simulation_type_of(scene);
    run::check_needs(scene, {.overwrite = true, .quiet = true});
    type.check_start(scene);
    if (!scene.sweep.vary.empty()) plan_sweep(scene);
    if (!scene.calibration.bead_area_fractions.empty()) plan_calibration(scene);
    analysis::check_boundary(scene);
    std::vector<std::string> warnings = type.warnings(scene);
    if (auto warning = run::disk_warning(run::needs_of(scene))) warnings.push_back(std::move(*warning));
    return warnings;
}

}  // namespace drover::jobs
