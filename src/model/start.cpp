// model/start.cpp: perturbed and stationary starts.
#include "model/start.hpp"

#include <algorithm>
#include <complex>
#include <cstdlib>
#include <numeric>
#include <tuple>

#include "base/mapped.hpp"
#include "drover/base/random.hpp"
#include "drover/model/linearised_at.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/fields/start_formula.hpp"
#include "numerics/solvers/fastest_growth.hpp"

namespace drover::model {

bool has_source(const Model& model, const TermSummary& term) {
    return std::ranges::any_of(placed_fields(model), [&](const PlacedField& one) {
        const auto is_of_it = [first = static_cast<int>(one.first), &one](int component) {
            return component >= first && component < first + components(one.field);
        };
        return one.field.left == LeftSide::given && std::ranges::any_of(term.reads, is_of_it);
    });
}

namespace {
numerics::StartFormula formula_of(const std::string& component, const Text& formula) {
    return numerics::read_start_formula("initial." + component, formula.text, formula.where);
}

std::vector<std::string> names_of(const std::vector<StateComponent>& components) {
    return mapped(components, &StateComponent::name);
}

/// The index of a component of a state; -1 if there is none of that name.
int index_of(const std::string& name, const std::vector<std::string>& names) {
    const auto found = std::ranges::find(names, name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

/// Terms without which isotropic linear theory describes the waves about the references: those that depend on
/// direction, position or time, as the source of a given field does, or have no derivative.
std::vector<std::string> terms_beyond_isotropic(const Equations& equations) {
    std::vector<std::string> directed, others;
    for (std::size_t n = 0; n < equations.terms().size(); ++n) {
        const TermSummary& term = equations.terms()[n];
        if (term.is_placed || has_source(equations.model(), term) ||
            !equations.has_derivative(n, equations.reference()))
            others.push_back(term.text);
        else if (!equations.is_isotropic(n)) directed.push_back(term.text);
    }
    if (const TermSummary* placed = equations.placed_term(); placed != nullptr && others.empty())
        others.push_back(placed->text);  // of a balance
    // The directions of some terms may cancel: d_x d_x phi + d_y d_y phi.
    if (others.empty() && LinearisedAt(equations, equations.reference()).is_isotropic()) return {};
    others.insert(others.end(), directed.begin(), directed.end());
    return others;
}

/// A stationary start is drawn from the isotropic linear theory about the references.
void check_stationary(const Equations& equations, const numerics::Grid& grid, int degree, const Locate& locate) {
    require(equations.has_noise(), locate("initial.kind"),
            "initial.kind = \"stationary\" of a model without noise; a stationary state needs noise: give a field "
            "noise, or choose another initial.kind");
    require(
        !equations.has_product_noise(), locate("initial.kind"),
        "initial.kind = \"stationary\", and the strength of the noise depends on fields, position or time; expected "
        "constant strengths: choose another initial.kind");
    for (const TermSummary& term : equations.terms())
        require(!term.is_explicit, locate("initial.kind"),
                "initial.kind = \"stationary\" draws from the exact linear part, and the term \"{}\" is not in it; "
                "expected no explicit(...): choose another initial.kind",
                term.text);
    const std::vector<std::string> beyond = terms_beyond_isotropic(equations);
    require(
        beyond.empty(), locate("initial.kind"),
        "initial.kind = \"stationary\" draws from the isotropic linear theory, and {} depend on direction, position "
        "or time, or have no derivative; expected none such: choose another initial.kind",
        joined(beyond));
    require(
        equations.uniform_rates(equations.reference()).isZero(0.0), locate("initial.kind"),
        "initial.kind = \"stationary\" draws about the references, which the equations change, such as by a force or "
        "a field of this model; expected references that are stationary: choose others, or another initial.kind");
    const numerics::FastestGrowth growth = numerics::fastest_growth(equations.linear_system(grid, degree));
    require(
        growth.rate < 0.0, locate("initial.kind"),
        "initial.kind = \"stationary\", but there is no stationary state: a linear mode grows at the rate {:.4g} at "
        "|q| = {:.3g}; expected every mode to decay; choose another initial.kind",
        growth.rate, growth.q);
}

void check_mode(const Start& start, const numerics::Grid& grid, int degree, const Locate& locate) {
    const int parts = degree + 1;
    for (const auto& [name, number, size] :
         {std::tuple{"mode_x", start.mode_x, grid.nx}, std::tuple{"mode_y", start.mode_y, grid.ny}})
        require(std::abs(std::int64_t{number}) * parts < size, locate(text("initial.{}", name)),
                "initial.{} = {}; expected a magnitude less than {:.4g}: the grid keeps modes below 1/{} of the points "
                "of that axis",
                name, number, static_cast<double>(size) / parts, parts);
}

/// Formulas belong to the kind "formula"; the message names all, since a scene often gives several.
void check_kind_of_formulas(const Start& start, const std::vector<std::string>& components, const Locate& locate) {
    if (start.formulas.empty() || start.kind == StartKind::formula) return;
    std::vector<std::string> keys;
    for (const std::string& component : components)
        if (start.formulas.contains(component)) keys.push_back("initial." + component);
    for (const auto& [name, formula] : start.formulas)
        if (index_of(name, components) < 0) keys.push_back("initial." + name);
    std::string cleared;
    for (const std::string& key : keys) cleared += text(" --set '{}=\"\"'", key);
    const char* them = keys.size() == 1 ? "it" : "them";
    fail_input(locate(keys.front()),
               "{} {} given with initial.kind = \"{}\"; expected \"formula\"; for another start remove {}, or override "
               "{}:{}",
               joined(keys), keys.size() == 1 ? "is" : "are", start.kind, them, them, cleared);
}

std::vector<StateComponent> components_with(const Equations& equations, LeftSide left) {
    std::vector<StateComponent> result;
    for (std::size_t n = 0; n < equations.model().fields.size(); ++n) {
        const Field& field = equations.model().fields[n];
        if (field.left != left) continue;
        const std::vector<std::string> names = dataset_names(field), symbols = component_names(field);
        for (std::size_t part = 0; part < names.size(); ++part)
            result.push_back({.name = names[part],
                              .unit = field.unit,
                              .meaning = field.meaning.empty() ? symbols[part] : field.meaning + ", " + symbols[part],
                              .field = n,
                              .part = static_cast<int>(part)});
    }
    return result;
}

void set_formulas(const Start& start, const std::vector<std::string>& names, const numerics::System& system,
                  Threads& threads, numerics::Spectra& state) {
    numerics::Fields cells(system.grid, state.count());
    numerics::Spectra made(system.grid, state.count());
    for (const auto& [name, formula] : start.formulas)
        numerics::fill(formula_of(name, formula), system.grid, threads, cells[index_of(name, names)]);
    numerics::Transform(system.grid, system.degree, threads).forward(cells, made);
    for (const auto& [name, formula] : start.formulas) {
        const int c = index_of(name, names);
        std::ranges::copy(made[c], state[c].begin());
    }
}

/// Adds independent normal numbers of this standard deviation in each cell; the means of scalars do not change.
void add_random(const numerics::System& system, double amplitude, std::uint64_t seed, Threads& threads,
                numerics::Spectra& state) {
    numerics::Fields cells(system.grid, state.count());
    for (int c = 0; c < state.count(); ++c) {
        const RandomKey key{.seed = seed, .stream = Stream::initial_state, .substep = static_cast<std::uint32_t>(c)};
        const std::span<double> all = cells[c];
        constexpr std::size_t cells_per_chunk = 4096;
        threads.for_chunks(all.size(), cells_per_chunk, [&](std::size_t begin, std::size_t end) {
            fill_normal(key, begin, 1, all.subspan(begin, end - begin));
            for (double& value : all.subspan(begin, end - begin)) value *= amplitude;
        });
    }
    numerics::Spectra noise(system.grid, state.count());
    numerics::Transform(system.grid, system.degree, threads).forward(cells, noise);
    for (const int c : numerics::scalar_components(system.layout)) noise[c][0] = 0.0;
    for (std::size_t m = 0; m < state.values.size(); ++m) state.values[m] += noise.values[m];
}

/// Adds amplitude cos(q.r + phase) to a component.
void add_mode(const numerics::Grid& grid, const Start& start, int component, numerics::Spectra& state) {
    // A real mode is its own conjugate at -q: the half with kx >= 0 is stored.
    const int sign = start.mode_x < 0 ? -1 : 1, kx = sign * start.mode_x, ky = sign * start.mode_y;
    const std::size_t width = numerics::columns(grid), rows = static_cast<std::size_t>(grid.ny);
    const auto column = static_cast<std::size_t>(kx);
    const auto row = static_cast<std::size_t>(ky < 0 ? ky + grid.ny : ky);
    const numerics::Complex half = 0.5 * std::polar(start.amplitude, sign * start.phase);
    state[component][row * width + column] += half;
    if (column == 0) state[component][(rows - row) % rows * width] += std::conj(half);
}

/// The start as it is given, whatever its divergence.
numerics::Spectra perturbed(const Start& start, const Equations& equations, const numerics::System& system,
                            std::uint64_t seed, Threads& threads) {
    const std::vector<std::string> names = names_of(components_of_state(equations));
    numerics::Spectra state(system.grid, static_cast<int>(names.size()));
    if (start.kind == StartKind::stationary)
        numerics::draw_stationary(system, {.seed = seed, .stream = Stream::stationary_state}, state);
    const UniformState reference = equations.reference();
    for (int c = 0; c < state.count(); ++c)
        state[c][0] += reference[static_cast<std::size_t>(equations.state_components()[static_cast<std::size_t>(c)])];
    if (start.kind == StartKind::formula) set_formulas(start, names, system, threads, state);
    if (start.kind == StartKind::random || (start.kind == StartKind::formula && start.amplitude > 0.0))
        add_random(system, start.amplitude, seed, threads, state);
    if (start.kind == StartKind::mode)
        add_mode(system.grid, start, start.component.empty() ? 0 : index_of(start.component, names), state);
    return state;
}

/// Of what remove_divergence() takes from a start that is given, as part of the variance.
void warn_of_divergence(const Start& start, const Equations& equations, const numerics::Grid& grid, int degree,
                        std::vector<std::string>& warnings) {
    const std::vector<Field>& fields = equations.model().fields;
    if (start.kind != StartKind::formula && start.kind != StartKind::mode) return;
    if (std::ranges::none_of(fields, [](const Field& one) { return one.solenoidal; })) return;
    Threads one(1);
    Start given = start;
    if (given.kind == StartKind::formula) given.amplitude = 0.0;
    const numerics::System system = equations.linear_system(grid, degree);
    const numerics::Spectra as_given = perturbed(given, equations, system, 0, one);
    numerics::Spectra without = as_given;
    remove_divergence(equations, grid, without);
    const std::vector<StateComponent> components = components_of_state(equations);
    for (int c = 0; c < as_given.count(); ++c) {
        const StateComponent& of_state = components[static_cast<std::size_t>(c)];
        if (of_state.part != 0 || !fields[of_state.field].solenoidal) continue;
        double all = 0.0, removed = 0.0;
        for (int k = c; k < c + 2; ++k)
            for (std::size_t m = 1; m < as_given.size; ++m) {
                const double weight = numerics::mode_weight(grid, m % numerics::columns(grid));
                all += weight * std::norm(as_given[k][m]);
                removed += weight * std::norm(as_given[k][m] - without[k][m]);
            }
        if (removed > 1e-6 * all)
            warnings.push_back(
                text("{} is solenoidal, and {:.2g} of the variance of its start has a divergence, which "
                     "is left out; expected none: give v_x = d_y psi and v_y = -d_x psi of a function "
                     "psi",
                     fields[of_state.field].symbol, removed / all));
    }
}
}  // namespace

std::vector<StateComponent> components_of_state(const Equations& equations) {
    return components_with(equations, LeftSide::rate);
}

std::vector<StateComponent> components_in_balance(const Equations& equations) {
    return components_with(equations, LeftSide::balance);
}

void check(const Start& start, const Equations& equations, const numerics::Grid& grid, int degree,
           const Locate& locate) {
    const std::vector<std::string> names = names_of(components_of_state(equations));
    check_kind_of_formulas(start, names, locate);
    require(start.kind != StartKind::file || !start.file.empty(), locate("initial.kind"),
            "initial.kind = \"file\" without initial.file; name the archive");
    const std::vector<std::string> follow = names_of(components_in_balance(equations));
    for (const auto& [name, formula] : start.formulas) {
        require(index_of(name, names) >= 0, locate("initial." + name), "initial.{} is given, {}; expected one of {}",
                name,
                index_of(name, follow) >= 0 ? "and that field is in balance: it follows the others"
                                            : "but the model has no such field",
                joined(names));
        numerics::check(formula_of(name, formula), grid, degree);
    }
    if (start.kind == StartKind::stationary) check_stationary(equations, grid, degree, locate);
    if (start.kind != StartKind::mode) return;
    require(start.component.empty() || index_of(start.component, names) >= 0, locate("initial.field"),
            "initial.field = \"{}\"; expected one of {}", start.component, joined(names));
    check_mode(start, grid, degree, locate);
}

void remove_divergence(const Equations& equations, const numerics::Grid& grid, numerics::Spectra& state) {
    const std::vector<StateComponent> components = components_of_state(equations);
    for (int c = 0; c < state.count(); ++c) {
        const StateComponent& one = components[static_cast<std::size_t>(c)];
        if (one.part != 0 || !equations.model().fields[one.field].solenoidal) continue;
        for (std::size_t row = 0, m = 0; row < static_cast<std::size_t>(grid.ny); ++row)
            for (std::size_t column = 0; column < numerics::columns(grid); ++column, ++m) {
                if (m == 0) continue;
                const numerics::Wavevector q = numerics::wavevector(grid, column, row);
                const numerics::Complex along = (q.x * state[c][m] + q.y * state[c + 1][m]) / (q.x * q.x + q.y * q.y);
                state[c][m] -= q.x * along;
                state[c + 1][m] -= q.y * along;
            }
    }
}

UniformState means_of_start(const Start& start, const Equations& equations, const numerics::Grid& grid) {
    UniformState means = equations.reference();
    const std::vector<std::string> names = names_of(components_of_state(equations));
    Threads one(1);
    numerics::Fields cells(grid, 1);
    for (const auto& [name, formula] : start.formulas) {
        numerics::fill(formula_of(name, formula), grid, one, cells[0]);
        const auto c = static_cast<std::size_t>(index_of(name, names));
        means[static_cast<std::size_t>(equations.state_components()[c])] =
            std::accumulate(cells[0].begin(), cells[0].end(), 0.0) / static_cast<double>(numerics::points(grid));
    }
    return means;
}

std::vector<std::string> start_warnings(const Start& start, const Equations& equations, const numerics::Grid& grid,
                                        int degree) {
    std::vector<std::string> warnings;
    const std::vector<StateComponent> components = components_of_state(equations);
    for (const StateComponent& component : components) {
        const auto found = start.formulas.find(component.name);
        if (start.kind != StartKind::formula || found == start.formulas.end()) continue;
        const std::string warning =
            numerics::warning_of(formula_of(component.name, found->second), component.unit, grid, degree);
        if (!warning.empty()) warnings.push_back(warning);
    }
    if (start.kind == StartKind::formula && start.formulas.empty())
        warnings.push_back(text(
            "initial.kind = \"formula\" without a formula: every field starts at its reference{}; give one, such as "
            "initial.{} = \"cos(2*pi*x/lx)\"",
            start.amplitude > 0.0 ? " with noise" : "", components.front().name));
    warn_of_divergence(start, equations, grid, degree, warnings);
    return warnings;
}

numerics::Spectra start_spectra(const Start& start, const Equations& equations, const numerics::System& system,
                                std::uint64_t seed, Threads& threads) {
    numerics::Spectra state = perturbed(start, equations, system, seed, threads);
    remove_divergence(equations, system.grid, state);
    return state;
}

Rows<Start> Start::rows() {
    return Rows<Start>{
        {"kind", &Start::kind,
         "uniform; random or mode: a perturbation of it; stationary: drawn from the stationary state of the linear "
         "theory; formula: fields as formulas in x, y, lx and ly; file: a frame of an archive, by its Fourier modes "
         "where the grid has other points"},
        {"amplitude", &Start::amplitude,
         "random: standard deviation in each cell (formula: of added noise); mode: amplitude of the cosine",
         "unit of the field", not_negative},
        {"field", &Start::component, "mode: the field that is perturbed"},
        {"mode_x", &Start::mode_x, "mode: wavelengths in the cell along x"},
        {"mode_y", &Start::mode_y, "mode: wavelengths in the cell along y"},
        {"phase", &Start::phase, "mode: phase of the cosine at the origin", "rad"},
        {"file", &Start::file, "file: the archive, relative to the scene"},
        {"frame", &Start::frame, "file: number of the frame from 0; -1 is the last", "", at_least(-1)},
    };
}

}  // namespace drover::model
