// run/warnings/growing_waves.cpp: a search over wavenumbers and directions.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <vector>

#include "base/constants.hpp"
#include "drover/base/text.hpp"
#include "drover/model/linearised_at.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/dense.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
using std::numbers::pi;

std::optional<model::LinearisedAt> linearised(const model::Equations& equations) try {
    if (equations.placed_term() != nullptr) return std::nullopt;
    return model::LinearisedAt(equations, equations.reference());
} catch (const Error& error) {
    if (error.fault() != Fault::input) throw;
    return std::nullopt;  // a derivative is not finite
}

/// Waves about the references.
class Waves {
public:
    Waves(const model::Equations& equations, const numerics::System& system)
        : system_(system), linear_(linearised(equations)) {
        const numerics::Grid& grid = system.grid;
        if (grid.ny == 1) angles_ = {0.0};
        else if (!linear_ || linear_->is_isotropic()) angles_ = {cut_at(0.0) <= cut_at(0.5 * pi) ? 0.0 : 0.5 * pi};
        else
            for (int n = 0; n < directions; ++n) angles_.push_back(pi * n / directions);
    }

    /// Of the directions to look at [rad].
    const std::vector<double>& angles() const { return angles_; }

    /// Beyond it waves at an angle are cut.
    double cut_at(double angle) const {
        const auto along = [&](int points, double side, double part) {
            return points > 1 ? 2.0 * pi / side * points / (system_.degree + 1) / std::abs(part) : INFINITY;
        };
        return std::min(along(system_.grid.nx, system_.grid.lx, std::cos(angle)),
                        along(system_.grid.ny, system_.grid.ly, std::sin(angle)));
    }

    bool grow(double q, double angle) const {
        // Of the largest: of reliable rates, and of others, where two modes that do not decay are nearly one.
        constexpr double rounding = 1e-12, doubtful = 1e-6;
        const double growth = growth_of(rates_of(q, angle, false));
        return std::abs(growth) > doubtful ? growth > 0.0 : growth_of(rates_of(q, angle, true)) > rounding;
    }

private:
    static constexpr int directions = 12;  // of half a turn, as waves are real

    /// The largest growth rate over the largest rate.
    static double growth_of(const std::vector<numerics::Complex>& rates) {
        double size = 0.0, growth = -infinite;
        for (const numerics::Complex s : rates) size = std::max(size, std::abs(s)), growth = std::max(growth, s.real());
        return size > 0.0 ? growth / size : 0.0;
    }

    std::vector<numerics::Complex> rates_of(double q, double angle, bool reliable) const {
        std::vector<numerics::Complex> rates;
        if (linear_) {
            const numerics::Wavevector at{q * std::cos(angle), q * std::sin(angle)};
            const Eigen::VectorXcd found = reliable
                                               ? Eigen::VectorXcd(theory::mode_rates(*linear_, at))
                                               : numerics::dense_eigenvalues(numerics::balanced(linear_->symbol(at)));
            rates.assign(found.begin(), found.end());
            return rates;
        }
        const numerics::IsotropicBlocks blocks = system_.linear(q);
        for (const numerics::Block* block : {&blocks.even, &blocks.odd})
            std::ranges::copy(numerics::eigenvalues(*block), std::back_inserter(rates));
        return rates;
    }

    const numerics::System& system_;
    std::optional<model::LinearisedAt> linear_;
    std::vector<double> angles_;
};

constexpr int max_octaves = 10, per_octave = 32;

/// Those that grow the furthest beyond the cut of their direction.
struct ShortestGrowing {
    double angle = 0.0;  ///< [rad]
    int step = -1;       ///< of an octave, above the cut; -1: the grid keeps all
};

ShortestGrowing shortest_growing(const Waves& waves) {
    ShortestGrowing shortest;
    for (const double angle : waves.angles()) {
        const double cut = waves.cut_at(angle);
        int step = max_octaves * per_octave;
        while (step > shortest.step && !waves.grow(cut * std::exp2(static_cast<double>(step) / per_octave), angle))
            --step;
        if (step > shortest.step) shortest = {.angle = angle, .step = step};
    }
    return shortest;
}
}  // namespace

double largest_growing(const model::Equations& equations, const numerics::System& system, double max_q) {
    constexpr int looks = 400;
    const Waves waves(equations, system);
    for (int n = looks; n >= 1; --n)
        for (const double angle : waves.angles())
            if (waves.grow(max_q * n / looks, angle)) return max_q * n / looks;
    return 0.0;
}

std::string growing_waves_warning(const model::Equations& equations, const numerics::System& system,
                                  const io::Units& units) {
    const Waves waves(equations, system);
    const ShortestGrowing found = shortest_growing(waves);
    if (found.step < 0) return "";
    if (found.step == max_octaves * per_octave)
        return "waves of any length, however short, grow about the references, so results depend on the grid; add a "
               "term that damps short waves, such as a Laplacian";
    const double cut = waves.cut_at(found.angle),
                 shortest = cut * std::exp2(static_cast<double>(found.step) / per_octave);
    int factor = 2;
    while (cut * factor <= 1.25 * shortest) factor *= 2;
    const auto length = [&](double q) { return io::in_unit("{:.3g}", 2.0 * pi / q, "mm", units); };
    const bool is_one_direction = waves.angles().size() == 1;
    return text(
        "waves{} down to a length of {} grow about the references, and {} keeps no waves shorter than "
        "{}{}: choose {}, or terms that damp short waves more",
        is_one_direction ? "" : text(" at {:.0f} degrees from x", found.angle * 180.0 / pi), length(shortest),
        grid_keys(system.grid), length(cut), is_one_direction ? "" : " there", grid_keys(system.grid, factor));
}

std::string grid_keys(const numerics::Grid& grid, int factor) {
    const std::string along_x = text("grid.nx = {}", factor * grid.nx);
    return grid.ny == 1 ? along_x : text("{} and grid.ny = {}", along_x, factor * grid.ny);
}

}  // namespace drover::run
