// theory/instabilities.cpp: bands of growing waves, and the fastest wave; maxima of growth over all waves, what kind
// each is, and where it ends.
#include "theory/instabilities.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/bracket.hpp"
#include "numerics/algebra/extremum.hpp"
#include "theory/maxima.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
constexpr int angle_steps = 45;  // of a quarter turn

/// Growth as a function of ln q and angle.
struct Landscape {
    const model::LinearisedAt& state;
    std::vector<double> log_q;
    bool has_direction;
    double uniform;             ///< growth rate of the uniform state; 0: it does not grow
    Eigen::MatrixXd conserved;  ///< conserved_means()

    double at(double x, double angle) const { return growth_rate(state, std::exp(x), angle); }
    numerics::Largest largest(double angle) const {
        numerics::Largest found{.place = log_q.front()};
        for (const auto& [x, _] : growth_maxima(growth_of_modes(state), log_q, {angle}))
            if (const double rate = at(x, angle); rate > found.value) found = {rate, x};
        return found;
    }
    /// The largest distance of a rate above its rounding error.
    double excess(double x, double angle) const {
        const Modes all = modes(state, state.wavevector(std::exp(x), angle));
        return all.rates.size() > 0 ? (all.rates.real() - all.roundings).maxCoeff() : -infinite;
    }
    bool grows(double x, double angle) const { return excess(x, angle) > 0.0; }
    /// Whether a wave grows faster than the uniform state.
    bool is_wave(double x, double angle) const { return at(x, angle) > uniform * (1.0 + 1e-6); }
};

/// What the fastest mode of a wave moves on a state without a direction.
InstabilityKind kind_without_direction(const Landscape& land, const numerics::Wavevector& q) {
    const model::Equations& equations = land.state.equations();
    const Eigen::VectorXcd shape = land.state.all_components(q) * modes(land.state, q).shapes.col(0);
    if ((land.conserved * shape(equations.state_components())).norm() > 1e-9) return InstabilityKind::phase_separation;
    for (const auto& [field, first] : model::placed_fields(equations.model()))
        if (field.spin == 0 && field.left == model::LeftSide::rate &&
            std::abs(shape(static_cast<Eigen::Index>(first))) > 1e-9)
            return InstabilityKind::pattern;
    return InstabilityKind::order;
}

InstabilityKind kind_of_wave(const Landscape& land, const Growth& found, double q, double angle) {
    if (!land.has_direction) return kind_without_direction(land, land.state.wavevector(q, angle));
    const double along = std::abs(std::sin(angle)), across = std::abs(std::cos(angle));
    if (along < 1e-6) return InstabilityKind::banding;
    if (across > 1e-6 || std::abs(found.frequency) > 1e-9 * std::abs(found.rate)) return InstabilityKind::oblique;
    // Sound of a negative stiffness grows in proportion to q, and faster at other angles.
    const std::vector<SlowMode> slow = slow_modes(land.state, angle).modes;
    const bool is_sound = std::ranges::any_of(slow, [](const SlowMode& mode) { return mode.speed.imag() > 0.0; });
    return is_sound ? InstabilityKind::oblique : InstabilityKind::phase_separation;
}

/// Of the uniform state.
InstabilityKind kind_of_change(const Landscape& land) {
    if (land.has_direction) return InstabilityKind::uniform;
    if (modes(land.state, {}).rates.size() == 0) return InstabilityKind::uniform;
    return kind_without_direction(land, {}) == InstabilityKind::order ? InstabilityKind::order
                                                                      : InstabilityKind::uniform;
}

/// Where the waves of one angle stop growing, on both sides of one that grows.
void set_range(const Landscape& land, Instability& found) {
    const std::vector<double>& log_q = land.log_q;
    const auto excess = [&](double x) { return land.excess(x, found.angle); };
    found.min = 0.0;
    found.max = infinite;
    const double inside = std::log(found.q);
    for (auto x = log_q.rbegin(); x != log_q.rend(); ++x)
        if (*x < inside && !(excess(*x) > 0.0)) {
            found.min = std::exp(numerics::crossing(*x, *(x - 1) < inside ? *(x - 1) : inside, 1e-14, excess));
            break;
        }
    for (const double& x : log_q)
        if (x > inside && !(excess(x) > 0.0)) {
            const double before = &x == log_q.data() ? inside : std::max(inside, *(&x - 1));
            found.max = std::exp(numerics::crossing(before, x, 1e-14, excess));
            break;
        }
}

