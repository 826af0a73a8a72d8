// run/declared_warnings.cpp: what is known of a run of a declared model before it.
#include <cmath>

#include "drover/physics/linear_theory.hpp"
#include "run/field_health.hpp"
#include "run/growing_waves.hpp"
#include "run/judged_field.hpp"

namespace drover::run {

std::vector<std::string> declared_warnings(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    std::vector<std::string> warnings;
    if (std::string cut = growing_waves_warning(equations.linear_system(scene.grid, io::kept_degree(scene, equations)));
        !cut.empty())
        warnings.push_back(std::move(cut));
    if (!equations.has_finite_degree())
        warnings.emplace_back(
            "some functions of the equations are no polynomials: their aliases are not removed exactly; compare with a "
            "run on twice the points");
    if (const double rate = equations.explicit_rate(scene.grid), part = rate * scene.time.dt;
        part > 1.0 && scene.time.tolerance == 0.0)
        warnings.push_back(text(
            "the terms that name an axis, or depend on position or time, change the waves of the grid at up to {:.3g} "
            "/s: {:.3g} in a step of time.dt = {}; expected less than 1, or the run may diverge: choose time.dt = "
            "{:.2g}, or a coarser grid",
            rate, part, scene.time.dt, scene.time.dt / (2.0 * part)));
    if (!equations.has_nonlinear_part()) {
        const physics::FastestGrowth growth =
            physics::fastest_growth(equations.linear_system(scene.grid, io::kept_degree(scene, equations)));
        if (const double most = std::log(max_field_size); growth.rate * scene.time.end > most)
            warnings.push_back(
                text("a mode grows at {:.4g} /s at |q| = {:.3g} /mm, by a factor e^{:.3g} in this run, and the "
                     "equations are linear: nothing stops it; choose time.end = {:.2g} or less, or add a product",
                     growth.rate, growth.q, growth.rate * scene.time.end, most / growth.rate));
    }
    if (scene.initial.kind != "uniform" || equations.has_noise()) return warnings;
    if (equations.uniform_rates(equations.reference()).cwiseAbs().maxCoeff() == 0.0)
        warnings.emplace_back(
            "the start is uniform, stationary and without noise: nothing will change; choose another initial.kind, "
            "such as \"random\"");
    return warnings;
}

}  // namespace drover::run
