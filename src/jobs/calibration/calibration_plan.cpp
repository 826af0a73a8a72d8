// jobs/calibration/calibration_plan.cpp: assays at points, from the section [calibrate].
#include <algorithm>

#include "base/mapped.hpp"
#include "calibrate/catalogue.hpp"
#include "io/scene_text.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "run/number_lists.hpp"

namespace drover::jobs {

namespace {
constexpr const char *calibrate_key = "calibrate.vary", *calibrate_example = "\"kick.strength = 0.01, 0.02\"";

void read_varied(const io::Scene& scene, calibrate::Table& axes) {
    const std::string& written = scene.calibration.vary;
    if (written.empty()) return;
    const SourceLocation where = io::locate(scene, calibrate_key);
    const auto [key, values] = run::read_assignment(written, calibrate_key, calibrate_example, where);
    for (const char* own :
         {"run.", "output.", "sweep.", "analysis.", "calibrate.", "packing.", "forces.", "time.", "beads.area_fraction",
          "beads.count", "rods.area_fraction", "rods.count", "cell.shape", "gravity.x", "gravity.y"})
        require(!key.starts_with(own), where,
                "calibrate.vary names {}; expected a key of the bodies, the plates or the contacts", key);
    axes.varied_key = key;
    axes.varied = mapped(run::split(values, ','), [&](const std::string& word) {
        return run::read_number(word, written, calibrate_key, calibrate_example, where);
    });
    require(!axes.varied.empty(), where, "calibrate.vary = \"{}\" has no values; expected at least one", written);
    for (std::size_t i = 1; i < axes.varied.size(); ++i)
        require(axes.varied[i] > axes.varied[i - 1], where, "calibrate.vary has {} after {}; expected ascending values",
                axes.varied[i], axes.varied[i - 1]);
}

/// Assays hold and release beds whose mean velocity is zero without their forces.
void require_level_plates(const io::Scene& scene) {
    const dem::Gravity& gravity = scene.particles.gravity;
    for (const auto& [key, value] : {std::pair{"gravity.x", gravity.x}, std::pair{"gravity.y", gravity.y}})
        require(value == 0.0, io::locate(scene, key),
                "{} = {} mm/s^2: tilted plates drive the bed, which the assays of drover calibrate would take for what "
                "they measure; expected 0",
                key, value);
}

std::string section_of(const std::string& assay) { return "calibrate." + assay; }

/// The plan of one assay, as scene text.
std::string plan_of(const io::Scene& scene, const std::string& assay) {
    const std::string section = section_of(assay), keys = section + ".";
    return "\n" +
           io::chosen_text(scene, [&](const std::string& one) { return one == section || one.starts_with(keys); });
}

/// What every trial depends on, whatever its assay and point: the scene with all other keys at their defaults, and
/// without the plans of the assays.  A new assay, or another plan of one, leaves the trials of all others valid.
std::string manifest_of(io::Scene scene) {
    const int single_rods = scene.calibration.single_rods;
    scene.calibration = {};
    scene.calibration.single_rods = single_rods;
    scene.output = {};
    scene.analysis = {};
    scene.sweep = {};
    scene.time.end = io::TimeControl{}.end;
    scene.run.threads = 0;
    scene.particles.packing = {};
    scene.particles.forces = {};
    scene.particles.beads.count = scene.particles.rods.count = 0;
    scene.particles.beads.area_fraction = scene.particles.rods.area_fraction = 0.0;
    std::vector<std::string> plans;
    calibrate::for_plans(scene.plans, [&](const std::string& assay, const char*, const auto&) {
        plans.push_back(section_of(assay));
    });
    return io::chosen_text(scene, [&](const std::string& one) { return std::ranges::find(plans, one) == plans.end(); });
}

/// The setup of one point.  Values are checked here, before anything runs.
dem::Setup setup_at(const io::Scene& scene, const CalibrationLayout& layout, const CalibrationUnit& unit) {
    const calibrate::Table& axes = layout.axes;
    io::Scene alone = scene;  // assays place bodies and act on them themselves
    alone.particles.packing = {};
    alone.particles.forces = {};
    std::vector<std::string> overrides{"beads.count=0", text("beads.area_fraction={}", axes.bead_fractions[unit.bead])};
    const auto rods = [&](const std::string& count, const std::string& fraction) {
        overrides.push_back("rods.count=" + count);
        overrides.push_back("rods.area_fraction=" + fraction);
    };
    switch (layout.assays[unit.assay].population) {
        case calibrate::Population::beads: rods("0", "0"); break;
        case calibrate::Population::single_rods: rods(text("{}", scene.calibration.single_rods), "0"); break;
        case calibrate::Population::all: rods("0", text("{}", axes.rod_fractions[unit.rod])); break;
    }
    if (!axes.varied_key.empty()) overrides.push_back(text("{}={}", axes.varied_key, axes.varied[unit.varied]));
    return io::changed(alone, overrides).particles;
}

void add_unit(const io::Scene& scene, CalibrationUnit unit, CalibrationLayout& layout) {
    const calibrate::Table& axes = layout.axes;
    const calibrate::Assay& assay = layout.assays[unit.assay];
    std::string point = text("bead-{}", axes.bead_fractions[unit.bead]);
    if (assay.population == calibrate::Population::all) point += text("-rod-{}", axes.rod_fractions[unit.rod]);
    if (!axes.varied_key.empty()) point += text("-{}-{}", axes.varied_key, axes.varied[unit.varied]);
    unit.name = assay.name + "-" + point;
    const dem::Setup setup = setup_at(scene, layout, unit);
    if (assay.check) assay.check(setup, [&](const std::string& key) { return io::locate(scene, key); });
    unit.conditions = {.setup = setup,
                       .seed = calibrate::trial_seed(static_cast<std::uint64_t>(scene.run.seed), point, 0)};
    layout.units.push_back(std::move(unit));
}
}  // namespace

CalibrationLayout plan_calibration(const io::Scene& scene) {
    io::require_kind(scene, io::SceneKind::particles, "calibrate");
    const io::CalibrationPlan& plan = scene.calibration;
    require(dem::is_periodic(scene.particles.cell), io::locate(scene, "cell.shape"),
            "cell.shape = \"{}\"; expected \"periodic\" for drover calibrate", scene.particles.cell.shape);
    require_level_plates(scene);
    require(!plan.bead_area_fractions.empty(), io::locate(scene, "calibrate.bead_area_fractions"),
            "nothing to calibrate; expected calibrate.bead_area_fractions, such as [0.2, 0.4, 0.6]");
    CalibrationLayout layout;
    layout.goal = {.relative_error = plan.relative_error,
                   .round = static_cast<std::size_t>(plan.round),
                   .max_trials = static_cast<std::size_t>(plan.max_trials)};
    layout.manifest = manifest_of(scene);
    io::Scene standard;
    standard.kind = io::SceneKind::particles;
    layout.defaults = io::resolved_text(standard);
    for (calibrate::Assay& assay : calibrate::make_assays(scene.plans))
        if (plan.assays.empty() || std::ranges::find(plan.assays, assay.name) != plan.assays.end())
            layout.assays.push_back(std::move(assay));
    layout.plans = mapped(layout.assays, [&](const calibrate::Assay& assay) { return plan_of(scene, assay.name); });
    layout.axes.bead_fractions = plan.bead_area_fractions;
    layout.axes.rod_fractions = plan.rod_area_fractions;
    read_varied(scene, layout.axes);
    constexpr double max_points = 10000.0;
    const double points = static_cast<double>(layout.axes.varied.size() * plan.bead_area_fractions.size()) *
                          static_cast<double>(std::max<std::size_t>(1, plan.rod_area_fractions.size()));
    require(points <= max_points, io::locate(scene, "calibrate.bead_area_fractions"),
            "a calibration of {:.3g} points; expected at most {:.0e}: choose fewer values", points, max_points);
    for (std::size_t varied = 0; varied < layout.axes.varied.size(); ++varied)
        for (std::size_t bead = 0; bead < plan.bead_area_fractions.size(); ++bead)
            for (std::size_t a = 0; a < layout.assays.size(); ++a) {
                const bool by_rods = layout.assays[a].population == calibrate::Population::all;
                require(!by_rods || !plan.rod_area_fractions.empty(), io::locate(scene, "calibrate.rod_area_fractions"),
                        "calibrate.rod_area_fractions is empty, but {} depends on it; set it, such as [0.05, 0.1], or "
                        "select other calibrate.assays",
                        layout.assays[a].name);
                for (std::size_t rod = 0; rod < (by_rods ? plan.rod_area_fractions.size() : 1); ++rod)
                    add_unit(scene,
                             {.name = {}, .assay = a, .varied = varied, .bead = bead, .rod = rod, .conditions = {}},
                             layout);
            }
    return layout;
}

}  // namespace drover::jobs