Instability found_at(const Landscape& land, double x, double angle) {
    const double q = std::exp(x), step = land.log_q[1] - land.log_q[0];
    const Growth here = growth(land.state, q, angle);
    Instability one{.kind = kind_of_wave(land, here, q, angle),
                    .rate = here.rate,
                    .frequency = here.frequency,
                    .q = q,
                    .angle = angle,
                    .at_longest = (x < land.log_q.front() + 1e-6 * step),
                    .at_shortest = (x > land.log_q.back() - 1e-6 * step)};
    set_range(land, one);
    return one;
}

bool faster(const Instability& a, const Instability& b) { return a.rate > b.rate; }

/// x: the place of the largest rate.
std::vector<Instability> isotropic_instabilities(const Landscape& land, const GrowthSearch& search, double x) {
    std::vector<Instability> found;
    const InstabilityKind change = kind_of_change(land);
    const auto add_change = [&](double at) {
        found.push_back(found_at(land, at, 0.0));
        found.back().kind = change;
        if (change == InstabilityKind::order && at >= land.log_q.front()) return;
        const Growth uniform = growth(land.state, 0.0);
        found.back().rate = uniform.rate;
        found.back().frequency = uniform.frequency;
        found.back().q = 0.0;
    };
    if (!land.grows(x, 0.0)) {
        constexpr double far = 20.0;  // below the waves that are searched, none of which grows
        if (land.uniform > 0.0) add_change(land.log_q.front() - far);
        return found;
    }
    // Order grows without a wave, or in waves that move no scalar; scalars make waves of their own.
    if (land.is_wave(x, 0.0)) {
        found.push_back(found_at(land, x, 0.0));
        if (found.back().kind != InstabilityKind::order && land.uniform > 0.0) add_change(land.log_q.front());
    } else {
        add_change(x);
    }
    for (const Band& band : growth_bands(land.state, 0.0, search)) {
        const bool is_known = std::ranges::any_of(found, [&](const Instability& one) {
            constexpr double rounding = 1e-9;  // of exp and log
            return one.q <= band.max * (1.0 + rounding) && (one.q >= band.min * (1.0 - rounding) || band.reaches_min);
        });
        if (!is_known) found.push_back(found_at(land, std::log(band.q), 0.0));
    }
    std::ranges::stable_sort(found, faster);
    return found;
}

double uniform_growth(const model::LinearisedAt& at) {
    const Eigen::VectorXcd rates = mode_rates(at, {});
    const double max_rate = rates.real().maxCoeff();
    return max_rate > 1e-13 * rates.cwiseAbs().maxCoeff() ? max_rate : 0.0;
}
/// Rates at q and -q are conjugate: half a turn holds all, a quarter where the state is its own mirror image.
struct Looks {
    bool quarter;
    int steps;
    std::vector<numerics::Largest> best;  ///< at each angle
};
constexpr double step_angle = right_angle / angle_steps;

Looks look_around(const Landscape& land, Threads& threads) {
    const bool quarter = land.state.is_mirrored();
    Looks looks{.quarter = quarter, .steps = quarter ? angle_steps : 2 * angle_steps, .best = {}};
    looks.best.resize(static_cast<std::size_t>(looks.steps) + 1);
    threads.for_chunks(looks.best.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t a = begin; a < end; ++a) looks.best[a] = land.largest(static_cast<double>(a) * step_angle);
    });
    return looks;
}

/// The uniform state itself, and the shortest wave to which its growth extends at any angle.
Instability uniform_change(const Landscape& land, int steps) {
    const Growth uniform = growth(land.state, 0.0);
    Instability found{.kind = kind_of_change(land), .rate = land.uniform, .frequency = uniform.frequency};
    const auto shortest = [&](double angle) {
        Instability one{.q = std::exp(land.log_q.front()), .angle = angle};
        if (!land.grows(land.log_q.front(), angle)) return 0.0;
        set_range(land, one);
        return one.max;
    };
    std::vector<double> angles;
    for (int a = 0; a <= steps; ++a) angles.push_back(a * step_angle);
    const numerics::Largest largest = numerics::largest_of(angles, shortest);
    found.max = std::isfinite(largest.value)
                    ? std::max(largest.value, shortest(numerics::refined_maximum(angles, largest.place, shortest)))
                    : largest.value;
    return found;
}

