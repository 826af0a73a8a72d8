// run/simulation_type.cpp: the kinds of scenes.
#include "run/simulation_type.hpp"

#include "io/scene.hpp"
#include "io/trajectory.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/particles/particle_simulation.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

const SimulationType& simulation_type_of(const io::Scene& scene) {
    static const SimulationType fields{
        .make = make_field_simulation,
        .threads = choose_threads,
        .bytes = field_bytes,
        .size = field_size,
        .body = "a grid of",
        .size_key = "grid.nx",
        .start = "initial",
        .timed = timed_fields,
        .check_start = check_field_start,
        .warnings = [](const io::Scene& given) { return field_scene_warnings(given, compiled_of(given)); },
        .report = make_field_report};
    static const SimulationType particles{.make = make_particle_simulation,
                                          .threads = particle_threads,
                                          .bytes = particle_bytes,
                                          .size = particle_size,
                                          .body = "a world of",
                                          .size_key = "beads.area_fraction",
                                          .start = "packing",
                                          .timed = timed_particles,
                                          .check_start = check_particle_start,
                                          .warnings = particle_warnings,
                                          .report = make_particle_report};
    return scene.kind == io::SceneKind::particles ? particles : fields;
}

io::Scene archived_scene(const files::ArchiveReader& archive) {
    return io::archived_scene(archive.text_attribute("scene"), archive.text_attribute("scene_file"));
}

bool is_start(const files::ArchiveReader& archive) {
    return io::has_trajectory(archive) && !archive.has(std::string(io::series_group) + "/time");
}

Report make_report(const files::ArchiveReader& archive, Theory theory) {
    return make_report(archive, archived_scene(archive), theory);
}

Report make_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory) {
    Report report = simulation_type_of(scene).report(archive, scene, theory);
    if (scene.analysis.warm_up >= scene.time.end)
        report.warnings.push_back(
            text("analysis.warm_up = {} is not shorter than the run, time.end = {}: the warm-up was "
                 "found from the series instead",
                 scene.analysis.warm_up, scene.time.end));
    return report;
}

}  // namespace drover::run
