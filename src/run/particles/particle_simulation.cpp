// run/particles/particle_simulation.cpp: a simulation of bodies between plates, world and recordings; the results of a
// run of particles from its archive.
#include "run/particles/particle_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "dem/bodies/plate_motion.hpp"
#include "dem/contact/contact_law.hpp"
#include "dem/packing/packing.hpp"
#include "drover/dem/world.hpp"
#include "files/bytes.hpp"
#include "io/scene.hpp"
#include "io/trajectory.hpp"
#include "measure/particles.hpp"
#include "measure/trajectories.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
std::uint64_t seed_of(const io::Scene& scene) { return static_cast<std::uint64_t>(scene.run.seed); }

dem::Bodies bodies_of(const io::Scene& scene) {
    return dem::make_bodies(scene.particles, seed_of(scene),
                            [&](const std::string& key) { return io::locate(scene, key); });
}

/// The shape and size of a cell, for messages.
std::string cell_text(const dem::Cell& cell) {
    if (cell.shape == dem::CellShape::circle) return text("circle of radius {} mm", cell.radius);
    if (cell.shape == dem::CellShape::flower)
        return text("flower of {} petals of radius {} mm about a radius of {} mm", cell.petals, cell.petal_radius,
                    cell.radius);
    return text("{} cell of {} by {} mm", cell.shape, cell.lx, cell.ly);
}

/// The frame of a file that a packing names.  Heights and velocities are relative to the base, whose phase differs at t
/// = 0.
dem::Bodies bodies_of_file(const io::Scene& scene) {
    const dem::Packing& packing = scene.particles.packing;
    const SourceLocation where = io::locate(scene, "packing.file");
    const std::string what = text("packing.file = \"{}\"", packing.file);
    require(!packing.file.empty(), io::locate(scene, "packing.kind"),
            "packing.kind = \"file\" without packing.file; expected an archive of a run of the same bodies");
    const files::ArchiveReader archive = named_archive(scene, "packing.file", packing.file);
    require(io::has_trajectory(archive), where,
            "{} holds no trajectory; expected an archive of a run of the same bodies", what);
    const auto frames = static_cast<int>(io::frame_count(archive));
    require(frames >= 1 && packing.frame < frames && packing.frame >= -1, io::locate(scene, "packing.frame"),
            "packing.frame = {}; expected one of the frames 0 to {} of the archive, or -1 for the last", packing.frame,
            frames - 1);
    const auto frame = static_cast<std::size_t>(packing.frame < 0 ? frames - 1 : packing.frame);
    warn_of_unfinished(archive, "packing.file", packing.file, packing.frame);
    dem::Bodies bodies = bodies_of(scene);
    io::read_bodies(archive, frame, bodies, what, where);
    const io::Scene source = io::parse_scene(archive.text_attribute("scene"), packing.file);
    const std::string theirs = cell_text(source.particles.cell), ours = cell_text(scene.particles.cell);
    require(theirs == ours, where, "{} lies in a {} and this scene in a {}; expected the same cell", what, theirs,
            ours);
    const double time = archive.read(std::string(io::spheres_group) + "/position/time").values.at(frame);
    const dem::PlateState now = dem::PlateMotion(scene.particles.plates).base(),
                          then = dem::PlateMotion(source.particles.plates, time).base();
    const double lift = now.height - then.height, push = -then.velocity;
    const auto move = [&](auto& body) {
        body.position.z += lift;
        body.velocity.z += push;
    };
    std::ranges::for_each(bodies.beads, move);
    std::ranges::for_each(bodies.rods, move);
    std::vector<double> places;  // of the frame: other kicks than those of its run, and of a run that went on from it
    for (const dem::Rod& rod : bodies.rods) places.insert(places.end(), {rod.position.x, rod.position.y});
    constexpr std::uint64_t blocks = 1u << 20u;
    constexpr std::int64_t longest = std::int64_t{1} << 40;  // number of kicks of one rod in one run
    bodies.first_kick =
        longest * static_cast<std::int64_t>(1 + files::checksum(std::as_bytes(std::span(places))) % blocks);
    return bodies;
}

