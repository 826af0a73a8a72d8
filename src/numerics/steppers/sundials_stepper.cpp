// numerics/steppers/sundials_stepper.cpp: the only integrators of SUNDIALS, behind plain functions.
#include "numerics/steppers/sundials_stepper.hpp"

#include <arkode/arkode_arkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_version.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <algorithm>
#include <cmath>
#include <exception>

#include "drover/base/error.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "numerics/steppers/mode_vector.hpp"
#include "numerics/steppers/sundials_handles.hpp"

namespace drover::numerics {

namespace {
struct CvodeDeleter {
    void operator()(void* memory) const { CVodeFree(&memory); }
};
struct ArkodeDeleter {
    void operator()(void* memory) const { ARKStepFree(&memory); }
};

constexpr long max_steps = 100000;  // in one dt
constexpr double min_step = 1e-12;  // relative to dt
}  // namespace

std::string sundials_library() {
    char version[32] = {};
    SUNDIALSGetVersion(version, sizeof(version));
    return text("SUNDIALS {}", version);
}

struct SundialsStepper::Work {
    System system;
    const TimeMethod& method;
    double dt, tolerance;
    ModeVector modes;
    LinearOperator linear, shifted_inverse;
    double shift = 0.0;  // gamma of shifted_inverse
    Spectra state, rate;
    std::vector<double> changes, latest_changes;  // mean squares of each field over dt: of the error norm, now
    std::vector<double> begin_values, values;     // at the last start without history, at next_step
    std::int64_t begin_step = 0, next_step = -1;
    std::int64_t steps_since_begin = 0;
    StepCount count, before;  // before: of the integrator at the last look
    std::exception_ptr failure;
    std::string message;
    Owned<SUNContext, ContextDeleter> context;
    Owned<N_Vector, VectorDeleter> vector;
    Owned<SUNLinearSolver, SolverDeleter> solver;
    std::unique_ptr<void, CvodeDeleter> cvode;
    std::unique_ptr<void, ArkodeDeleter> arkode;

