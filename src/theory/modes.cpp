// theory/modes.cpp: the modes of one wave, the shares of terms in their rates, and branches from wave to wave.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "theory/decaying_part.hpp"
#include "theory/instabilities.hpp"
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

Modes reordered(const Modes& modes, const std::vector<Eigen::Index>& order) {
    return {.rates = modes.rates(order),
            .shapes = modes.shapes(Eigen::all, order),
            .duals = modes.duals(order, Eigen::all),
            .roundings = modes.roundings(order)};
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
    std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::ranges::sort(order, [&](Eigen::Index a, Eigen::Index b) {
        const std::complex<double> one = all.rates(a), other = all.rates(b);
        return one.real() != other.real() ? one.real() > other.real() : one.imag() > other.imag();
    });
    for (std::size_t k = 0; k + 1 < order.size(); ++k) {  // of a conjugate pair, whose order is one of rounding errors
        const std::complex<double> one = all.rates(order[k]), other = all.rates(order[k + 1]);
        const double rounding = std::max(all.roundings(order[k]), 1e-12 * std::abs(one));
        if (one.imag() > 0.0 && std::abs(other - std::conj(one)) <= 2.0 * rounding) std::swap(order[k], order[k + 1]);
    }
    return reordered(all, order);
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

/// Which mode of `next` each mode of `last` has become.
std::vector<Eigen::Index> continuation(const Modes& last, const Modes& next) {
    const auto n = last.rates.size();
    // |l_i r'_j| |l'_j r_i|: 1 for the same shape, whatever its length and phase; no guide where a matrix is defective.
    const Eigen::MatrixXd there = (last.duals * next.shapes).cwiseAbs(), back = (next.duals * last.shapes).cwiseAbs();
    const Eigen::MatrixXd alike = there.cwiseProduct(back.transpose());
    const double size = std::max(last.rates.cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
    const bool guided = alike.allFinite() && alike.rowwise().sum().maxCoeff() < 4.0;
    Eigen::MatrixXd merit(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j) {
            const double distance = std::abs(last.rates(i) - next.rates(j)) / size;
            merit(i, j) = guided ? alike(i, j) - 1e-6 * distance : -distance;
        }
    std::vector<Eigen::Index> chosen(static_cast<std::size_t>(n));
    for (Eigen::Index count = 0; count < n; ++count) {
        Eigen::Index i = 0, j = 0;
        merit.maxCoeff(&i, &j);
        chosen[static_cast<std::size_t>(i)] = j;
        merit.row(i).setConstant(-infinite);
        merit.col(j).setConstant(-infinite);
    }
    return chosen;
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

ModeMap mode_map(const model::LinearisedAt& at, const std::vector<double>& wavenumbers,
                 const std::vector<double>& angles, Threads& threads) {
    ModeMap map{.wavenumbers = wavenumbers,
                .angles = angles,
                .modes = std::vector<Modes>(wavenumbers.size() * angles.size())};
    const std::size_t width = wavenumbers.size();
    threads.for_chunks(angles.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a)
            for (std::size_t k = 0; k < width; ++k) {
                Modes& here = map.modes[a * width + k];
                here = modes(at, at.wavevector(wavenumbers[k], angles[a]));
                if (k > 0) here = reordered(here, continuation(map.modes[a * width + k - 1], here));
            }
    });
    for (std::size_t a = 1; a < angles.size(); ++a) {
        const std::vector<Eigen::Index> order = continuation(map.at(a - 1, 0), map.at(a, 0));
        for (std::size_t k = 0; k < width; ++k) map.modes[a * width + k] = reordered(map.at(a, k), order);
    }
    return map;
}

}  // namespace drover::theory
