// theory/modes.cpp: the modes of one wave, and the shares of terms in their rates.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/algebra/precise_eigenvalues.hpp"
#include "theory/decaying_part.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
using numerics::Wavevector;

/// Sets of rows that are not coupled to each other.  The components of one field are in one set, since their rates are
/// sums of the same terms: where these cancel, rounding errors of all are left.
std::vector<std::vector<int>> uncoupled_sets(const model::Symbol& m, std::vector<int> set) {
    const auto rows = static_cast<int>(m.rows());
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < rows; ++j)
            if (m(i, j) != 0.0 && set[static_cast<std::size_t>(i)] != set[static_cast<std::size_t>(j)])
                std::ranges::replace(set, int{set[static_cast<std::size_t>(j)]}, int{set[static_cast<std::size_t>(i)]});
    std::vector<std::vector<int>> result;
    for (int i = 0; i < rows; ++i) {
        const auto same = std::ranges::find_if(result, [&](const std::vector<int>& members) {
            return set[static_cast<std::size_t>(members.front())] == set[static_cast<std::size_t>(i)];
        });
        if (same != result.end()) same->push_back(i);
        else result.push_back({i});
    }
    return result;
}

/// visit(rows, scale, balanced) for each uncoupled set: balanced = diag(1/scale) m(rows, rows) diag(scale).
template <class Visit>
void for_balanced_sets(const model::Symbol& m, const std::vector<int>& fields, Visit visit) {
    for (const std::vector<int>& rows : uncoupled_sets(m, fields)) {
        Eigen::MatrixXcd inside = m(rows, rows);
        const Eigen::VectorXd scale = numerics::balance(inside);
        if ((scale.array() != 1.0).any()) inside = scale.cwiseInverse().asDiagonal() * inside * scale.asDiagonal();
        visit(rows, scale, inside);
    }
}

/// Eigenvalues to six digits of each rate where the matrix is small enough; as modes().  `fields`: of the rows.
Modes sorted_modes(const model::Symbol& m, const std::vector<int>& fields) {
    const Eigen::Index n = m.rows();
    Modes all{.rates = Eigen::VectorXcd(n),
              .shapes = model::Symbol::Zero(n, n),
              .duals = model::Symbol::Zero(n, n),
              .roundings = Eigen::VectorXd(n)};
    Eigen::Index first = 0;
    for_balanced_sets(m, fields, [&](const std::vector<int>& rows, const Eigen::VectorXd& scale, const auto& balanced) {
        const auto count = static_cast<Eigen::Index>(rows.size());
        const numerics::DenseEigen found =
            count <= numerics::max_small_rows ? numerics::reliable_eigen(balanced) : numerics::dense_eigen(balanced);
        if (!found.has_converged)
            fail_run("the eigenvalues of a linear mode do not converge; choose less extreme coefficients");
        const Eigen::MatrixXcd duals = numerics::inverse(found.vectors);
        const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * found.values.cwiseAbs().maxCoeff();
        const Eigen::MatrixXcd shapes = scale.asDiagonal() * found.vectors;
        const Eigen::VectorXd norms = shapes.colwise().stableNorm().transpose();
        for (Eigen::Index k = 0; k < count; ++k) {
            all.rates(first + k) = found.values(k);
            all.roundings(first + k) = rounding * duals.row(k).norm();  // columns have the norm 1
        }
        const auto places = Eigen::seqN(first, count);
        all.shapes(rows, places) = shapes * norms.cwiseInverse().asDiagonal();
        all.duals(places, rows) = norms.asDiagonal() * duals * scale.cwiseInverse().asDiagonal();
        first += count;
    });
    std::vector<int> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, [&](int a, int b) {
        const std::complex<double> one = all.rates(a), other = all.rates(b);
        return one.real() != other.real() ? one.real() > other.real() : one.imag() > other.imag();
    });
    for (std::size_t k = 0; k + 1 < order.size(); ++k) {  // of a conjugate pair, whose order is one of rounding errors
        const std::complex<double> one = all.rates(order[k]), other = all.rates(order[k + 1]);
        const double rounding = std::max(all.roundings(order[k]), 1e-12 * std::abs(one));
        if (one.imag() > 0.0 && std::abs(other - std::conj(one)) <= 2.0 * rounding) std::swap(order[k], order[k + 1]);
    }
    return {.rates = all.rates(order),
            .shapes = all.shapes(Eigen::all, order),
            .duals = all.duals(order, Eigen::all),
            .roundings = all.roundings(order)};
}

/// Eigenvalues of a balanced set.
Eigen::VectorXcd rates_of(const Eigen::MatrixXcd& balanced) {
    return balanced.rows() <= numerics::max_small_rows ? numerics::reliable_eigenvalues(balanced)
                                                       : numerics::dense_eigenvalues(balanced);
}

/// Changes that leave the conserved means, which the symbol maps into themselves.
struct FreeChanges {
    model::Symbol basis;      ///< columns, orthonormal
    model::Symbol symbol;     ///< among them
    std::vector<int> fields;  ///< of the rows of the symbol; those of combinations count as one
};

