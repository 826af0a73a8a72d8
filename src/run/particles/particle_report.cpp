// run/particles/particle_report.cpp: the results of a run of particles from its archive.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "io/trajectory.hpp"
#include "measure/particles.hpp"
#include "measure/trajectories.hpp"
#include "run/particles/particle_simulation.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// The paths after the warm-up, read frame by frame; none where only the first and the last frame are kept.
std::optional<measure::Paths> paths_of(const files::ArchiveReader& archive, const io::Scene& scene,
                                       const dem::Bodies& bodies, double warm_up) {
    const double spacing = io::whole_interval(scene, "output.frame_every", scene.output.frame_every);
    const std::string rods = std::string(io::rods_group) + "/", beads = std::string(io::beads_group) + "/";
    const bool has_rods = !bodies.rods.empty(), has_beads = !bodies.beads.empty();
    if (!(spacing > 0.0) || (!has_rods && !has_beads)) return std::nullopt;
    const std::size_t end = rows_on_schedule(archive.read((has_rods ? rods : beads) + "position/time").values, spacing);
    const std::size_t first = std::min(end, static_cast<std::size_t>(std::ceil(warm_up / spacing - 1e-9)));
    measure::Paths paths = measure::make_paths(spacing, end - first, bodies.rods.size(), bodies.beads.size());
    const auto row = [&](bool wanted, const std::string& element, std::size_t frame) {
        return wanted ? archive.read_row(element + "/value", frame).values : std::vector<double>();
    };
    for (std::size_t frame = first; frame < end; ++frame)
        measure::add_frame(paths, row(has_rods, rods + "position", frame), row(has_rods, rods + "axis", frame),
                           row(has_beads, beads + "position", frame));
    return paths;
}

/// Takes the error of 0 from means that have changed before the samples they are of: nothing has happened since, as
/// without an impact, and may happen again.
void doubt_constant_means(const measure::Recorded& recorded, measure::Summary& summary) {
    for (measure::SummaryRow& row : summary.rows) {
        const measure::RecordedSeries* series = measure::find_row(recorded.series, row.name);
        if (series == nullptr) continue;
        for (std::size_t k = 0; k < row.estimates.size(); ++k) {
            measure::Estimate& estimate = row.estimates[k];
            if (estimate.error != 0.0) continue;
            std::vector<double> all;
            for (std::size_t i = k; i < series->values.size(); i += row.estimates.size())
                all.push_back(series->values[i]);
            if (measure::estimate_mean({.series = {all}, .spacing = recorded.spacing}, 0).error == 0.0) continue;
            estimate.error.reset();
            estimate.why_no_error =
                text("no error estimate: it is constant in the last {:.4g} s, but not before, and may change again",
                     static_cast<double>(estimate.samples) * recorded.spacing);
        }
    }
}
}  // namespace

Report make_particle_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory) {
    const dem::Bodies bodies = dem::make_bodies(scene.particles, static_cast<std::uint64_t>(scene.run.seed));
    const measure::ParticleSetting setting = measure::make_particle_setting(scene.particles, bodies);
    const Sampling sampling = sampling_of(archive, scene, io::series_group);
    auto rows = measure::particle_observables(setting);
    std::erase_if(rows, [&](const auto& row) {  // archives of earlier versions have fewer
        return !archive.has(std::string(io::series_group) + "/" + row.name);
    });
    measure::Recorded recorded =
        measure::particle_recording(setting, read_series(archive, io::series_group, rows, sampling.samples));
    Report report = summary_report(scene, sampling, recorded);
    doubt_constant_means(recorded, report.summary);
    report.warnings = particle_warnings(scene);
    std::ranges::move(particle_state_warnings(scene, bodies, recorded.series, sampling.spacing),
                      std::back_inserter(report.warnings));
    const double warm_up = static_cast<double>(report.summary.warm_up) * sampling.spacing;
    if (const std::optional<measure::Paths> paths = paths_of(archive, scene, bodies, warm_up)) {
        std::ranges::move(measure::path_rows(*paths), std::back_inserter(report.summary.rows));
        std::ranges::move(frame_warnings(*paths), std::back_inserter(report.warnings));
        std::ranges::move(scatter_warnings(*paths), std::back_inserter(report.warnings));
    }
    return report;
}

}  // namespace drover::run
