// run/session_state.hpp: a run in memory and its samples.
#pragma once
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "drover/base/threads.hpp"
#include "io/scene.hpp"
#include "run/loop/simulation.hpp"
#include "run/report/report.hpp"

namespace drover::run {

/// A run with the same states, frames and observables, to the last bit, as run_scene() writes.  Use one from one thread
/// at a time.
struct SessionState {
    /// At t = 0; without time.dt the step is chosen first.  Throws an input Error where memory is insufficient, and as
    /// the simulations of the scene.
    explicit SessionState(const io::Scene& given);

    double time() const { return static_cast<double>(step) * simulation->dt; }

    /// Calls `poll` before every step; an exception from it leaves the run as it is then.  Throws run Errors, after
    /// which the run cannot be advanced any more.
    void advance(std::int64_t more, const std::function<void()>& poll);

    /// What frames hold, and their arrays now; these keep their places until the session ends.
    std::span<const ScheduledRecording> frames() const;
    const files::Recording& observables() const { return simulation->recordings.back().recording; }
    /// Of the rows of the observables so far their times [s], and the values of a quantity.
    const std::vector<double>& sample_times() const { return samples.at(observables().group + "/time").values; }
    const files::Array& samples_of(const files::Quantity& quantity) const {
        return samples.at(observables().group + "/" + quantity.name);
    }
    /// Means with errors and linear theory of the samples so far, as of a run that ends now; of particles without what
    /// needs their paths, which are not kept.  Throws an input Error before the first step.
    Report report() const;

    /// Takes the arrays of the frames as the fields, or the bodies.  Throws an input Error, and keeps the state, for
    /// values that are not finite, and for bodies that overlap.
    void accept();

    io::Scene scene;  ///< with its time step
    std::unique_ptr<Threads> threads;
    std::unique_ptr<Simulation> simulation;
    Arrays samples;         ///< of the observables
    std::int64_t step = 0;  ///< taken so far
    bool was_changed = false, failed = false;
};

}  // namespace drover::run
