// theory/modes.cpp: the modes of one wave, and the shares of terms in their rates.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/algebra/precise_eigenvalues.hpp"

namespace drover::theory {

namespace {
using numerics::Wavevector;

/// Eigenvalues to six digits of each rate where the matrix is small enough; as modes().
Modes sorted_modes(const model::Symbol& m) {
    const numerics::DenseEigen found =
        m.rows() <= numerics::max_small_rows ? numerics::reliable_eigen(m) : numerics::dense_eigen(m);
    if (!found.has_converged)
        fail_run("the eigenvalues of a linear mode do not converge; choose less extreme coefficients");
    std::vector<int> order(static_cast<std::size_t>(found.values.size()));
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) {
        const std::complex<double> first = found.values(a), second = found.values(b);
        return first.real() != second.real() ? first.real() > second.real() : first.imag() > second.imag();
    });
    Modes sorted{.rates = found.values(order), .shapes = found.vectors(Eigen::all, order), .duals = {}};
    sorted.duals = numerics::inverse(sorted.shapes);
    return sorted;
}

/// Uniform changes that leave the conserved means: the symbol at q = 0 maps them into themselves.
Modes uniform_modes(const model::LinearisedAt& at) {
    const Eigen::MatrixXd conserved = conserved_means(at);
    const Eigen::Index n = conserved.cols(), free = n - conserved.rows();
    if (free == 0) return {.rates = Eigen::VectorXcd(0), .shapes = model::Symbol(n, 0), .duals = model::Symbol(0, n)};
    Eigen::MatrixXd basis = Eigen::MatrixXd::Identity(n, n);
    if (conserved.rows() > 0) basis = numerics::orthogonal_factor(conserved.transpose()).rightCols(free);
    Modes inside = sorted_modes(basis.transpose() * at.symbol({}) * basis);
    return {.rates = inside.rates, .shapes = basis * inside.shapes, .duals = inside.duals * basis.transpose()};
}
}  // namespace

Eigen::MatrixXd conserved_means(const model::LinearisedAt& at) {
    // Equations of rates alone may be taken with some fields in balance.
    std::vector<Eigen::Index> places;
    const std::vector<int>&with_rate = at.equations().state_components(), &state = at.state_components();
    for (std::size_t k = 0; k < with_rate.size(); ++k)
        if (std::count(state.begin(), state.end(), with_rate[k]) > 0) places.push_back(static_cast<Eigen::Index>(k));
    return conserved_means(at.equations())(Eigen::all, places);
}

Modes modes(const model::LinearisedAt& at, const Wavevector& q) {
    return q.x == 0.0 && q.y == 0.0 ? uniform_modes(at) : sorted_modes(at.symbol(q));
}

Eigen::VectorXcd mode_rates(const model::LinearisedAt& at, const Wavevector& q) {
    const model::Symbol m = at.symbol(q);
    if (m.rows() <= numerics::max_small_rows) return numerics::reliable_eigenvalues(m);
    return numerics::dense_eigenvalues(m);
}

double growth_rate(const model::LinearisedAt& at, double q, double angle) {
    return mode_rates(at, at.wavevector(q, angle)).real().maxCoeff();
}

double Modes::rounding(Eigen::Index mode) const {
    return 4.0 * std::numeric_limits<double>::epsilon() * rates.cwiseAbs().maxCoeff() * duals.row(mode).norm() *
           shapes.col(mode).norm();
}

bool Modes::grows() const {
    for (Eigen::Index k = 0; k < rates.size(); ++k)
        if (rates(k).real() > rounding(k)) return true;
    return false;
}

Growth growth(const model::LinearisedAt& at, double q, double angle) {
    const Modes all = modes(at, at.wavevector(q, angle));
    if (all.rates.size() == 0) return {.rate = -std::numeric_limits<double>::infinity()};
    const std::complex<double> fastest = all.rates(0);
    const double rounding = all.rounding(0);
    const bool oscillates = std::abs(fastest.imag()) > std::max(rounding, 1e-12 * std::abs(fastest));
    return {.rate = fastest.real(), .frequency = oscillates ? -fastest.imag() : 0.0, .rounding = rounding};
}

std::vector<std::complex<double>> term_shares(const model::LinearisedAt& at, const Wavevector& q, std::size_t mode) {
    const Modes all = modes(at, q);
    require(mode < static_cast<std::size_t>(all.rates.size()), {}, "mode {}; expected one of the {} modes of the wave",
            mode, all.rates.size());
    const auto k = static_cast<Eigen::Index>(mode);
    const Eigen::VectorXcd right = at.all_components(q) * all.shapes.col(k);
    const Eigen::RowVectorXcd left = at.of_forces(all.duals.row(k), q);
    std::vector<std::complex<double>> shares;
    for (std::size_t n = 0; n < at.equations().terms().size(); ++n)
        shares.emplace_back(left * at.term_symbol(n, q) * right);
    return shares;
}

}  // namespace drover::theory