std::vector<Instability> anisotropic_instabilities(const Landscape& land, const Looks& looks) {
    const std::vector<double>& log_q = land.log_q;
    const auto& [quarter, steps, best] = looks;
    std::vector<Instability> found;
    if (land.uniform > 0.0) found.push_back(uniform_change(land, steps));
    const auto add = [&](double x, double angle) {
        if (land.grows(x, angle) && land.is_wave(x, angle)) found.push_back(found_at(land, x, angle));
    };
    for (int a = 0; a <= (quarter ? steps : steps - 1); ++a) {
        const auto rate = [&](int n) { return best[static_cast<std::size_t>((n + steps) % steps)].value; };
        const double angle = a * step_angle, x = best[static_cast<std::size_t>(a)].place;
        if (quarter && (a == 0 || a == steps)) {
            add(x, angle);  // symmetry keeps a wave at its angle
        } else if (rate(a) > rate(a - 1) && rate(a) >= (quarter && a + 1 == steps ? best.back().value : rate(a + 1))) {
            auto [fine, turned] =
                numerics::climbed([&](double one, double other) { return land.at(one, other); }, {x, angle},
                                  {0.3 * (log_q[1] - log_q[0]), 0.3 * step_angle}, {log_q.front(), log_q.back()});
            fine = std::clamp(fine, log_q.front(), log_q.back());
            if (land.at(fine, turned) <= best[static_cast<std::size_t>(a)].value) fine = x, turned = angle;
            // A maximum that moves to an end is already listed as that of the end.
            if (!quarter || (turned > 1e-6 && turned < right_angle - 1e-6)) add(fine, turned);
        }
    }
    std::ranges::stable_sort(found, faster);
    return found;
}

/// Climbs from a place, as log |q| and angle, to the nearest maximum within the search.
std::pair<double, double> climbed(const model::LinearisedAt& at, std::pair<double, double> from,
                                  std::pair<double, double> steps, const GrowthSearch& search) {
    const double low = std::log(search.min), high = std::log(search.max);
    const auto rate = [&](double log_q, double angle) {
        return growth_rate(at, std::exp(std::clamp(log_q, low, high)), angle);
    };
    std::pair<double, double> found = numerics::climbed(rate, from, steps, {low, high});
    found.first = std::clamp(found.first, low, high);
    return rate(found.first, found.second) >= rate(from.first, from.second) ? found : from;
}

/// The grid of a search with its maxima refined: log |q| ascending.
std::vector<double> with_maxima(const model::LinearisedAt& at, double angle, const std::vector<double>& log_q) {
    std::vector<double> places = log_q;
    for (const auto& [x, _] : growth_maxima(growth_of_modes(at), log_q, {angle})) places.push_back(x);
    std::ranges::sort(places);
    return places;
}

/// The wave of the maximum next to a place, as log |q| and angle, or the uniform state where that grows faster.
/// log_q: the places of the search; step_angle: between its angles, 0 where all directions are equivalent.
FastestWave refined_wave(const model::LinearisedAt& at, const GrowthSearch& search, const std::vector<double>& log_q,
                         std::pair<double, double> place, double step_angle) {
    const double step = log_q[1] - log_q[0];
    if (step_angle > 0.0) place = climbed(at, place, {step, step_angle}, search);
    place.first = numerics::refined_maximum(log_q, place.first,
                                            [&](double x) { return growth_rate(at, std::exp(x), place.second); });
    FastestWave wave{.q = std::exp(place.first), .angle = place.second};
    wave.angle -= std::numbers::pi * std::floor(wave.angle / std::numbers::pi);  // waves of q and -q are conjugates
    wave.growth = growth(at, wave.q, wave.angle);
    wave.at_min = place.first < log_q.front() + 1e-6 * step;
    wave.at_max = place.first > log_q.back() - 1e-6 * step;
    if (const Growth uniform = growth(at, 0.0); uniform.rate >= wave.growth.rate)
        wave = {.q = 0.0, .angle = 0.0, .growth = uniform};
    const numerics::Wavevector q = at.wavevector(wave.q, wave.angle);
    wave.shape = at.all_components(q) * modes(at, q).shapes.col(0);
    wave.shares = term_shares(at, q);
    return wave;
}
}  // namespace

