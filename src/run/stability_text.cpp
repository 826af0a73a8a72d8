// run/stability_text.cpp: the stability of a scene for people.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/run/stability.hpp"

namespace drover::run {

namespace {
constexpr double degree = std::numbers::pi / 180.0;

void add_coefficients(const StabilityReport& report, std::string& out) {
    const physics::EffectiveCoefficients& c = report.coefficients;
    const auto add = [&](const char* name, double value, const char* unit, const char* meaning) {
        if (std::isfinite(value)) out += text("  {:<8} {:>12.6g} {:<8} {}\n", name, value, unit, meaning);
    };
    const physics::Form form = physics::form(report.scene.model);
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    const bool velocity = form.velocity != physics::Velocity::absent;
    out += "effective coefficients\n";
    add("abar", c.relaxation, "1/s", velocity ? "a - lambda alpha/Gamma; a flock below 0" : "a; a flock below 0");
    if (beads && c.relaxation_by_beads != 0.0)
        add("abar_rho", c.relaxation_by_beads, "mm^2/s", "its slope in the bead density");
    if (rods && c.relaxation_by_rods != 0.0)
        add("abar_sig", c.relaxation_by_rods, "mm^2/s", "its slope in the rod density");
    if (velocity)
        add("chi", c.inertia, "", "1 + m rho lambda alpha/Gamma^2: slow rates of the order are divided by it");
    if (beads) add("Abar", c.pressure_beads, "", "A + lambda E/Gamma: rods turn away from crowded beads");
    if (rods) add("Bbar", c.pressure_rods, "", "B + lambda F/Gamma: rods turn away from crowded rods");
    add("Kbar_t", c.stiffness_across, "mm^2/s", "stiffness of waves of the order across q");
    add("Kbar_l", c.stiffness_along, "mm^2/s", "stiffness of waves of the order along q");
    add("xi", c.correlation_length, "mm", "correlation length of the order across q, without a flock");
    add("q_c", c.neutral_wavenumber, "1/mm", "waves of the order longer than this grow on the isotropic state");
}

void add_slow_modes(const StateStability& one, std::string& out) {
    if (!one.waves.undefined.empty()) {
        out += "  long waves: " + one.waves.undefined + "\n";
        return;
    }
    if (one.slow.empty() || one.slow.front().modes.empty()) return;
    const bool isotropic = physics::is_isotropic(one.state.point);
    out +=
        text("  long waves, s = -i u q - gamma q^2: {}u [mm/s] (gamma [mm^2/s])\n", isotropic ? "" : "angle to p0, ");
    double largest = 0.0;
    for (const SlowAngle& at : one.slow)
        for (const physics::SlowMode& mode : at.modes) largest = std::max(largest, std::abs(mode.speed));
    const auto rounded = [&](double speed) { return std::abs(speed) > 1e-12 * largest ? speed : 0.0; };
    for (const SlowAngle& at : one.slow) {
        if (isotropic && at.angle > 0.0) break;
        out += isotropic ? text("{:>8}", "") : text("{:>8.0f}", at.angle / degree);
        for (const physics::SlowMode& mode : at.modes) {
            out += text("   {:>10.4g}", rounded(mode.speed.real()));
            if (mode.speed.imag() != 0.0)
                out += text(" {} {:.4g} i", mode.speed.imag() > 0.0 ? "+" : "-", std::abs(mode.speed.imag()));
            out +=
                std::isnan(mode.damping.real()) ? std::string(" (defective)") : text(" ({:.4g})", mode.damping.real());
        }
        out += '\n';
    }
}

std::string range_text(const physics::Instability& one) {
    if (one.min == 0.0 && std::isinf(one.max)) return "at all wavelengths searched";
    if (one.min == 0.0) return text("for |q| < {:.4g} /mm", one.max);
    if (std::isinf(one.max)) return text("for |q| > {:.4g} /mm", one.min);
    return text("for {:.4g} < |q| < {:.4g} /mm", one.min, one.max);
}

void add_instabilities(const StateStability& one, const StabilityReport& report, std::string& out) {
    if (one.instabilities.empty()) {
        out +=
            text("  stable against all waves from |q| = {:.3g} to {:.3g} /mm\n", report.search.min, report.search.max);
        return;
    }
    out += "  unstable:\n";
    for (const physics::Instability& found : one.instabilities) {
        out += text("    {:<17} grows at {:.5g} /s", found.name, found.rate);
        if (found.frequency != 0.0) out += text(", turning by {:.4g} /s,", std::abs(found.frequency));
        if (found.q == 0.0) {
            out += " as a whole, without a wave\n";
            continue;
        }
        if (found.at_longest) out += ", the longer the wave the faster";
        else out += text(" at |q| = {:.4g} /mm (a wave of {:.4g} mm)", found.q, 2.0 * std::numbers::pi / found.q);
        if (!physics::is_isotropic(one.state.point)) out += text(", {:.1f} degrees from p0", found.angle / degree);
        out += "; " + range_text(found) + "\n";
        if (found.at_shortest)
            out += "      it grows fastest at the shortest wave searched: nothing in the model stops short waves\n";
    }
}
}  // namespace

std::string stability_text(const StabilityReport& report) {
    const physics::UniformState& uniform = report.scene.model.uniform;
    std::string out = text("form: {}\n", report.form);
    const physics::Form form = physics::form(report.scene.model);
    if (form.bead_density >= 0) out += text("rho = {:.6g} /mm^2\n", uniform.bead_density);
    if (form.rod_density >= 0) out += text("sigma = {:.6g} /mm^2\n", uniform.rod_density);
    add_coefficients(report, out);
    for (const StateStability& one : report.states) {
        const physics::UniformPoint& point = one.state.point;
        out += text("\nstate: {}", one.state.name);
        if (point.order.norm() > 0.0) {
            out += text(", |p| = {:.6g}", point.order.norm());
            if (form.order_is_density) out += text(" (P = {:.4g})", point.order.norm() / uniform.rod_density);
            if (form.velocity != physics::Velocity::absent) out += text(", |v| = {:.6g} mm/s", point.velocity.norm());
        }
        out += "\n";
        add_instabilities(one, report, out);
        add_slow_modes(one, out);
        if (one.direction_diffusion > 0.0)
            out += text("  the direction of the mean order walks by <theta^2> = 2 D t, D = {:.4g} /s in this cell\n",
                        one.direction_diffusion / numerics::area(report.scene.grid));
    }
    if (!report.no_order.empty()) out += "\nno ordered state: " + report.no_order + "\n";
    for (const std::string& note : report.notes) out += "\nnote: " + note + "\n";
    return out;
}

}  // namespace drover::run