FreeChanges free_changes(const model::LinearisedAt& at, const Wavevector& q) {
    const model::Symbol m = at.symbol(q);
    const Eigen::Index n = m.rows();
    FreeChanges all{.basis = model::Symbol::Identity(n, n),
                    .symbol = m,
                    .fields = fields_of(at.equations(), at.state_components())};
    if (q.x != 0.0 || q.y != 0.0) return all;
    const Eigen::MatrixXd conserved = conserved_means(at);
    if (conserved.rows() == 0) return all;
    const Eigen::Index free = n - conserved.rows();
    const Eigen::MatrixXd basis = numerics::orthogonal_factor(conserved.transpose()).rightCols(free);
    return {.basis = basis,
            .symbol = basis.transpose() * m * basis,
            .fields = std::vector<int>(static_cast<std::size_t>(free), 0)};
}
}  // namespace

Eigen::MatrixXd conserved_means(const model::LinearisedAt& at) {
    // Equations of rates alone may be taken with some fields in balance.
    std::vector<Eigen::Index> places;
    const std::vector<int>&with_rate = at.equations().state_components(), &state = at.state_components();
    for (std::size_t k = 0; k < with_rate.size(); ++k)
        if (std::ranges::count(state, with_rate[k]) > 0) places.push_back(static_cast<Eigen::Index>(k));
    return conserved_means(at.equations())(Eigen::all, places);
}

Modes modes(const model::LinearisedAt& at, const Wavevector& q) {
    const FreeChanges free = free_changes(at, q);
    Modes inside = sorted_modes(free.symbol, free.fields);
    if (q.x != 0.0 || q.y != 0.0) return inside;
    inside.shapes = free.basis * inside.shapes;
    inside.duals = inside.duals * free.basis.adjoint();
    return inside;
}

DecayingPart decaying_part(const model::LinearisedAt& at, const Wavevector& q) {
    const FreeChanges free = free_changes(at, q);
    const Eigen::Index n = free.basis.rows(), size = free.basis.cols();
    DecayingPart part{.basis = model::Symbol::Zero(n, size),
                      .inverse = model::Symbol::Zero(size, n),
                      .symbol = model::Symbol::Zero(size, size)};
    const model::Symbol noise = at.noise(q);
    Eigen::Index first = 0;
    for_balanced_sets(free.symbol, free.fields,
                      [&](const std::vector<int>& rows, const Eigen::VectorXd& scale, const auto& balanced) {
                          const model::Symbol changes = free.basis(Eigen::all, rows);
                          // Of small sets the rates are known in 113 bits, of others in 53.
                          const double relative = rows.size() <= numerics::max_small_rows ? 1e-13 : 1e-10,
                                       margin = relative * balanced.norm(),
                                       largest = rates_of(balanced).real().maxCoeff();
                          if (std::abs(largest) <= margin && (changes.adjoint() * noise * changes).isZero(0.0)) return;
                          const auto places = Eigen::seqN(first, static_cast<Eigen::Index>(rows.size()));
                          part.basis(Eigen::all, places) = changes * scale.asDiagonal();
                          part.inverse(places, Eigen::all) = scale.cwiseInverse().asDiagonal() * changes.adjoint();
                          part.symbol(places, places) = balanced;
                          part.decays = part.decays && largest < -margin;
                          first += places.size();
                      });
    part.basis.conservativeResize(n, first);
    part.inverse.conservativeResize(first, n);
    part.symbol.conservativeResize(first, first);
    part.noise = part.inverse * noise * part.inverse.adjoint();
    return part;
}

Eigen::VectorXcd mode_rates(const model::LinearisedAt& at, const Wavevector& q) {
    const model::Symbol m = at.symbol(q);
    Eigen::VectorXcd rates(m.rows());
    Eigen::Index first = 0;
    const std::vector<int> fields = fields_of(at.equations(), at.state_components());
    for_balanced_sets(m, fields, [&](const std::vector<int>& rows, const auto&, const auto& balanced) {
        const auto count = static_cast<Eigen::Index>(rows.size());
        rates.segment(first, count) = rates_of(balanced);
        first += count;
    });
    return rates;
}

double growth_rate(const model::LinearisedAt& at, double q, double angle) {
    return mode_rates(at, at.wavevector(q, angle)).real().maxCoeff();
}

double Modes::frequency(Eigen::Index mode) const {
    require(mode >= 0 && mode < rates.size(), {}, "mode {}; expected one of the {} modes of the wave", mode,
            rates.size());
    const std::complex<double> rate = rates(mode);
    const double rounding = std::max(roundings(mode), 1e-12 * std::abs(rate));
    return std::abs(rate.imag()) > rounding ? -rate.imag() : 0.0;
}

Growth growth(const model::LinearisedAt& at, double q, double angle) {
    const Modes all = modes(at, at.wavevector(q, angle));
    if (all.rates.size() == 0) return {.rate = -infinite};
    return {.rate = all.rates(0).real(), .frequency = all.frequency(0), .rounding = all.roundings(0)};
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
