// run/warnings/particle_warnings.cpp: what the results of a run of particles cannot be trusted in.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/base/text.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// Adds a warning that `what` stopped if the observable is below `threshold` from some sample to the last of at least
/// two.
void add_stopped(const std::string& observable, const std::string& what,
                 const std::vector<measure::RecordedSeries>& series, double spacing, double threshold,
                 std::vector<std::string>& warnings) {
    const std::vector<double> values = values_of(series, observable);
    std::size_t first = values.size();
    while (first > 0 && values[first - 1] <= threshold) --first;
    if (first + 1 >= values.size()) return;
    warnings.push_back(text(
        "{}: {} is {:.2g} mg mm2 s-2 from t = {:.6g} s to the end (expected more than {:.2g}): an absorbing state; "
        "choose a larger plates.amplitude, more beads or rods, more restitution or less "
        "friction, or end the run before",
        what, observable, values.back(), spacing * static_cast<double>(first), threshold));
}

struct BodyKind {
    std::string prefix, bodies;
    std::size_t count = 0;
    double scale = 0.0;
};
/// Temperatures are relative to the mean of all bodies of a kind: of one body they are zero at any speed.
void add_temperatures(const BodyKind& kind, const std::vector<measure::RecordedSeries>& series, double spacing,
                      std::vector<std::string>& warnings) {
    constexpr double part = 1e-12;
    if (kind.count < 2) return;
    const std::string all = text("all {} {}", kind.count, kind.bodies);
    add_stopped(kind.prefix + "_temperature_horizontal", all + " are at rest in the plane, or move as one", series,
                spacing, part * kind.scale, warnings);
    add_stopped(kind.prefix + "_temperature_vertical", all + " move up and down in step, or rest on a plate", series,
                spacing, part * kind.scale, warnings);
}
}  // namespace

std::vector<std::string> unit_warnings(const dem::Setup& setup) {
    const dem::Plates& plates = setup.plates;
    const double rate = 2.0 * std::numbers::pi * plates.frequency, acceleration = plates.amplitude * rate * rate,
                 gravity = std::abs(setup.gravity.z);
    if (plates.amplitude == 0.0) return {};  // at rest, by choice
    if (acceleration < gravity)
        return {
            text("plates.amplitude = {} mm at plates.frequency = {} /s accelerates by at most {:.3g} mm/s2, less "
                 "than gravity, {:.4g} mm/s2: no body leaves the bottom plate; expected lengths in mm and times in "
                 "s: choose plates.amplitude above {:.2g} mm, or a higher frequency",
                 plates.amplitude, plates.frequency, acceleration, gravity, gravity / (rate * rate))};
    double smallest = INFINITY;
    const auto add = [&](bool is_there, const std::vector<double>& diameters) {
        for (const double one : diameters)
            if (is_there) smallest = std::min(smallest, one);
    };
    add(setup.beads.any(), setup.beads.diameters);
    add(setup.rods.any(), setup.rods.diameters);
    if (plates.amplitude <= smallest) return {};
    return {
        text("plates.amplitude = {} mm exceeds the diameter of the smallest body, {} mm; expected a small part of "
             "it, as in experiments, with lengths in mm",
             plates.amplitude, smallest)};
}

std::vector<std::string> particle_state_warnings(const io::Scene& scene, const dem::Bodies& bodies,
                                                 const std::vector<measure::RecordedSeries>& series, double spacing) {
    std::vector<std::string> warnings;
    BodyKind beads{.prefix = "bead", .bodies = "beads", .count = bodies.beads.size()},
        rods{.prefix = "rod", .bodies = "rods", .count = bodies.rods.size()};
    const dem::Plates& plates = scene.particles.plates;
    const double speed = 2.0 * std::numbers::pi * plates.frequency * plates.amplitude;
    const auto scale_of = [&](std::uint32_t shape) {  // energy that the plates and gravity can give [mg mm^2/s^2]
        const dem::Shape& s = bodies.shapes[shape];
        return s.mass * (speed * speed + std::abs(scene.particles.gravity.z) * (2.0 * s.radius.front()));
    };
    for (const dem::Bead& bead : bodies.beads) beads.scale += scale_of(bead.shape) / static_cast<double>(beads.count);
    for (const dem::Rod& rod : bodies.rods) rods.scale += scale_of(rod.shape) / static_cast<double>(rods.count);
    add_temperatures(beads, series, spacing, warnings);
    add_temperatures(rods, series, spacing, warnings);
    const double whole = beads.scale * static_cast<double>(beads.count) + rods.scale * static_cast<double>(rods.count);
    add_stopped("energy_kinetic", "all bodies are at rest", series, spacing, 1e-12 * whole, warnings);

    const std::vector<double> gained = values_of(series, "work_impact"), kinetic = values_of(series, "energy_kinetic");
    if (!gained.empty() && !kinetic.empty() && gained.back() > 1e-9 * kinetic.back())
        warnings.push_back(text(
            "impacts gained {:.3g} mg mm2 s-2 (work_impact; expected 0 or less): contacts.restitution = \"{}\" can "
            "create energy where the slip turns; choose \"energetic\"",
            gained.back(), scene.particles.contacts.restitution));
    return warnings;
}

std::vector<std::string> scatter_warnings(const measure::Paths& paths) {
    constexpr double max_scatter = 3.0;  // of what few rods scatter by chance
    if (paths.rods.empty() || paths.added < 2) return {};
    const double scatter = measure::speeds_along(paths.rods, paths.angles, paths.spacing).scatter;
    if (!(scatter > max_scatter)) return {};  // NaN: not known
    return {
        text("the mean speeds of rods differ by {:.2g} times their errors over time, as they do for rods of different "
             "sizes or gaits: errors over time alone, such as that of rod_velocity_along, hold for these rods only, "
             "and other seeds differ by more; run several seeds (drover sweep --seeds)",
             scatter)};
}

std::vector<std::string> frame_warnings(const measure::Paths& paths) {
    constexpr double min_part = 0.9;  // of the speed
    const double kept = measure::persistence(paths);
    if (!(kept < 1.0)) return {};  // NaN: without rods
    // Of a rod that turns at random: the mean of n(t).n(0) = exp(-t/tau) over a frame.
    const double part = kept > 0.0 ? (kept - 1.0) / std::log(kept) : 0.0;
    if (part >= min_part) return {};
    return {
        text("rods turn between frames of {} s (the mean cosine of a turn is {:.2g}): rod_speed, d.n/T with n at the "
             "start of a frame, is at most {:.2g} of the speed along n; reduce output.frame_every",
             paths.spacing, kept, part)};
}

}  // namespace drover::run
