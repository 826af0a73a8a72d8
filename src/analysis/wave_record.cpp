// analysis/wave_record.cpp: reads frames of fields or of bodies, and keeps their longest waves.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/wave_fit.hpp"
#include "drover/base/error.hpp"
#include "drover/base/text.hpp"
#include "drover/numerics/transform.hpp"
#include "io/trajectory.hpp"
#include "run/loop/signals.hpp"

namespace drover::analysis {

namespace {
using calibrate::WaveRecord;
using numerics::Complex;
constexpr std::size_t max_waves = 400;

/// Frames at equal times: numbers of the first and of those after it.
struct FrameTimes {
    std::vector<std::size_t> numbers;
    double spacing = 0.0;
};

/// Whether the last frame, that of the end of a run, comes sooner after the one before than the others do.
bool ends_off_schedule(const std::vector<double>& times, const std::vector<std::size_t>& numbers) {
    const std::size_t count = numbers.size();
    if (count < 3 || numbers.back() + 1 != times.size()) return false;
    const double first = times[numbers[1]] - times[numbers[0]],
                 last = times[numbers[count - 1]] - times[numbers[count - 2]];
    return last < (1.0 - 1e-6) * first;
}

FrameTimes frames_of(const std::vector<double>& times, const std::string& name, const WaveChoice& choice) {
    require(choice.every >= 1, {name}, "every {} frames; expected at least 1", choice.every);
    const double end = choice.end.value_or(times.empty() ? 0.0 : times.back());
    require(choice.begin >= 0.0 && end >= 0.0, {name}, "frames from {} to {}; expected times of 0 or more",
            io::in_unit("{}", choice.begin, "s", choice.units), io::in_unit("{}", end, "s", choice.units));
    const double slack = times.size() > 1 ? 1e-6 * (times[1] - times[0]) : 0.0;
    FrameTimes frames;
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (times[i] < choice.begin - slack || times[i] > end + slack) continue;
        if (!frames.numbers.empty() && i % static_cast<std::size_t>(choice.every) !=
                                           frames.numbers.front() % static_cast<std::size_t>(choice.every))
            continue;
        frames.numbers.push_back(i);
    }
    if (ends_off_schedule(times, frames.numbers)) frames.numbers.pop_back();
    const std::size_t count = frames.numbers.size();
    const auto time_text = [&](double time) { return io::in_unit("{:.6g}", time, "s", choice.units); };
    require(count > calibrate::min_wave_pairs, {name},
            "has {} frames from {} to {}, one in {}; expected at least {}: run it with a smaller "
            "output.frame_every, or for longer",
            count, time_text(choice.begin), time_text(end), choice.every, calibrate::min_wave_pairs + 1);
    frames.spacing = (times[frames.numbers.back()] - times[frames.numbers.front()]) / static_cast<double>(count - 1);
    for (std::size_t k = 1; k < count; ++k) {
        const double apart = times[frames.numbers[k]] - times[frames.numbers[k - 1]];
        require(std::abs(apart - frames.spacing) <= 1e-6 * frames.spacing, {name},
                "has frames {} apart at {}, where the mean is {}; expected equal times: choose a "
                "part of the run with --from and --to",
                time_text(apart), time_text(times[frames.numbers[k]]), time_text(frames.spacing));
    }
    return frames;
}

/// Integer wavenumbers of the cell, one of each pair q and -q, and the mean.
struct Wavenumber {
    int x = 0, y = 0;
};
std::vector<Wavenumber> wavenumbers_of(double lx, double ly, const std::string& name, const WaveChoice& choice) {
    const double turn = 2.0 * std::numbers::pi, smallest = turn / std::max(lx, ly),
                 largest = choice.max_wavenumber.value_or(3.0 * smallest) * (1.0 + 1e-9);
    const std::string shown = io::in_unit("{:.4g}", largest, "/mm", choice.units);
    require(largest >= 0.0, {name}, "a largest wavenumber of {}; expected 0 or more", shown);
    const double columns = largest * lx / turn, rows = largest * ly / turn;
    require(std::numbers::pi / 2.0 * columns * rows <= 2.0 * static_cast<double>(max_waves), {name},
            "a largest wavenumber of {}; expected one below which there are at most {} waves: choose {:.3g}", shown,
            max_waves, 3.0 * smallest);
    std::vector<Wavenumber> found{{0, 0}};
    for (int x = 0; x <= static_cast<int>(columns); ++x)
        for (int y = -static_cast<int>(rows); y <= static_cast<int>(rows); ++y)
            if ((x > 0 || y > 0) && std::hypot(turn * x / lx, turn * y / ly) <= largest) found.push_back({x, y});
    require(found.size() <= max_waves, {name}, "{} waves up to {}; expected at most {}: choose {:.3g}", found.size(),
            shown, max_waves, 3.0 * smallest);
    return found;
}

WaveRecord record_of(double lx, double ly, const std::vector<Wavenumber>& waves, const FrameTimes& frames) {
    WaveRecord record{.spacing = frames.spacing, .area = lx * ly, .frames = frames.numbers.size()};
    const double turn = 2.0 * std::numbers::pi;
    for (const Wavenumber& wave : waves) record.q.push_back({turn * wave.x / lx, turn * wave.y / ly});
    record.amplitudes.resize(waves.size());
    return record;
}

void require_finite(const std::vector<double>& values, const std::string& name, const std::string& what,
                    std::size_t frame) {
    require(std::ranges::all_of(values, [](double value) { return std::isfinite(value); }), {name},
            "{} is not finite in frame {}; choose a part of the run before it with --to", what, frame);
}

std::vector<double> times_of(const files::ArchiveReader& archive, const std::string& name, const std::string& path) {
    require(archive.has(path), {name}, "has no frames; expected the archive of a run with output.frame_every > 0");
    return archive.read(path).values;
}

/// Plane components of one vector of each body in a frame.
struct Plane {
    std::vector<double> x, y;
};

class BodyFrames {
public:
    BodyFrames(const files::ArchiveReader& archive, const std::string& name) : archive_(archive), name_(name) {}

