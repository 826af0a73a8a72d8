// theory/sorted_modes.cpp: eigenvalues to six digits of each rate where the matrix is small enough.
#include "theory/sorted_modes.hpp"

#include <algorithm>
#include <numeric>

#include "numerics/algebra/dense.hpp"
#include "numerics/algebra/precise_eigenvalues.hpp"

namespace drover::theory {

Modes sorted_modes(const model::Symbol& m) {
    Modes found;
    if (m.rows() <= numerics::max_small_rows) {
        const numerics::EigenDecomposition solved = numerics::reliable_eigen_decomposition(m);
        found = {.rates = solved.values, .shapes = solved.vectors, .duals = {}};
    } else {
        const numerics::DenseEigen solved = numerics::dense_eigen(m);
        if (!solved.has_converged)
            fail_run("the eigenvalues of a linear mode do not converge; choose less extreme coefficients");
        found = {.rates = solved.values, .shapes = solved.vectors, .duals = {}};
    }
    std::vector<int> order(static_cast<std::size_t>(found.rates.size()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const std::complex<double> first = found.rates(a), second = found.rates(b);
        return first.real() != second.real() ? first.real() > second.real() : first.imag() > second.imag();
    });
    Modes sorted{.rates = found.rates(order), .shapes = found.shapes(Eigen::all, order), .duals = {}};
    sorted.duals = numerics::inverse(sorted.shapes);
    return sorted;
}

}  // namespace drover::theory
