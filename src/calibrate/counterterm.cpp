// calibrate/counterterm.cpp: the sum over kept waves.
#include "calibrate/counterterm.hpp"

#include "drover/base/error.hpp"
#include "physics/compiled_model.hpp"

namespace drover::calibrate {

namespace {
constexpr const char *rate_key = "relaxation.rate", *saturation_key = "relaxation.saturation";

struct IndependentRods {
    double rate = 0.0, stiffness = 0.0, splay = 0.0, bilaplacian = 0.0;
    double noise_per_area = 0.0;

    /// |p|^2 of one wave.
    double variance(double square) const {
        const double across = rate + stiffness * square + bilaplacian * square * square;
        return 0.5 * noise_per_area * (1.0 / across + 1.0 / (across + splay * square));
    }
};

physics::CompiledModel without_contact(physics::ModelValues model) {
    physics::number_in(model, "relaxation.contact") = 0.0;
    return physics::CompiledModel(model);
}
}  // namespace

double counterterm(const physics::ModelValues& model, const numerics::KeptGrid& on, const SourceLocation& where) {
    const physics::CompiledModel compiled = without_contact(model);
    const physics::Densities means = physics::mean_densities(model);
    const auto at = [&](const char* key) { return compiled.coefficient(key).at(means); };
    const auto require_positive = [&](const char* key) {
        require(at(key) > 0.0, where,
                "approximation.counterterm with {} = {}; expected > 0: it is of rods that lose their "
                "direction, whose fluctuations saturate the order",
                key, at(key));
    };
    for (const char* key : {rate_key, saturation_key, "noise.order"}) require_positive(key);
    require(compiled.coefficient(rate_key).table() == nullptr, where,
            "approximation.counterterm with a table of {}; expected a number, or a polynomial in the densities",
            rate_key);
    const IndependentRods rods{.rate = at(rate_key),
                               .stiffness = at("elasticity.stiffness"),
                               .splay = at("elasticity.splay"),
                               .bilaplacian = at("elasticity.bilaplacian"),
                               .noise_per_area = at("noise.order") / numerics::area(on.grid)};
    double sum = 0.0;
    numerics::for_kept_rows(on, [&](std::size_t first, std::size_t count) {
        const std::size_t row = first / numerics::columns(on.grid);
        for (std::size_t column = 0; column < count; ++column) {
            const numerics::Wavevector q = numerics::wavevector(on.grid, column, row);
            if (row == 0 && column == 0) continue;
            sum += (column == 0 ? 1.0 : 2.0) * rods.variance(q.x * q.x + q.y * q.y);  // of k and -k
        }
    });
    return 2.0 * at(saturation_key) * sum;
}

double part_of_waves(const physics::ModelValues& model, const numerics::KeptGrid& on) {
    const physics::CompiledModel compiled = without_contact(model);
    const physics::Coefficient& rate = compiled.coefficient(rate_key);
    const auto is_positive = [&](const char* key) {
        return compiled.coefficient(key).at(physics::mean_densities(model)) > 0.0;
    };
    if (rate.table() != nullptr || !is_positive(rate_key) || !is_positive(saturation_key) ||
        !is_positive("noise.order"))
        return 0.0;
    return counterterm(model, on, {}) / rate.at(physics::mean_densities(model));
}

void add_counterterm(double rate, physics::ModelValues& model) { physics::number_in(model, rate_key) -= rate; }

}  // namespace drover::calibrate
