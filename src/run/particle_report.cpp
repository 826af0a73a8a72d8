// run/particle_report.cpp: from an archive of a run of particles to its results.
#include "drover/io/trajectory.hpp"
#include "drover/measure/particle_summary.hpp"
#include "drover/run/particle_simulation.hpp"

namespace drover::run {

std::vector<measure::ParticleObservable> recorded_observables(const measure::ParticleSetting& setting) {
    std::vector<measure::ParticleObservable> rows = measure::particle_observables(setting);
    std::erase_if(rows, [&](const auto& row) { return measure::size_of(row, setting) == 0; });
    return rows;
}

std::vector<io::Axis> series_axes(const measure::ParticleSetting& setting,
                                  std::span<const measure::ParticleObservable> observables) {
    std::vector<io::Axis> axes;
    for (const measure::ParticleObservable& row : observables)
        for (const measure::ParticleAxis axis : row.axes) {
            const measure::AxisValues values = measure::axis_of(axis, setting);
            if (std::none_of(axes.begin(), axes.end(), [&](const io::Axis& one) { return one.name == values.name; }))
                axes.push_back({values.name, values.unit, values.meaning, values.values});
        }
    return axes;
}

Report make_particle_report(const io::ArchiveReader& archive, const io::Scene& scene) {
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
    return report;
}

}  // namespace drover::run