    Work(const System& the_system, const TimeMethod& the_method, double the_dt, double the_tolerance);
    void make_cvode();
    void make_arkode();
    void begin(std::int64_t step);
    void advance(std::int64_t step);
    void look_ahead(double t, double end);
    void look_at_counts();
    [[noreturn]] void fail(double t);
    int evaluate(double t, N_Vector from, N_Vector to, bool with_linear, bool with_rest);
    // What SUNDIALS calls.
    static int all_rates(double t, N_Vector y, N_Vector to, void* work) {
        return static_cast<Work*>(work)->evaluate(t, y, to, true, true);
    }
    static int explicit_rates(double t, N_Vector y, N_Vector to, void* work) {
        return static_cast<Work*>(work)->evaluate(t, y, to, false, true);
    }
    static int implicit_rates(double t, N_Vector y, N_Vector to, void* work) {
        return static_cast<Work*>(work)->evaluate(t, y, to, true, false);
    }
    static int error_weights(N_Vector y, N_Vector to, void* work) {
        return static_cast<Work*>(work)->write_weights(y, to);
    }
    /// Messages are kept for the Error, and not printed.
    static void keep_message(int, const char*, const char*, char* words, void* work) {
        static_cast<Work*>(work)->message = words;
    }
    int solve_shifted(double gamma, N_Vector from, N_Vector to);
    int write_weights(N_Vector y, N_Vector weights) const;
};

SundialsStepper::Work::Work(const System& the_system, const TimeMethod& the_method, double the_dt, double the_tolerance)
    : system(the_system),
      method(the_method),
      dt(the_dt),
      tolerance(the_tolerance),
      modes(system.grid, system.layout, system.degree),
      linear(system),
      shifted_inverse(linear),
      state(system.grid, components(system.layout)),
      rate(state),
      changes(modes.fields().size(), 0.0),
      latest_changes(changes),
      begin_values(modes.size(), 0.0),
      values(begin_values) {
    require(!system.noise, {},
            "stepper \"{}\" with noise; expected a system without: choose etdrk2, or set the noise to 0", method.name);
    require(std::isfinite(dt) && dt > 0.0, {}, "dt = {}; expected a positive time", dt);
    require(tolerance > 0.0 || !method.needs_tolerance, {},
            "stepper \"{}\" without a tolerance; expected one: it has no steps of fixed length", method.name);
    SUNContext made = nullptr;
    if (SUNContext_Create(nullptr, &made) != 0) fail_environment("SUNDIALS cannot be started; it is out of memory");
    context.reset(made);
    vector.reset(N_VNew_Serial(static_cast<sunindextype>(modes.size()), context.get()));
    if (!vector) fail_environment("no memory for a state of {} numbers; expected a smaller grid", modes.size());
    if (method.implicit_table.empty()) make_cvode();
    else make_arkode();
}

void SundialsStepper::Work::make_cvode() {
    cvode.reset(CVodeCreate(method.name == "cvode-bdf" ? CV_BDF : CV_ADAMS, context.get()));
    const auto prepare = [](double, N_Vector, N_Vector, int, int* is_current, double, void*) {
        *is_current = SUNTRUE;  // solve_shifted follows gamma by itself
        return 0;
    };
    const auto solve = [](double, N_Vector, N_Vector, N_Vector right, N_Vector to, double gamma, double, int,
                          void* work) { return static_cast<Work*>(work)->solve_shifted(gamma, right, to); };
    solver.reset(SUNLinSol_SPGMR(vector.get(), SUN_PREC_LEFT, 0, context.get()));
    void* memory = cvode.get();
    if (!memory || !solver || CVodeInit(memory, all_rates, 0.0, vector.get()) != 0 ||
        CVodeSetUserData(memory, this) != 0 || CVodeSetErrHandlerFn(memory, keep_message, this) != 0 ||
        CVodeWFtolerances(memory, error_weights) != 0 || CVodeSetMaxNumSteps(memory, max_steps) != 0 ||
        CVodeSetMinStep(memory, min_step * dt) != 0 || (system.is_timed && CVodeSetMaxStep(memory, dt) != 0) ||
        CVodeSetLinearSolver(memory, solver.get(), nullptr) != 0 || CVodeSetPreconditioner(memory, prepare, solve) != 0)
        fail_run("CVODE cannot be prepared: {}", message);
}

void SundialsStepper::Work::make_arkode() {
    arkode.reset(ARKStepCreate(explicit_rates, implicit_rates, 0.0, vector.get(), context.get()));
    solver.reset(SUNLinSolNewEmpty(context.get()));
    void* memory = arkode.get();
    if (!memory || !solver) fail_environment("no memory for ARKODE; expected a smaller grid");
    solver->content = this;
    solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_MATRIX_EMBEDDED; };
    solver->ops->solve = [](SUNLinearSolver self, SUNMatrix, N_Vector to, N_Vector right, double) {
        auto& work = *static_cast<Work*>(self->content);
        double gamma = 0.0;
        if (ARKStepGetCurrentGamma(work.arkode.get(), &gamma) != 0) return -1;
        return work.solve_shifted(gamma, right, to);
    };
    solver->ops->free = [](SUNLinearSolver self) {
        SUNLinSolFreeEmpty(self);
        return 0;
    };
    if (ARKStepSetUserData(memory, this) != 0 || ARKStepSetErrHandlerFn(memory, keep_message, this) != 0 ||
        ARKStepSetTableName(memory, method.implicit_table.c_str(), method.explicit_table.c_str()) != 0 ||
        ARKStepWFtolerances(memory, error_weights) != 0 || ARKStepSetMaxNumSteps(memory, max_steps) != 0 ||
        ARKStepSetMinStep(memory, min_step * dt) != 0 || ARKStepSetLinearSolver(memory, solver.get(), nullptr) != 0 ||
        ARKStepSetLinear(memory, 0) != 0 || (tolerance == 0.0 && ARKStepSetFixedStep(memory, dt) != 0))
        fail_run("ARKODE cannot be prepared: {}", message);
}

int SundialsStepper::Work::evaluate(double t, N_Vector from, N_Vector to, bool with_linear, bool with_rest) {
    const int flag = guarded(failure, [&] {
        modes.unpack(numbers(from), state);
        std::ranges::fill(rate.values, Complex(0.0));
        if (with_rest && system.nonlinear) system.nonlinear(t, state, rate);
        if (with_rest) ++count.right_hand_sides;
        if (with_linear) linear.add(state, rate);
        modes.pack(rate, numbers(to));
    });
    if (flag != 0 || !with_rest) return flag;
    latest_changes = modes.mean_squares(numbers(to));
    bool is_finite = true;
    for (double& square : latest_changes) {
        square *= dt * dt;
        is_finite = is_finite && std::isfinite(square);
    }
    return is_finite ? 0 : 1;
}

