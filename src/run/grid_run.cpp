// run/grid_run.cpp: recordings, checks and sizes of fields on a grid.
#include "run/grid_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "run/start_file.hpp"

namespace drover::run {

files::Recording frames_on(const numerics::Grid& grid) {
    return {.group = "/",
            .axes = {{"y", "mm", "position along y", cell_corners(grid.ny, grid.ly)},
                     {"x", "mm", "position along x", cell_corners(grid.nx, grid.lx)}},
            .quantities = {},
            .rows_per_chunk = 1};
}

io::Scene start_alone(const io::Scene& scene) {
    io::Scene start = scene;
    if (start.time.dt == 0.0) start.time.dt = io::longest_step(start);
    start.time.stepper = io::TimeControl{}.stepper;
    start.time.tolerance = start.time.max_error = 0.0;
    start.output.powers = false;
    start.accuracy.effort = 0.0;
    return start;
}

bool is_finite(numerics::Complex value, std::size_t modes) {
    const double max = std::numeric_limits<double>::max() / static_cast<double>(2 * modes);
    return std::abs(value.real()) < max && std::abs(value.imag()) < max;
}

void require_finite(const numerics::Fields& fields, const std::vector<std::string>& names, const numerics::Grid& grid) {
    for (int c = 0; c < fields.count(); ++c) {
        const std::span<const double> values = fields[c];
        const auto found =
            std::find_if(values.begin(), values.end(), [](double value) { return !std::isfinite(value); });
        require(found == values.end(), {},
                "{} is {} in cell ({}, {}); expected finite values: the fields were not changed",
                names[static_cast<std::size_t>(c)], found == values.end() ? 0.0 : *found,
                (found - values.begin()) % grid.nx, (found - values.begin()) / grid.nx);
    }
}

void append_numbers(const numerics::Spectra& state, std::vector<double>& to) {
    to.reserve(to.size() + 2 * state.values.size());
    for (const numerics::Complex value : state.values) {
        to.push_back(value.real());
        to.push_back(value.imag());
    }
}

void take_numbers(std::span<const double> numbers, numerics::Spectra& state) {
    for (std::size_t m = 0; m < state.values.size(); ++m) state.values[m] = {numbers[2 * m], numbers[2 * m + 1]};
}

std::vector<double> numbers_of_run(std::vector<double> stepper, double time, const numerics::Spectra& state,
                                   const std::vector<double>& bias) {
    std::vector<double> all = std::move(stepper);
    all.push_back(time);
    append_numbers(state, all);
    all.insert(all.end(), bias.begin(), bias.end());
    all.push_back(static_cast<double>(bias.size()));
    return all;
}

SavedRun saved_run(std::span<const double> all, std::size_t state_numbers) {
    const double last = all.empty() ? 0.0 : all.back();
    require(last >= 0.0 && last < static_cast<double>(all.size()) && last == std::round(last), {},
            "the checkpoint holds {} numbers of the step bias; expected fewer than the {} of all; use the other "
            "checkpoint",
            last, all.size());
    const auto of_bias = static_cast<std::size_t>(last);
    const std::span<const double> values = all.first(all.empty() ? 0 : all.size() - 1 - of_bias);
    require(values.size() > state_numbers, {}, "the checkpoint holds {} numbers; this scene's state has more than {}",
            values.size(), state_numbers);
    const std::size_t before = values.size() - state_numbers;
    return {.stepper = values.first(before - 1),
            .state = values.last(state_numbers),
            .bias = all.subspan(values.size(), of_bias),
            .time = values[before - 1]};
}

std::string steps_text(const numerics::AdaptiveStepper& stepper, const io::Scene& scene) {
    const numerics::StepCount& count = stepper.count();
    if (count.right_hand_sides > 0)
        return text("{} steps taken, {} rejected, {} right-hand sides; the last step was {:.4g} s", count.accepted,
                    count.rejected, count.right_hand_sides, stepper.last_step());
    if (scene.time.tolerance > 0.0)
        return text("{} steps taken, {} rejected; the last were {:.4g} s (time.dt/{})", count.accepted, count.rejected,
                    scene.time.dt / stepper.division(), stepper.division());
    return "";
}

double steppers_bytes(const numerics::System& system, const io::TimeControl& time, int count) {
    if (const numerics::SundialsMethod* sundials = numerics::find_sundials_method(time.stepper))
        return count * numerics::sundials_stepper_bytes(system, *sundials);
    return numerics::stepper_bytes(system, numerics::stepper_table(time.stepper),
                                   time.tolerance > 0.0 ? 2 * count : count);
}

double twin_stepper_bytes(const numerics::System& system, const io::TimeControl& time) {
    return numerics::noise_path_bytes(system, 0.5 * time.dt, 0) +
           numerics::stepper_bytes(system, numerics::stepper_table(time.stepper), 1) +
           static_cast<double>(numerics::modes(system.grid)) * numerics::components(system.layout) *
               sizeof(numerics::Complex);
}

}  // namespace drover::run
