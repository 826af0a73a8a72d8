// model/system.cpp: L, N and Q of equations for a stepper, with noise that multiplies fields.
#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"
#include "model/compiled.hpp"
#include "model/explicit_part.hpp"

namespace drover::model {

using numerics::Complex;
using numerics::Spectra;

namespace {
/// What noise makes of the fields by products.
struct ProductsOfNoise {
    struct Driven {
        ExplicitPart part;
        std::string field;
        std::vector<int> increments, arrays;  ///< of its noises, and of its components in a state
    };
    std::vector<Driven> driven;
    Spectra rate;

    void add(double t, const Spectra& state, const Spectra& increments, Spectra& to) {
        for (int array = 0; array < state.count(); ++array)
            if (!std::isfinite(state[array][1].real())) return;  // the run has diverged, which it says itself
        for (Driven& one : driven) {
            one.part.set_given(mapped(one.increments, [&](int array) { return increments[array].data(); }));
            one.part(t, state, rate);
            for (const int array : one.arrays) {
                const std::span<const Complex> from = std::as_const(rate)[array];
                // What is not finite at a point is so in all modes; a conserved mean is 0.
                if (!std::isfinite(from[1].real()))
                    fail_run(
                        "the noise of {} is not finite at t = {:.6g}: it has the square root of a field below 0, or a "
                        "quotient by 0; expected a strength that is finite for all values that noise reaches, such as "
                        "sqrt(max({}, 0)), or a coarser grid, on which the field fluctuates less",
                        one.field, t, one.field);
                std::transform(from.begin(), from.end(), to[array].begin(), to[array].begin(), std::plus<>());
            }
        }
    }
};
}  // namespace

numerics::System Equations::system(const numerics::Grid& grid, Threads& threads, int kept_degree,
                                   std::shared_ptr<ExplicitPart>* seen) const {
    numerics::System system = linear_system(grid, kept_degree);
    if (!has_nonlinear_part()) return system;
    const auto part = std::make_shared<ExplicitPart>(*this, system, threads);
    if (seen != nullptr) *seen = part;
    system.nonlinear = [part](double t, const numerics::Spectra& state, numerics::Spectra& rate) {
        (*part)(t, state, rate);
    };
    for (const std::vector<Term>* terms : {&compiled_->terms, &compiled_->substitutes})
        for (const Term& term : *terms) system.is_timed = system.is_timed || term.summary.is_timed;
    for (const Field& field : model().fields)
        system.is_timed = system.is_timed || (field.left == LeftSide::given &&
                                              std::hypot(field.source.velocity_x, field.source.velocity_y) > 0.0);
    const auto products = std::make_shared<ProductsOfNoise>();
    int increment = 0;
    for (const NoiseProducts& one : compiled_->products) {
        ProductsOfNoise::Driven driven{.part = ExplicitPart(Equations(one.equations), system, threads),
                                       .field = model().fields[one.field].symbol,
                                       .increments = {},
                                       .arrays = {}};
        for (int k = components(); k < one.equations->components; ++k) driven.increments.push_back(increment++);
        for (int k = 0; k < components(); ++k)
            if (compiled_->field(k) == one.field) driven.arrays.push_back(compiled_->array_of[std::size_t(k)]);
        products->driven.push_back(std::move(driven));
    }
    if (!compiled_->products.empty()) {
        products->rate = Spectra(grid, static_cast<int>(state_components().size()));
        auto noise = std::make_shared<numerics::ProductNoise>(*system.product_noise);
        noise->add = [products](double t, const Spectra& state, const Spectra& increments, Spectra& to) {
            products->add(t, state, increments, to);
        };
        system.product_noise = std::move(noise);
    }
    if (!compiled_->masses.empty())
        system.set_step = [part, products](double dt) {
            part->set_step(dt);
            for (ProductsOfNoise::Driven& one : products->driven) one.part.set_step(dt);
        };
    return system;
}

}  // namespace drover::model