int SundialsStepper::Work::solve_shifted(double gamma, N_Vector from, N_Vector to) {
    if (gamma != shift) shifted_inverse = linear.shifted_inverse(gamma);
    shift = gamma;
    modes.unpack(numbers(from), state);
    std::ranges::fill(rate.values, Complex(0.0));
    shifted_inverse.add(state, rate);
    modes.pack(rate, numbers(to));
    return 0;
}

/// Of a norm that is the mean over all numbers.
int SundialsStepper::Work::write_weights(N_Vector y, N_Vector weights) const {
    std::vector<double> squares = modes.mean_squares(numbers(y));
    double largest = 0.0;
    for (std::size_t f = 0; f < squares.size(); ++f) {
        squares[f] = std::max(squares[f], changes[f]);
        largest = std::max(largest, squares[f]);
    }
    if (!std::isfinite(largest)) return -1;
    const double allowed = tolerance > 0.0 ? tolerance : 1e-10;
    constexpr double rounding = 1e-15;  // of the largest field: where a field is zero but for it, no step is exact
    const double floor = std::max(largest * (rounding / allowed) * (rounding / allowed), 1e-200);
    const std::span<double> out = numbers(weights);
    const auto count_of_numbers = static_cast<double>(out.size());
    for (std::size_t f = 0; f < squares.size(); ++f)
        for (std::size_t i = modes.fields()[f].begin; i < modes.fields()[f].end; ++i)
            out[i] = std::sqrt(count_of_numbers * modes.weight(i) / std::max(squares[f], floor)) / allowed;
    return 0;
}

void SundialsStepper::Work::begin(std::int64_t step) {
    begin_step = step;
    begin_values = values;
    steps_since_begin = 0;
    before = {};
    const double t = static_cast<double>(step) * dt;
    std::ranges::copy(values, numbers(vector.get()).begin());
    const Owned<N_Vector, VectorDeleter> first(N_VClone(vector.get()));
    if (evaluate(t, vector.get(), first.get(), true, true) != 0) fail(t);
    changes = latest_changes;
    const int flag = cvode ? CVodeReInit(cvode.get(), t, vector.get())
                           : ARKStepReInit(arkode.get(), explicit_rates, implicit_rates, t, vector.get());
    if (flag != 0) fail(t);
}

/// A field at rest that begins to move within dt is measured by its rates until then: no step could meet a tolerance
/// relative to 0.
void SundialsStepper::Work::look_ahead(double t, double end) {
    const Owned<N_Vector, VectorDeleter> rates(N_VClone(vector.get()));
    constexpr int parts = 4;
    for (int part = 1; part <= parts; ++part) {
        if (evaluate(t + (end - t) * part / parts, vector.get(), rates.get(), true, true) != 0) continue;
        for (std::size_t f = 0; f < changes.size(); ++f) changes[f] = std::max(changes[f], latest_changes[f]);
    }
    failure = nullptr;  // outside of a domain, say: the steps themselves find that out
}

/// Steps accepted and rejected since the last look.
void SundialsStepper::Work::look_at_counts() {
    long steps = 0, error_failures = 0, solve_failures = 0;
    if (cvode) {
        CVodeGetNumSteps(cvode.get(), &steps);
        CVodeGetNumErrTestFails(cvode.get(), &error_failures);
        CVodeGetNumStepSolveFails(cvode.get(), &solve_failures);
    } else {
        ARKStepGetNumSteps(arkode.get(), &steps);
        ARKStepGetNumErrTestFails(arkode.get(), &error_failures);
        ARKStepGetNumStepSolveFails(arkode.get(), &solve_failures);
    }
    const StepCount now{.accepted = steps, .rejected = error_failures + solve_failures};
    steps_since_begin += now.accepted - before.accepted;
    count.accepted += now.accepted - before.accepted;
    count.rejected += now.rejected - before.rejected;
    before = now;
}