/// Visits the vectors of all bodies in a fixed order.
template <class AnyBodies, class Visit>
void for_vectors(AnyBodies& bodies, Visit visit) {
    for (auto& bead : bodies.beads)
        for (auto* vector : {&bead.position, &bead.velocity, &bead.spin}) visit(*vector);
    for (auto& rod : bodies.rods)
        for (auto* vector : {&rod.position, &rod.velocity, &rod.axis, &rod.angular_momentum}) visit(*vector);
}

std::size_t saved_of_bodies(const dem::Bodies& bodies) { return 9 * bodies.beads.size() + 12 * bodies.rods.size(); }

constexpr std::size_t saved_before = 2;  // time and energy_start; then the bodies, then the world's own state

/// The bodies of a checkpoint.
dem::Bodies bodies_of_saved(const io::Scene& scene, std::span<const double> saved) {
    dem::Bodies bodies = bodies_of(scene);
    require(saved.size() > saved_before + saved_of_bodies(bodies), {},
            "the checkpoint holds {} numbers; the {} beads and {} rods of this scene have more", saved.size(),
            bodies.beads.size(), bodies.rods.size());
    std::size_t i = saved_before;
    for_vectors(bodies, [&](dem::Vector& vector) {
        vector = {saved[i], saved[i + 1], saved[i + 2]};
        i += 3;
    });
    return bodies;
}

dem::Bodies start_bodies(const io::Scene& scene, std::span<const double> saved) {
    if (!saved.empty()) return bodies_of_saved(scene, saved);
    if (scene.particles.packing.kind == dem::PackingKind::file) return bodies_of_file(scene);
    return dem::pack(scene.particles, seed_of(scene), [&](const std::string& key) { return io::locate(scene, key); });
}

RunBytes bytes_of(const io::Scene& scene, const dem::Bodies& bodies, const measure::ParticleSetting& setting) {
    constexpr double per_sphere = 2000.0, fixed = 4e6;  // state, contacts, neighbours, rows, a checkpoint's copies
    const auto spheres = static_cast<double>(io::sphere_count(bodies));
    double sample = 1.0;
    for (const auto& row : measure::particle_observables(setting))
        sample += static_cast<double>(measure::size_of(row.axes));
    const double frame = 9.0 * spheres + static_cast<double>(saved_of_bodies(bodies) + 20);
    return {.memory = fixed + per_sphere * spheres, .disk = recorded_bytes(scene, frame, sample)};
}

class ParticleSimulation final : public Simulation {
public:
    ParticleSimulation(const io::Scene& the_scene, dem::Bodies bodies, Threads& the_threads)
        : Simulation(the_scene.time.dt, io::whole_steps(the_scene, "time.end", the_scene.time.end),
                     the_threads.count()),
          scene_(the_scene),
          setting_(measure::make_particle_setting(scene_.particles, bodies)),
          world_(
              scene_.particles, std::move(bodies), dt, seed_of(scene_), the_threads,
              [this](const std::string& key) { return io::locate(scene_, key); },
              false),  // a packing has no overlaps; see check_start() and restore()
          energy_start_(world_.energy_kinetic()) {
        bytes = bytes_of(scene_, world_.bodies(), setting_);
        const std::int64_t every = io::whole_steps(scene_, "output.frame_every", scene_.output.frame_every);
        for (const io::BodyRecording& one : io::trajectory_recordings(scene_.particles, world_.bodies()))
            recordings.push_back({one.recording, every, [this, make_row = one.row, group = one.recording.group] {
                                      return store_in_place(rows_[group], make_row(scene_.particles, world_.bodies()));
                                  }});
        recordings.push_back(samples());
    }

    void advance(std::int64_t step) override {
        world_.advance(step);
        time_ = static_cast<double>(step + 1) * dt;
    }

    void check_health(std::int64_t step) override {
        if (std::isfinite(world_.energy_kinetic())) return;
        fail_run(
            "the solution became NaN or infinite at or before step {} (t = {:.6g} s): {}; the last checkpoint is "
            "still valid",
            step, static_cast<double>(step) * scene_.time.dt, world_.non_finite());
    }

