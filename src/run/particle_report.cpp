// run/particle_report.cpp: from an archive of a run of particles to its results.
#include <cmath>

#include "drover/io/trajectory.hpp"
#include "drover/measure/particle_summary.hpp"
#include "drover/measure/path_summary.hpp"
#include "drover/run/particle_simulation.hpp"

namespace drover::run {

std::vector<measure::ParticleObservable> recorded_observables(const measure::ParticleSetting& setting) {
    std::vector<measure::ParticleObservable> rows = measure::particle_observables(setting);
    std::erase_if(rows, [&](const auto& row) { return measure::size_of(row, setting) == 0; });
    return rows;
}

std::vector<files::Axis> series_axes(const measure::ParticleSetting& setting,
                                     std::span<const measure::ParticleObservable> observables) {
    std::vector<files::Axis> axes;
    for (const measure::ParticleObservable& row : observables)
        for (const measure::ParticleAxis axis : row.axes) {
            const measure::AxisValues values = measure::axis_of(axis, setting);
            if (std::none_of(axes.begin(), axes.end(), [&](const files::Axis& one) { return one.name == values.name; }))
                axes.push_back({values.name, values.unit, values.meaning, values.values});
        }
    return axes;
}

namespace {
/// Frames that stand on the schedule (the last one may not) and the first of them that is not warm-up.
struct FrameRange {
    std::size_t first = 0, end = 0;
};
FrameRange frames_on_schedule(const std::vector<double>& times, double spacing, double warm_up) {
    FrameRange range;
    while (range.end < times.size() &&
           std::abs(times[range.end] - spacing * static_cast<double>(range.end)) < 1e-6 * spacing)
        ++range.end;
    range.first = std::min(range.end, static_cast<std::size_t>(std::ceil(warm_up / spacing - 1e-9)));
    return range;
}

/// What paths say after the warm-up, frame by frame; nothing where the scene asks for the first and the last frame alone.
std::vector<measure::SummaryRow> path_rows(const files::ArchiveReader& archive, const io::Scene& scene,
                                           const dem::Bodies& bodies, double warm_up) {
    const double spacing = scene.output.frame_every;
    const std::string rods = std::string(io::rods_group) + "/", beads = std::string(io::beads_group) + "/";
    const bool has_rods = !bodies.rods.empty(), has_beads = !bodies.beads.empty();
    if (!(spacing > 0.0) || (!has_rods && !has_beads)) return {};
    const std::vector<double> times = archive.read((has_rods ? rods : beads) + "position/time").values;
    const FrameRange range = frames_on_schedule(times, spacing, warm_up);
    measure::Paths paths =
        measure::make_paths(spacing, range.end - range.first, bodies.rods.size(), bodies.beads.size());
    const auto row = [&](bool wanted, const std::string& element, std::size_t frame) {
        return wanted ? archive.read_row(element + "/value", frame).values : std::vector<double>();
    };
    for (std::size_t frame = range.first; frame < range.end; ++frame)
        measure::add_frame(paths, row(has_rods, rods + "position", frame), row(has_rods, rods + "axis", frame),
                           row(has_beads, beads + "position", frame));
    return measure::path_rows(paths);
}
}  // namespace

Report make_particle_report(const files::ArchiveReader& archive, const io::Scene& scene) {
    const dem::Bodies bodies = dem::make_bodies(scene.particles, static_cast<std::uint64_t>(scene.run.seed));
    const measure::ParticleSetting setting = measure::make_particle_setting(scene.particles, bodies);
    const std::vector<measure::ParticleObservable> observables = recorded_observables(setting);
    const Sampling sampling = sampling_of(archive, scene, io::series_group);
    std::vector<std::vector<double>> series;
    for (const measure::ParticleObservable& row : observables) {
        series.push_back(archive.read(std::string(io::series_group) + "/" + row.name).values);
        series.back().resize(sampling.samples * measure::size_of(row, setting));
    }
    Report report;
    report.scene = scene;
    report.axes = series_axes(setting, observables);
    report.time = sampling.end;
    report.summary = measure::summarise(measure::ParticleRecorded{.setting = setting,
                                                                  .observables = observables,
                                                                  .series = series,
                                                                  .spacing = sampling.spacing,
                                                                  .warm_up = sampling.warm_up});
    const double warm_up = static_cast<double>(report.summary.warm_up) * sampling.spacing;
    for (measure::SummaryRow& row : path_rows(archive, scene, bodies, warm_up))
        report.summary.rows.push_back(std::move(row));
    return report;
}

}  // namespace drover::run
