// run/warnings/complete_problem.cpp: the sizes of the fields of any model, and why a run of it may have failed.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/mapped.hpp"
#include "model/energy.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "physics/integrated.hpp"
#include "run/fields/field_problem.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/warnings/warnings.hpp"

namespace drover::run {

namespace {
/// The largest wavenumber that a grid keeps.
double largest_wavenumber(const numerics::Grid& grid, int degree) {
    const auto cut = [&](int points, double length) {
        return points > 1 ? 2.0 * std::numbers::pi / length * points / (degree + 1) : 0.0;
    };
    return std::hypot(cut(grid.nx, grid.lx), cut(grid.ny, grid.ly));
}

/// A quarter above the largest wavenumber at which the state of the references is unstable: patterns have such waves,
/// and errors of a pattern that is not resolved would seem to grow without limit.
double shortest_of_patterns(const model::Equations& equations, const numerics::Grid& grid, int degree) {
    const numerics::System system = equations.linear_system(grid, degree);
    return 1.25 * largest_growing(equations, system, largest_wavenumber(grid, system.degree));
}

// ---- Sizes

/// Of a vector of bodies: their density where it is the sum of their directions, 1 where it is the mean; else 0.
double size_of_alignment(const model::Model& model, const model::Field& field) {
    if (field.observed.of.empty()) return 0.0;
    if (field.unit == "1") return 1.0;
    if (field.unit != "mm-2") return 0.0;
    for (const model::Field& other : model.fields)
        if (other.symbol == field.observed.of) return other.reference;
    const auto number = model.coefficients.find(field.observed.of);  // of a density that is no field
    return number == model.coefficients.end() ? 0.0 : number->second;
}

enum class Sizes { at_hand, searched };

/// By field: references, full alignment, and values in the uniform stationary states if these are searched, whichever
/// is larger; 0: unknown.
std::vector<double> known_sizes(const io::Scene& scene, const model::Equations& equations, Sizes how) {
    const model::Model& model = equations.model();
    const std::vector<int> first = model::first_components(model);
    std::vector<double> sizes;
    for (const model::Field& field : model.fields) {
        double size = std::max(std::abs(field.reference), size_of_alignment(model, field));
        if (field.left == model::LeftSide::given)
            size = std::hypot(field.source.x, field.source.y) / numerics::area(scene.grid);
        sizes.push_back(size);
    }
    if (how == Sizes::searched) try {
            for (const theory::StationaryState& state : stationary_states_of(scene, equations).states)
                for (std::size_t n = 0; n < sizes.size(); ++n) {
                    double square = 0.0;
                    for (int k = first[n]; k < first[n] + model::components(model.fields[n]); ++k)
                        square += std::pow(state.values[static_cast<std::size_t>(k)], 2);
                    if (std::isfinite(square)) sizes[n] = std::max(sizes[n], std::sqrt(square));
                }
        } catch (const Error&) {  // no uniform state has finite rates
        }
    return sizes;
}

/// What the other fields of their sizes drive a field to, that damps its own waves: the largest force on it over its
/// damping, or over the run without one.  0: unknown.
double driven_size(const model::Equations& equations, const std::vector<double>& sizes, std::size_t field,
                   double largest_q, double duration) {
    const model::Model& model = equations.model();
    const std::vector<int> first = model::first_components(model);
    const model::UniformState about = equations.reference();
    model::UniformState moved = about;
    for (std::size_t n = 0; n < sizes.size(); ++n) moved[static_cast<std::size_t>(first[n])] = sizes[n];
    const int own = first[field], end = own + model::components(model.fields[field]);
    for (std::size_t n = 0; n < equations.terms().size(); ++n)
        if (equations.terms()[n].field == field &&
            (equations.terms()[n].is_placed || !equations.has_derivative(n, about)))
            return 0.0;
    const auto matrix = [&](double q) {
        model::Symbol sum = model::Symbol::Zero(equations.components(), equations.components());
        for (std::size_t n = 0; n < equations.terms().size(); ++n)
            if (equations.terms()[n].field == field) sum += equations.term_symbol(n, about, {q, 0.0});
        return sum;
    };
    constexpr int looks = 32;
    for (int i = 0; i <= looks; ++i)
        if (matrix(largest_q * i / looks)(own, own).real() > 0.0) return 0.0;
    const model::Symbol shortest = matrix(largest_q);
    double force = equations.uniform_rate_sizes(moved)(own);
    for (std::size_t n = 0; n < sizes.size(); ++n)
        for (int k = first[n]; k < first[n] + model::components(model.fields[n]); ++k)
            if (k < own || k >= end) force += std::abs(shortest(own, k)) * sizes[n];
    return force / std::max(-matrix(0.0)(own, own).real(), 1.0 / duration);
}

/// Of each component of a state.
std::vector<double> sizes_of(const io::Scene& scene, const model::Integrated& what, Sizes how) {
    const model::Equations& equations = what.equations;
    const std::vector<model::Field>& fields = equations.model().fields;
    const double largest_q = largest_wavenumber(scene.grid, 1);
    std::vector<double> known = known_sizes(scene, equations, how), sizes = known, result;
    for (std::size_t n = 0; n < fields.size(); ++n) try {
            if (known[n] == 0.0 || (fields[n].spin > 0 && size_of_alignment(equations.model(), fields[n]) == 0.0))
                sizes[n] = std::max(known[n], driven_size(equations, known, n, largest_q, scene.time.end));
        } catch (const Error&) {  // no finite slope: unknown
        }
    for (std::size_t n = 0; n < fields.size(); ++n)
        if (fields[n].left == model::LeftSide::rate)
            result.insert(result.end(), static_cast<std::size_t>(model::components(fields[n])),
                          std::isfinite(sizes[n]) ? sizes[n] : 0.0);
    return result;
}

// ---- Causes

/// Whether a field that is large decreases by its own products in a uniform state; of a scalar also products with
/// itself that vanish there, which take from its waves what they have.
bool limits_itself(const model::Equations& equations, std::size_t field) {
    const auto first = static_cast<std::size_t>(model::first_components(equations.model())[field]);
    const auto own = static_cast<int>(first);
    for (const model::TermSummary& term : equations.terms())
        if (term.field == field && term.vanishes_when_uniform && !term.is_linear && term.reads == std::vector{own} &&
            equations.model().fields[field].spin == 0)
            return true;
    constexpr double large = 1e3;  // so that weak products count
    const auto rate = [&](double value) {
        model::UniformState at = equations.reference();
        at[first] = value;
        return equations.uniform_rates(at)(own) / value;
    };
    const double size = large * std::max(1.0, std::abs(equations.reference()[first]));
    return std::ranges::all_of(std::array{1.0, -1.0}, [&](double sign) {
        const double once = rate(sign * size), twice = rate(2.0 * sign * size);
        return once < 0.0 && twice < 1.5 * once;  // linear damping has the same
    });
}

/// Whether a term limits the growth of some field, and the key of the coefficient of such a term; "": none is known.
struct Limit {
    bool is_there = false;
    std::string key = {};
};

Limit limit_of(const io::Scene& scene, const model::Equations& equations) {
    Limit limit;
    const std::vector<model::Field>& fields = equations.model().fields;
    for (std::size_t n = 0; n < fields.size(); ++n) {
        if (fields[n].left != model::LeftSide::rate) continue;
        const std::string key = key_of_term(scene, equations, fields[n], text("|{0}|^2 {0}", fields[n].symbol));
        try {
            if (limits_itself(equations, n)) return {.is_there = true, .key = key};
        } catch (const Error&) {  // not finite so far from the references: not known
        }
        if (limit.key.empty()) limit.key = key;
    }
    return limit;
}

/// Terms as people wrote them.
std::vector<std::string> texts_of(const io::Scene& scene, const model::Equations& equations) {
    if (scene.kind != io::SceneKind::model) return physics::written_terms(physics::Equations(scene.model));
    return mapped(equations.terms(), &model::TermSummary::text);
}
}  // namespace

std::vector<double> searched_sizes(const io::Scene& scene, const model::Integrated& what) {
    return sizes_of(scene, what, Sizes::searched);
}

std::string likely_cause(const io::Scene& scene, const model::Equations& equations, const numerics::System& linear,
                         double tail) {
    const Limit limit = limit_of(scene, equations);
    const numerics::FastestGrowth growth = numerics::fastest_growth(linear);
    const std::string unlimited =
        text("no term of the equations stops it{}",
             limit.key.empty() ? "" : text(" ({} = {})", limit.key, number_of(scene, "", limit.key, {}).value));
    const bool is_coarse = tail > max_spectral_tail;
    const std::string step =
        text("the time step is too long for the nonlinear terms{}",
             is_coarse ? text(", or the grid is too coarse ({:.2g} of the variance is in the shortest waves)", tail)
                       : "");
    const std::string remedy = text(": choose time.dt = {}{}", 0.5 * scene.time.dt,
                                    is_coarse ? text(", or {}", grid_keys(scene.grid, 2)) : "");
    if (!(growth.rate > 0.0))
        return step + (limit.is_there ? "" : text(", or a field grows where others have changed and {}", unlimited)) +
               remedy;
    const std::string grows =
        text("a linear mode grows at {} (|q| = {}) and ", io::in_unit("{:.3g}", growth.rate, "/s", scene.units),
             io::in_unit("{:.3g}", growth.q, "/mm", scene.units));
    if (limit.is_there)
        return grows + text("{} does not stop it, or ", limit.key.empty() ? "a product" : limit.key) + step + remedy;
    if (equations.has_nonlinear_part()) return grows + unlimited + ", or " + step + remedy;
    return grows + unlimited;
}

/// Of terms that no mass divides: where it vanishes none is finite.
std::string term_not_finite(const io::Scene& scene, const model::Integrated& what, double t,
                            const numerics::Spectra& state) {
    const model::Equations& equations = what.equations;
    Threads one(1);
    for (const std::size_t n : model::terms_with_power(equations)) {
        const model::Field& field = equations.model().fields[equations.terms()[n].field];
        if (!field.mass.text.empty()) continue;
        numerics::Spectra rate(scene.grid, state.count());
        try {
            const numerics::System system = equations.only(n).system(scene.grid, one, what.kept_degree);
            if (system.nonlinear) system.nonlinear(t, state, rate);
        } catch (const Error&) {  // a value that is not allowed, not a term
            continue;
        }
        if (!std::ranges::all_of(rate.values, [&](numerics::Complex value) { return is_finite(value, state.size); }))
            return text("the term of {} written as text, ({}), is not finite there", field.name,
                        texts_of(scene, equations)[n]);
    }
    return "";
}

void complete_problem(const io::Scene& scene, FieldProblem& problem) {
    model::Integrated& what = problem.integrated;
    // A flock is far from its references, and so are its errors.
    if (scene.kind == io::SceneKind::model)
        what.shortest = shortest_of_patterns(what.equations, scene.grid, what.kept_degree);
    problem.sizes = sizes_of(scene, what, Sizes::at_hand);
}

}  // namespace drover::run