    bool has(const char* group) const { return archive_.has(path(group, "position")); }
    Plane plane(const char* group, const char* element, std::size_t frame) const {
        const files::Array row = archive_.read_row(path(group, element), frame);
        require(row.shape.size() == 2 && row.shape[1] == 3, {name_}, "{} is not an array of vectors; it is damaged",
                path(group, element));
        require_finite(row.values, name_, path(group, element), frame);
        Plane plane;
        for (std::size_t i = 0; i < row.values.size(); i += 3) {
            plane.x.push_back(row.values[i]);
            plane.y.push_back(row.values[i + 1]);
        }
        return plane;
    }

private:
    static std::string path(const char* group, const char* element) { return text("{}/{}/value", group, element); }
    const files::ArchiveReader& archive_;
    const std::string& name_;
};

/// Sum of weights exp(-i q r).
Complex wave_sum(const numerics::Wavevector& q, const Plane& at, const std::vector<double>& weights) {
    Complex sum = 0.0;
    for (std::size_t i = 0; i < at.x.size(); ++i) sum += weights[i] * std::polar(1.0, -(q.x * at.x[i] + q.y * at.y[i]));
    return sum;
}

constexpr const char* bead_body = "bead";
}  // namespace

WaveRecord field_waves(const files::ArchiveReader& archive, const std::string& name, const RecordedFields& recorded,
                       const WaveChoice& choice) {
    const numerics::Grid& grid = recorded.grid;
    const FrameTimes frames = frames_of(times_of(archive, name, "/time"), name, choice);
    std::vector<Wavenumber> waves;
    std::vector<std::size_t> modes;
    for (const Wavenumber& wave : wavenumbers_of(grid.lx, grid.ly, name, choice)) {
        if (2 * wave.x >= grid.nx || 2 * std::abs(wave.y) >= grid.ny) continue;
        const auto column = static_cast<std::size_t>(wave.x),
                   row = static_cast<std::size_t>(wave.y < 0 ? wave.y + grid.ny : wave.y);
        if (!numerics::is_kept(grid, recorded.kept_degree, column, row)) continue;  // the run holds it at zero
        waves.push_back(wave);
        modes.push_back(row * numerics::columns(grid) + column);
    }
    WaveRecord record = record_of(grid.lx, grid.ly, waves, frames);
    const std::vector<RecordedFields::Component>& components = recorded.components;
    Threads threads(1);
    const numerics::Transform transform(grid, 1, threads);
    numerics::Fields fields(grid, static_cast<int>(components.size()));
    numerics::Spectra spectra(grid, fields.count());
    for (const RecordedFields::Component& one : components)
        require(archive.has("/" + one.name) && archive.text_attribute("/" + one.name, "units") == one.unit, {name},
                "has no {} in {}; expected the fields of the model", one.name, one.unit);
    for (const std::size_t frame : frames.numbers) {
        run::check_stop_signal();
        for (std::size_t c = 0; c < components.size(); ++c) {
            const files::Array row = archive.read_row("/" + components[c].name, frame);
            require(row.values.size() == fields.size, {name}, "has {} points of {} in frame {}; expected {} by {}",
                    row.values.size(), components[c].name, frame, grid.nx, grid.ny);
            require_finite(row.values, name, components[c].name, frame);
            std::ranges::copy(row.values, fields[static_cast<int>(c)].begin());
        }
        transform.forward(fields, spectra);
        for (std::size_t n = 0; n < modes.size(); ++n)
            for (int c = 0; c < spectra.count(); ++c) record.amplitudes[n].push_back(spectra[c][modes[n]]);
    }
    return record;
}

