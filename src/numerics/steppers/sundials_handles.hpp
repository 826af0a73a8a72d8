// numerics/steppers/sundials_handles.hpp: objects of SUNDIALS that free themselves, and their numbers.
#pragma once
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_nvector.h>

#include <exception>
#include <memory>
#include <span>
#include <type_traits>

#include "drover/base/error.hpp"

namespace drover::numerics {

struct ContextDeleter {
    void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
struct VectorDeleter {
    void operator()(N_Vector vector) const { N_VDestroy(vector); }
};
struct SolverDeleter {
    void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
};
template <class Handle, class Deleter>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Deleter>;

inline std::span<double> numbers(N_Vector vector) {
    return {N_VGetArrayPointer(vector), static_cast<std::size_t>(N_VGetLength(vector))};
}

/// Runs the body of a callback, out of which no exception may go: `failure` keeps it.  0: done; 1 tells SUNDIALS to try
/// a shorter step, -1 to end.
template <class Body>
int guarded(std::exception_ptr& failure, Body body) {
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

}  // namespace drover::numerics