    std::vector<double> save() const override {
        std::vector<double> values{time_, energy_start_};
        const dem::Bodies bodies = world_.bodies();
        for_vectors(bodies, [&](const dem::Vector& vector) {
            values.insert(values.end(), {vector.x, vector.y, vector.z});
        });
        const std::vector<double> state = world_.save();
        values.insert(values.end(), state.begin(), state.end());
        return values;
    }

    void restore(std::span<const double> saved) override {
        const std::size_t before = saved_before + saved_of_bodies(world_.bodies());
        require(saved.size() > before, {}, "the checkpoint holds {} numbers; this world has more than {}", saved.size(),
                before);
        time_ = saved[0];
        energy_start_ = saved[1];
        world_.restore(saved.subspan(before));
    }

    void accept(std::int64_t step) override {
        if (rows_.empty()) return;  // nobody has changed them
        dem::Bodies bodies = world_.bodies();
        io::set_bodies(rows_[io::beads_group], rows_[io::rods_group], bodies, "the frame", {});
        world_.set_bodies(bodies, step);
    }

    /// Impacts, groups, overlaps and the energy balance.
    std::string describe() const override {
        const dem::Counts counts = world_.counts();
        const dem::EnergyBalance balance = world_.balance();
        const dem::OverlapRecord worst = world_.worst_overlap();
        const double now = world_.energy_kinetic(), change = now - energy_start_;
        double largest = std::abs(now);
        for (const auto entry : dem::balance_parts) largest = std::max(largest, std::abs(balance.*entry));
        std::string words = text(
            "impacts: {} bead-bead, {} rod-bead, {} rod-rod, {} bead-plate, {} rod-plate, {} bead-wall, {} rod-wall",
            counts.bead_bead, counts.rod_bead, counts.rod_rod, counts.bead_plate, counts.rod_plate, counts.bead_wall,
            counts.rod_wall);
        if (dem::PairwiseLaw::is_chosen(scene_.particles.contacts))
            words += text("; {} with less friction, which would have created energy", counts.limited);
        else
            words += text("; {} groups, the largest of {} contacts, {} unresolved", counts.groups, counts.largest_group,
                          counts.unresolved);
        words += text("; {} neighbour lists", counts.lists);
        if (worst.depth > 0.0)
            words += text("; largest overlap {:.2g} of a radius ({} and {}, t = {:.6g} s)", worst.of_radius,
                          dem::name_text(worst.first), dem::name_text(worst.second), worst.time);
        words += text(
            "; energy in mg mm2/s2: plates {:.4g}, gravity {:.4g}, forces {:.4g}, kicks {:.4g}, impacts {:.4g}, "
            "friction {:.4g}; change of the kinetic energy {:.4g}",
            balance.plates, balance.gravity, balance.forces, balance.kicks, balance.impact, balance.friction, change);
        if (largest > 0.0)
            words += text(", balanced to {:.1e} of the largest", std::abs(change - dem::sum(balance)) / largest);
        return words;
    }

    /// Throws an input Error where bodies of a file overlap in this scene, or are beyond its plates.
    void check_start() try { world_.set_bodies(world_.bodies(), 0); } catch (const Error& error) {
        throw Error(error.fault(), io::locate(scene_, "packing.file"),
                    text("the start in packing.file: {}", error.message()));
    }

private:
    ScheduledRecording samples() {
        const auto rows = measure::particle_observables(setting_);
        return sample_recording(scene_, io::series_group, measure::axes_of(rows), quantities_of(rows), [this, rows] {
            return measure_all(rows, measure::ParticleMoment{.setting = setting_,
                                                             .bodies = world_.bodies(),
                                                             .time = time_,
                                                             .balance = world_.balance(),
                                                             .counts = world_.counts(),
                                                             .energy_kinetic = world_.energy_kinetic()});
        });
    }

