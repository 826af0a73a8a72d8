// physics/evaluation_cost.cpp: transforms and memory of one evaluation.
#include "drover/physics/evaluation_cost.hpp"

#include <algorithm>
#include <complex>

#include "point_arrays.hpp"
#include "quasi_linear.hpp"

namespace drover::physics {

TransformCount transform_count(const Equations& equations) {
    const Arrays arrays = arrays_of(equations);
    const int times = evaluations(equations);
    return {.inverse = arrays.forward > 0 ? times * arrays.inverse : 0, .forward = times * arrays.forward};
}

bool is_nonlinear(const Equations& equations) {
    return arrays_of(equations).forward > 0 ||
           std::any_of(equations.active.begin(), equations.active.end(), [](const Term& term) {
               return term.source || (term.linear_part == LinearPart::averaged && !term.whole);
           });
}

double right_hand_side_bytes(const Equations& equations, const numerics::Grid& grid, int degree) {
    if (!is_nonlinear(equations)) return 0.0;
    const Arrays arrays = arrays_of(equations);
    int derived = 0;
    for (int input = Input::d_x; input < Input::x; ++input)
        if (arrays.in[static_cast<std::size_t>(input)] >= 0) ++derived;
    const double spectra = static_cast<double>(numerics::modes(grid)) * sizeof(std::complex<double>);
    const double displaced =
        evaluations(equations) > 1 ? 2.0 * static_cast<double>(component_names(equations.form).size()) : 0.0;
    return spectra *
           (2.0 + displaced + derived + arrays.forward + 2.0 * (arrays.inverse + arrays.forward) / (degree + 1));
}

}  // namespace drover::physics
