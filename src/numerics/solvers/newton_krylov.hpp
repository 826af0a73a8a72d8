// numerics/solvers/newton_krylov.hpp: systems of nonlinear equations by Newton's method and GMRES (KINSOL of SUNDIALS).
#pragma once
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace drover::numerics {

/// f(u) = 0 for as many unknowns as equations.  Functions may throw.
struct NonlinearEquations {
    using Values = std::span<const double>;
    std::function<void(Values u, std::span<double> f)> residual;
    std::function<void(Values u, Values v, std::span<double> product)> derivative;  ///< the derivative at u, times v
    std::function<void(Values u)> prepare;                  ///< the preconditioner for derivatives near u
    std::function<void(std::span<double> v)> precondition;  ///< v becomes an approximate solution of derivative * x = v
    std::vector<double> unknown_sizes, equation_sizes;      ///< typical sizes of u and of the terms of f; > 0
};

struct NewtonControl {
    double tolerance = 1e-13;  ///< aimed at: the largest |f|, relative to the size of its equation
    double accepted = 1e-10;   ///< still accepted where rounding ends the iteration earlier
    int max_iterations = 100;
    int max_krylov = 400;  ///< dimensions of GMRES, without restarts
};

struct NewtonOutcome {
    bool converged = false;
    double residual = 0.0;  ///< the largest |f|, relative to the size of its equation
    int iterations = 0;
    std::string problem;  ///< of an iteration that did not converge
};

/// Replaces u.  With a line search.  Throws what the functions throw where it cannot continue.
NewtonOutcome solve_newton_krylov(const NonlinearEquations& equations, const NewtonControl& control,
                                  std::span<double> u);

}  // namespace drover::numerics
