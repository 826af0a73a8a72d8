// physics/regimes.cpp: regimes from margins of stability.
#include "drover/physics/regimes.hpp"

#include <array>
#include <cmath>

namespace drover::physics {

namespace {
constexpr std::array legend{std::pair{Regime::undefined, "not defined"},
                            std::pair{Regime::isotropic, "isotropic"},
                            std::pair{Regime::separating, "isotropic, phase-separating"},
                            std::pair{Regime::flock, "flock"},
                            std::pair{Regime::banding, "flock unstable to banding"},
                            std::pair{Regime::oblique, "flock unstable to oblique waves"}};

constexpr AreaFraction area_fractions[] = {{"bead_area_fraction", "uniform.bead_area", &UniformState::bead_density,
                                            &UniformState::bead_area},
                                           {"rod_area_fraction", "uniform.rod_area", &UniformState::rod_density,
                                            &UniformState::rod_area}};
}  // namespace

std::string regime_legend() {
    std::string result;
    for (const auto& [regime, meaning] : legend)
        result += text("{}{} {}", result.empty() ? "" : ", ", static_cast<int>(regime), meaning);
    return result;
}

Regime regime_of(double onset, double phase_separation, double banding, double oblique) {
    if (std::isnan(onset)) return Regime::undefined;
    if (onset >= 0.0) return phase_separation < 0.0 ? Regime::separating : Regime::isotropic;
    if (std::isnan(banding)) return Regime::undefined;
    if (banding < 0.0) return Regime::banding;
    return oblique < 0.0 ? Regime::oblique : Regime::flock;
}

const AreaFraction* find_area_fraction(const std::string& name) {
    for (const AreaFraction& fraction : area_fractions)
        if (name == fraction.name) return &fraction;
    return nullptr;
}

PlaneAxis area_fraction_axis(const AreaFraction& fraction, double area, double from, double to) {
    return {.name = fraction.name,
            .unit = "1",
            .from = from,
            .to = to,
            .set = [density = fraction.density, area](Model& model,
                                                      double covered) { model.uniform.*density = covered / area; },
            .is_density = true};
}

DensityAxis density_axis(const std::string& key) {
    if (key == "uniform.bead_density" || key == "bead_area_fraction") return DensityAxis::beads;
    if (key == "uniform.rod_density" || key == "rod_area_fraction") return DensityAxis::rods;
    return DensityAxis::none;
}

bool is_same_axis(const std::string& key, const std::string& other) {
    return key == other || (density_axis(key) != DensityAxis::none && density_axis(key) == density_axis(other));
}

bool affects_boundaries(const std::string& key) {
    return !key.starts_with("noise.") && key != "uniform.rod_area" && key != "uniform.bead_area";
}

}  // namespace drover::physics
