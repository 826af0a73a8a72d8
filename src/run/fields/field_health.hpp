// run/fields/field_health.hpp: whether the fields of a run still have a meaning, and which of them failed first.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/numerics/transform.hpp"
#include "numerics/steppers/kept_modes.hpp"
#include "run/fields/field_problem.hpp"

namespace drover::run {

/// A run stops when the root mean square of a field exceeds this multiple of its scale.  The scale comes from the
/// model, not from the start: a perturbation of a linear model may grow by any factor up to there.  No coefficient
/// means anything at a density or an order a million times that of the uniform state, and doubles are far from
/// overflow there.
inline constexpr double max_field_size = 1e6;

/// The last state in which all fields had a meaning.
struct FieldHealth {
    std::vector<double> scales;   ///< of each component: its size in the model, or at the start if larger; 0: unknown
    std::vector<double> start;    ///< of each component: its size at the start
    bool has_searched = false;    ///< for its size in the model: not before it may matter
    numerics::KeptModes healthy;  ///< of the state at the last check
    numerics::KeptModes earlier;  ///< at the check before it, from which a diagnosis repeats the steps
    std::int64_t step = 0, earlier_step = 0;  ///< of both
};

FieldHealth make_field_health(const FieldProblem& problem, const numerics::System& linear,
                              const numerics::Spectra& initial);

/// The record of a state read from a checkpoint.
void restore_field_health(const numerics::System& system, const numerics::Spectra& state, std::int64_t step,
                          FieldHealth& health);

/// What a diagnosis needs of a run, whose last steps it may repeat.
struct Diagnosed {
    const io::Scene& scene;
    const FieldProblem& problem;
    model::FieldEvolution& evolution;
};

/// Records a state that is finite and no larger than allowed; otherwise throws a run Error with field, place and cause.
void check_field_health(const Diagnosed& run, numerics::Transform& transform, const numerics::Spectra& state,
                        std::int64_t step, FieldHealth& health);

/// Throws the run Error of a step in which a value was not allowed, led by the field that changed most before it when
/// that is another one.
[[noreturn]] void fail_step(const Diagnosed& run, const FieldHealth& health, std::int64_t step,
                            const model::DomainFailure& error);

}  // namespace drover::run
