// theory/fluctuations.cpp: stationary fluctuations by the Lyapunov equation, and their spectra by the resolvent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/fields/shells.hpp"
#include "theory/decaying_part.hpp"

namespace drover::theory {

namespace {
using numerics::Wavevector;
using Complex = std::complex<double>;

std::string mode_text(const Wavevector& q) { return text("a mode at q = ({:.4g}, {:.4g})", q.x, q.y); }

/// Modes of a wave of which some neither grow nor decay, and are not driven.
struct DrivenModes {
    Modes all;
    Eigen::VectorXd decays;  ///< 1, or 0 for a mode that neither grows nor decays
    model::Symbol drive;     ///< noise of the amplitudes of the modes
    std::string why_none;    ///< why there is no stationary state; empty if there is one
};

DrivenModes driven_modes(const model::LinearisedAt& at, const Wavevector& q) {
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    const model::Symbol noise = at.noise(q);
    DrivenModes result{.all = modes(at, q), .decays = {}, .drive = {}, .why_none = {}};
    const Modes& all = result.all;
    result.drive = all.duals * noise * all.duals.adjoint();
    result.decays = Eigen::VectorXd::Zero(all.rates.size());
    for (Eigen::Index k = 0; k < all.rates.size(); ++k) {
        const double rate = all.rates(k).real(), rounding = all.roundings(k);
        if (rate > rounding) {
            result.why_none = text("no stationary state: {} grows at the rate {:.3g}", mode_text(q), rate);
            break;
        }
        if (rate < -rounding) result.decays(k) = 1.0;
        const Eigen::RowVectorXd sizes = all.duals.row(k).cwiseAbs();
        const double parts = sizes * noise.cwiseAbs() * sizes.transpose();
        if (result.decays(k) == 0.0 && result.drive(k, k).real() > 16.0 * epsilon * parts) {
            result.why_none = text(
                "no stationary state: noise drives {}, which does not decay: its rate of {:.2g} "
                "is 0 within a rounding error of {:.2g}",
                mode_text(q), rate, rounding);
            break;
        }
    }
    return result;
}

/// Modes that decay, added up one by one: those that neither grow nor decay must not be driven.
Covariance by_modes(const DrivenModes& driven) {
    if (!driven.why_none.empty()) return {.matrix = {}, .why_none = driven.why_none};
    const Modes& all = driven.all;
    const Eigen::Index n = all.rates.size();
    model::Symbol amplitudes = model::Symbol::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
            if (driven.decays(i) * driven.decays(j) != 0.0)
                amplitudes(i, j) = -driven.drive(i, j) / (all.rates(i) + std::conj(all.rates(j)));
    return {.matrix = all.shapes * amplitudes * all.shapes.adjoint(), .why_none = {}};
}

/// Whether the largest growth rate is certainly below 0 in the units of the equations; else decaying_part() knows.
bool all_decay(double largest, const model::Symbol& m) { return largest < -1e-10 * m.norm(); }

/// The components that noise reaches, as 1; 0: others, which do not fluctuate.
Eigen::VectorXd reached_by_noise(const model::Symbol& m, const model::Symbol& noise) {
    Eigen::VectorXd reached = (noise.diagonal().array() != 0.0).cast<double>();
    for (Eigen::Index round = 0; round < m.rows(); ++round)
        for (Eigen::Index i = 0; i < m.rows(); ++i)
            for (Eigen::Index j = 0; j < m.rows(); ++j)
                if (reached(j) != 0.0 && m(i, j) != 0.0) reached(i) = 1.0;
    return reached;
}

/// None where the result does not solve the Lyapunov equation: modes that are nearly equal have shapes that are, and
/// their sums are differences of large numbers.
void check_sum(const model::LinearisedAt& at, const Wavevector& q, Covariance& of) {
    if (!of.why_none.empty()) return;
    constexpr double tolerance = 1e-6;
    const model::Symbol m = at.symbol(q), noise = at.noise(q);
    const Eigen::VectorXd reached = reached_by_noise(m, noise);
    of.matrix = reached.asDiagonal() * of.matrix * reached.asDiagonal();  // the others are rounding errors
    const model::Symbol product = m * of.matrix;
    const Eigen::VectorXd deviations = of.matrix.diagonal().cwiseAbs().cwiseSqrt();
    const Eigen::MatrixXd size = m.cwiseAbs() * deviations * deviations.transpose();
    const Eigen::MatrixXd left = (product + product.adjoint() + noise).cwiseAbs(),
                          parts = size + size.transpose() + noise.cwiseAbs();
    if ((left.array() <= tolerance * parts.array()).all() && (of.matrix.diagonal().real().array() >= 0.0).all()) return;
    of = {.matrix = {},
          .why_none = text("the stationary state of {} is not known: modes that decay are too nearly equal beside one "
                           "that does not",
                           mode_text(q))};
}

/// That of the components with a rate.
Covariance covariance_of_state(const model::LinearisedAt& at, const Wavevector& q) {
    Covariance result;
    if (all_decay(solve_covariance(at, q, result.matrix), at.symbol(q))) return result;
    const DecayingPart part = decaying_part(at, q);
    model::Symbol inside;
    if (part.decays && numerics::solve_lyapunov_precisely(part.symbol, part.noise, inside) < 0.0)
        return {.matrix = part.basis * inside * part.basis.adjoint(), .why_none = {}};
    result = by_modes(driven_modes(at, q));
    check_sum(at, q, result);
    return result;
}

/// (-i omega - m)^-1.
model::Symbol resolvent(const model::Symbol& m, const Wavevector& q, double omega) {
    const model::Symbol shifted = Complex(0.0, -omega) * model::Symbol::Identity(m.rows(), m.cols()) - m;
    model::Symbol inverse = numerics::inverse(shifted);
    if (!inverse.allFinite())
        fail_run("{} has the frequency {} and does not decay: its spectrum is not finite", mode_text(q), omega);
    return inverse;
}
}  // namespace

double solve_covariance(const model::LinearisedAt& at, const Wavevector& q, model::Symbol& matrix) {
    const model::Symbol m = at.symbol(q);
    matrix = model::Symbol::Zero(m.rows(), m.cols());
    return numerics::solve_lyapunov(m, at.noise(q), matrix);
}

Covariance covariance(const model::LinearisedAt& at, const Wavevector& q) {
    if (const model::TermSummary* placed = at.equations().placed_noise())
        return {.matrix = {},
                .why_none = text("the noise \"{}\" depends on position or time, so that no uniform state has it",
                                 placed->text)};
    if (q.x == 0.0 && q.y == 0.0) {
        const model::Symbol noise = at.noise(q), conserved = conserved_means(at).cast<Complex>();
        if ((conserved * noise * conserved.adjoint()).norm() > 1e-12 * noise.norm() * conserved.squaredNorm())
            return {.matrix = {}, .why_none = "no stationary state: noise drives a mean that the equations conserve"};
    }
    Covariance result = covariance_of_state(at, q);
    if (!result.why_none.empty()) return result;
    const model::Symbol all = at.all_components(q);
    result.matrix = all * result.matrix * all.adjoint();
    return result;
}

model::Symbol dynamic_structure(const model::LinearisedAt& at, const Wavevector& q, double omega) {
    const model::Symbol response = at.all_components(q) * resolvent(at.symbol(q), q, omega);
    return response * at.noise(q) * response.adjoint();
}

Correlations dynamic_structures(const model::LinearisedAt& at, const Wavevector& q,
                                const std::vector<double>& frequencies) {
    Correlations result;
    model::Symbol ignored;
    if (all_decay(solve_covariance(at, q, ignored), at.symbol(q))) {
        for (const double omega : frequencies) result.matrices.push_back(dynamic_structure(at, q, omega));
        return result;
    }
    if (const DecayingPart part = decaying_part(at, q); part.decays) {
        const model::Symbol basis = at.all_components(q) * part.basis;
        for (const double omega : frequencies) {
            const model::Symbol response = basis * resolvent(part.symbol, q, omega);
            result.matrices.emplace_back(response * part.noise * response.adjoint());
        }
        return result;
    }
    const DrivenModes driven = driven_modes(at, q);
    result.why_none = driven.why_none;
    if (!result.why_none.empty()) return result;
    const model::Symbol shapes = at.all_components(q) * driven.all.shapes;
    for (const double omega : frequencies) {
        Eigen::VectorXcd response = Eigen::VectorXcd::Zero(driven.decays.size());
        for (Eigen::Index k = 0; k < response.size(); ++k)
            if (driven.decays(k) != 0.0) response(k) = 1.0 / (Complex(0.0, -omega) - driven.all.rates(k));
        const model::Symbol parts = shapes * response.asDiagonal();
        result.matrices.emplace_back(parts * driven.drive * parts.adjoint());
    }
    return result;
}

Correlations lagged_covariances(const model::LinearisedAt& at, const Wavevector& q, double interval, std::size_t lags) {
    require(interval >= 0.0 && std::isfinite(interval), {}, "an interval of {}; expected a finite time >= 0", interval);
    const model::Symbol all = at.all_components(q), step = numerics::exponential(interval * at.symbol(q));
    Covariance lagged = covariance_of_state(at, q);
    Correlations result{.matrices = {}, .why_none = lagged.why_none};
    if (!result.why_none.empty()) return result;
    for (std::size_t n = 0; n < lags; ++n) {
        result.matrices.emplace_back(all * lagged.matrix * all.adjoint());
        lagged.matrix = step * lagged.matrix;
    }
    return result;
}

std::vector<std::string> part_names(const model::Equations& equations) {
    std::vector<std::string> names;
    for (const model::Field& field : equations.model().fields) {
        if (field.spin == 0) names.push_back(field.symbol);
        else names.insert(names.end(), {field.symbol + "_along", field.symbol + "_across"});
    }
    return names;
}

StructureFactors structure_factors(const model::LinearisedAt& at, const numerics::Grid& grid, int degree,
                                   Threads& threads, const IsWanted& is_wanted) {
    StructureFactors result{.names = part_names(at.equations()), .values = {}, .why_none = {}};
    const std::size_t width = numerics::columns(grid), parts = result.names.size();
    const numerics::DistinctWavenumbers distinct = numerics::distinct_wavenumbers(grid, degree);
    // Where all directions are equivalent, the parts depend on |q| alone.
    const bool is_isotropic = at.is_isotropic();
    const std::size_t count = is_isotropic ? distinct.q.size() : numerics::modes(grid);
    std::vector<char> wanted(count);
    for (std::size_t mode = 0; mode < numerics::modes(grid); ++mode)
        if (distinct.of_mode[mode] > 0 && (!is_wanted || is_wanted(mode)))  // kept, and not q = 0
            wanted[is_isotropic ? static_cast<std::size_t>(distinct.of_mode[mode]) : mode] = 1;
    std::vector<std::complex<double>> of_place(count * parts * parts, 0.0);
    std::vector<std::string> why_none(count);
    threads.for_chunks(count, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            if (wanted[n] == 0) continue;
            const Wavevector q = is_isotropic ? Wavevector{.x = distinct.q[n], .y = 0.0}
                                              : numerics::wavevector(grid, n % width, n / width);
            const Covariance found = covariance(at, q);
            why_none[n] = found.why_none;
            if (!found.why_none.empty()) continue;
            const model::Symbol s = at.along_and_across(found.matrix, q);
            for (std::size_t i = 0; i < parts; ++i)
                for (std::size_t j = 0; j < parts; ++j)
                    of_place[(n * parts + i) * parts + j] =
                        s(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
    });
    for (const std::string& why : why_none)
        if (!why.empty()) {
            result.why_none = why;
            return result;
        }
    if (!is_isotropic) {
        result.values = std::move(of_place);
        return result;
    }
    result.values.assign(numerics::modes(grid) * parts * parts, 0.0);
    for (std::size_t mode = 0; mode < numerics::modes(grid); ++mode)
        if (distinct.of_mode[mode] > 0 && (!is_wanted || is_wanted(mode)))
            std::copy_n(&of_place[static_cast<std::size_t>(distinct.of_mode[mode]) * parts * parts], parts * parts,
                        &result.values[mode * parts * parts]);
    return result;
}

}  // namespace drover::theory
