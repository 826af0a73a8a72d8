// model/white_noise.cpp: the noise of equations: of each field alone, and of the white noises that they name.
#include <algorithm>

#include "drover/model/equations.hpp"
#include "model/compiled.hpp"
#include "model/summands.hpp"

namespace drover::model {

using numerics::Wavevector;

bool CompiledEquations::has_sums() const {
    return std::ranges::any_of(model.fields, [](const Field& one) { return one.noise != 0.0; }) ||
           std::ranges::any_of(noise_rows, [](const LinearForm& row) { return !row.empty(); });
}

bool Equations::has_noise() const { return compiled_->has_sums() || has_product_noise(); }
bool Equations::has_product_noise() const { return !compiled_->products.empty(); }
const std::vector<TermSummary>& Equations::noise_terms() const { return compiled_->noise_terms; }

int CompiledEquations::first_of_noise(std::size_t noise) const {
    int first = 0;
    for (std::size_t n = 0; n < noise; ++n) first += model::components(model.noises[n]);
    return first;
}

Symbol CompiledEquations::noise_symbol(const std::vector<LinearForm>& rows, const Wavevector& q) const {
    return form_symbol(rows, q, components + noise_components).rightCols(noise_components);
}

Symbol CompiledEquations::product_symbol(const UniformState& uniform, const Wavevector& q) const {
    Symbol result = Symbol::Zero(components, noise_components);
    for (const NoiseProducts& one : products) {
        const CompiledEquations& driven = *one.equations;
        std::vector<int> column_of;  // of each given component
        for (const std::size_t noise : one.noises)
            for (int k = 0; k < model::components(model.noises[noise]); ++k)
                column_of.push_back(first_of_noise(noise) + k);
        UniformState at = uniform;
        at.resize(static_cast<std::size_t>(driven.components), 0.0);
        const std::vector<double> slots = driven.slots_at(driven.balanced(at));
        for (const Term& term : driven.terms) {
            require(
                !term.summary.is_placed, term.summary.where,
                "the noise \"{}\" depends on position or time, so that no uniform state has it; expected noise that "
                "depends on the fields alone",
                term.summary.text);
            const auto add = [&](std::size_t row, const LinearForm& form, const Order& order, double factor) {
                for (const auto& [derivative, coefficient] : form)
                    if (derivative.component >= components)
                        result(first_component[one.field] + static_cast<int>(row),
                               column_of[static_cast<std::size_t>(derivative.component - components)]) +=
                            factor * coefficient * factor_of(derivative.order + order, q);
            };
            for (std::size_t k = 0; k < term.rows.size(); ++k) {
                add(k, term.rows[k].linear, {}, 1.0);
                for (const PointFunction& function : term.rows[k].functions)
                    for (const PointFunction::Slope& slope : function.slopes) {
                        const LinearForm& form = driven.form_of(slope.slot);
                        if (std::ranges::any_of(form, [&](const auto& e) { return e.first.component >= components; }))
                            add(k, form, function.order, driven.limit_at(slope.value, slots));
                    }
            }
        }
    }
    return result;
}

Symbol CompiledEquations::sum_noise(const Wavevector& q) const {
    const Symbol shared = noise_symbol(noise_rows, q);
    Symbol strengths = shared * shared.adjoint();
    for (int k = 0; k < components; ++k) {
        const Field& one = model.fields[field(k)];
        strengths(k, k) += one.noise * (one.noise_conserves ? q.x * q.x + q.y * q.y : 1.0);
    }
    leave_out_divergence(strengths, q);
    return strengths;
}

Symbol Equations::noise(const UniformState& about, const Wavevector& q) const {
    check_state(about, static_cast<std::size_t>(compiled_->components));
    Symbol strengths = compiled_->sum_noise(q);
    if (!has_product_noise()) return strengths;
    const Symbol shared = compiled_->product_symbol(about, q);
    strengths += shared * shared.adjoint();
    compiled_->leave_out_divergence(strengths, q);
    return strengths;
}

void CompiledEquations::check_noise() const {
    const auto parts = by_order(noise_rows);
    if (parts.empty()) return;
    const auto sum_over = [&](int order, const auto& product) {  // of all pairs of parts that make this order
        for (const auto& [of_one, rows] : parts)
            if (const auto other = parts.find(order - of_one); other != parts.end()) product(rows, other->second);
    };
    for (int order = 0; order <= 2 * parts.rbegin()->first; ++order) {
        const auto strengths = [&](const Wavevector& q) {
            Symbol sum = Symbol::Zero(components, components);
            sum_over(order,
                     [&](const auto& a, const auto& b) { sum += noise_symbol(a, q) * noise_symbol(b, q).adjoint(); });
            return sum;
        };
        Eigen::MatrixXd sizes = Eigen::MatrixXd::Zero(components, components);
        sum_over(order, [&](const auto& a, const auto& b) { sizes += sizes_of(a) * sizes_of(b).transpose(); });
        require(is_same_in_all_directions(strengths, over_fields(sizes), !model.chiral), model.noises[0].where,
                "the white noises drive the fields differently in different directions; expected isotropic noise, such "
                "as xi, grad xi or div xi, with all components of a noise");
    }
}

// ---- for the solver

namespace {
/// One noise that drives one field.
struct Drive {
    std::size_t noise = 0, field = 0;
    int part = 0;  ///< component of the noise
};
}  // namespace

numerics::ProductNoise product_noise(const std::shared_ptr<const CompiledEquations>& c) {
    numerics::ProductNoise result;
    std::vector<Drive> drives;  // of each component
    result.layout.chiral = c->model.chiral;
    for (const NoiseProducts& one : c->products)
        for (const std::size_t n : one.noises) {
            const WhiteNoise& noise = c->model.noises[n];
            result.layout.fields.push_back({noise.spin, noise.odd});
            for (int k = 0; k < components(noise); ++k) drives.push_back({n, one.field, k});
        }
    const numerics::BlockParts parts = numerics::block_parts(result.layout);
    const auto blocks = [parts](const auto& entry) {  // by components
        return numerics::blocks_of(parts, [&](const numerics::Part& row, const numerics::Part& column) {
            return entry(static_cast<std::size_t>(row.component), static_cast<std::size_t>(column.component));
        });
    };
    result.noise = [drives, blocks](double) {
        return blocks([&](std::size_t i, std::size_t j) {
            return drives[i].noise == drives[j].noise && drives[i].part == drives[j].part ? 1.0 : 0.0;
        });
    };
    result.linear = [c, drives, blocks](double q) {
        const Symbol m = c->eliminated(c->averaged(c->linear, q));
        return blocks([&](std::size_t i, std::size_t j) {
            if (i != j) return 0.0;
            const int first = c->first_component[drives[i].field];
            const int count = components(c->model.fields[drives[i].field]);
            if (q > 0.0 && c->is_solenoidal(first)) return m(first + 1, first + 1).real();
            double rate = 0.0;
            for (int k = first; k < first + count; ++k) rate += m(k, k).real() / count;
            return rate;
        });
    };
    return result;
}

}  // namespace drover::model
