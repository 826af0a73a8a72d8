// theory/limits.cpp: margins of the limits of stability, and regimes from them.
#include "theory/limits.hpp"
#include "base/constants.hpp"

#include <cmath>
#include <numbers>

namespace drover::theory {

namespace {
constexpr std::array legend{std::pair{Regime::undefined, "not defined"},
                            std::pair{Regime::isotropic, "isotropic"},
                            std::pair{Regime::separating, "isotropic, phase-separating"},
                            std::pair{Regime::flock, "flock"},
                            std::pair{Regime::banding, "flock unstable to banding"},
                            std::pair{Regime::oblique, "flock unstable to oblique waves"}};

/// The slow modes of a state at every angle.
class SlowMargin {
public:
    explicit SlowMargin(const model::LinearisedAt& at) : at_(at) {
        if (!at.has_solenoidal()) waves_ = long_waves(at);
    }
    bool has_modes() const {
        return at_.has_solenoidal() ? !slow_modes(at_, 0.0).modes.empty()
                                    : waves_.why_none.empty() && waves_.right.cols() > 0;
    }
    /// angle: from the direction of the state.
    double at(double angle) const {
        if (!at_.has_solenoidal()) return slow_growth(waves_, at_.direction() + angle).margin();
        SlowGrowth growth;
        for (const SlowMode& mode : slow_modes(at_, angle).modes) growth.add(mode.speed, mode.damping);
        return growth.margin();
    }

private:
    const model::LinearisedAt& at_;
    LongWaves waves_;
};

/// The minimum margin over angles from the order: sampled, then refined about the smallest sample.
Margin min_over_angles(const SlowMargin& slow, bool quarter) {
    const int samples = quarter ? 18 : 36;  // every 5 degrees of a quarter or of half a turn
    constexpr double quarter_turn = std::numbers::pi / 2.0, step = quarter_turn / 18.0;
    Margin lowest{.value = infinite, .angle = step};
    for (int n = 1; n <= samples; ++n)
        if (const double value = slow.at(n * step); value < lowest.value) lowest = {.value = value, .angle = n * step};
    double width = 0.5 * step;
    // Closing in by halves; a kink between two modes does no harm.
    for (int i = 0; i < 16 && width > 1e-6; ++i, width *= 0.5)
        for (const double angle : {lowest.angle - width, lowest.angle + width}) {
            if (quarter && (angle <= 0.0 || angle > quarter_turn)) continue;
            if (const double value = slow.at(angle); value < lowest.value) lowest = {.value = value, .angle = angle};
        }
    return lowest;
}

/// Whether a reflection in the line of the direction of a state maps waves to waves.
bool is_mirrored(const model::LinearisedAt& at, const OrderSearch& search) {
    const model::Model& model = at.equations().model();
    if (!search.turns_freely || model.chiral) return at.is_mirrored();
    // No direction but that of the state, and of its source: what changes sign has to vanish.
    const model::UniformState& values = at.about();
    for (const auto& [field, first] : model::placed_fields(model)) {
        double odd = field.spin == 0 ? (field.odd ? values[first] : 0.0) : 0.0, size = std::abs(odd);
        if (field.spin > 0) {
            const double angle = field.spin * at.direction(), c = std::cos(angle), s = std::sin(angle);
            const double along = c * values[first] + s * values[first + 1];
            const double across = c * values[first + 1] - s * values[first];
            odd = field.odd ? along : across;
            size = std::hypot(along, across);
        }
        if (std::abs(odd) > 1e-12 * size) return false;
    }
    return true;
}
}  // namespace

Margin PointMargins::of_isotropic(Limit limit) {
    if (!isotropic_) isotropic_ = isotropic_state(theory_, means_);
    const std::optional<PointState>& rest = *isotropic_;
    if (!rest) return {.value = nan};
    const bool has_order = order_component(theory_.equations()) >= 0;
    const double relaxation = has_order ? relaxation_of_order(theory_, *rest) : nan;
    if (limit == Limit::onset) return {.value = relaxation};
    if (has_order && !(relaxation > 0.0)) return {.value = nan};
    const SlowMargin slow(rest->linear);
    return {.value = slow.has_modes() ? slow.at(0.0) : nan};
}

Margin PointMargins::at(Limit limit) {
    if (limit == Limit::onset || limit == Limit::phase_separation) return of_isotropic(limit);
    if (!ordered_) ordered_ = ordered_state(theory_, means_, search_);
    const std::optional<PointState>& flock = *ordered_;
    if (!flock) return {.value = nan};
    const SlowMargin slow(flock->linear);
    if (!slow.has_modes()) return {.value = nan};
    if (limit == Limit::oblique) return min_over_angles(slow, is_mirrored(flock->linear, search_));
    return {.value = slow.at(0.0)};
}

std::string regime_legend() {
    std::string result;
    for (const auto& [regime, meaning] : legend)
        result += text("{}{} {}", result.empty() ? "" : ", ", static_cast<int>(regime), meaning);
    return result;
}

Regime regime_of(const std::function<double(Limit)>& margin) {
    const double onset = margin(Limit::onset);
    if (std::isnan(onset)) return Regime::undefined;
    if (onset >= 0.0) return margin(Limit::phase_separation) < 0.0 ? Regime::separating : Regime::isotropic;
    const double banding = margin(Limit::banding);
    if (std::isnan(banding)) return Regime::undefined;
    if (banding < 0.0) return Regime::banding;
    return margin(Limit::oblique) < 0.0 ? Regime::oblique : Regime::flock;
}

}  // namespace drover::theory
