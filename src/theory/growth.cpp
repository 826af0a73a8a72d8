// theory/growth.cpp: bands of growing waves, and the fastest wave.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/mapped.hpp"
#include "drover/theory/theory.hpp"
#include "numerics/algebra/bracket.hpp"
#include "numerics/algebra/extremum.hpp"
#include "theory/instabilities.hpp"

namespace drover::theory {

void check(const GrowthSearch& search) {
    require(search.min > 0.0 && search.min < search.max && std::isfinite(search.max), {},
            "a search from |q| = {} to {}; expected 0 < min < max", search.min, search.max);
    require(search.wavenumbers >= 3 && search.angles >= 1, {},
            "a search of {} wavenumbers at {} angles; expected at least 3 and 1", search.wavenumbers, search.angles);
}

namespace {
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
    const auto rate = [&](double x) { return growth_rate(at, std::exp(x), angle); };
    const std::vector<double> rates = mapped(log_q, rate);
    std::vector<double> places = log_q;
    for (std::size_t k = 0; k < log_q.size(); ++k) {
        const double left = k > 0 ? rates[k - 1] : rates[k], right = k + 1 < rates.size() ? rates[k + 1] : rates[k];
        if (rates[k] < left || rates[k] < right) continue;
        const double low = log_q[k > 0 ? k - 1 : k], high = log_q[k + 1 < log_q.size() ? k + 1 : k];
        const double fine = numerics::golden_maximum(low, high, rate);
        if (rate(fine) > rates[k]) places.push_back(fine);
    }
    std::ranges::sort(places);
    return places;
}
}  // namespace

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

}  // namespace drover::theory
