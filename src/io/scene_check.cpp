// io/scene_check.cpp: the rows of the scene's own structs, and what its keys ask of each other.
#include <cmath>

#include "drover/dem/bodies.hpp"
#include "drover/dem/contact_law.hpp"
#include "drover/io/scene.hpp"
#include "drover/numerics/stepper_table.hpp"

namespace drover::io {

std::int64_t whole_steps(const Scene& scene, const std::string& key, double duration) {
    const double dt = scene.time.dt, steps = std::round(duration / dt);
    constexpr double most = 1e15;
    require(steps <= most, location_of(scene, key), "{} = {} is {:.3g} steps of time.dt = {}; expected at most {:.0e}",
            key, duration, steps, dt, most);
    // Times are typed as decimals: a millionth of a step is a slip of rounding, more is not.
    require(std::abs(steps * dt - duration) <= 1e-6 * dt + 1e-12 * duration, location_of(scene, key),
            "{} = {} is not a whole number of steps of time.dt = {}; choose {} or {}", key, duration, dt,
            std::floor(duration / dt) * dt, std::ceil(duration / dt) * dt);
    return static_cast<std::int64_t>(steps);
}

namespace {
void check_fields(const Scene& scene, const LocationOf& place) {
    numerics::check(scene.grid, place);
    physics::check(scene.model, place);
    physics::check(scene.initial, scene.model, scene.grid, scene.dealiasing, place);
    const physics::Noise& noise = scene.model.noise;
    require(scene.time.tolerance == 0.0 || (noise.order == 0.0 && noise.rods == 0.0 && noise.beads == 0.0),
            place("time.tolerance"),
            "time.tolerance = {} with noise: no embedded estimate tells the error of a noisy step; set it to 0, or the "
            "noise",
            scene.time.tolerance);
    require(scene.time.tolerance == 0.0 || !numerics::stepper_table(scene.time.stepper).error.empty(),
            place("time.tolerance"),
            "time.tolerance = {} with the stepper \"{}\", which has no embedded estimate; choose etdrk2 or etdrk4",
            scene.time.tolerance, scene.time.stepper);
}

void check_fractions(const std::vector<double>& fractions, const std::string& key, const LocationOf& place) {
    for (std::size_t i = 1; i < fractions.size(); ++i)
        require(fractions[i] > fractions[i - 1], place(key), "{} has {} after {}; expected numbers that ascend", key,
                fractions[i], fractions[i - 1]);
}

void check_calibration(const Scene& scene, const LocationOf& place) {
    const CalibrationPlan& plan = scene.calibration;
    check_fractions(plan.bead_area_fractions, "calibrate.bead_area_fractions", place);
    check_fractions(plan.rod_area_fractions, "calibrate.rod_area_fractions", place);
    require(plan.max_trials >= 2 * plan.round, place("calibrate.max_trials"),
            "calibrate.max_trials = {}; expected two rounds of calibrate.round = {} or more", plan.max_trials,
            plan.round);
    try {
        calibrate::make_assays(scene.plans);
    } catch (const Error& error) {
        fail_input({.file = scene.file}, "calibrate.{}", error.what());
    }
}

void check_particles(const Scene& scene, const LocationOf& place) {
    dem::check(scene.particles, place);
    dem::check_contact_law(scene.particles, dem::shapes_of(scene.particles, place), scene.time.dt, place);
    check_calibration(scene, place);
    // The plates' path within a step is a series in its part of a period.
    constexpr double least = 20.0;
    const dem::Plates& plates = scene.particles.plates;
    const double steps = 1.0 / (scene.time.dt * plates.frequency);
    require(plates.amplitude == 0.0 || steps >= least, place("time.dt"),
            "time.dt = {} s is {:.3g} steps a period of plates.frequency = {} 1/s; expected at least {}: choose a "
            "smaller time.dt",
            scene.time.dt, steps, plates.frequency, least);
}
}  // namespace

void check(const Scene& scene) {
    const LocationOf place = [&](const std::string& key) { return location_of(scene, key); };
    if (scene.kind == SceneKind::fields) check_fields(scene, place);
    else check_particles(scene, place);
    const std::int64_t steps = whole_steps(scene, "time.end", scene.time.end);
    require(steps >= 1, place("time.end"), "time.end = {} is less than one step of time.dt = {}; expected at least one",
            scene.time.end, scene.time.dt);
    for (const auto& [key, every] : {std::pair{"output.frame_every", scene.output.frame_every},
                                     std::pair{"output.sample_every", scene.output.sample_every}})
        require(every == 0.0 || whole_steps(scene, key, every) >= 1, place(key),
                "{} = {} is less than one step of time.dt = {}; expected 0 or at least one step", key, every,
                scene.time.dt);
    require(scene.analysis.warm_up == -1.0 ||
                (scene.analysis.warm_up >= 0.0 && scene.analysis.warm_up < scene.time.end),
            place("analysis.warm_up"),
            "analysis.warm_up = {}; expected -1 (found from the series) or less than time.end = {}",
            scene.analysis.warm_up, scene.time.end);
}

}  // namespace drover::io

