// model/white_noise.cpp: the noise of equations: of each field alone, and of the white noises that they name.
#include <algorithm>
#include <cmath>

#include "compiled.hpp"
#include "drover/model/equations.hpp"

namespace drover::model {

using numerics::Wavevector;

bool Equations::has_noise() const {
    const CompiledEquations& c = *compiled_;
    return std::any_of(c.model.fields.begin(), c.model.fields.end(),
                       [](const Field& one) { return one.noise != 0.0; }) ||
           std::any_of(c.noise_rows.begin(), c.noise_rows.end(), [](const LinearForm& row) { return !row.empty(); });
}

const std::vector<TermSummary>& Equations::noise_terms() const { return compiled_->noise_terms; }

Symbol CompiledEquations::noise_symbol(const Wavevector& q) const {
    Symbol result = Symbol::Zero(components, noise_components);
    for (int row = 0; row < components; ++row)
        for (const auto& [derivative, coefficient] : noise_rows[static_cast<std::size_t>(row)])
            result(row, derivative.component - components) += coefficient * factor_of(derivative.order, q);
    return result;
}

Symbol Equations::noise(const Wavevector& q) const {
    const Symbol shared = compiled_->noise_symbol(q);
    Symbol strengths = shared * shared.adjoint();
    for (int k = 0; k < components(); ++k) {
        const Field& field = model().fields[compiled_->field(k)];
        strengths(k, k) += field.noise * (field.noise_conserves ? q.x * q.x + q.y * q.y : 1.0);
    }
    return strengths;
}

void CompiledEquations::check_noise() const {
    if (noise_components == 0) return;
    const auto fails = [this](const Symbol& found, const Symbol& expected) {
        return ((found - expected).cwiseAbs().array() > 1e-12 * expected.diagonal().cwiseAbs().maxCoeff()).any();
    };
    for (const double q : {0.31, 1.0, 2.7}) {
        const auto strengths = [this](const numerics::Wavevector& at) {
            const Symbol rows = noise_symbol(at);
            return Symbol(rows * rows.adjoint());
        };
        const Symbol along_x = strengths({q, 0.0});
        Symbol allowed = along_x;
        for (int i = 0; i < components && !model.chiral; ++i)
            for (int j = 0; j < components; ++j)
                if (is_odd(i) != is_odd(j)) allowed(i, j) = 0.0;
        bool acts_alike = !fails(along_x, allowed);
        for (const double angle : {0.7, 2.1}) {
            const double cosine = std::cos(angle), sine = std::sin(angle);
            const Symbol turned = in_frame(strengths({q * cosine, q * sine}), cosine, sine);
            acts_alike = acts_alike && !fails(turned, along_x);
        }
        require(acts_alike, model.noises[0].where,
                "the white noises drive the fields differently in different directions; expected isotropic noise, such "
                "as xi, grad xi or div xi, with all components of a noise");
    }
}

}  // namespace drover::model
