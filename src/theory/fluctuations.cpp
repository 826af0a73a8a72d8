// theory/fluctuations.cpp: stationary fluctuations by the Lyapunov equation, and their spectra by the resolvent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/fields/wavenumbers.hpp"

namespace drover::theory {

namespace {
using numerics::Wavevector;
using Complex = std::complex<double>;

std::string mode_text(const Wavevector& q) { return text("a mode at q = ({:.4g}, {:.4g})", q.x, q.y); }

/// Modes that decay, added up one by one: those that neither grow nor decay must not be driven.
Covariance by_modes(const Modes& all, const model::Symbol& noise, const Wavevector& q) {
    constexpr double epsilon = std::numeric_limits<double>::epsilon();
    const Eigen::Index n = all.rates.size();
    const model::Symbol drive = all.duals * noise * all.duals.adjoint();
    std::vector<bool> decays;
    for (Eigen::Index k = 0; k < n; ++k) {
        const double rate = all.rates(k).real(), rounding = all.roundings(k);
        if (rate > rounding)
            return {.matrix = {},
                    .why_none = text("no stationary state: {} grows at the rate {:.3g}", mode_text(q), rate)};
        decays.push_back(rate < -rounding);
        const Eigen::RowVectorXd sizes = all.duals.row(k).cwiseAbs();
        const double parts = sizes * noise.cwiseAbs() * sizes.transpose();
        if (!decays.back() && drive(k, k).real() > 16.0 * epsilon * parts)
            return {.matrix = {},
                    .why_none = text("no stationary state: noise drives {}, which does not decay: its rate of {:.2g} "
                                     "is 0 within a rounding error of {:.2g}",
                                     mode_text(q), rate, rounding)};
    }
    model::Symbol amplitudes = model::Symbol::Zero(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j)
            if (decays[static_cast<std::size_t>(i)] && decays[static_cast<std::size_t>(j)])
                amplitudes(i, j) = -drive(i, j) / (all.rates(i) + std::conj(all.rates(j)));
    return {.matrix = all.shapes * amplitudes * all.shapes.adjoint(), .why_none = {}};
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
    Covariance result;
    const double largest = solve_covariance(at, q, result.matrix);
    // Close to 0 the sign of the rate is not certain.
    if (!(largest < -1e-10 * at.symbol(q).norm())) result = by_modes(modes(at, q), at.noise(q), q);
    if (!result.why_none.empty()) return result;
    const model::Symbol all = at.all_components(q);
    result.matrix = all * result.matrix * all.adjoint();
    return result;
}

model::Symbol dynamic_structure(const model::LinearisedAt& at, const Wavevector& q, double omega) {
    const model::Symbol m = at.symbol(q);
    const model::Symbol shifted = Complex(0.0, -omega) * model::Symbol::Identity(m.rows(), m.cols()) - m;
    const model::Symbol inverse = numerics::inverse(shifted);
    if (!inverse.allFinite())
        fail_run("{} has the frequency {} and does not decay: its spectrum is not finite", mode_text(q), omega);
    const model::Symbol response = at.all_components(q) * inverse;
    return response * at.noise(q) * response.adjoint();
}

std::vector<model::Symbol> lagged_covariances(const model::LinearisedAt& at, const Wavevector& q, double interval,
                                              std::size_t lags) {
    const model::Symbol all = at.all_components(q), step = numerics::exponential(interval * at.symbol(q));
    model::Symbol lagged;
    if (!(solve_covariance(at, q, lagged) < 0.0)) return {};
    std::vector<model::Symbol> result;
    for (std::size_t n = 0; n < lags; ++n) {
        result.emplace_back(all * lagged * all.adjoint());
        lagged = step * lagged;
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
                                   Threads& threads) {
    StructureFactors result{.names = part_names(at.equations()), .values = {}, .why_none = {}};
    const std::size_t width = numerics::columns(grid), parts = result.names.size();
    const numerics::DistinctWavenumbers distinct = numerics::distinct_wavenumbers(grid, degree);
    // Where all directions are equivalent, the parts depend on |q| alone.
    const bool is_isotropic = at.is_isotropic();
    const std::size_t count = is_isotropic ? distinct.q.size() : numerics::modes(grid);
    std::vector<std::complex<double>> of_place(count * parts * parts, 0.0);
    std::vector<std::string> why_none(count);
    threads.for_chunks(count, 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            if (is_isotropic ? n == 0 : distinct.of_mode[n] <= 0) continue;
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
        if (distinct.of_mode[mode] > 0)  // kept, and not q = 0
            std::copy_n(&of_place[static_cast<std::size_t>(distinct.of_mode[mode]) * parts * parts], parts * parts,
                        &result.values[mode * parts * parts]);
    return result;
}

}  // namespace drover::theory