WaveRecord particle_waves(const files::ArchiveReader& archive, const std::string& name, const io::Scene& scene,
                          const model::Model& model, const WaveChoice& choice) {
    const dem::Cell& cell = scene.particles.cell;
    require(dem::is_periodic(cell), {name}, "is a run in a {} cell; expected a periodic one, which has waves",
            cell.shape);
    const std::vector<double> times = times_of(archive, name, std::string(io::spheres_group) + "/position/time");
    FrameTimes frames = frames_of(times, name, choice);
    const BodyFrames bodies(archive, name);
    const bool has_beads =
        std::ranges::any_of(model.fields, [](const model::Field& field) { return field.observed.body == bead_body; });
    require(!has_beads || bodies.has(io::beads_group), {name}, "has no beads; expected some, as in the model");
    require(bodies.has(io::rods_group), {name}, "has no rods; expected some, whose order the model describes");
    if (has_beads) {  // velocities need a frame on either side
        if (frames.numbers.front() == 0) frames.numbers.erase(frames.numbers.begin());
        if (frames.numbers.back() + 1 == times.size()) frames.numbers.pop_back();
    }
    WaveRecord record = record_of(cell.lx, cell.ly, wavenumbers_of(cell.lx, cell.ly, name, choice), frames);
    const double area = record.area;
    for (const std::size_t frame : frames.numbers) {
        run::check_stop_signal();
        const Plane rods = bodies.plane(io::rods_group, "position", frame),
                    axes = bodies.plane(io::rods_group, "axis", frame);
        require(axes.x.size() == rods.x.size(), {name}, "has {} positions and {} axes of rods; it is damaged",
                rods.x.size(), axes.x.size());
        Plane beads, flow;
        if (has_beads) {
            beads = bodies.plane(io::beads_group, "position", frame);
            const Plane before = bodies.plane(io::beads_group, "position", frame - 1);
            flow = bodies.plane(io::beads_group, "position", frame + 1);
            const double time = (times[frame + 1] - times[frame - 1]) * static_cast<double>(beads.x.size());
            for (std::size_t i = 0; i < flow.x.size(); ++i) {
                flow.x[i] = (flow.x[i] - before.x[i]) / time;
                flow.y[i] = (flow.y[i] - before.y[i]) / time;
            }
        }
        for (std::size_t n = 0; n < record.q.size(); ++n) {
            const numerics::Wavevector& q = record.q[n];
            std::vector<Complex>& to = record.amplitudes[n];
            for (const model::Field& field : model.fields) {
                if (field.left != model::LeftSide::rate) continue;
                const bool is_of_beads = field.observed.body == bead_body;
                const Plane& at = is_of_beads ? beads : rods;
                // A mean over the bodies, or a sum over those of a unit of area.  The flow is a mean already.
                const double of = is_of_beads ? 1.0 : field.unit == "1" ? static_cast<double>(at.x.size()) : area;
                const Plane& vectors = is_of_beads ? flow : axes;
                if (field.spin == 0) to.push_back(wave_sum(q, at, std::vector(at.x.size(), 1.0 / area)));
                else
                    for (const std::vector<double>* part : {&vectors.x, &vectors.y})
                        to.push_back(wave_sum(q, at, *part) / of);
            }
        }
    }
    return record;
}

}  // namespace drover::analysis
