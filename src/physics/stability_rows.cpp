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

std::vector<std::string> instability_names() { return {"order", "phase separation", "banding", "oblique", "uniform"}; }

std::vector<Component> components_in_symbol_order(const Form& form) {
    const std::vector<Component> components = component_names(form);
    std::vector<Component> ordered;
    const auto add = [&](int first, int count) {
        for (int c = first; first >= 0 && c < first + count; ++c)
            ordered.push_back(components[static_cast<std::size_t>(c)]);
    };
    add(form.bead_density, 1);
    add(form.rod_density, 1);
    add(form.bead_velocity, 2);
    add(form.polar_order, 2);
    return ordered;
}

std::vector<StructurePart> structure_parts(const Form& form, double direction) {
    std::vector<StructurePart> parts;
    const auto density = [&](const char* name, FieldIndex::Value place) {
        parts.push_back({name, "mm-2", [place](const Symbol& s) { return s(place, place).real(); }});
    };
    if (form.rod_density >= 0) density("rods", FieldIndex::rod_density);
    if (form.bead_density >= 0) density("beads", FieldIndex::bead_density);
    const std::string unit = form.order_is_density ? "mm-2" : "mm2";
    const auto order = [&](const char* name, double angle) {
        parts.push_back({name, unit, [c = std::cos(angle), sn = std::sin(angle)](const Symbol& s) {
                             return c * c * s(FieldIndex::polar_order_x, FieldIndex::polar_order_x).real() +
                                    sn * sn * s(FieldIndex::polar_order_y, FieldIndex::polar_order_y).real() +
                                    2.0 * c * sn * s(FieldIndex::polar_order_x, FieldIndex::polar_order_y).real();
                         }});
    };
    order("order_along_p0", direction);
    order("order_across_p0", direction + 0.5 * std::numbers::pi);
    return parts;
}

std::vector<double> structure_frequencies(const Equations& equations, const UniformPoint& about, double q,
                                          const std::vector<double>& angles, int count) {
    double largest = 0.0;
    for (const double angle : angles)
        for (const std::complex<double> s : mode_rates(equations, about, wavevector_from_order(about, q, angle)))
            if (std::abs(s.imag()) > 1e-9 * std::abs(s))  // smaller ones are rounding errors
                largest = std::max(largest, std::abs(s.imag()));
    if (largest == 0.0)
        for (const std::complex<double> s : mode_rates(equations, about, wavevector_from_order(about, q, 0.0)))
            largest = largest == 0.0 ? std::abs(s) : std::min(largest, std::abs(s));
    std::vector<double> result;
    for (int k = 0; k < count; ++k) result.push_back(2.0 * largest * (2.0 * k / (count - 1.0) - 1.0));
    return result;
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
