// numerics/solvers/newton_krylov.cpp: KINSOL behind one function.
#include "numerics/solvers/newton_krylov.hpp"

#include <kinsol/kinsol.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_spgmr.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>

#include "drover/base/error.hpp"
#include "numerics/steppers/sundials_handles.hpp"

namespace drover::numerics {

namespace {
struct KinsolDeleter {
    void operator()(void* memory) const { KINFree(&memory); }
};

/// What the callbacks need.
struct Call {
    const NonlinearEquations& equations;
    bool has_begun = false;
    std::exception_ptr failure = nullptr;
    std::string message = {};

    /// 1 tells KINSOL to try a shorter step, -1 to end.
    template <class Body>
    int guarded(Body body) {
        try {
            body();
            return 0;
        } catch (const Error& error) {
            failure = std::current_exception();
            return error.fault() == Fault::run ? 1 : -1;
        } catch (...) {
            failure = std::current_exception();
            return -1;
        }
    }
};

/// Outside the domain of the equations the residual counts as huge, so that the line search comes back.
int residual(N_Vector u, N_Vector f, void* call) {
    auto& c = *static_cast<Call*>(call);
    const int flag = c.guarded([&] {
        c.equations.residual(numbers(u), numbers(f));
        for (const double value : numbers(f))
            if (!std::isfinite(value))
                fail_run("the residual of Newton's method is not finite; expected finite fields");
    });
    if (flag == 1 && c.has_begun) {
        constexpr double far = 1e10;
        std::transform(c.equations.equation_sizes.begin(), c.equations.equation_sizes.end(), numbers(f).begin(),
                       [](double size) { return far * size; });
        return 0;
    }
    c.has_begun = true;
    return flag;
}

int derivative(N_Vector v, N_Vector product, N_Vector u, int*, void* call) {
    auto& c = *static_cast<Call*>(call);
    return c.guarded([&] { c.equations.derivative(numbers(u), numbers(v), numbers(product)); });
}

int prepare(N_Vector u, N_Vector, N_Vector, N_Vector, void* call) {
    auto& c = *static_cast<Call*>(call);
    return c.guarded([&] { c.equations.prepare(numbers(u)); });
}

int precondition(N_Vector, N_Vector, N_Vector, N_Vector, N_Vector v, void* call) {
    auto& c = *static_cast<Call*>(call);
    return c.guarded([&] { c.equations.precondition(numbers(v)); });
}

void keep_message(int, const char*, const char*, char* words, void* call) { static_cast<Call*>(call)->message = words; }
}  // namespace

NewtonOutcome solve_newton_krylov(const NonlinearEquations& equations, const NewtonControl& control,
                                  std::span<double> u) {
    Call call{equations};
    SUNContext made = nullptr;
    if (SUNContext_Create(nullptr, &made) != 0) fail_environment("SUNDIALS cannot be started; it is out of memory");
    const Owned<SUNContext, ContextDeleter> context(made);
    const auto vector_of = [&](std::span<const double> from, bool inverse) {
        Owned<N_Vector, VectorDeleter> vector(N_VNew_Serial(static_cast<sunindextype>(u.size()), context.get()));
        if (!vector) fail_environment("no memory for {} unknowns; expected a smaller grid", u.size());
        std::transform(from.begin(), from.end(), numbers(vector.get()).begin(),
                       [&](double value) { return inverse ? 1.0 / value : value; });
        return vector;
    };
    const auto unknowns = vector_of(u, false), unknown_scale = vector_of(equations.unknown_sizes, true),
               equation_scale = vector_of(equations.equation_sizes, true);
    const std::unique_ptr<void, KinsolDeleter> kinsol(KINCreate(context.get()));
    const int dimensions = std::min<int>(control.max_krylov, static_cast<int>(u.size()));
    const Owned<SUNLinearSolver, SolverDeleter> solver(
        SUNLinSol_SPGMR(unknowns.get(), SUN_PREC_RIGHT, dimensions, context.get()));
    void* memory = kinsol.get();
    constexpr double smallest_step = 1e-15, largest_step = 1.0;
    if (!memory || !solver || KINSetErrHandlerFn(memory, keep_message, &call) != 0 ||
        KINInit(memory, residual, unknowns.get()) != 0 || KINSetUserData(memory, &call) != 0 ||
        KINSetFuncNormTol(memory, control.tolerance) != 0 || KINSetScaledStepTol(memory, smallest_step) != 0 ||
        KINSetNumMaxIters(memory, control.max_iterations) != 0 || KINSetMaxSetupCalls(memory, 1) != 0 ||
        KINSetMaxNewtonStep(memory, largest_step) != 0 || KINSetNoResMon(memory, SUNTRUE) != 0 ||
        KINSetLinearSolver(memory, solver.get(), nullptr) != 0 || KINSetJacTimesVecFn(memory, derivative) != 0 ||
        KINSetPreconditioner(memory, prepare, precondition) != 0)
        fail_run("KINSOL cannot be prepared: {}", call.message);
    const int flag = KINSol(memory, unknowns.get(), KIN_LINESEARCH, unknown_scale.get(), equation_scale.get());
    NewtonOutcome outcome{.problem = call.message};
    long iterations = 0;
    KINGetNumNonlinSolvIters(memory, &iterations);
    outcome.iterations = static_cast<int>(iterations);
    std::vector<double> f(u.size());
    if (flag < 0 && call.failure && flag != KIN_LINESEARCH_NONCONV) std::rethrow_exception(call.failure);
    const std::span<const double> found = numbers(unknowns.get());
    std::copy(found.begin(), found.end(), u.begin());
    equations.residual(u, f);
    for (std::size_t i = 0; i < f.size(); ++i)
        outcome.residual = std::max(outcome.residual, std::abs(f[i]) / equations.equation_sizes[i]);
    outcome.converged = outcome.residual <= control.accepted;
    return outcome;
}

}  // namespace drover::numerics
