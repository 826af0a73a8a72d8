// io/scene_calibrated.cpp: the table that a scene names, into its model.
#include <algorithm>
#include <iterator>

#include "base/mapped.hpp"
#include "io/calibration.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"

namespace drover::io {

namespace {
bool is_given(const Scene& scene, const std::string& key) { return scene.places.contains(key); }

/// With one of the numbers of the mean field from the scene it is not that of the table.
bool has_mean_field_of_table(const Scene& scene, const std::vector<std::string>& missing) {
    for (const char* key : {"relaxation.rate", "weathercock.strength", "drag.coefficient", "driving.strength"})
        if (std::ranges::find(missing, key) == missing.end()) return false;
    return !is_given(scene, "relaxation.contact");
}

calibrate::StatePoint point_of(const Scene& scene, const calibrate::Table& table) {
    const CalibratedPlan& plan = scene.calibrated;
    // A resolved scene holds the key, also where there is nothing to choose from.
    const bool absent = plan.varied == 0.0 && (table.varied_key.empty() || !is_given(scene, "calibrated.varied"));
    return {.bead_fraction = plan.bead_area_fraction,
            .rod_fraction = plan.rod_area_fraction,
            .varied = calibrate::varied_index(table, absent ? std::nullopt : std::optional(plan.varied),
                                              "calibrated.varied", locate(scene, "calibrated.varied")),
            .outside = plan.outside};
}

/// use(table, point) of a scene.  A table is a file of its own; what it has not, this scene asked for.
template <class Use>
auto with_table(const Scene& scene, Use use) try {
    const calibrate::Table table = read_calibration(beside(scene.file, scene.calibrated.table));
    return use(table, point_of(scene, table));
} catch (const Error& error) {
    throw Error(error.fault(), locate(scene, "calibrated.table"), error.what());
}
}  // namespace

bool is_from_table(const Scene& scene, const std::string& key) {
    return std::ranges::find(scene.found.filled, key, &calibrate::FilledNumber::key) != scene.found.filled.end();
}

std::vector<physics::ModelValues> drawn_models(const Scene& scene, int count) {
    if (scene.found.filled.empty())
        return std::vector<physics::ModelValues>(static_cast<std::size_t>(count), scene.model);
    require(
        std::filesystem::exists(beside(scene.file, scene.calibrated.table)), locate(scene, "calibrated.table"),
        "no file {}; expected the table of the calibrated numbers, from which their errors are drawn: put it there, "
        "or leave the errors out by boundary.draws = 0",
        scene.calibrated.table);
    const auto keys = mapped(scene.found.filled, &calibrate::FilledNumber::key);
    return with_table(scene, [&](const calibrate::Table& table, const calibrate::StatePoint& point) {
        return calibrate::redrawn_models(table, point, keys, scene.model, count);
    });
}

void fill_from_table(Scene& scene) {
    CalibratedPlan& plan = scene.calibrated;
    if (plan.table.empty()) return;
    for (const auto& [key, fraction] : {std::pair{"calibrated.bead_area_fraction", plan.bead_area_fraction},
                                        std::pair{"calibrated.rod_area_fraction", plan.rod_area_fraction}})
        require(fraction > 0.0, locate(scene, key),
                "{} is not given; expected the area fraction of the scene, within those of {}", key, plan.table);
    const std::vector<std::string> missing =
        calibrate::missing_keys(scene.model, plan.coefficients == CoefficientsOf::local,
                                [&](const std::string& key) { return is_given(scene, key); });
    if (missing.empty()) return;
    with_table(scene, [&](const calibrate::Table& table, const calibrate::StatePoint& point) {
        std::ranges::move(calibrate::fill_model(table, point, missing, scene.model),
                          std::back_inserter(scene.found.filled));
        if (has_mean_field_of_table(scene, missing)) scene.found.expected = calibrate::expected_texts(table, point);
    });
}

Rows<CalibratedPlan> CalibratedPlan::rows() {
    using Plan = CalibratedPlan;
    return Rows<CalibratedPlan>{
        {"table", &Plan::table,
         "a file that drover calibrate made, beside the scene or where drover runs: it gives the numbers of the "
         "model that the scene leaves out"},
        {"bead_area_fraction", &Plan::bead_area_fraction, "Phi_b of the scene", "", within(0.0, 0.95)},
        {"rod_area_fraction", &Plan::rod_area_fraction, "Phi_r of the scene", "", within(0.0, 0.95)},
        {"varied", &Plan::varied,
         "the value of the key that the table varies, one of its own; of a table that has such a key"},
        {"coefficients", &Plan::coefficients,
         "uniform: those of these area fractions everywhere; local: a, b, Gamma, alpha and lambda follow "
         "the densities of each place, and a boundary has error bands"},
        {"outside", &Plan::outside, "densities beyond the table: refuse, or hold the value of its edge"},
    };
}

}  // namespace drover::io
