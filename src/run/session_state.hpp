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
class SessionState {
public:
    /// At t = 0; without time.dt the step is chosen first.  Throws an input Error where memory is insufficient, and as
    /// the simulations of the scene.
    explicit SessionState(const io::Scene& scene);

    const io::Scene& scene() const { return scene_; }  ///< with its time step
    std::int64_t step() const { return step_; }
    std::int64_t steps() const { return simulation_->steps; }  ///< to time.end
    double time() const { return static_cast<double>(step_) * simulation_->dt; }
    int threads() const { return simulation_->threads; }
    /// Steps between rows of the frames; 0: none between the first and the last.
    std::int64_t frame_every() const { return simulation_->recordings.front().every; }
    bool was_changed() const { return was_changed_; }

    /// Calls `poll` before every step; an exception from it leaves the run as it is then.  Throws run Errors, after
    /// which the run cannot be advanced any more.
    void advance(std::int64_t steps, const std::function<void()>& poll);

    /// What frames hold, and their arrays now; these keep their places until the session ends.
    std::span<const ScheduledRecording> frames() const;
    std::vector<std::span<const double>> observe(std::size_t frame) const { return frames()[frame].observe(); }

    const files::Recording& observables() const { return simulation_->recordings.back().recording; }
    /// Of the rows of the observables so far their times [s], and the values of a quantity.
    const std::vector<double>& sample_times() const { return samples_.at(observables().group + "/time").values; }
    const files::Array& samples_of(const files::Quantity& quantity) const {
        return samples_.at(observables().group + "/" + quantity.name);
    }
    /// Means with errors and linear theory of the samples so far, as of a run that ends now; of particles without what
    /// needs their paths, which are not kept.  Throws an input Error before the first step.
    Report report() const;

    /// Takes the arrays of the frames as the fields, or the bodies.  Throws an input Error, and keeps the state, for
    /// values that are not finite, and for bodies that overlap.
    void accept();

private:
    io::Scene scene_;
    std::unique_ptr<Threads> threads_;
    std::unique_ptr<Simulation> simulation_;
    Arrays samples_;  // of the observables
    std::int64_t step_ = 0;
    bool was_changed_ = false, failed_ = false;
};

}  // namespace drover::run
