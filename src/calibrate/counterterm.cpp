// calibrate/counterterm.cpp: the sum over kept waves.
#include "calibrate/counterterm.hpp"

#include <optional>
#include <string>

#include "drover/base/error.hpp"
#include "physics/compiled_model.hpp"

namespace drover::calibrate {

namespace {
constexpr const char *rate_key = "relaxation.rate", *saturation_key = "relaxation.saturation";

/// Rods that do not touch each other, at the mean densities.
class IndependentRods {
public:
    explicit IndependentRods(physics::ModelValues model)
        : compiled_(without_contact(model)), means_(mean_densities(model)) {}

    double at(const char* key) const { return compiled_.coefficient(key).at(means_); }

    /// Why their fluctuations do not saturate the order, if they do not.
    std::optional<std::string> why_none() const {
        for (const char* key : {rate_key, saturation_key, "noise.order"})
            if (!(at(key) > 0.0))
                return text(
                    "{} = {}; expected > 0: it is of rods that lose their direction, whose fluctuations "
                    "saturate the order",
                    key, at(key));
        if (compiled_.coefficient(rate_key).table() == nullptr) return {};
        return text("a table of {}; expected a number, or a polynomial in the densities", rate_key);
    }

    /// |p|^2 in the kept waves but q = 0.
    double variance(const numerics::KeptGrid& on) const {
        const double rate = at(rate_key), stiffness = at("elasticity.stiffness"), splay = at("elasticity.splay"),
                     bilaplacian = at("elasticity.bilaplacian");
        double sum = 0.0;
        numerics::for_kept_rows(on, [&](std::size_t first, std::size_t count) {
            const std::size_t row = first / numerics::columns(on.grid);
            for (std::size_t column = 0; column < count; ++column) {
                if (row == 0 && column == 0) continue;
                const numerics::Wavevector q = numerics::wavevector(on.grid, column, row);
                const double square = q.x * q.x + q.y * q.y;
                const double across = rate + stiffness * square + bilaplacian * square * square;
                sum += (column == 0 ? 1.0 : 2.0) * (1.0 / across + 1.0 / (across + splay * square));  // of k and -k
            }
        });
        return 0.5 * at("noise.order") / numerics::area(on.grid) * sum;
    }

private:
    static physics::ModelValues& without_contact(physics::ModelValues& model) {
        physics::number_in(model, "relaxation.contact") = 0.0;
        return model;
    }

    physics::CompiledModel compiled_;
    physics::Densities means_;
};
}  // namespace

double counterterm(const physics::ModelValues& model, const numerics::KeptGrid& on, const SourceLocation& where) {
    const IndependentRods rods(model);
    if (const auto why = rods.why_none()) fail_input(where, "approximation.counterterm with {}", *why);
    return 2.0 * rods.at(saturation_key) * rods.variance(on);
}

double part_of_waves(const physics::ModelValues& model, const numerics::KeptGrid& on) {
    const IndependentRods rods(model);
    if (rods.why_none()) return 0.0;
    return 2.0 * rods.at(saturation_key) * rods.variance(on) / rods.at(rate_key);
}

void add_counterterm(double rate, physics::ModelValues& model) { physics::number_in(model, rate_key) -= rate; }

}  // namespace drover::calibrate
