// numerics/steppers/sundials_handles.hpp: objects of SUNDIALS that free themselves, and their numbers.
#pragma once
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_nvector.h>

#include <memory>
#include <span>
#include <type_traits>

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

}  // namespace drover::numerics