namespace drover {

using namespace io;

template <>
const std::vector<Row<TimeControl>>& schema<TimeControl>() {
    static const std::vector<Row<TimeControl>> rows = [] {
        std::vector<std::string> steppers;
        for (const auto& table : numerics::stepper_tables()) steppers.push_back(table.name);
        return std::vector<Row<TimeControl>>{
            {.name = "dt",
             .member = &TimeControl::dt,
             .unit = "s",
             .range = positive,
             .doc = "time step; of fields: linear terms and noise are exact at any, products of fields are not; "
                    "of particles "
                    "the default is 2e-5 s"},
            {.name = "end",
             .member = &TimeControl::end,
             .unit = "s",
             .range = positive,
             .doc = "time at the end of the run, a whole number of steps"},
            {.name = "stepper",
             .member = &TimeControl::stepper,
             .choices = steppers,
             .doc = "method for what is not linear; fields alone"},
            {.name = "tolerance",
             .member = &TimeControl::tolerance,
             .range = {.min = 0.0, .max = 0.1},
             .doc = "largest local error of a step beside the root mean square of its field, or of the field's "
                    "change over dt: dt is then cut into as many equal "
                    "steps as that takes (1, 2, 3, 4, 6, 8, ...); without noise and of fields alone; 0: steps of dt"}};
    }();
    return rows;
}

template <>
const std::vector<Row<Output>>& schema<Output>() {
    static const std::vector<Row<Output>> rows{
        {.name = "file",
         .member = &Output::file,
         .doc = "the archive (HDF5); empty: the scene's name with .h5, in the folder where drover runs"},
        {.name = "frame_every",
         .member = &Output::frame_every,
         .unit = "s",
         .range = not_negative,
         .doc =
             "time between frames of all fields or bodies, a whole number of steps; 0: the first and the last alone"},
        {.name = "sample_every",
         .member = &Output::sample_every,
         .unit = "s",
         .range = not_negative,
         .doc = "time between samples of the observables, a whole number of steps; 0: the first and the last alone"},
        {.name = "checkpoint_minutes",
         .member = &Output::checkpoint_minutes,
         .unit = "min",
         .range = not_negative,
         .doc = "wall time between checkpoints"},
        {.name = "powers",
         .member = &Output::powers,
         .doc = "samples hold the energy of the beads and of the order, and the power of each term on them; one "
                "right-hand side "
                "a term and sample; fields alone"}};
    return rows;
}

template <>
const std::vector<Row<Analysis>>& schema<Analysis>() {
    static const std::vector<Row<Analysis>> rows{
        {.name = "warm_up",
         .member = &Analysis::warm_up,
         .unit = "s",
         .range = {.min = -1.0},
         .doc = "time left out of means at the start; -1: found from the series"}};
    return rows;
}

template <>
const std::vector<Row<RunControl>>& schema<RunControl>() {
    static const std::vector<Row<RunControl>> rows{{.name = "seed",
                                                    .member = &RunControl::seed,
                                                    .range = {.min = 0, .max = 9.2e18},
                                                    .doc = "of all random numbers; the same seed gives the same bytes"},
                                                   {.name = "threads",
                                                    .member = &RunControl::threads,
                                                    .range = {.min = 0, .max = 1024},
                                                    .doc =
                                                        "0: as many as the process may use and the grid or the spheres "
                                                        "can feed; the results are the same bytes for any number"}};
    return rows;
}

template <>
const std::vector<Row<SweepPlan>>& schema<SweepPlan>() {
    static const std::vector<Row<SweepPlan>> rows{
        {.name = "vary",
         .member = &SweepPlan::vary,
         .doc = "keys and their values, \"relaxation.rate = 0.5, 1, 2\" or, 11 even steps, \"relaxation.rate = "
                "0.5:2:11\"; "
                "several make a grid"},
        {.name = "seeds",
         .member = &SweepPlan::seeds,
         .range = {.min = 1, .max = 1e6},
         .doc = "runs at each point, with the seeds run.seed, run.seed + 1, ...; on a ramp each point has its own"},
        {.name = "ramp",
         .member = &SweepPlan::ramp,
         .choices = {"none", "up", "up-down"},
         .doc =
             "up: each point starts from the state at the end of the one before; up-down: and back again (hysteresis)"},
        {.name = "workers",
         .member = &SweepPlan::workers,
         .range = {.min = 0, .max = 1024},
         .doc = "runs at a time; 0: the cores the process may use"}};
    return rows;
}

template <>
const std::vector<Row<StabilityPlan>>& schema<StabilityPlan>() {
    static const std::vector<Row<StabilityPlan>> rows{
        {.name = "wavenumbers",
         .member = &StabilityPlan::wavenumbers,
         .range = {.min = 8, .max = 4096},
         .doc = "of the map, evenly by their logarithm"},
        {.name = "angles",
         .member = &StabilityPlan::angles,
         .range = {.min = 2, .max = 4096},
         .doc = "of the map, between q and p0, on a quarter turn; in a field from outside four times as many on a "
                "whole one"},
        {.name = "min_wavenumber",
         .member = &StabilityPlan::min_wavenumber,
         .unit = "1/mm",
         .range = not_negative,
         .doc = "smallest |q| searched; 0: a thousandth of the cell's longest wave"},
        {.name = "max_wavenumber",
         .member = &StabilityPlan::max_wavenumber,
         .unit = "1/mm",
         .range = not_negative,
         .doc = "largest |q| searched; 0: the shortest wave of the grid"},
        {.name = "sound",
         .member = &StabilityPlan::sound,
         .unit = "1/mm",
         .range = not_negative,
         .doc = "|q| of the dynamic structure factor; 0: the cell's longest wave"},
        {.name = "frequencies",
         .member = &StabilityPlan::frequencies,
         .range = {.min = 3, .max = 100001},
         .doc = "of the dynamic structure factor"}};
    return rows;
}

template <>
const std::vector<Row<BoundaryPlan>>& schema<BoundaryPlan>() {
    constexpr const char* axis =
        "a number of the model and its range, \"driving.strength = 0.5:2\"; or an area fraction, "
        "\"bead_area_fraction = 0.2:0.7\" or \"rod_area_fraction = 0.02:0.2\", by uniform.bead_area and "
        "uniform.rod_area";
    static const std::vector<Row<BoundaryPlan>> rows{
        {.name = "x", .member = &BoundaryPlan::x, .doc = axis},
        {.name = "y", .member = &BoundaryPlan::y, .doc = axis},
        {.name = "lines",
         .member = &BoundaryPlan::lines,
         .choices = {"onset", "phase-separation", "banding", "oblique"},
         .doc =
             "which to trace: onset (a flock forms), phase-separation (of the isotropic state), banding (of the flock, "
             "along p0), oblique (of the flock, at other angles)"},
        {.name = "conventions",
         .member = &BoundaryPlan::conventions,
         .choices = {"mean", "single-rod"},
         .doc = "weathercock.convention for which to trace: mean, single-rod or both; empty: that of the scene"},
        {.name = "errors",
         .member = &BoundaryPlan::errors,
         .doc = "standard errors of numbers of the model, \"relaxation.rate = 0.02\", independent of each other; those "
                "of the table stand there"},
        {.name = "cells",
         .member = &BoundaryPlan::cells,
         .range = {.min = 1, .max = 2048},
         .doc = "an island that holds a disc wider than 1/cells of the plane (laid on a square) is found for certain"},
        {.name = "chord",
         .member = &BoundaryPlan::chord,
         .range = {.min = 1e-7, .max = 0.5},
         .doc = "largest distance of the polyline from the line, on that square"},
        {.name = "map",
         .member = &BoundaryPlan::map,
         .range = {.min = 0, .max = 4096},
         .doc = "points on each side of the map of stable states; 0: none"}};
    return rows;
}

template <>
const std::vector<Row<CalibrationPlan>>& schema<CalibrationPlan>() {
    constexpr Range fraction{.min = 0.0, .max = 0.95, .min_open = true};
    static const std::vector<Row<CalibrationPlan>> rows = [&] {
        std::vector<std::string> names;
        for (const calibrate::Assay& assay : calibrate::make_assays()) names.push_back(assay.name);
        return std::vector<Row<CalibrationPlan>>{
            {.name = "bead_area_fractions",
             .member = &CalibrationPlan::bead_area_fractions,
             .range = fraction,
             .doc = "Phi_b, ascending: every assay is made at each, in place of beads.area_fraction"},
            {.name = "rod_area_fractions",
             .member = &CalibrationPlan::rod_area_fractions,
             .range = fraction,
             .doc = "Phi_r, ascending: for drag, which depends on it, in place of rods.area_fraction"},
            {.name = "vary",
             .member = &CalibrationPlan::vary,
             .doc = "one key more and its values, \"kick.strength = 0.01, 0.02\": everything is measured at each"},
            {.name = "assays",
             .member = &CalibrationPlan::assays,
             .choices = names,
             .doc = "which to make; empty: all"},
            {.name = "relative_error",
             .member = &CalibrationPlan::relative_error,
             .range = {.min = 0.0, .max = 10.0, .min_open = true},
             .doc = "of every wanted coefficient: an assay makes trials until it is reached"},
            {.name = "round",
             .member = &CalibrationPlan::round,
             .range = {.min = 4, .max = 100000},
             .doc = "trials between looks at the error; the first look is after two rounds"},
            {.name = "max_trials",
             .member = &CalibrationPlan::max_trials,
             .range = {.min = 8, .max = 1e6},
             .doc = "of one assay at one point, in whole rounds: it then keeps the error it has, and says so"},
            {.name = "max_failed",
             .member = &CalibrationPlan::max_failed,
             .range = {.min = 0.0, .max = 0.9},
             .doc = "part of the trials of an assay at a point that may fail; with more of them the point is refused"},
            {.name = "single_rods",
             .member = &CalibrationPlan::single_rods,
             .range = {.min = 1, .max = 10000},
             .doc = "rods in the cell of relaxation, weathercock and propulsion: few enough that they hardly meet"},
            {.name = "workers",
             .member = &CalibrationPlan::workers,
             .range = {.min = 0, .max = 1024},
             .doc = "trials at a time; 0: the cores the process may use; the table is the same for any number"}};
    }();
    return rows;
}

}  // namespace drover
