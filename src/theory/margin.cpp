// theory/margin.cpp: how far a uniform state of any model is from its first instability.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "numerics/algebra/extremum.hpp"
#include "theory/boundary.hpp"
#include "theory/maxima.hpp"
#include "theory/uniform_equations.hpp"

namespace drover::theory {

namespace {
const StationaryState* state_of(const model::Equations& equations, const StationaryStates& found, MarginState which) {
    const model::UniformState reference = equations.reference();
    const auto rank = [&](const StationaryState& state) {  // the smallest is taken
        return which == MarginState::isotropic ? squared_distance(state.values, reference)
                                               : -squared_order(equations.model(), state.values);
    };
    const StationaryState* result = nullptr;
    for (const StationaryState& state : found.states)
        if (state.is_isotropic == (which == MarginState::isotropic) && (!result || rank(state) < rank(*result)))
            result = &state;
    return result;
}

/// Rates of waves, weighted so that those of diffusion have a limit at q = 0.
class Waves {
public:
    Waves(const model::LinearisedAt& at, const GrowthSearch& search)
        : at_(at), search_(search), weight_(search.min * search.max) {}

    /// The least stable change of the uniform state that is not slow.
    Margin uniform() const {
        const Modes at_zero = modes(at_, {});
        const double slow = at_zero.rates.size() > 0 ? 1e-10 * at_zero.rates.cwiseAbs().maxCoeff() : 0.0;
        for (Eigen::Index k = 0; k < at_zero.rates.size(); ++k)
            if (std::abs(at_zero.rates(k)) > slow)
                return {.value = -at_zero.rates(k).real(), .frequency = at_zero.frequency(k), .is_uniform = true};
        return {.value = infinite, .is_uniform = true};
    }
    /// The least stable change in the limit of long waves that is not slow: with a pressure it is not one at q = 0.
    Margin limit(double angle) const {
        Margin result{.value = infinite, .angle = angle};
        if (!at_.has_solenoidal()) return result;
        const Eigen::VectorXcd rates = mode_rates(at_, at_.wavevector(1e-9 * search_.min, angle));
        const double slow = 1e-10 * rates.cwiseAbs().maxCoeff();
        for (const std::complex<double>& rate : rates)
            if (std::abs(rate) > slow && -rate.real() < result.value)
                result.value = -rate.real(), result.frequency = -rate.imag();
        return result;
    }
    /// In the limit of long waves; infinite without a slow mode.
    Margin slow(double angle) const {
        const SlowModes slow = slow_modes(at_, angle);
        Margin result{.value = infinite, .angle = angle};
        for (const SlowMode& mode : slow.modes) {
            const double growth = mode.speed.imag();
            if (growth > 1e-9 * std::abs(mode.speed)) result.value = std::min(result.value, -growth);
            else if (std::isfinite(mode.damping.real()))
                result.value = std::min(result.value, weight_ * mode.damping.real());
        }
        return result;
    }
    /// The least stable wave at all |q| and angles of the search that is finite; infinite without one.
    Margin wave(const std::vector<double>& log_q, const std::vector<double>& angles) const {
        const GrowthOfModes growth = [&](double x, double angle) -> Eigen::VectorXd {
            const double q = std::exp(x);
            return mode_rates(at_, at_.wavevector(q, angle)).real() * (1.0 + weight_ / (q * q));
        };
        Margin best{.value = infinite};
        for (const auto& [x, angle] : growth_maxima(growth, log_q, angles))
            if (const double value = -growth(x, angle).maxCoeff(); value < best.value)
                best = {.value = value, .angle = angle, .q = std::exp(x)};
        return best;
    }
    /// The least stable change of all.
    Margin lowest() const {
        const std::vector<double> log_q = numerics::even_logarithms(search_.min, search_.max, search_.wavenumbers);
        const int angles = at_.is_isotropic() ? 1 : search_.angles;
        const double step_angle = std::numbers::pi / angles;
        Margin lowest = uniform();
        Margin slowest = slow(0.0), limiting = limit(0.0);
        std::vector<double> turns;
        for (int a = 0; a < angles; ++a) {
            turns.push_back(a * step_angle);
            if (const Margin here = slow(turns.back()); here.value < slowest.value) slowest = here;
            if (const Margin here = limit(turns.back()); here.value < limiting.value) limiting = here;
        }
        if (angles > 1) {  // between the angles
            const auto refined = [&](const Margin& from, auto at) {
                if (!std::isfinite(from.value)) return from;
                const Margin fine = at(numerics::golden_maximum(from.angle - step_angle, from.angle + step_angle,
                                                                [&](double angle) { return -at(angle).value; }));
                return fine.value < from.value ? fine : from;
            };
            slowest = refined(slowest, [&](double angle) { return slow(angle); });
            limiting = refined(limiting, [&](double angle) { return limit(angle); });
        }
        for (const Margin& long_wave : {slowest, limiting})
            if (long_wave.value < lowest.value) lowest = long_wave;
        Margin best = wave(log_q, turns);
        if (!(best.value < lowest.value)) return lowest;
        if (!std::isfinite(best.value)) return best;
        best.frequency = growth(at_, best.q, best.angle).frequency;
        return best;
    }

private:
    const model::LinearisedAt& at_;
    GrowthSearch search_;
    double weight_;
};
}  // namespace

std::size_t ordered_states(const StationaryStates& found) {
    return static_cast<std::size_t>(
        std::ranges::count_if(found.states, [](const StationaryState& state) { return !state.is_isotropic; }));
}

Margin margin(const model::Equations& equations, MarginState which, const KnownStates& known,
              const GrowthSearch& search) {
    const bool is_ordered = which == MarginState::ordered;
    StationaryStates found;
    if (!is_ordered || known.ordered > 0)
        found = stationary_states_near(equations, equations.reference(), known.values, is_ordered);
    if (is_ordered && (known.ordered == 0 || ordered_states(found) < known.ordered))
        found = stationary_states(equations);
    const StationaryState* state = state_of(equations, found, which);
    if (state == nullptr) return {.value = nan};
    const model::LinearisedAt at(equations, state->values);
    return Waves(at, search).lowest();
}

}  // namespace drover::theory
