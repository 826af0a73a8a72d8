// io/scene_check.cpp: the schema rows of the scene's structs, and consistency checks of its keys.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/mapped.hpp"
#include "base/memory.hpp"
#include "calibrate/slow_order.hpp"
#include "dem/contact/contact_law.hpp"
#include "drover/dem/bodies.hpp"
#include "io/scene.hpp"
#include "io/scene_parts.hpp"
#include "numerics/steppers/time_method.hpp"
#include "physics/integrated.hpp"

namespace drover::io {

namespace {
/// Times are decimals in the scene: a deviation below a millionth of a step is rounding.
bool is_whole(double duration, double dt) {
    return std::abs(std::round(duration / dt) * dt - duration) <= 1e-6 * dt + 1e-12 * duration;
}

void check_time_method(const Scene& scene, bool has_noise, const Locate& locate) {
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    require(scene.time.tolerance == 0.0 || method.start.empty(), locate("time.tolerance"),
            "time.tolerance = {} with the stepper \"{}\", a multistep method, whose steps are all equal; choose etdrk2 "
            "or etdrk4-krogstad, or leave out the tolerance",
            scene.time.tolerance, method.name);
    require(
        scene.time.tolerance == 0.0 || method.estimates_error, locate("time.tolerance"),
        "time.tolerance = {} with the stepper \"{}\", which has no embedded error estimate; choose etdrk2 or etdrk4",
        scene.time.tolerance, method.name);
    require(scene.time.tolerance > 0.0 || !method.needs_tolerance, locate("time.stepper"),
            "time.stepper = \"{}\" with time.tolerance = 0; expected a tolerance, such as 1e-6: the method chooses its "
            "steps by it",
            method.name);
    require(method.allows_noise || !has_noise, locate("time.stepper"),
            "time.stepper = \"{}\" with noise; expected a model without: choose etdrk2, or set {} to 0", method.name,
            scene.kind == SceneKind::model ? "the noise of every field"
                                           : "noise.order, noise.velocity, noise.rods and noise.beads");
}

void check_approximation(const Approximation& approximation, const Locate& locate) {
    require(approximation.quasi_linear || approximation.quasi_linear_above == 0.0,
            locate("approximation.quasi_linear_above"),
            "approximation.quasi_linear_above = {} has no effect without approximation.quasi_linear = true; set that, "
            "or leave it out",
            approximation.quasi_linear_above);
}

/// Before any check that visits every mode: the least a run of any scheme needs.
void check_min_memory(const Scene& scene, std::size_t components, const Locate& locate) {
    const double arrays = 4.0 * static_cast<double>(components);
    const double needed = arrays * sizeof(double) * static_cast<double>(numerics::points(scene.grid));
    require(needed <= static_cast<double>(memory_available()), locate("grid.nx"),
            "a grid of {} by {} points needs more than {} of memory, and {} are free; choose a smaller grid",
            scene.grid.nx, scene.grid.ny, bytes_text(needed), bytes_text(static_cast<double>(memory_available())));
}

void check_dealiasing(const numerics::Dealiasing& dealiasing, const numerics::Grid& grid, const Locate& locate) {
    const int fewest = grid.ny == 1 ? grid.nx : std::min(grid.nx, grid.ny);
    require(dealiasing.degree + 1 < fewest, locate("dealiasing.degree"),
            "dealiasing.degree = {} keeps no wave on {} points; expected less than {}", dealiasing.degree, fewest,
            fewest - 1);
    require(dealiasing.degree == 0 || dealiasing.rule == numerics::DealiasingRule::exact, locate("dealiasing.degree"),
            "dealiasing.degree = {} has no effect with dealiasing.rule = \"{}\"; expected 0, or rule = \"exact\"",
            dealiasing.degree, dealiasing.rule);
}

void check_fields(const Scene& scene, const Locate& locate) {
    numerics::check(scene.grid, locate);
    const physics::Equations rod_bead = physics::check(scene.model, locate);
    check_dealiasing(scene.dealiasing, scene.grid, locate);
    const model::Equations equations = rod_bead.solver();
    check_min_memory(scene, equations.state_components().size(), locate);
    check_unread(scene.initial, scene.kind, locate);
    check_noise_of_start(scene.initial, equations, locate);
    model::check(scene.initial, equations, scene.grid, physics::kept_degree(rod_bead, scene.dealiasing), locate);
    check_time_method(scene, physics::has_noise(scene.model), locate);
    check_approximation(scene.approximation, locate);
    if (scene.approximation.counterterm)
        calibrate::counterterm(scene.model, {scene.grid, physics::kept_degree(rod_bead, scene.dealiasing)},
                               locate("approximation.counterterm"));
}

/// The equations, the grid and the start of a declared model.
void check_declared(const Scene& scene, const Locate& locate) {
    numerics::check(scene.grid, locate);
    check_dealiasing(scene.dealiasing, scene.grid, locate);
    const model::Equations equations(model_of(scene.declared));
    check_min_memory(scene, equations.state_components().size(), locate);
    check_unread(scene.initial, scene.kind, locate);
    model::check(scene.initial, equations, scene.grid, kept_degree(scene, equations), locate);
    check_time_method(scene, equations.has_noise(), locate);
    require(
        !scene.approximation.counterterm, locate("approximation.counterterm"),
        "approximation.counterterm = true in a model of one's own; expected false: it applies to the shipped model of "
        "rods and beads only; add the linear term to the equation instead");
    check_approximation(scene.approximation, locate);
}

void check_fractions(const std::vector<double>& fractions, const std::string& key, const Locate& locate) {
    for (std::size_t i = 1; i < fractions.size(); ++i)
        require(fractions[i] > fractions[i - 1], locate(key), "{} has {} after {}; expected ascending numbers", key,
                fractions[i], fractions[i - 1]);
}

void check_calibration(const Scene& scene, const Locate& locate) {
    const CalibrationPlan& plan = scene.calibration;
    check_fractions(plan.bead_area_fractions, "calibrate.bead_area_fractions", locate);
    check_fractions(plan.rod_area_fractions, "calibrate.rod_area_fractions", locate);
    require(plan.max_trials >= 2 * plan.round, locate("calibrate.max_trials"),
            "calibrate.max_trials = {}; expected two rounds of calibrate.round = {} or more", plan.max_trials,
            plan.round);
    try {
        calibrate::make_assays(scene.plans);
    } catch (const Error& error) {
        fail_input({.file = scene.file}, "calibrate.{}", error.what());
    }
}

void check_particles(const Scene& scene, const Locate& locate) {
    dem::check(scene.particles, locate);
    require(scene.time.dt > 0.0, locate("time.dt"),
            "time.dt = 0 in a scene of particles; expected a number > 0 [s]: choose one, or leave it out for {} s",
            dt_of_particles);
    dem::check_contact_law(scene.particles, dem::shapes_of(scene.particles, locate), scene.time.dt, locate);
    check_calibration(scene, locate);
}

/// Of any kind of scene, with a step.
void check_values(const Scene& scene, const Locate& locate) {
    const std::int64_t steps = whole_steps(scene, "time.end", scene.time.end);
    require(steps >= 1, locate("time.end"),
            "time.end = {} is less than one step of time.dt = {}; expected at least one", scene.time.end,
            scene.time.dt);
    for (const auto& [key, every] : {std::pair{"output.frame_every", scene.output.frame_every},
                                     std::pair{"output.sample_every", scene.output.sample_every}})
        require(every == 0.0 || whole_steps(scene, key, every) >= 1, locate(key),
                "{} = {} is less than one step of time.dt = {}; expected 0 or at least one step", key, every,
                scene.time.dt);
    for (const auto& [key, name] :
         {std::pair{"units.length", scene.units.length}, std::pair{"units.time", scene.units.time},
          std::pair{"units.mass", scene.units.mass}})
        require(!name.empty() &&
                    std::ranges::all_of(name, [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }),
                locate(key), "{} = \"{}\"; expected the name of a unit in letters, such as \"cm\", or \"none\"", key,
                name);
    require(scene.analysis.warm_up == -1.0 || scene.analysis.warm_up >= 0.0, locate("analysis.warm_up"),
            "analysis.warm_up = {}; expected -1 (found from the series) or >= 0", scene.analysis.warm_up);
}
}  // namespace

bool has_noise(const Scene& scene) {
    if (scene.kind == SceneKind::fields) return physics::has_noise(scene.model);
    if (scene.kind != SceneKind::model) return false;
    const model::Model model = model_of(scene.declared);
    return std::ranges::any_of(model.fields, [](const auto& field) { return field.noise != 0.0; }) ||
           (!model.noises.empty() && model::Equations(model).has_noise());
}

std::int64_t whole_steps(const Scene& scene, const std::string& key, double duration) {
    const double dt = scene.time.dt, steps = std::round(duration / dt);
    constexpr double max_steps = 1e15;
    require(steps <= max_steps, locate(scene, key), "{} = {} is {:.3g} steps of time.dt = {}; expected at most {:.0e}",
            key, duration, steps, dt, max_steps);
    require(is_whole(duration, dt), locate(scene, key),
            "{} = {} is not a whole number of steps of time.dt = {}; choose {}{}", key, duration, dt,
            duration < dt ? "" : text("{:.10g} or ", std::floor(duration / dt) * dt),
            text("{:.10g}", std::ceil(duration / dt) * dt));
    return static_cast<std::int64_t>(steps);
}

double whole_interval(const Scene& scene, const std::string& key, double duration) {
    return static_cast<double>(whole_steps(scene, key, duration)) * scene.time.dt;
}

double longest_step(const Scene& scene) {
    std::vector<double> durations{scene.time.end};
    for (const double every : {scene.output.frame_every, scene.output.sample_every})
        if (every > 0.0) durations.push_back(every);
    const double shortest = *std::ranges::min_element(durations);
    constexpr int max_parts = 1000;  // with more, any three durations have a step
    for (int parts = 1; parts <= max_parts; ++parts) {
        const double step = shortest / parts;
        if (std::ranges::all_of(durations, [&](double duration) { return is_whole(duration, step); })) return step;
    }
    fail_input(locate(scene, "time.end"),
               "time.end = {}, output.frame_every = {} and output.sample_every = {} are not whole numbers of any step "
               "down to {:.3g} s; choose durations with a common divisor, or give time.dt",
               scene.time.end, scene.output.frame_every, scene.output.sample_every, shortest / max_parts);
}

Scene with_step(Scene scene) {
    if (scene.time.dt == 0.0) scene.time.dt = longest_step(scene);
    return scene;
}

void check(const Scene& scene) {
    const Locate locate = [&](const std::string& key) { return io::locate(scene, key); };
    const Locate at_or_in = [&](const std::string& key) {  // of a key that is left out: its section
        return scene.places.contains(key) ? locate(key) : locate(key.substr(0, key.rfind('.')));
    };
    switch (scene.kind) {
        case SceneKind::fields: check_fields(scene, locate); break;
        case SceneKind::particles: check_particles(scene, locate); break;
        case SceneKind::model: check_declared(scene, at_or_in); break;
    }
    check_values(with_step(scene), locate);
}

Rows<TimeControl> TimeControl::rows() {
    const std::vector<std::string> steppers = mapped(numerics::time_methods(), &numerics::TimeMethod::name);
    return {{"dt", &TimeControl::dt,
             "time step; linear terms and noise of fields are exact for any step, nonlinear terms are not; 0, or left "
             "out: drover run finds a step for which the error is below time.max_error; particles: the default is "
             "2e-5 s",
             "s", not_negative},
            {"end", &TimeControl::end, "end time, an integer number of steps", "s", positive},
            {"stepper", &TimeControl::stepper,
             "method for the nonlinear terms; cvode-* (steps chosen by time.tolerance) and arkode-* (L "
             "implicit) are those of SUNDIALS, without noise; fields only",
             "", any_number, steppers},
            {"tolerance", &TimeControl::tolerance,
             "maximum local error of a step relative to the root mean square of its field, or of the change of the "
             "field over dt: dt is then divided into as many equal steps as needed (1, 2, 3, 4, 6, 8, ...; with "
             "noise 1, 2, 4, 8, ... on one noise path); fields only; 0: steps of dt",
             "", within(0.0, 0.1)},
            {"max_error", &TimeControl::max_error,
             "a run warns when the estimated error of its time steps (observable step_error) exceeds this part of "
             "the fluctuation of a field, its deviation from its mean over the cell and time; fields only; 0: the "
             "error is not estimated",
             "", within(0.0, 1.0)}};
}

Rows<Output> Output::rows() {
    return Rows<Output>{
        {"file", &Output::file, "the archive (HDF5); empty: the scene's name with .h5, in the working folder"},
        {"frame_every", &Output::frame_every,
         "time between frames of all fields or bodies, an integer number of steps; 0: the first and the last only", "s",
         not_negative},
        {"sample_every", &Output::sample_every,
         "time between samples of the observables, an integer number of steps; 0: the first and the last only", "s",
         not_negative},
        {"checkpoint_minutes", &Output::checkpoint_minutes, "wall time between checkpoints", "min", not_negative},
        {"powers", &Output::powers,
         "samples include the energies of fields, the integrals of m F^2/2, and the power of each term; costs "
         "one right-hand side per term and sample; fields only"},
    };
}

Rows<Analysis> Analysis::rows() {
    return Rows<Analysis>{
        {"warm_up", &Analysis::warm_up,
         "time omitted from means at the start; -1, or time.end and above: estimated from the series", "s",
         at_least(-1.0)},
    };
}

Rows<Units> Units::rows() {
    return Rows<Units>{
        {"length", &Units::length,
         "what archives, tables and figures call the unit of length of the scene; none: numbers without a unit. "
         "All three are names alone: nothing is converted, and messages say mm, s and mg"},
        {"time", &Units::time, "the same for the unit of time"},
        {"mass", &Units::mass, "the same for the unit of mass"},
    };
}

Rows<Accuracy> Accuracy::rows() {
    return Rows<Accuracy>{
        {"effort", &Accuracy::effort,
         "fraction of the counted work of a run that may be spent on estimating the errors of its time step (twice "
         "this fraction up to 3.3 s of work, falling to it at 10 s): the error of the fields and the bias of each "
         "result; with noise, pieces of the run are repeated with dt/2 on the same noise path; without noise, "
         "observables are compared with those of the fields minus their estimated error; 0: no biases, and 0.05 for "
         "the error of the fields",
         "", within(0.0, 10.0)},
    };
}

Rows<RunControl> RunControl::rows() {
    return Rows<RunControl>{
        {"seed", &RunControl::seed, "seed of all random numbers; the same seed gives the same bytes", "",
         within(0, 9.2e18)},
        {"threads", &RunControl::threads,
         "threads; 0: the available cores, capped where the grid or the spheres are "
         "too few; results are bitwise identical for any number",
         "", within(0, 1024)},
    };
}

Rows<SweepPlan> SweepPlan::rows() {
    return Rows<SweepPlan>{
        {"vary", &SweepPlan::vary,
         "keys and their values, \"relaxation.rate = 0.5, 1, 2\" or, in 11 equal steps, \"relaxation.rate = "
         "0.5:2:11\"; "
         "several keys make a grid"},
        {"seeds", &SweepPlan::seeds,
         "runs at each point, with the seeds run.seed, run.seed + 1, ...; on a ramp each point has a different "
         "one",
         "", within(1, 1e6)},
        {"want", &SweepPlan::want,
         "observables and the standard errors of their means, \"polar_order=2%\": seeds are added at each point "
         "until they are met, or up to max_seeds"},
        {"max_seeds", &SweepPlan::max_seeds, "with want: the largest number of runs at a point", "", within(2, 1e6)},
        {"ramp", &SweepPlan::ramp,
         "up: each point starts from the final state of the previous one; up-down: up, then back (hysteresis); "
         "of several keys the last is ramped"},
        {"refine", &SweepPlan::refine,
         "observables and a change, \"polar_order = 0.1\": between neighbouring points that differ by more, and "
         "by more than twice their standard error, points are added, until none do or after refine_levels"},
        {"refine_levels", &SweepPlan::refine_levels, "maximum number of times the distance of points is halved", "",
         within(1, 20)},
        {"keep", &SweepPlan::keep,
         "archives: an archive of each run, from which it also resumes; table: the results alone, in one file "
         "for each process"},
        {"workers", &SweepPlan::workers, "parallel runs; 0: the available cores", "", within(0, 1024)},
    };
}

Rows<StabilityPlan> StabilityPlan::rows() {
    return Rows<StabilityPlan>{
        {"wavenumbers", &StabilityPlan::wavenumbers, "wavenumbers of the map, logarithmically spaced", "",
         within(8, 4096)},
        {"angles", &StabilityPlan::angles,
         "angles of the map, between q and p0, from 0 to 90 degrees; where mirror images differ, as in an external "
         "field that is oblique, twice as many, from 0 to 180 degrees",
         "", within(2, 4096)},
        {"min_wavenumber", &StabilityPlan::min_wavenumber,
         "smallest |q| searched; 0: 1/1000 of the smallest |q| of the cell", "1/mm", not_negative},
        {"max_wavenumber", &StabilityPlan::max_wavenumber, "largest |q| searched; 0: the largest |q| of the grid",
         "1/mm", not_negative},
        {"sound", &StabilityPlan::sound, "|q| of the dynamic structure factor; 0: the smallest |q| of the cell", "1/mm",
         not_negative},
        {"frequencies", &StabilityPlan::frequencies, "number of frequencies of the dynamic structure factor", "",
         within(3, 100001)},
    };
}

Rows<BoundaryPlan> BoundaryPlan::rows() {
    constexpr const char* axis =
        "a number of the model and its range, \"driving.strength = 0.5:2\"; or an area fraction, "
        "\"bead_area_fraction = 0.2:0.7\" or \"rod_area_fraction = 0.02:0.2\", by uniform.bead_area and "
        "uniform.rod_area; in a model of its own a coefficient, \"coefficients.a = 0.5:2\"";
    return Rows<BoundaryPlan>{
        {"x", &BoundaryPlan::x, axis},
        {"y", &BoundaryPlan::y, axis},
        {"lines",
         &BoundaryPlan::lines,
         "boundaries to trace: onset (a flock forms), phase-separation (of the isotropic state), banding (of "
         "the flock, along p0), oblique (of the flock, at other angles), binodal (densities of phases that "
         "coexist; the initial fields are the guess of such a state), isotropic and ordered (where that state "
         "becomes unstable to any wave; both are the default in a model of its own)",
         "",
         any_number,
         {"onset", "phase-separation", "banding", "oblique", "binodal", "isotropic", "ordered"}},
        {"conventions",
         &BoundaryPlan::conventions,
         "values of weathercock.convention to trace: mean, single-rod or both; empty: that of the scene",
         "",
         any_number,
         {"mean", "single-rod"}},
        {"errors", &BoundaryPlan::errors,
         "standard errors of numbers of the model, \"relaxation.rate = 0.02\", mutually independent; a "
         "table provides its own"},
        {"draws", &BoundaryPlan::draws,
         "draws of all numbers with errors, from which the error bands follow; 0: no bands", "", within(0, 10000)},
        {"cells", &BoundaryPlan::cells,
         "every island that contains a disc wider than 1/cells of the plane (scaled to a square) is found", "",
         within(1, 2048)},
        {"chord", &BoundaryPlan::chord, "maximum distance between polyline and line, on that square", "",
         within(1e-7, 0.5)},
        {"map", &BoundaryPlan::map, "points along each side of the map of stable states; 0: no map", "",
         within(0, 4096)},
    };
}

Rows<CalibrationPlan> CalibrationPlan::rows() {
    constexpr Range fraction{.min = 0.0, .max = 0.95, .min_open = true};
    const std::vector<std::string> names = mapped(calibrate::make_assays(), &calibrate::Assay::name);
    return {{"bead_area_fractions", &CalibrationPlan::bead_area_fractions,
             "Phi_b, ascending: replaces beads.area_fraction; every assay runs at each value", "", fraction},
            {"rod_area_fractions", &CalibrationPlan::rod_area_fractions,
             "Phi_r, ascending: replaces rods.area_fraction; assays that depend on it (drag, alignment, stiffness "
             "among rods) run at each value",
             "", fraction},
            {"vary", &CalibrationPlan::vary,
             "an additional key and its values, \"kick.strength = 0.01, 0.02\": all assays run at each value"},
            {"assays", &CalibrationPlan::assays, "assays to run; empty: all", "", any_number, names},
            {"relative_error",
             &CalibrationPlan::relative_error,
             "target relative error of every wanted coefficient: an assay runs trials until it is reached",
             "",
             {.min = 0.0, .max = 10.0, .min_open = true}},
            {"round", &CalibrationPlan::round,
             "trials between two evaluations of the error; the first is after two rounds", "", within(4, 100000)},
            {"max_trials", &CalibrationPlan::max_trials,
             "maximum trials of one assay at one point, in complete rounds; the result is then reported with "
             "its larger error",
             "", within(8, 1e6)},
            {"max_failed", &CalibrationPlan::max_failed,
             "allowed fraction of failed trials of an assay at a point; with more the point has no result", "",
             within(0.0, 0.9)},
            {"single_rods", &CalibrationPlan::single_rods,
             "rods in the cell of relaxation, weathercock and propulsion: few enough that they rarely interact", "",
             within(1, 10000)},
            {"workers", &CalibrationPlan::workers,
             "parallel trials; 0: the available cores; the table is the same for any number", "", within(0, 1024)}};
}

}  // namespace drover::io
