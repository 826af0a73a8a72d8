// physics/model.cpp: the System of a model and its linear theory.
#include "drover/physics/model.hpp"

#include <algorithm>
#include <limits>

#include "drover/numerics/wavenumbers.hpp"

namespace drover::physics {

Form form(const Model&) { return rods_only; }

namespace {
numerics::IsotropicBlocks zero_blocks(const Form& form) {
    const numerics::Layout fields = layout(form);
    return {numerics::Block(fields.scalars + fields.vectors), numerics::Block(fields.vectors)};
}
}  // namespace

numerics::System make_system(const Model& model, const numerics::Grid& grid) {
    const Form fields = form(model);
    numerics::System system{.grid = grid, .layout = layout(fields), .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [model, fields](double q) {
        numerics::IsotropicBlocks rates = zero_blocks(fields);
        add_linearisation(model.current, fields, q, rates);
        add_linearisation(model.relaxation, fields, q, rates);
        add_linearisation(model.elasticity, fields, q, rates);
        add_linearisation(model.pressure, fields, q, rates);
        add_linearisation(model.diffusion, fields, q, rates);
        return rates;
    };
    if (model.noise.order != 0.0 || model.noise.rods != 0.0)
        system.noise = [noise = model.noise, fields](double q) {
            numerics::IsotropicBlocks covariance = zero_blocks(fields);
            add_covariance(noise, fields, q, covariance);
            return covariance;
        };
    return system;
}

std::vector<ActiveTerm> active_terms(const Model& model) {
    std::vector<ActiveTerm> terms;
    const auto add = [&](double coefficient, const char* name, const char* equation) {
        if (coefficient != 0.0) terms.push_back({name, text(equation, coefficient)});
    };
    add(model.current.speed, "current", "d_t sigma: -u div p, u = {} mm/s");
    add(model.diffusion.diffusivity, "diffusion", "d_t sigma: D lap sigma, D = {} mm^2/s");
    add(model.relaxation.rate, "relaxation", "d_t p: -a p, a = {} 1/s");
    add(model.elasticity.stiffness, "elasticity", "d_t p: K3 lap p, K3 = {} mm^2/s");
    add(model.elasticity.splay, "elasticity", "d_t p: K1 grad(div p), K1 = {} mm^2/s");
    add(model.pressure.strength, "pressure", "d_t p: -B grad sigma, B = {} mm/s");
    add(model.noise.order, "noise", "d_t p: white noise, Delta = {} 1/(mm^2 s)");
    add(model.noise.rods, "noise", "d_t sigma: conserved noise, strength {} 1/s");
    return terms;
}

namespace {
/// Calls see(q, s) for the rates of both blocks at every |q| of the kept modes.
template <class See>
void for_rates(const numerics::System& system, See see) {
    for (const double q : numerics::distinct_wavenumbers(system.grid, system.degree).q) {
        const numerics::IsotropicBlocks blocks = system.linear(q);
        for (const auto* block : {&blocks.along, &blocks.across})
            for (const numerics::Complex s : numerics::eigenvalues(*block)) see(q, s);
    }
}
}  // namespace

FastestGrowth fastest_growth(const numerics::System& system) {
    FastestGrowth result{.rate = -std::numeric_limits<double>::infinity()};
    for_rates(system, [&](double q, numerics::Complex s) {
        const bool conserved = q == 0.0 && s == 0.0;
        if (!conserved && s.real() > result.rate) result = {.rate = s.real(), .q = q};
    });
    return result;
}

double fastest_rate(const numerics::System& system) {
    double result = 0.0;
    for_rates(system, [&](double, numerics::Complex s) { result = std::max(result, std::abs(s)); });
    return result;
}

StructureFactor structure_factor(const numerics::System& system, const Form& form, double q) {
    const numerics::IsotropicBlocks rates = system.linear(q), noise = system.noise(q);
    const numerics::Block along = numerics::stationary_covariance(rates.along, noise.along);
    const numerics::Block across = numerics::stationary_covariance(rates.across, noise.across);
    const int order = layout(form).scalars;
    return {.rods = along(form.rod_density, form.rod_density),
            .order_along = along(order, order),
            .order_across = across(0, 0)};
}

std::vector<StructureFactor> structure_factors(const numerics::System& system, const Form& form) {
    const numerics::DistinctWavenumbers wavenumbers = numerics::distinct_wavenumbers(system.grid, system.degree);
    std::vector<StructureFactor> of_q(wavenumbers.q.size());
    for (std::size_t n = 1; n < of_q.size(); ++n) of_q[n] = structure_factor(system, form, wavenumbers.q[n]);
    std::vector<StructureFactor> result;
    result.reserve(wavenumbers.of_mode.size());
    for (const std::int32_t n : wavenumbers.of_mode)
        result.push_back(n < 0 ? StructureFactor{} : of_q[static_cast<std::size_t>(n)]);
    return result;
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>() {
    static const std::vector<Row<physics::UniformState>> rows{
        {.name = "rod_density",
         .member = &physics::UniformState::rod_density,
         .unit = "1/mm^2",
         .range = positive,
         .sentence = "sigma: mean density of the rods, which the equations conserve"}};
    return rows;
}

}  // namespace drover
