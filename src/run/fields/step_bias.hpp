// run/fields/step_bias.hpp: what the time step changes in each observable of a run.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "io/scene.hpp"
#include "numerics/steppers/effort.hpp"
#include "run/fields/field_problem.hpp"
#include "run/loop/simulation.hpp"

namespace drover::run {

/// accuracy.effort, and that of the error of the fields where it is 0.
double effort_of_estimates(const io::Scene& scene);
/// The part of it for the error of the fields, which pilots need whatever it costs.  The rest is for the biases.
double effort_of_step_error(const io::Scene& scene);

/// What a step bias takes from its run, which outlives it.
struct BiasedRun {
    const io::Scene& scene;
    const FieldProblem& problem;
    const model::FieldEvolution& evolution;
    const numerics::Transform& transform;
    const SharedObserver& observer;
    Threads& threads;
};

/// Measures the change of the observables of one run by its time step, within its share of accuracy.effort.
///
/// With noise, pieces of the run are repeated by a twin: from the state at their start, with dt/2, on the same noise
/// path.  The difference of an observable grows over its correlation time to that of the means.  A piece begins when
/// the steps so far allow it, and is an eighth of what they allow: the pieces follow from the steps alone, not from the
/// end of the run.  Without noise the observables of the fields less their estimated error (numerics::StepError) are
/// compared with those of the fields, at some of the samples.
class StepBias {
public:
    explicit StepBias(const BiasedRun& run);
    StepBias(const StepBias&) = delete;
    StepBias& operator=(const StepBias&) = delete;

    /// Called with the state after each step; `step`: the number of steps so far.
    void advance(std::int64_t step, const numerics::Spectra& state);

    /// One row for each piece, or each comparison; `state` is that of the run.  Refers to this.
    ScheduledRecording recording(const numerics::Spectra& state);

    std::vector<double> save() const;
    void restore(std::span<const double> values);

private:
    int components() const { return static_cast<int>(run_.problem.components.size()); }
    std::vector<double> observe(std::int64_t step, const numerics::Spectra& state);
    double work_of_comparison() const;
    void make_twin();
    void begin_piece(std::int64_t step, const numerics::Spectra& state);
    void advance_piece(std::int64_t step, const numerics::Spectra& state);
    std::vector<std::vector<double>> compare(const numerics::Spectra& state);

    BiasedRun run_;
    bool noisy_;
    numerics::Effort effort_;
    SharedObserver observer_;             // of a state alone
    numerics::Fields fields_, balanced_;  // of what is observed, on the grid; made when they are needed

    // With noise: the twin, and its piece from step `begin` on; length 0: there is none now.
    std::unique_ptr<model::FieldEvolution> twin_;  // the same equations with half of the step, on the same noise path
    numerics::Spectra twin_state_;
    std::int64_t begin_ = 0, length_ = 0;
    std::vector<double> early_, late_;
    std::int64_t completed_ = -1, completed_length_ = 0;  // step at which the last piece ended
    // Without noise: the step now, and that of the next comparison at the earliest; the last one was at `completed`.
    std::int64_t now_ = 0, next_ = 0;
    std::vector<std::vector<double>> row_;  // as recorded
};

/// Whether the bias of the time step is measured: or that there is none, or why not.
enum class StepBiasState { measured, exact, not_measured, without_effort, noise_and_tolerance, without_max_error };
constexpr auto names_of(StepBiasState) {
    return std::array{"",
                      "exact",
                      "not measured",
                      "not measured (accuracy.effort = 0)",
                      "not measured (noise and a tolerance)",
                      "not measured (time.max_error = 0)"};
}
StepBiasState step_bias_state(const io::Scene& scene);

/// The group of an archive that holds its rows.
inline constexpr const char* step_bias_group = "/step_bias";

}  // namespace drover::run
