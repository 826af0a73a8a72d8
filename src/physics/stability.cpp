// physics/stability.cpp: eigenvalues of the linear symbol, branches followed, maxima of growth.
#include "drover/physics/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/constants.hpp"
#include "drover/physics/long_waves.hpp"
#include "numerics/extremum.hpp"

namespace drover::physics {

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
            .duals = modes.duals(order, Eigen::all)};
}
}  // namespace

ModeMap mode_map(const Equations& equations, const StationaryState& about, const std::vector<double>& wavenumbers,
                 const std::vector<double>& angles, Threads& threads) {
    ModeMap map{.wavenumbers = wavenumbers,
                .angles = angles,
                .modes = std::vector<Modes>(wavenumbers.size() * angles.size())};
    const auto at = equations.linearised(about.point);
    const std::size_t width = wavenumbers.size();
    threads.for_chunks(angles.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a)
            for (std::size_t k = 0; k < width; ++k) {
                Modes& here = map.modes[a * width + k];
                here = model::modes(*at, at->wavevector(wavenumbers[k], angles[a]));
                if (k > 0) here = reordered(here, continuation(map.modes[a * width + k - 1], here));
            }
    });
    for (std::size_t a = 1; a < angles.size(); ++a) {
        const std::vector<Eigen::Index> order = continuation(map.at(a - 1, 0), map.at(a, 0));
        for (std::size_t k = 0; k < width; ++k) map.modes[a * width + k] = reordered(map.at(a, k), order);
    }
    return map;
}

namespace {
constexpr int angle_steps = 45;  // 2 degrees where a quarter turn is enough

/// Growth as a function of ln q and angle.
struct Landscape {
    const model::LinearisedAt& state;
    double at(double log_q, double angle) const { return model::growth_rate(state, std::exp(log_q), angle); }
    auto along(double angle) const {
        return [this, angle](double log_q) { return at(log_q, angle); };
    }
    Modes modes(double log_q, double angle) const {
        return model::modes(state, state.wavevector(std::exp(log_q), angle));
    }
    bool grows(double log_q, double angle) const { return modes(log_q, angle).grows(); }
};

/// Of a wave on a flock.
std::string name_of(const Equations& equations, const StationaryState& about, const Growth& found, double angle) {
    const double along = std::abs(std::sin(angle)), across = std::abs(std::cos(angle));
    if (along < 1e-6) return "banding";
    if (across < 1e-6 && std::abs(found.frequency) < 1e-9 * std::abs(found.rate)) {
        const LongWaves slow = long_waves(equations, about);
        if (!slow.why_none.empty() || slow_growth(slow, direction_of(about.point) + angle).first == 0.0)
            return "phase separation";
    }
    return "oblique";
}

/// Where the waves of one angle stop growing, on both sides of one that grows.
void set_range(const Landscape& land, const std::vector<double>& log_q, Instability& found) {
    const auto grows = [&](double x) { return land.grows(x, found.angle); };
    found.min = 0.0;
    found.max = infinite;
    double inside = std::log(found.q);
    for (auto x = log_q.rbegin(); x != log_q.rend(); ++x)
        if (*x < inside && !grows(*x)) {
            found.min = std::exp(numerics::boundary_between(*x, *(x - 1) < inside ? *(x - 1) : inside, 1e-14, grows));
            break;
        }
    for (const double& x : log_q)
        if (x > inside && !grows(x)) {
            const double before = &x == log_q.data() ? inside : std::max(inside, *(&x - 1));
            found.max = std::exp(numerics::boundary_between(before, x, 1e-14, grows));
            break;
        }
}

/// Growth rate of the uniform instability, at q = 0; 0 if there is none.
double uniform_growth(const Landscape& land) {
    const Eigen::VectorXcd rates = model::mode_rates(land.state, {});
    const double most = rates.real().maxCoeff();
    return most > 1e-13 * rates.cwiseAbs().maxCoeff() ? most : 0.0;
}

Instability found_at(const Landscape& land, const std::vector<double>& log_q, const std::string& name, double x,
                     double angle) {
    const Growth here = model::growth(land.state, std::exp(x), angle);
    const double step = log_q[1] - log_q[0];
    Instability one{.name = name,
                    .rate = here.rate,
                    .frequency = here.frequency,
                    .q = std::exp(x),
                    .angle = angle,
                    .at_longest = (x < log_q.front() + 1e-6 * step),
                    .at_shortest = (x > log_q.back() - 1e-6 * step)};
    set_range(land, log_q, one);
    return one;
}

/// Whether the fastest mode of a wave moves a density: the first components.
bool moves_density(const Landscape& land, const Form& form, double x) {
    const Eigen::Index densities = (form.bead_density >= 0 ? 1 : 0) + (form.rod_density >= 0 ? 1 : 0);
    return land.modes(x, 0.0).shapes.col(0).head(densities).cwiseAbs().sum() > 1e-9;
}

std::vector<Instability> isotropic_instabilities(const Landscape& land, const Form& form,
                                                 const std::vector<double>& log_q) {
    std::vector<Instability> found;
    const auto rate = land.along(0.0);
    const double uniform = uniform_growth(land),
                 x = numerics::refined_maximum(log_q, numerics::largest_of(log_q, rate).place, rate);
    if (!land.grows(x, 0.0)) return found;
    // Order grows without a wave, or in waves that move no density; densities that attract make waves of their own.
    const bool waves = land.at(x, 0.0) > uniform * (1.0 + 1e-6) && moves_density(land, form, x);
    if (waves) found.push_back(found_at(land, log_q, "phase separation", x, 0.0));
    if (!waves || uniform > 0.0) found.push_back(found_at(land, log_q, "order", waves ? log_q.front() : x, 0.0));
    return found;
}
}  // namespace