    io::Scene scene_;
    measure::ParticleSetting setting_;
    dem::World world_;
    double time_ = 0.0, energy_start_;
    std::map<std::string, std::vector<std::vector<double>>> rows_;  // of the latest frame, by group
};

double spheres_of(const io::Scene& scene) { return static_cast<double>(io::sphere_count(bodies_of(scene))); }

/// The steps within which the single rod of pairwise_rod.csv keeps its speed, at plates of 200 /s.
std::vector<std::string> pairwise_warnings(const io::Scene& scene) {
    constexpr double max_dt = 2e-5, max_rod_step = 2e-6, frequency = 200.0;
    const double faster = std::max(1.0, scene.particles.plates.frequency / frequency);
    const bool rods = scene.particles.rods.any();
    std::vector<std::string> long_steps;
    if (scene.time.dt * faster > max_dt) long_steps.push_back(text("time.dt = {} s", scene.time.dt));
    if (rods && std::min(scene.particles.contacts.rod_step, scene.time.dt) * faster > max_rod_step)
        long_steps.push_back(text("contacts.rod_step = {} s", scene.particles.contacts.rod_step));
    if (long_steps.empty()) return {};
    return {joined(long_steps, " and ") +
            text(" at plates.frequency = {} /s: longer than the steps (time.dt = {} s, contacts.rod_step = {} s, "
                 "plates of {} /s) below which the pairwise law has converged; its rods change speed and "
                 "direction with longer ones",
                 scene.particles.plates.frequency, max_dt, max_rod_step, frequency)};
}

std::vector<std::string> step_warnings(const io::Scene& scene) {
    if (scene.particles.contacts.model != dem::ContactModel::impulse) return {};  // check_contact_law() limits the step
    if (dem::PairwiseLaw::is_chosen(scene.particles.contacts)) return pairwise_warnings(scene);
    // The ranges of rod_step.csv, bed_step.csv and rod_laws.csv, at plates of 200 /s.
    constexpr double min_dt = 2e-6, max_dt = 5e-5, max_substep = 5e-5, frequency = 200.0, max_gap = 1e-4,
                     max_threshold = 0.1;
    const double faster = std::max(1.0, scene.particles.plates.frequency / frequency);
    const double dt = scene.time.dt * faster, substep = scene.particles.contacts.substep * faster;
    const bool rods = scene.particles.rods.any();
    std::vector<std::string> outside;
    if (dt < min_dt || dt > max_dt)
        outside.push_back(
            text("time.dt = {} s at plates.frequency = {} /s", scene.time.dt, scene.particles.plates.frequency));
    if (rods && substep > max_substep)
        outside.push_back(text("contacts.substep = {} s", scene.particles.contacts.substep));
    if (const double gap = scene.particles.contacts.simultaneity_gap; gap > max_gap)
        outside.push_back(text("contacts.simultaneity_gap = {} mm (above {})", gap, max_gap));
    if (const double threshold = scene.particles.contacts.inelastic_threshold; threshold > max_threshold)
        outside.push_back(text("contacts.inelastic_threshold = {} (above {})", threshold, max_threshold));
    if (outside.empty()) return {};
    return {
        joined(outside, " and ") +
        text(": outside the range of the time-step study ({} to {} s, substep at most {} s, plates of {} /s): compare "
             "with a run of half the step",
             min_dt, max_dt, max_substep, frequency)};
}
/// Bodies thinner than a gap between the spheres of a rod pass through it.
std::vector<std::string> gap_warnings(const io::Scene& scene) {
    double widest = 0.0, longest = INFINITY;  // of a rod whose spheres touch
    for (const dem::Shape& shape : dem::shapes_of(scene.particles))
        for (std::size_t i = 0; i + 1 < shape.at.size(); ++i) {
            const double reach = shape.radius[i] + shape.radius[i + 1];
            widest = std::max(widest, shape.at[i + 1] - shape.at[i] - reach);
            longest = std::min(longest, reach * static_cast<double>(shape.at.size() - 1) + shape.radius.front() +
                                            shape.radius.back());
        }
    constexpr double rounding = 1e-9;  // mm
    if (widest <= rounding) return {};
    return {
        text("the spheres of a rod are up to {:.3g} mm apart, and thinner bodies pass between them; expected spheres "
             "that touch: give rods.length <= {:.4g} mm, or more rods.diameters",
             widest, longest)};
}

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

