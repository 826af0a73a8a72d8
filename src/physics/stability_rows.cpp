// physics/stability_rows.cpp: descriptions of stability results.
#include "drover/physics/stability_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/physics/function_terms.hpp"

namespace drover::physics {

std::vector<EffectiveCoefficientRow> effective_coefficient_rows(const Form& form) {
    using C = EffectiveCoefficients;
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    const bool velocity = form.velocity != Velocity::absent;
    return {
        {"relaxation", "s-1",
         velocity ? "abar = a - lambda alpha/Gamma; a flock forms where it is negative"
                  : "abar = a; a flock forms where it is negative",
         &C::relaxation},
        {"relaxation_by_beads", "mm2 s-1", "d abar/d rho", &C::relaxation_by_beads, beads},
        {"relaxation_by_rods", "mm2 s-1", "d abar/d sigma", &C::relaxation_by_rods, rods},
        {"inertia", "1", "chi = 1 + m rho lambda alpha/Gamma^2; divides the slow rates of the order", &C::inertia,
         velocity},
        {"pressure_beads", "1", "Abar = A + lambda E/Gamma; rods turn away from high bead density where it is positive",
         &C::pressure_beads, beads},
        {"pressure_rods", "1", "Bbar = B + lambda F/Gamma; rods turn away from high rod density where it is positive",
         &C::pressure_rods, rods},
        {"stiffness_across", "mm2 s-1", "Kbar of the order transverse to q", &C::stiffness_across},
        {"stiffness_along", "mm2 s-1", "Kbar of the order along q", &C::stiffness_along},
        {"sound_stiffness", "mm2 s-2", "C0; sound transverse to p0 has the speed sqrt(C0/chi)", &C::sound_stiffness,
         beads || rods},
        {"correlation_length", "mm", "xi of the order transverse to q in the isotropic state", &C::correlation_length},
        {"neutral_wavenumber", "mm-1", "q_c; longer waves of the order grow on the isotropic state",
         &C::neutral_wavenumber},
    };
}

std::vector<StructurePart> structure_parts(const Equations& equations, double direction) {
    std::vector<StructurePart> parts;
    const auto density = [&](const char* name, FieldIndex::Value field) {
        if (const int place = equations.component(field); place >= 0)
            parts.push_back({name, "mm-2", [place](const model::Symbol& s) { return s(place, place).real(); }});
    };
    density("rods", FieldIndex::rod_density);
    density("beads", FieldIndex::bead_density);
    const int x = equations.component(FieldIndex::polar_order_x), y = x + 1;
    const auto order = [&](const char* name, double angle) {
        parts.push_back({name, equations.form.order_is_density ? "mm-2" : "mm2",
                         [x, y, c = std::cos(angle), sn = std::sin(angle)](const model::Symbol& s) {
                             return c * c * s(x, x).real() + sn * sn * s(y, y).real() + 2.0 * c * sn * s(x, y).real();
                         }});
    };
    order("order_along_p0", direction);
    order("order_across_p0", direction + 0.5 * std::numbers::pi);
    return parts;
}

std::vector<std::string> stability_remarks(const Equations& equations, const EffectiveCoefficients& coefficients) {
    std::vector<std::string> remarks;
    const Noise& noise = equations.model.noise;
    if (has_noise(noise) && equations.form.rod_density >= 0 && noise.rods == 0.0)
        remarks.push_back(
            "noise.rods is 0: sigma has no shot noise, and DN^2/N tends to 0 in small boxes, to 1 for particles");
    for (const auto& [key, coefficient] : named(equations))
        if (coefficient->table() && equations.model.table.outside == "hold")
            remarks.push_back(
                text("outside its table ({}), {} keeps its value at the edge", range_text(*coefficient->table()), key));
    for (const std::string& remark : function_remarks(equations)) remarks.push_back(remark);
    if (coefficients.pressure_beads < 0.0 && equations.form.bead_density >= 0)
        remarks.push_back(
            text("Abar = A + lambda E/Gamma = {:.4g} < 0 (E = {:.4g}): rods turn towards high bead "
                 "density, which makes most flocks unstable at an oblique angle",
                 coefficients.pressure_beads, equations.model.stiffness.beads));
    return remarks;
}

}  // namespace drover::physics