std::vector<Instability> instabilities(const Equations& equations, const StationaryState& about, const Search& search) {
    const auto state = equations.linearised(about.point);
    const Landscape land{*state};
    const std::vector<double> log_q = numerics::even_logarithms(search.min, search.max, search.wavenumbers);
    if (is_isotropic(about.point)) return isotropic_instabilities(land, equations.form, log_q);
    // Rates at q and -q are conjugate: half a turn holds all, a quarter where the state is its own mirror image.
    const bool quarter = is_mirrored(about.point);
    const int steps = quarter ? angle_steps : 2 * angle_steps;
    const double step_angle = right_angle / angle_steps, uniform = uniform_growth(land);
    std::vector<numerics::Largest> best;
    for (int a = 0; a <= steps; ++a) best.push_back(numerics::largest_of(log_q, land.along(a * step_angle)));
    std::vector<Instability> found;
    const bool ordered = about.point.order.norm() > 0.0;
    if (uniform > 0.0) found.push_back({.name = ordered ? "uniform" : "order", .rate = uniform});
    const auto add = [&](double x, double angle) {
        if (!land.grows(x, angle) || land.at(x, angle) <= uniform * (1.0 + 1e-6)) return;
        const Growth here = model::growth(land.state, std::exp(x), angle);
        const std::string name = ordered ? name_of(equations, about, here, angle) : "phase separation";
        found.push_back(found_at(land, log_q, name, x, angle));
    };
    for (int a = 0; a <= (quarter ? steps : steps - 1); ++a) {
        const auto rate = [&](int n) { return best[static_cast<std::size_t>((n + steps) % steps)].value; };
        const double angle = a * step_angle, x = best[static_cast<std::size_t>(a)].place;
        if (quarter && (a == 0 || a == steps)) {
            add(numerics::refined_maximum(log_q, x, land.along(angle)), angle);  // symmetry keeps a wave at its angle
        } else if (rate(a) > rate(a - 1) && rate(a) >= (quarter && a + 1 == steps ? best.back().value : rate(a + 1))) {
            auto [fine, turned] = numerics::climbed([&](double one, double other) { return land.at(one, other); },
                                                    {x, angle}, {0.3 * (log_q[1] - log_q[0]), 0.3 * step_angle});
            fine = std::clamp(fine, log_q.front(), log_q.back());
            if (land.at(fine, turned) <= best[static_cast<std::size_t>(a)].value) fine = x, turned = angle;
            // A maximum that moves to an end is already listed as that of the end.
            if (!quarter || (turned > 1e-6 && turned < right_angle - 1e-6)) add(fine, turned);
        }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Instability& a, const Instability& b) { return a.rate > b.rate; });
    return found;
}

}  // namespace drover::physics
