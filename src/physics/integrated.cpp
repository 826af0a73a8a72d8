// physics/integrated.cpp: what the fields of a model file may not reach, and the degree of their products.
#include "physics/integrated.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "physics/written_model.hpp"

namespace drover::physics {

int kept_degree(const Equations& equations, const numerics::Dealiasing& dealiasing) {
    int max_degree = std::max(1, dealiasing.degree);
    const FieldRow* pointwise = pointwise_balance(equations);
    const int balanced = pointwise == nullptr ? -1 : equations.component(pointwise->symbol);
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const model::TermSummary& term = equations.right_sides().terms()[n];
        // A field in balance is divided by its drag as it is, which needs no product.
        const model::Field& field = equations.right_sides().model().fields[term.field];
        if (presence(equations.model, field.symbol) == Presence::balance &&
            equations.terms()[n] == key_of_term(field.symbol, field.symbol))
            continue;
        // One that is a nonlinear function of the fields counts as two factors.
        const bool is_product = pointwise != nullptr && std::ranges::count(term.reads, balanced) > 0;
        max_degree = std::max(max_degree, term.degree + (is_product ? 1 : 0));
    }
    // 1/rho has no finite degree: its products count as quadratic, and outputs tell the tail of the spectrum.
    for (const FieldRow& field : equations.model.file->fields)
        for (const FieldRow* density : densities(*equations.model.file))
            if (presence(equations.model, field) == Presence::rate &&
                presence(equations.model, *density) == Presence::rate && is_in_mass(field, *density))
                max_degree = std::max(max_degree, 2);
    return numerics::kept_degree(max_degree, dealiasing.rule);
}

namespace {
/// What a right-hand side divides by at points, and the tables that it reads.
struct Domain {
    CompiledModel model;
    std::vector<const FieldRow*> fields;   ///< the densities
    std::array<int, 2> component{-1, -1};  ///< of each density, in a state; -1: not there
    const FieldRow* massive = nullptr;     ///< a field whose mass contains a density
    std::size_t mass_of = 0;               ///< that density
    std::string drag;                      ///< key of what a balance divides by; "": none
    std::string slaved = {};               ///< its field
};

/// Smallest and largest densities; infinite for one that is no field.
struct Extremes {
    static constexpr double none = infinite;
    Densities min{none, none}, max{-none, -none};
};

[[noreturn]] void fail_domain(const Domain& domain, std::size_t density, const std::string& message) {
    throw model::DomainFailure(message, domain.component[density]);
}

/// "the bead density 0.5 and the rod density 2".
std::string densities_text(const Domain& domain, const Densities& at) {
    std::string result;
    for (std::size_t k = 0; k < domain.fields.size(); ++k)
        result += text("{}the {} {:.4g}", k == 0 ? "" : " and ", words_of(domain.fields[k]->name), at[k]);
    return result;
}

void check_drag(const Domain& domain, const Extremes& extremes) {
    const Coefficient& drag = domain.model.coefficient(domain.drag);
    for (const double first : {extremes.min[0], extremes.max[0]})
        for (const double second : {extremes.min[1], extremes.max[1]})
            if (std::isfinite(first) && std::isfinite(second) && drag.at({first, second}) <= 0.0)
                throw model::DomainFailure(text("{} is {:.4g} at {}; expected > 0: a slaved {} divides by it",
                                                domain.drag, drag.at({first, second}),
                                                densities_text(domain, {first, second}), domain.slaved),
                                           -1);
}

void check_tables(const Domain& domain, const Extremes& extremes) {
    const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
    for (const auto& [key, coefficient] : domain.model.coefficients) {
        if (!coefficient.table()) continue;
        // No term of this right-hand side reads the coefficient: its densities are not on the grid.
        if ((coefficient.depends_on(0) && !std::isfinite(extremes.min[0])) ||
            (coefficient.depends_on(1) && !std::isfinite(extremes.min[1])))
            continue;
        for (const Densities& at : {extremes.min, extremes.max})
            if (std::isnan(coefficient.at({finite(at[0]), finite(at[1])})))
                fail_domain(domain, 0,
                            text("the densities reached {}, outside the table of {}: {}; expected them inside: give a "
                                 "wider table, or table.outside = \"hold\"",
                                 densities_text(domain, at), key, range_text(*coefficient.table())));
    }
}

/// NaN is left to the health check, which locates it.
void check(const Domain& domain, const Extremes& extremes) {
    const std::size_t k = domain.mass_of;
    if (domain.massive != nullptr && extremes.min[k] <= 0.0)
        fail_domain(domain, k,
                    text("the {} reached {:.4g} {} on the grid, and the mass of the {} is proportional to it; a vacuum "
                         "needs {} = \"slaved\"; else expected a density > 0: take a finer grid, a smaller dt or less "
                         "noise",
                         words_of(domain.fields[k]->name), extremes.min[k], domain.fields[k]->unit,
                         words_of(domain.massive->name), domain.massive->present));
    if (!domain.drag.empty() && !domain.model.coefficient(domain.drag).table()) check_drag(domain, extremes);
    check_tables(domain, extremes);
}

Domain domain_of(const Equations& e) {
    const ModelFile& file = *e.model.file;
    Domain domain{.model = e, .fields = densities(file)};
    for (std::size_t k = 0; k < domain.fields.size(); ++k) {
        domain.component[k] = e.component(domain.fields[k]->symbol);
        for (const FieldRow& field : file.fields) {
            if (!is_in_mass(field, *domain.fields[k]) || domain.component[k] < 0 ||
                presence(e.model, field) != Presence::rate)
                continue;
            for (std::size_t n = 0; n < e.terms().size(); ++n)  // a term that is a mass times something is not divided
                if (e.is_of(n, field) && e.right_sides().terms()[n].text.find(field.mass) == std::string::npos)
                    domain.massive = &field, domain.mass_of = k;
        }
    }
    if (const FieldRow* slaved = pointwise_balance(e)) {
        domain.drag = key_of_term(slaved->symbol, slaved->symbol);
        domain.slaved = words_of(slaved->name);
    }
    return domain;
}

}  // namespace

model::Integrated integrated(const Equations& e, const Densities& about, const numerics::Dealiasing& dealiasing) {
    model::Integrated what{.equations = e.solver(about), .kept_degree = kept_degree(e, dealiasing)};
    const Domain domain = domain_of(e);
    for (const int k : domain.component)
        if (k >= 0) what.watched.push_back(k);
    what.check = [domain](std::span<const model::Range> found) {
        Extremes extremes;
        std::size_t next = 0;
        for (std::size_t k = 0; k < domain.component.size(); ++k)
            if (domain.component[k] >= 0) extremes.min[k] = found[next].min, extremes.max[k] = found[next++].max;
        check(domain, extremes);
    };
    return what;
}

model::Integrated integrated(const ModelValues& model, const numerics::Dealiasing& dealiasing) {
    return integrated(Equations(model), mean_densities(model), dealiasing);
}

std::string nonuniform_term(const Equations& equations) {
    const bool has_point = source_kind(equations.model) == SourceKind::point;
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (const std::string& term = equations.terms()[n];
            equations.right_sides().terms()[n].is_placed || (has_point && term == equations.model.file->source.section))
            return term;
    return "";
}

}  // namespace drover::physics