GrowingWaves growing_waves(const model::LinearisedAt& at, const GrowthSearch& search, Threads& threads) {
    check(search);
    const Landscape land{.state = at,
                         .log_q = numerics::even_logarithms(search.min, search.max, search.wavenumbers),
                         .has_direction = has_order(at.equations().model(), at.about()),
                         .uniform = uniform_growth(at),
                         .conserved = conserved_means(at.equations())};
    if (at.is_isotropic()) {
        const double best = land.largest(0.0).place;
        return {.kinds = isotropic_instabilities(land, search, best),
                .fastest = refined_wave(at, search, land.log_q, {best, 0.0}, 0.0)};
    }
    const Looks looks = look_around(land, threads);
    const auto top =
        std::ranges::max_element(looks.best, [](const auto& a, const auto& b) { return a.value < b.value; });
    const double angle = static_cast<double>(top - looks.best.begin()) * step_angle;
    GrowingWaves result{.kinds = anisotropic_instabilities(land, looks),
                        .fastest = refined_wave(at, search, land.log_q, {top->place, angle}, step_angle)};
    if (looks.quarter && result.fastest.angle > right_angle) {
        // Its mirror image, and the conjugate wave of the opposite wavevector.
        result.fastest.angle = std::numbers::pi - result.fastest.angle;
        result.fastest.growth.frequency *= -1.0;
        for (std::complex<double>& share : result.fastest.shares) share = std::conj(share);
    }
    return result;
}

double direction_diffusion(const model::LinearisedAt& at, const LongWaves& waves) {
    if (!waves.why_none.empty()) return nan;
    const std::vector<int>&members = at.members(), &state = at.state_components();
    Eigen::VectorXd turn = Eigen::VectorXd::Zero(at.mass_density().size());  // of the state, by an angle
    for (const auto& [field, first] : model::placed_fields(at.equations().model()))
        if (field.spin > 0)
            turn.segment<2>(static_cast<Eigen::Index>(first)) << -field.spin * at.about()[first + 1],
                field.spin * at.about()[first];
    if (at.equations().placed_noise() != nullptr) return nan;
    const Eigen::VectorXd mass_density = at.mass_density()(members);
    const Eigen::VectorXd amplitudes = waves.left * mass_density.cwiseProduct(turn(members));  // a turn is a slow mode
    Eigen::MatrixXd by_rates = Eigen::MatrixXd::Zero(waves.left.rows(), at.mass_density().size());
    by_rates(Eigen::all, members) = waves.left * mass_density.asDiagonal();
    const Eigen::MatrixXd driven =
        by_rates(Eigen::all, state) * at.noise({}).real() * by_rates(Eigen::all, state).transpose();
    const Eigen::VectorXd angle = amplitudes / amplitudes.squaredNorm();
    const double diffusion = angle.dot(driven * angle);
    // The noise may drive another slow mode as well, such as the turn of an order of its own.
    const Eigen::MatrixXd of_turn = diffusion * amplitudes * amplitudes.transpose();
    if ((driven - of_turn).norm() > 1e-6 * driven.norm()) return nan;
    return 0.5 * diffusion;
}

void check(const GrowthSearch& search) {
    require(search.min > 0.0 && search.min < search.max && std::isfinite(search.max), {},
            "a search from |q| = {} to {}; expected 0 < min < max", search.min, search.max);
    require(search.wavenumbers >= 3 && search.angles >= 1, {},
            "a search of {} wavenumbers at {} angles; expected at least 3 and 1", search.wavenumbers, search.angles);
}

std::vector<Band> growth_bands(const model::LinearisedAt& at, double angle, const GrowthSearch& search) {
    check(search);
    const std::vector<double> places =
        with_maxima(at, angle, numerics::even_logarithms(search.min, search.max, search.wavenumbers));
    const auto excess = [&](double x) {
        const Growth here = growth(at, std::exp(x), angle);
        return here.rate - here.rounding;
    };
    std::vector<Band> bands;
    bool inside = false;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const Growth here = growth(at, std::exp(places[k]), angle);
        if (here.grows() && !inside) {
            Band band{.min = search.min, .max = search.max, .q = std::exp(places[k]), .growth = here};
            band.reaches_min = k == 0;
            if (k > 0) band.min = std::exp(numerics::crossing(places[k - 1], places[k], 1e-15, excess));
            bands.push_back(band);
        } else if (here.grows() && here.rate > bands.back().growth.rate) {
            bands.back().q = std::exp(places[k]);
            bands.back().growth = here;
        } else if (!here.grows() && inside) {
            bands.back().max = std::exp(numerics::crossing(places[k - 1], places[k], 1e-15, excess));
        }
        inside = here.grows();
    }
    if (inside) bands.back().reaches_max = true;
    return bands;
}

}  // namespace drover::theory
