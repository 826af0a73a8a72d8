// run/field_simulation.cpp: fields, their stepper and their observables behind the loop's functions.
#include "drover/run/field_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "drover/measure/observables.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/physics/energy.hpp"
#include "drover/run/field_evolution.hpp"

namespace drover::run {

namespace {
using numerics::Complex;

/// All that the functions of one simulation share.
struct World {
    io::Scene scene;
    physics::Form form;
    FieldEvolution evolution;
    numerics::Transform transform;
    numerics::Spectra state, healthy;  // healthy: at the last health check
    numerics::Fields fields;
    numerics::Fields slaved;     // the velocity of the beads, of a slaved form
    numerics::Spectra velocity;  // the same as modes, of every form that has one
    std::optional<physics::EnergyMeter> energy;
    double time = 0.0;
    measure::Setting setting;
    std::vector<measure::Observable> observables;
    std::vector<std::vector<double>> measured;

    World(const io::Scene& the_scene, Threads& threads);
    void bring_to_grid();
};

/// Where the values of a field stand along an axis.
std::vector<double> cell_corners(int count, double side) {
    std::vector<double> result;
    for (int i = 0; i < count; ++i) result.push_back(side / count * i);
    return result;
}

/// A frame of an archive as the state; fields, points and sides of the cell must be the scene's.
numerics::Fields frame_of(const files::ArchiveReader& archive, const io::Scene& scene, const physics::Form& form) {
    const SourceLocation here = io::location_of(scene, "initial.file");
    const std::vector<physics::Component> names = physics::component_names(form);
    numerics::Fields frame(scene.grid, static_cast<int>(names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string dataset = "/" + names[c].name;
        require(archive.has(dataset), here, "initial.file = \"{}\" has no field {}; expected an archive of this model",
                scene.initial.file, names[c].name);
        const std::vector<std::size_t> shape = archive.shape(dataset);
        require(shape.size() == 3 && shape[1] == static_cast<std::size_t>(scene.grid.ny) &&
                    shape[2] == static_cast<std::size_t>(scene.grid.nx) &&
                    archive.read("/x").values == cell_corners(scene.grid.nx, scene.grid.lx) &&
                    archive.read("/y").values == cell_corners(scene.grid.ny, scene.grid.ly),
                here, "initial.file = \"{}\" is of another grid or cell; expected {} by {} points on {} by {} mm",
                scene.initial.file, scene.grid.nx, scene.grid.ny, scene.grid.lx, scene.grid.ly);
        const auto frames = static_cast<int>(shape[0]);
        require(scene.initial.frame < frames && frames >= 1, io::location_of(scene, "initial.frame"),
                "initial.frame = {}; expected one of the frames 0 to {} of the archive, or -1 for the last",
                scene.initial.frame, frames - 1);
        const int number = scene.initial.frame < 0 ? frames - 1 : scene.initial.frame;
        const files::Array row = archive.read_row(dataset, static_cast<std::size_t>(number));
        require(std::all_of(row.values.begin(), row.values.end(), [](double value) { return std::isfinite(value); }),
                here,
                "initial.file = \"{}\" has a {} that is not finite in frame {}; expected numbers: choose another frame",
                scene.initial.file, names[c].name, number);
        std::copy(row.values.begin(), row.values.end(), frame[static_cast<int>(c)].begin());
    }
    return frame;
}

numerics::Spectra spectra_of_file(const io::Scene& scene, const World& world) {
    numerics::Spectra state(scene.grid, numerics::components(world.evolution.system().layout));
    std::optional<files::ArchiveReader> archive;
    try {
        archive.emplace(file_beside(scene, scene.initial.file));
    } catch (const Error& error) {
        fail_input(io::location_of(scene, "initial.file"), "initial.file: {}", error.what());
    }
    world.transform.forward(frame_of(*archive, scene, world.form), state);
    return state;
}

World::World(const io::Scene& the_scene, Threads& threads)
    : scene(the_scene),
      form(physics::form(scene.model)),
      evolution(scene, threads),
      transform(scene.grid, evolution.system().degree, threads),
      fields(scene.grid, numerics::components(evolution.system().layout)) {
    const numerics::System& system = evolution.system();
    if (scene.output.powers) energy.emplace(evolution.equations(), scene.grid, scene.dealiasing, threads);
    setting =
        measure::make_setting(scene.grid, form, system.degree, energy ? energy->terms() : std::vector<std::string>{});
    observables = measure::observables(form, scene.output.powers);
    state = scene.initial.kind == "file"
                ? spectra_of_file(scene, *this)
                : physics::initial_spectra(scene.initial, scene.model, system,
                                           static_cast<std::uint64_t>(scene.run.seed), threads);
    healthy = state;
    evolution.start(state);
    for (const measure::Observable& observable : observables)
        measured.emplace_back(measure::size_of(observable, setting));
}

/// The state on the grid, and the velocity of the beads where the form has one.
void World::bring_to_grid() {
    transform.backward(state, fields);
    if (form.velocity == physics::Velocity::absent) return;
    if (velocity.size == 0) velocity = numerics::Spectra(scene.grid, 2);
    if (form.velocity == physics::Velocity::slaved) {
        slaved = physics::slaved_velocity(evolution.equations(), evolution.system(), time, state, transform);
        transform.forward(slaved, velocity);
        return;
    }
    for (int axis = 0; axis < 2; ++axis)
        std::copy(state[form.bead_velocity + axis].begin(), state[form.bead_velocity + axis].end(),
                  velocity[axis].begin());
}

files::Recording frame_recording(const World& world) {
    const numerics::Grid& grid = world.scene.grid;
    files::Recording recording{.group = "/",
                               .axes = {{"y", "mm", "position along y", cell_corners(grid.ny, grid.ly)},
                                        {"x", "mm", "position along x", cell_corners(grid.nx, grid.lx)}},
                               .quantities = {},
                               .rows_per_chunk = 1};
    for (const physics::Component& component : physics::component_names(world.form))
        recording.quantities.push_back({component.name, component.unit, component.meaning, {"y", "x"}});
    if (world.form.velocity == physics::Velocity::slaved)
        for (const char* axis : {"x", "y"})
            recording.quantities.push_back(
                {text("bead_velocity_{}", axis),
                 "mm s-1",
                 text("velocity of the beads along {}, in balance with the forces on them", axis),
                 {"y", "x"}});
    return recording;
}
}  // namespace

std::vector<files::Axis> observable_axes(const measure::Setting& setting) {
    std::vector<double> directions, sides, short_sides;
    for (int s = 0; s < setting.sectors.count; ++s) directions.push_back(180.0 / setting.sectors.count * s);
    const double cell = setting.grid.lx / setting.grid.nx;
    for (const int cells : setting.boxes) sides.push_back(cell * cells);
    for (const int cells : setting.long_boxes) short_sides.push_back(cell * cells);
    std::vector<files::Axis> axes{
        {"wavenumber", "mm-1", "mean |q| of the shell", setting.shells.q},
        {"direction", "degree", "angle of q from x, q and -q being one", directions},
        {"box_side", "mm", "side of the box along x", sides},
        {"long_box_side", "mm", "shorter side, on cells as wide as along x, of a box four times longer the other way",
         short_sides},
        {"separation", "mm", "mean distance in the bin", setting.separations}};
    if (!setting.terms.empty()) {
        std::vector<double> numbers;
        for (std::size_t i = 0; i < setting.terms.size(); ++i) numbers.push_back(static_cast<double>(i));
        axes.push_back({"term", "1", "number of the term: 0, 1, ... for " + joined(setting.terms), numbers});
    }
    return axes;
}

int choose_threads(const io::Scene& scene) {
    if (scene.run.threads > 0) return scene.run.threads;
    // Below this much work a thread costs more to wake than it saves.
    constexpr std::size_t points_per_thread = 16384;
    const auto useful = static_cast<int>(std::min<std::size_t>(numerics::points(scene.grid) / points_per_thread, 64));
    return std::clamp(useful, 1, usable_cores());
}

std::string field_size(const io::Scene& scene) { return text("{} by {} points", scene.grid.nx, scene.grid.ny); }

double field_disk_bytes(const io::Scene& scene) {
    const double frame = static_cast<double>(numerics::points(scene.grid)) *
                         numerics::components(physics::layout(physics::form(scene.model)));
    const double shells = 0.5 * std::min(scene.grid.nx, scene.grid.ny);
    return recorded_bytes(scene, frame, 16.0 + shells * (4.0 + 2.0 * measure::direction_sectors) + 32.0);
}

TimedScene timed_fields(const io::Scene& scene) {
    constexpr double max_points = 256.0 * 256.0;
    const auto work = [](const numerics::Grid& grid) {
        const auto points = static_cast<double>(numerics::points(grid));
        return points * std::log2(points);
    };
    io::Scene timed = scene;
    if (timed.initial.kind != "formula") timed.initial = {};
    while (static_cast<double>(numerics::points(timed.grid)) > max_points && timed.grid.nx % 4 == 0 &&
           timed.grid.ny % 4 == 0 && std::min(timed.grid.nx, timed.grid.ny) > 8) {
        timed.grid.nx /= 2;
        timed.grid.ny /= 2;
    }
    return {timed, work(scene.grid) / work(timed.grid)};
}

double field_simulation_bytes(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    numerics::System system =
        physics::linear_system(equations, scene.grid, physics::reference(scene.model.uniform), scene.dealiasing);
    if (physics::is_nonlinear(equations)) system.nonlinear = [](double, const auto&, auto&) {};
    const double spectra = static_cast<double>(numerics::modes(scene.grid)) * sizeof(Complex);
    const double reals = static_cast<double>(numerics::points(scene.grid)) * sizeof(double);
    const int count = numerics::components(system.layout);
    // state, the healthy one, a checkpoint's copy and its file; fields; the transform's scratch; shells, sectors and powers.
    const double rungs = scene.time.tolerance > 0.0 ? 4.0 : 1.0;
    return rungs * (numerics::stepper_bytes(system, numerics::stepper_table(scene.time.stepper)) +
                    physics::right_hand_side_bytes(equations, scene.grid, system.degree)) +
           (4.0 * count + count) * spectra + count * reals + 3.0 * reals;
}

namespace {
/// Finite, and so far from the largest number that a sum over all modes is finite too.  False for not-a-number.
bool is_healthy(Complex value, std::size_t modes) {
    const double most = std::numeric_limits<double>::max() / static_cast<double>(2 * modes);
    return std::abs(value.real()) < most && std::abs(value.imag()) < most;
}

/// The non-finite mode of least wavenumber, and where the field was largest when it was last finite.
[[noreturn]] void report_blow_up(World& world, std::int64_t step) {
    const std::vector<physics::Component> names = physics::component_names(world.form);
    const std::size_t width = numerics::columns(world.scene.grid);
    std::size_t component = 0, mode = 0;
    double least = INFINITY;
    for (std::size_t c = 0; c < names.size(); ++c)
        for (std::size_t m = 0; m < world.state.size; ++m) {
            const Complex value = world.state[static_cast<int>(c)][m];
            const numerics::Wavevector q = numerics::wavevector(world.scene.grid, m % width, m / width);
            if (is_healthy(value, world.state.size) || std::hypot(q.x, q.y) >= least) continue;
            least = std::hypot(q.x, q.y);
            component = c;
            mode = m;
        }
    world.transform.backward(world.healthy, world.fields);
    const std::span<const double> field = world.fields[static_cast<int>(component)];
    const auto largest =
        std::max_element(field.begin(), field.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
    const auto cell = static_cast<std::size_t>(largest - field.begin()),
               nx = static_cast<std::size_t>(world.scene.grid.nx);
    const physics::FastestGrowth growth = physics::fastest_growth(world.evolution.system());
    fail_run(
        "the run left the finite numbers at or before step {} (t = {:.6g} s): {}, mode ({}, {}), dt = {}; its largest "
        "value was {:.3g} "
        "in cell ({}, {}) when last finite; likely cause: {}; the last checkpoint is good to restart from",
        step, static_cast<double>(step) * world.scene.time.dt, names[component].name, mode % width,
        numerics::mode_number_y(world.scene.grid, mode / width), world.scene.time.dt, *largest, cell % nx, cell / nx,
        growth.rate > 0.0
            ? text("a linear mode grows at {:.3g} /s (|q| = {:.3g} /mm) and {}", growth.rate, growth.q,
                   world.evolution.equations().saturation.is_active()
                       ? "relaxation.saturation does not stop it; or the time step is too large for the nonlinear terms"
                       : "this model has no term to stop it (relaxation.saturation = 0)")
        : world.evolution.equations().saturation.is_active()
            ? "the time step is too large for the nonlinear terms"
            : "the time step is too large for the nonlinear terms, or order grows where the densities have changed and "
              "this model has no "
              "term to stop it (relaxation.saturation = 0)");
}
}  // namespace

namespace {
ScheduledRecording frames_of(const std::shared_ptr<World>& world) {
    const io::Scene& scene = world->scene;
    const auto observe = [world] {
        world->bring_to_grid();
        std::vector<std::span<const double>> arrays;
        for (const numerics::Fields* fields : {&std::as_const(world->fields), &std::as_const(world->slaved)})
            for (int c = 0; c < fields->count(); ++c) arrays.push_back((*fields)[c]);
        return arrays;
    };
    return {frame_recording(*world), io::whole_steps(scene, "output.frame_every", scene.output.frame_every), observe};
}

ScheduledRecording samples_of(const std::shared_ptr<World>& world) {
    const io::Scene& scene = world->scene;
    files::Recording samples{.group = "/observables",
                             .axes = observable_axes(world->setting),
                             .quantities = {},
                             .rows_per_chunk = samples_per_chunk(scene)};
    for (const measure::Observable& observable : world->observables)
        samples.quantities.push_back(
            {observable.name, observable.unit, observable.formula, measure::names_of(observable.axes)});
    const auto observe = [world] {
        world->bring_to_grid();
        measure::Moment moment{.setting = world->setting,
                               .spectra = world->state,
                               .fields = world->fields,
                               .velocity = world->velocity.size > 0 ? &world->velocity : nullptr};
        if (world->energy) moment.energy = world->energy->measure(world->time, world->state);
        std::vector<std::span<const double>> arrays;
        for (std::size_t o = 0; o < world->observables.size(); ++o) {
            world->observables[o].measure(moment, world->measured[o]);
            arrays.emplace_back(world->measured[o]);
        }
        return arrays;
    };
    return {std::move(samples), io::whole_steps(scene, "output.sample_every", scene.output.sample_every), observe};
}
}  // namespace

namespace {
/// What the stepper chose for itself.
std::string describe(const StepCount& count, const io::Scene& scene) {
    std::string words;
    if (scene.time.tolerance > 0.0)
        words = text("{} steps taken, {} refused; the last were of {:.4g} s (time.dt/{})", count.accepted,
                     count.refused, scene.time.dt / count.division, count.division);
    if (count.references > 0)
        words += text("{}the reference density followed the beads {} time{}", words.empty() ? "" : "; ",
                      count.references, count.references == 1 ? "" : "s");
    return words;
}
}  // namespace

Simulation make_field_simulation(const io::Scene& scene, Threads& threads, std::span<const double> saved) {
    const auto world = std::make_shared<World>(scene, threads);
    Simulation simulation{.dt = scene.time.dt,
                          .steps = io::whole_steps(scene, "time.end", scene.time.end),
                          .recordings = {},
                          .advance = {},
                          .check_health = {},
                          .save = {},
                          .restore = {},
                          .describe = {}};
    simulation.threads = threads.count();
    simulation.recordings = {frames_of(world), samples_of(world)};
    simulation.advance = [world](std::int64_t step) {
        world->evolution.advance(step, world->state);
        world->time = static_cast<double>(step + 1) * world->scene.time.dt;
    };
    simulation.check_health = [world](std::int64_t step) {
        for (const Complex value : world->state.values)
            if (!is_healthy(value, world->state.size)) report_blow_up(*world, step);
        std::copy(world->state.values.begin(), world->state.values.end(), world->healthy.values.begin());
    };
    simulation.describe = [world] { return describe(world->evolution.count(), world->scene); };
    simulation.save = [world] {
        std::vector<double> values = world->evolution.save();
        values.push_back(world->time);
        values.reserve(values.size() + 2 * world->state.values.size());
        for (const Complex value : world->state.values) {
            values.push_back(value.real());
            values.push_back(value.imag());
        }
        return values;
    };
    simulation.restore = [world](std::span<const double> values) {
        constexpr std::size_t before = FieldEvolution::saved_numbers + 1;
        require(values.size() == before + 2 * world->state.values.size(), {},
                "the checkpoint holds {} numbers; this scene's state has {}", values.size(),
                before + 2 * world->state.values.size());
        world->evolution.restore(values.first(FieldEvolution::saved_numbers));
        world->time = values[before - 1];
        for (std::size_t m = 0; m < world->state.values.size(); ++m)
            world->state.values[m] = {values[before + 2 * m], values[before + 2 * m + 1]};
        world->healthy = world->state;
    };
    if (!saved.empty()) simulation.restore(saved);
    return simulation;
}

}  // namespace drover::run
