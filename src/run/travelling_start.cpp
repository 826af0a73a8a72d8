// run/travelling_start.cpp: from the initial fields of a scene to a travelling state.
#include "run/travelling_start.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/log.hpp"
#include "drover/physics/field_evolution.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/signals.hpp"

namespace drover::run {

using physics::TravellingState;

io::Scene line_of(const io::Scene& scene) {
    io::Scene line = scene;
    line.grid.ny = 1;
    line.model.noise = {};
    return line;
}

namespace {
/// The average over y of the initial fields, which may be those of an archive.
numerics::Spectra guess_of(const io::Scene& scene, const io::Scene& line, Threads& threads) {
    const numerics::Spectra whole = initial_fields(scene, threads);
    numerics::Spectra guess(line.grid, whole.count());
    for (int c = 0; c < guess.count(); ++c) std::copy_n(whole[c].begin(), guess.size, guess[c].begin());
    return guess;
}

/// Evolves a guess: it comes nearer to a stable state.
void settle(const io::Scene& line, double duration, Threads& threads, numerics::Spectra& state) {
    if (duration == 0.0) return;
    const double longest = line.time.dt > 0.0 ? line.time.dt : io::longest_step(line);
    const double steps = std::ceil(duration / longest);
    physics::FieldEvolution evolution(
        line.model, line.grid, line.dealiasing,
        {.method = "etdrk4-krogstad", .dt = duration / steps, .tolerance = 1e-4, .watches_error = false}, 0, threads);
    evolution.start(state);
    for (std::int64_t step = 0; step < std::llround(steps); ++step) {
        check_stop_signal();
        evolution.advance(step, state);
    }
}
}  // namespace

TravellingState find_state(const io::Scene& scene, const io::Scene& line, const TravellingGuess& from,
                           physics::TravellingSolver& solver, Threads& threads) {
    const numerics::Spectra guess = guess_of(scene, line, threads);
    std::vector<double> durations{from.settle.value_or(0.0)};
    if (!from.settle)
        for (const double part : {0.001, 0.01, 0.1, 1.0}) durations.push_back(part * line.time.end);
    std::string problem;
    for (const double duration : durations) {
        try {
            numerics::Spectra settled = guess;
            settle(line, duration, threads, settled);
            TravellingState found = solver.find(settled, from.speed);
            if (!problem.empty()) log_information("the state was found from a guess that settled for {} s", duration);
            return found;
        } catch (const Error& error) {
            if (error.fault() != Fault::run || stop_signal() != 0) throw;
            if (problem.empty()) problem = error.what();
        }
    }
    fail_run("{}", problem);
}

}  // namespace drover::run
