// run/passed_onset.cpp: growth of order along a ramp that is written as text.
#include "run/passed_onset.hpp"

#include <algorithm>
#include <cmath>

#include "drover/base/error.hpp"
#include "drover/base/threads.hpp"
#include "drover/physics/integrated.hpp"

namespace drover::run {

namespace {
/// The rate at which uniform order grows from the isotropic state at a time, with what texts add [1/s].
double growth_of_order(const io::Scene& scene, double t) {
    const physics::Equations equations(scene.model);
    const physics::Reference about = physics::reference(scene.model.uniform);
    numerics::Grid small = scene.grid;
    small.nx = std::min(small.nx, 8);
    small.ny = std::min(small.ny, 8);
    Threads one(1);
    const numerics::System system =
        model::system_of(physics::integrated(equations, about, scene.dealiasing), small, one);
    numerics::Spectra state(small, numerics::components(system.layout)), rate = state;
    const int order = equations.form.polar_order;
    if (equations.form.bead_density >= 0) state[equations.form.bead_density][0] = scene.model.uniform.bead_density;
    if (equations.form.rod_density >= 0) state[equations.form.rod_density][0] = scene.model.uniform.rod_density;
    constexpr double tiny = 1e-6;
    state[order][0] = tiny;
    if (system.nonlinear) system.nonlinear(t, state, rate);
    double growth = rate[order][0].real() / tiny;
    const numerics::Block even = system.linear(0.0).even;
    const numerics::BlockParts parts = numerics::block_parts(system.layout);
    for (int k = 0; k < even.size; ++k)
        if (parts.even[static_cast<std::size_t>(k)].component == order) growth += even(k, k);
    return growth;
}
}  // namespace

PassedOnset passed_onset(const io::Scene& scene) {
    constexpr int parts = 100;
    PassedOnset result;
    try {
        for (int part = 1; part <= parts; ++part) {
            result.rate = growth_of_order(scene, scene.time.end * part / parts);
            result.exponent = std::max(0.0, result.exponent + result.rate * scene.time.end / parts);
        }
    } catch (const Error& error) {  // the isotropic state lies outside the domain of a term
        if (error.fault() != Fault::run) throw;
        return {};
    }
    const physics::UniformState& uniform = scene.model.uniform;
    const double saturation =
        physics::Equations(scene.model).saturation.at(uniform.bead_density, uniform.rod_density).value;
    result.order = std::sqrt(std::max(0.0, result.rate / saturation));
    return result;
}

}  // namespace drover::run
