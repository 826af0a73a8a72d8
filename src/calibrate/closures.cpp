// calibrate/closures.cpp: conversions of measured quantities, and closures for independent rods.
#include "calibrate/closures.hpp"

#include <cmath>

#include "calibrate/alignment.hpp"
#include "physics/model_file.hpp"

namespace drover::calibrate {

namespace {
using M = const ClosureNumbers&;

/// A number of a model that is an input itself.
Closure input_as(const char* key, Input input, Origin origin) {
    return {.key = key, .origin = origin, .of = {input}, .value = [input](M m) { return m[input]; }};
}

// D_r is the relaxation rate, P the mean orientation.
std::vector<Closure> of_densities() {
    return {{.key = "uniform.rod_density",
             .of = {rod_area},
             .under = {rod_area},
             .value = [](M m) { return m.rod_density(); }},
            {.key = "uniform.bead_density",
             .of = {bead_area},
             .under = {bead_area},
             .value = [](M m) { return m.bead_density(); }},
            input_as("uniform.rod_area", rod_area, Origin::set),
            input_as("uniform.bead_area", bead_area, Origin::set),
            input_as("current.speed", speed, Origin::measured)};
}

std::vector<Closure> of_beads() {
    return {input_as("inertia.bead_mass", bead_mass, Origin::set),
            {.row = "friction",
             .key = "drag.coefficient",
             .formula = "Gamma = m rho/tau: friction of plates and rods",
             .origin = Origin::measured,
             .of = {bead_area, bead_mass, response},
             .under = {bead_area},
             .value = [](M m) { return m.friction(); }},
            {.row = "friction_of_plates",
             .unit = "mg/(mm^2 s)",
             .formula = "[Gamma/(m rho)] m rho, without rods",
             .origin = Origin::measured,
             .of = {bead_area, bead_mass, damping},
             .under = {bead_area},
             .value = [](M m) { return m[damping] * m.mass_density(); }},
            {.row = "viscosity",
             .key = "viscosity.shear",
             .formula = "eta = [eta/(m rho)] m rho",
             .origin = Origin::measured,
             .of = {bead_area, bead_mass, viscosity},
             .under = {bead_area},
             .value = [](M m) { return m[viscosity] * m.mass_density(); }},
            {.row = "viscosity_bulk", .key = "viscosity.bulk", .formula = "zeta = 0: no assay and no closure"},
            {.row = "driving_strength",
             .key = "driving.strength",
             .unit = "mg/s",
             .formula = "alpha = (alpha/Gamma) Gamma/(sigma u), for p = sigma u P",
             .origin = Origin::measured,
             .of = {bead_area, bead_mass, response, drag},
             .under = {bead_area},
             .value = [](M m) { return m[drag] * m.friction(); }},
            {.row = "driving_cubic",
             .key = "driving.cubic",
             .unit = "mg mm^2 s",
             .formula = "alpha_3 = (alpha_3/Gamma) Gamma/(sigma u)^3, for p = sigma u P",
             .origin = Origin::measured,
             .of = {bead_area, bead_mass, response, cubic},
             .under = {bead_area},
             .value = [](M m) { return m[cubic] * m.friction(); }},
            input_as("stiffness.beads", stiffness, Origin::measured),
            {.row = "stiffness_rods", .key = "stiffness.rods", .formula = "F = 0: no assay and no closure"}};
}

std::vector<Closure> of_relaxation() {
    return {input_as("relaxation.rate", relaxation, Origin::measured),
            {.row = "relaxation_saturation",
             .key = "relaxation.saturation",
             .unit = "mm^2 s",
             .formula = "b = D_r [(g/2 - 1)/P^2 + g3/2]/(sigma u)^2 at P = I1(x)/I0(x), x = gP + g3 P^3, "
                        "D_r g^2/(8 sigma^2 u^2) below onset, for p = sigma u P; g3 = lambda_s alpha_3/(Gamma D_r)",
             .origin = Origin::closure,
             .of = {relaxation, weathercock, drag, cubic, contact, rod_area},
             .under = {relaxation, rod_area},
             .value = [](M m) { return m[relaxation] * saturation_of_alignment(m.alignment(), m.alignment_cubic()); }},
            input_as("relaxation.contact", contact, Origin::measured),
            {.row = "elasticity_stiffness",
             .key = "elasticity.stiffness",
             .formula = "K3 = u^2/(16 D_r)",
             .origin = Origin::closure,
             .of = {speed, relaxation},
             .under = {relaxation},
             .value = [](M m) { return m[speed] * m[speed] / (16.0 * m[relaxation]); }},
            {.row = "elasticity_splay", .key = "elasticity.splay", .formula = "K1 = 0", .origin = Origin::closure}};
}

std::vector<Closure> of_order() {
    return {{.row = "weathercock_strength",
             .key = "weathercock.strength",
             .unit = "1/(mm^2 s)",
             .formula = "lambda sigma u, for p = sigma u P",
             .origin = Origin::measured,
             .of = {weathercock},
             .value = [](M m) { return m[weathercock]; }},
            {.row = "advection",
             .key = "advection.strength",
             .unit = "mm^2",
             .formula = "w = 3 g/(16 sigma), for p = sigma u P",
             .origin = Origin::closure,
             .of = {relaxation, weathercock, drag, contact, rod_area, speed},
             .under = {relaxation, rod_area},
             .value = [](M m) { return 3.0 / 16.0 * m.alignment() * m[speed]; }},
            {.row = "pressure_beads",
             .key = "pressure.beads",
             .unit = "mm^2/s^2",
             .formula = "A = 0: no assay and no closure"},
            {.row = "pressure_rods",
             .key = "pressure.rods",
             .unit = "mm^2/s^2",
             .formula = "B = u^2/2, for p = sigma u P",
             .origin = Origin::closure,
             .of = {speed, rod_area},
             .under = {rod_area},
             .value = [](M m) { return 0.5 * m[speed] / m.rod_density(); }},
            {.row = "noise_order",
             .key = "noise.order",
             .unit = "1/s^3",
             .formula = "Delta = D_r sigma u^2, for p = sigma u P",
             .origin = Origin::closure,
             .of = {relaxation, rod_area},
             .under = {rod_area},
             .value = [](M m) { return m[relaxation] / m.rod_density(); }}};
}

std::vector<Closure> of_onset() {
    return {{.row = "relaxation_over_weathercock",
             .unit = "mm/s",
             .formula = "a/lambda: without contacts, a flock forms where alpha/Gamma is larger",
             .origin = Origin::measured,
             .of = {relaxation, weathercock},
             .under = {weathercock},
             .value = [](M m) { return m[relaxation] / m[weathercock]; }},
            {.row = "alignment_by_flow",
             .unit = "1",
             .formula = "lambda_s alpha/(Gamma D_r)",
             .origin = Origin::measured,
             .of = {relaxation, weathercock, drag},
             .under = {relaxation},
             .value = [](M m) { return m.alignment_by_flow(); }},
            {.row = "alignment",
             .unit = "1",
             .formula = "g = (lambda_s alpha/Gamma + 2 c sigma)/D_r: a flock forms above 2",
             .origin = Origin::measured,
             .of = {relaxation, weathercock, drag, contact, rod_area},
             .under = {relaxation, rod_area},
             .value = [](M m) { return m.alignment(); }}};
}

// From collisions of pairs (scattering assay) and the flow, without a fit to a flock: psi_3 = 0, psi_2 follows psi_1
// (Bertin, Droz & Gregoire, J. Phys. A 42, 445001 (2009)).  Without collisions they are the closures above.
std::vector<Closure> of_collisions() {
    const auto with = [](std::initializer_list<Input> more) {
        std::vector<Input> all{relaxation, weathercock, drag, rod_area, scattered_second, scattered_excitation};
        all.insert(all.end(), more);
        return all;
    };
    return {{.row = "alignment_kinetic",
             .unit = "1",
             .formula = "g = (lambda_s alpha/Gamma + 2 c sigma)/D_r, c of pairs of rods",
             .origin = Origin::measured,
             .of = {relaxation, weathercock, drag, rod_area, scattered},
             .under = {relaxation, rod_area},
             .value = [](M m) { return m.alignment(scattered); }},
            {.row = "saturation_kinetic",
             .unit = "1/s",
             .formula = "b for p = P, from collisions of pairs and the flow",
             .origin = Origin::closure,
             .of = with({scattered_saturation}),
             .under = {relaxation, rod_area},
             .value = [](M m) { return m.reaction() * m.excitation() / m.second_rate(); }},
            {.row = "advection_kinetic",
             .unit = "mm/s",
             .formula = "w for p = P, from collisions of pairs and the flow",
             .origin = Origin::closure,
             .of = with({scattered_saturation, speed}),
             .under = {relaxation, rod_area},
             .value = [](M m) { return m[speed] * (m.excitation() - 0.5 * m.reaction()) / m.second_rate(); }},
            {.row = "elasticity_kinetic",
             .unit = "mm^2/s",
             .formula = "K3 = u^2/(16 D_r - 4 J sigma), J of the second moment, of pairs of rods",
             .origin = Origin::closure,
             .of = {relaxation, rod_area, speed, scattered_second},
             .under = {relaxation, rod_area},
             .value = [](M m) { return 0.25 * m[speed] * m[speed] / m.second_rate(); }}};
}

/// The unit of a coefficient that does not depend on that of p, and the power of sigma that it takes with p.
void take_from_registry(Closure& closure) {
    const auto& rows = physics::shipped_model().coefficients;
    const auto row = std::ranges::find_if(rows, [&](const auto& one) { return one.key() == closure.key; });
    if (row == rows.end()) return;
    closure.order_power = row->order_power;
    if (row->order_power == 0) closure.unit = row->unit;
}
}  // namespace

const std::vector<Closure>& closures() {
    static const std::vector<Closure> all = [] {
        std::vector<Closure> list;
        for (const auto& part : {of_densities(), of_beads(), of_relaxation(), of_order(), of_onset(), of_collisions()})
            list.insert(list.end(), part.begin(), part.end());
        for (Closure& closure : list) take_from_registry(closure);
        return list;
    }();
    return all;
}

Closure scaled(Closure closure, const std::vector<Input>& scale_of, const Formula& scale) {
    if (closure.order_power == 0.0 || closure.of.empty()) return closure;
    for (const Input input : scale_of) {
        if (std::ranges::find(closure.of, input) == closure.of.end()) closure.of.push_back(input);
        if (closure.order_power < 0.0) closure.under.push_back(input);
    }
    closure.value = [unscaled = closure.value, scale, power = closure.order_power](const ClosureNumbers& at) {
        return unscaled(at) * std::pow(scale(at), power);
    };
    return closure;
}

std::string divisor_refusal(Input input, double value, double error) {
    constexpr double errors_from_zero = 3.0;
    if (std::abs(value) > errors_from_zero * error) return "";
    return text("the divisor {} = {:.3g} +- {:.2g} is not significantly different from 0", name_of(input), value,
                error);
}

void put(ClosureNumbers& at, Input input, double value, double error) {
    at.numbers[input] = is_below_error(input, value, error) ? error : value;
    at.errors[input] = error;
}

}  // namespace drover::calibrate