void SundialsStepper::Work::fail(double t) {
    if (failure) std::rethrow_exception(failure);
    fail_run(
        "{} failed between t = {:.6g} and {:.6g}: {}; expected steps that meet time.tolerance = {}: the fields may "
        "be diverging; otherwise choose another time.tolerance, or time.stepper = \"etdrk4-krogstad\"",
        method.name, t, t + dt, message.empty() ? "the right-hand side is not finite" : message, tolerance);
}

void SundialsStepper::Work::advance(std::int64_t step) {
    if (system.set_step) system.set_step(tolerance > 0.0 ? 0.0 : dt);
    if (step != next_step || steps_since_begin >= steps_between_starts) begin(step);
    next_step = -1;  // until it has succeeded
    failure = nullptr;
    message.clear();
    const double t = static_cast<double>(step) * dt, end = static_cast<double>(step + 1) * dt;
    if (system.is_timed) look_ahead(t, end);
    double reached = t;
    int flag = 0;
    if (cvode) {
        flag = CVode(cvode.get(), end, vector.get(), &reached, CV_NORMAL);
    } else {
        flag = ARKStepSetStopTime(arkode.get(), end);
        if (flag >= 0) flag = ARKStepEvolve(arkode.get(), end, vector.get(), &reached, ARK_NORMAL);
    }
    if (flag < 0) fail(t);
    look_at_counts();
    changes = latest_changes;
    const std::span<const double> result = numbers(vector.get());
    values.assign(result.begin(), result.end());
    next_step = step + 1;
}

SundialsStepper::SundialsStepper(const System& system, const TimeMethod& method, double dt, double tolerance)
    : work_(std::make_unique<Work>(system, method, dt, tolerance)) {}
SundialsStepper::~SundialsStepper() = default;
SundialsStepper::SundialsStepper(SundialsStepper&&) noexcept = default;

void SundialsStepper::advance(std::int64_t step, Spectra& state) {
    Work& w = *work_;
    std::vector<double> given(w.modes.size());
    w.modes.pack(state, given);
    if (given != w.values) w.next_step = -1;
    w.values = std::move(given);
    w.advance(step);
    w.modes.unpack(w.values, state);
}

const StepCount& SundialsStepper::count() const { return work_->count; }

double SundialsStepper::last_step() const {
    double step = 0.0;
    if (work_->cvode) CVodeGetLastStep(work_->cvode.get(), &step);
    else ARKStepGetLastStep(work_->arkode.get(), &step);
    return step;
}

std::vector<double> SundialsStepper::save() const {
    const Work& w = *work_;
    std::vector<double> saved{static_cast<double>(w.begin_step), static_cast<double>(w.next_step)};
    saved.insert(saved.end(), w.begin_values.begin(), w.begin_values.end());
    return saved;
}

std::size_t SundialsStepper::saved_numbers() const { return 2 + work_->modes.size(); }

void SundialsStepper::restore(std::span<const double> saved) {
    Work& w = *work_;
    require(saved.size() == saved_numbers() && std::isfinite(saved[0]) && std::isfinite(saved[1]) &&
                std::abs(saved[0]) < 0x1p53 && std::abs(saved[1]) < 0x1p53,
            {}, "the checkpoint contains {} numbers of {}; expected {} and finite steps; use the other checkpoint",
            saved.size(), w.method.name, saved_numbers());
    const auto begin = static_cast<std::int64_t>(saved[0]), next = static_cast<std::int64_t>(saved[1]);
    w.next_step = -1;
    w.values.assign(saved.begin() + 2, saved.end());
    for (std::int64_t step = begin; step < next; ++step) w.advance(step);
}

double sundials_stepper_bytes(const System& system, const TimeMethod& method) {
    const ModeVector modes(system.grid, system.layout, system.degree);
    // CVODE: an array of a history of order + 1, those of Newton's method and of GMRES; ARKODE: two rates of each
    // stage.
    const double vectors = method.implicit_table.empty() ? method.order + 1.0 + 8.0 + 12.0 : 2.0 * 8.0 + 12.0;
    const double spectra = static_cast<double>(numerics::modes(system.grid)) * components(system.layout);
    return (vectors + 3.0) * static_cast<double>(modes.size()) * sizeof(double) + 2.0 * spectra * sizeof(Complex);
}

}  // namespace drover::numerics
