// theory/mode_map.cpp: branches of modes, followed from wave to wave.
#include <algorithm>
#include <limits>

#include "base/constants.hpp"
#include "theory/instabilities.hpp"

namespace drover::theory {

namespace {
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

Modes reordered(const Modes& modes, const std::vector<Eigen::Index>& order) {
    return {.rates = modes.rates(order),
            .shapes = modes.shapes(Eigen::all, order),
            .duals = modes.duals(order, Eigen::all),
            .roundings = modes.roundings(order)};
}
}  // namespace

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