int particle_threads(const io::Scene& scene) {
    if (scene.run.threads > 0) return scene.run.threads;
    // With less work per thread, waking a thread costs more than it saves.
    constexpr double spheres_per_thread = 20000.0;
    return std::clamp(static_cast<int>(std::min(spheres_of(scene) / spheres_per_thread, 64.0)), 1, usable_cores());
}

RunBytes particle_bytes(const io::Scene& scene) {
    const dem::Bodies bodies = bodies_of(scene);
    return bytes_of(scene, bodies, measure::make_particle_setting(scene.particles, bodies));
}

std::string particle_size(const io::Scene& scene) {
    const dem::Bodies bodies = bodies_of(scene);
    return text("{} beads and {} rods", bodies.beads.size(), bodies.rods.size());
}

std::vector<std::string> particle_warnings(const io::Scene& scene) {
    std::vector<std::string> warnings = unit_warnings(scene.particles);
    std::ranges::move(step_warnings(scene), std::back_inserter(warnings));
    std::ranges::move(gap_warnings(scene), std::back_inserter(warnings));
    const dem::Setup& setup = scene.particles;
    const dem::BodyForces& forces = setup.forces;
    const bool has_beads = setup.beads.any(), has_rods = setup.rods.any();
    if (!has_rods && (forces.torque != 0.0 || forces.rod_x != 0.0 || forces.rod_y != 0.0))
        warnings.emplace_back("forces.torque, rod_x and rod_y have no effect without rods");
    if (!has_beads && (forces.push != 0.0 || forces.bead_x != 0.0 || forces.bead_y != 0.0))
        warnings.emplace_back("forces.push, bead_x and bead_y have no effect without beads");
    if (spheres_of(scene) == 0.0)
        warnings.emplace_back(
            "the cell has neither beads nor rods: nothing will move; give beads.area_fraction, rods.area_fraction or "
            "their counts");
    return warnings;
}

TimedScene timed_particles(const io::Scene& scene) {
    constexpr double max_spheres = 4000.0;
    const double spheres = spheres_of(scene), scale = std::sqrt(std::min(1.0, max_spheres / std::max(spheres, 1.0)));
    io::Scene timed = scene;
    if (timed.particles.packing.kind == dem::PackingKind::file) timed.particles.packing = {};
    if (scale == 1.0) return {timed, 1.0};
    for (double* side : {&timed.particles.cell.lx, &timed.particles.cell.ly, &timed.particles.cell.radius,
                         &timed.particles.cell.petal_radius})
        *side *= scale;
    for (int* count : {&timed.particles.beads.count, &timed.particles.rods.count})
        if (*count > 0) *count = std::max(1, static_cast<int>(scale * scale * *count));
    return {timed, spheres / std::max(spheres_of(timed), 1.0)};
}

void check_particle_start(const io::Scene& scene) {
    if (scene.particles.packing.kind == dem::PackingKind::file) bodies_of_file(scene);
}

std::unique_ptr<Simulation> make_particle_simulation(const io::Scene& scene, Threads& threads,
                                                     std::span<const double> saved) {
    auto simulation = std::make_unique<ParticleSimulation>(scene, start_bodies(scene, saved), threads);
    if (!saved.empty()) simulation->restore(saved);
    else if (scene.particles.packing.kind == dem::PackingKind::file) simulation->check_start();
    return simulation;
}

Report make_particle_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory) {
    const dem::Bodies bodies = bodies_of(scene);
    const measure::ParticleSetting setting = measure::make_particle_setting(scene.particles, bodies);
    const Sampling sampling = sampling_of(archive, scene, io::series_group);
    measure::Recorded recorded =
        measure::particle_recording(setting, read_series(archive, io::series_group,
                                                         measure::particle_observables(setting), sampling.samples));
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
