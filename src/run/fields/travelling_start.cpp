// run/fields/travelling_start.cpp: guesses, and the state next to one.
#include "run/fields/travelling_start.hpp"

#include <algorithm>
#include <cmath>

#include "base/log.hpp"
#include "run/fields/field_problem.hpp"
#include "run/fields/field_simulation.hpp"
#include "run/loop/signals.hpp"

namespace drover::run {

io::Scene line_of(const io::Scene& scene) {
    io::Scene line = scene;
    line.grid.ny = 1;
    physics::remove_noise(line.model);
    return line;
}

namespace {
/// Fields averaged over y, on one row of points.
numerics::Spectra average_over_y(const numerics::Spectra& fields, const numerics::Grid& line) {
    numerics::Spectra average(line, fields.count());
    for (int c = 0; c < average.count(); ++c) std::copy_n(fields[c].begin(), average.size, average[c].begin());
    return average;
}

constexpr const char* settling_method = "etdrk4-krogstad";
constexpr double settling_tolerance = 1e-4;

/// By equal steps of at most time.dt of the line.
void settle(const io::Scene& line, double duration, Threads& threads, numerics::Spectra& state) {
    const double longest = io::with_step(line).time.dt;
    const double steps = std::ceil(duration / longest);
    model::Integrated what = field_problem(line).integrated;
    what.is_quiet = true;
    model::FieldEvolution evolution(
        std::move(what), line.grid,
        {.method = settling_method, .dt = duration / steps, .tolerance = settling_tolerance, .watches_error = false}, 0,
        threads);
    evolution.start(state);
    for (std::int64_t step = 0; step < std::llround(steps); ++step) {
        check_stop_signal();
        evolution.advance(step, state);
    }
}

constexpr double far = 0.5;  // of the variation of a guess

/// The state nearest to a guess that has no speed: where the first is far from it, those from other speeds as well.
numerics::TravellingState nearest_state(const numerics::Spectra& guess, numerics::TravellingSolver& solver) {
    numerics::TravellingState best = solver.find(guess);
    const double first = best.guessed_speed;
    for (const double factor : {0.0, 0.5, 2.0, -1.0}) {
        if (best.change <= far) return best;
        try {
            numerics::TravellingState other = solver.find(guess, factor * first);
            if (other.change < best.change) best = std::move(other);
        } catch (const Error& error) {
            if (error.fault() != Fault::run || stop_signal() != 0) throw;
        }
    }
    return best;
}
}  // namespace

TravellingGuess travelling_guess(const io::Scene& scene, const io::Scene& line, Threads& threads) {
    return {.fields = average_over_y(initial_fields(scene, threads), line.grid),
            .settle = [line, &threads](double duration,
                                       numerics::Spectra& state) { settle(line, duration, threads, state); },
            .longest = line.time.end};
}

numerics::TravellingState find_state(const TravellingGuess& from, numerics::TravellingSolver& solver) {
    std::vector<double> durations{from.time.value_or(0.0)};
    if (!from.time)
        for (const double part : {0.001, 0.01, 0.1, 1.0}) durations.push_back(part * from.longest);
    std::string problem;
    for (const double duration : durations) {
        try {
            numerics::Spectra settled = from.fields;
            if (duration > 0.0) from.settle(duration, settled);
            numerics::TravellingState found =
                from.speed ? solver.find(settled, from.speed) : nearest_state(settled, solver);
            if (found.change > far)
                log_warning(
                    "the state differs from its guess by {:.2g} of the variation of the guess, so it may lie on a "
                    "different branch from the one intended; expected less than {}: give a closer guess, --speed, or "
                    "--settle",
                    found.change, far);
            if (!problem.empty())
                log_information("the state was found from a guess that settled until t = {}", duration);
            return found;
        } catch (const Error& error) {
            if (error.fault() != Fault::run || stop_signal() != 0) throw;
            if (problem.empty()) problem = error.what();
        }
    }
    fail_run("{}", problem);
}

}  // namespace drover::run
