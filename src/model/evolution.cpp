// model/evolution.cpp: a stepper on the system of a model.
#include "drover/model/evolution.hpp"

#include <algorithm>
#include <cmath>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/stepper_table.hpp"
#include "drover/numerics/transform.hpp"
#include "model/explicit_part.hpp"
#include "model/start.hpp"

namespace drover::model {

namespace {
EvolutionControl checked(const EvolutionControl& control) {
    numerics::check(control.grid);
    require(control.dt > 0.0 && std::isfinite(control.dt), {}, "dt = {}; expected a finite step above 0", control.dt);
    require(control.threads >= 1, {}, "threads = {}; expected 1 or more", control.threads);
    require(control.first_step >= 0, {}, "first_step = {}; expected 0 or more", control.first_step);
    return control;
}
}  // namespace

struct Evolution::Work {
    Equations equations;
    EvolutionControl control;
    Threads threads;
    numerics::System system;
    numerics::Transform transform;
    numerics::Stepper stepper;
    numerics::Spectra state;
    std::int64_t step = control.first_step;
    bool failed = false;

    Work(const Equations& the_equations, const EvolutionControl& the_control)
        : equations(the_equations),
          control(checked(the_control)),
          threads(control.threads),
          system(equations.system(control.grid, threads)),
          transform(control.grid, system.degree, threads),
          stepper(system, numerics::stepper_table(control.method), control.dt, control.seed, threads),
          state(control.grid, static_cast<int>(equations.state_components().size())) {
        const UniformState reference = equations.reference();
        for (int c = 0; c < state.count(); ++c)
            state[c][0] =
                reference[static_cast<std::size_t>(equations.state_components()[static_cast<std::size_t>(c)])];
    }

    void check_finite() const {
        for (int c = 0; c < state.count(); ++c) {
            const auto values = state[c];
            if (std::ranges::all_of(values, [](const numerics::Complex& value) {
                    return std::isfinite(value.real()) && std::isfinite(value.imag());
                }))
                continue;
            const StateComponent component = components_of_state(equations)[static_cast<std::size_t>(c)];
            fail_run(
                "the run diverged: {} is NaN or infinite at t = {:.6g} (step {} of dt = {}); choose a shorter dt, or "
                "check the signs of the equations",
                equations.model().fields[component.field].name, static_cast<double>(step) * control.dt, step,
                control.dt);
        }
    }
};

Evolution::Evolution(const Equations& equations, const EvolutionControl& control)
    : work_(std::make_unique<Work>(equations, control)) {}
Evolution::~Evolution() = default;
Evolution::Evolution(Evolution&&) noexcept = default;
Evolution& Evolution::operator=(Evolution&&) noexcept = default;

numerics::Fields Evolution::fields() const {
    numerics::Fields result(work_->control.grid, work_->state.count());
    work_->transform.backward(work_->state, result);
    return result;
}

numerics::Fields Evolution::balanced() const {
    return ExplicitPart(work_->equations, work_->system, work_->threads).balanced(time(), work_->state);
}

void Evolution::set_fields(const numerics::Fields& fields) {
    numerics::check(fields, work_->control.grid, work_->state.count());
    require(std::ranges::all_of(fields.values, [](double value) { return std::isfinite(value); }), {},
            "the fields have values that are not finite; expected finite values");
    numerics::Spectra fresh(work_->control.grid, work_->state.count());
    work_->transform.forward(fields, fresh);
    remove_divergence(work_->equations, work_->control.grid, fresh);
    work_->state = std::move(fresh);
    work_->stepper.restore_history({});  // rates of other fields are no history of these
    work_->failed = false;
}

void Evolution::advance(std::int64_t steps) {
    require(steps >= 0, {}, "steps = {}; expected 0 or more: a run does not go back", steps);
    require(!work_->failed, {}, "the run has failed at t = {:.6g}; expected other fields first, by set_fields()",
            time());
    constexpr std::int64_t check_every = 8;
    work_->failed = true;  // unless all steps succeed
    for (std::int64_t i = 0; i < steps; ++i) {
        work_->stepper.step(time(), static_cast<std::uint64_t>(work_->step), work_->state);
        ++work_->step;
        if (work_->step % check_every == 0 || i + 1 == steps) work_->check_finite();
    }
    work_->failed = false;
}

std::int64_t Evolution::step() const { return work_->step; }
double Evolution::time() const { return static_cast<double>(work_->step) * work_->control.dt; }

}  // namespace drover::model
