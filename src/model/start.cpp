// model/start.cpp: perturbed and stationary starts.
#include "drover/model/start.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "drover/base/expression.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/formula_on_grid.hpp"
#include "numerics/perturbation.hpp"

namespace drover::model {

namespace {
constexpr double max_variance_cut = 1e-3;  // a formula is resolved to 3 % of its root mean square
constexpr double max_edge_jump = 0.01;     // of the range of the formula in the cell

Expression in_x_and_y(const Text& formula) {
    return parse_expression(formula.text, {.variables = {{"x", 0}, {"y", 1}}}, formula.where);
}

std::vector<std::string> names_of(const std::vector<StateComponent>& components) {
    std::vector<std::string> names;
    for (const StateComponent& one : components) names.push_back(one.name);
    return names;
}

/// The index of a component of a state; -1 if there is none of that name.
int index_of(const std::string& name, const std::vector<std::string>& names) {
    const auto found = std::find(names.begin(), names.end(), name);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

std::string finer_grid(const Expression& formula, const numerics::Grid& grid, int degree) {
    const numerics::Grid finer = numerics::grid_that_resolves(formula, grid, degree, max_variance_cut);
    std::string words;
    if (finer.nx != grid.nx) words = text("grid.nx = {}", finer.nx);
    if (finer.ny != grid.ny) words += text("{}grid.ny = {}", words.empty() ? "" : " and ", finer.ny);
    return words.empty() ? "make it smoother" : "choose " + words + " or make it smoother";
}

void check_formula(const std::string& key, const Text& written, const numerics::Grid& grid, int degree) {
    const Expression formula = in_x_and_y(written);
    const double cut = numerics::fraction_cut(formula, grid, degree);
    if (!std::isfinite(cut)) {
        Threads one(1);
        numerics::Fields cells(grid, 1);
        const std::size_t cell = numerics::fill_cells(formula, grid, one, cells[0]);
        const auto nx = static_cast<std::size_t>(grid.nx);
        if (cell < cells.size)
            fail_input(written.where, "{} = \"{}\" is {} in cell ({}, {}); expected a finite number in every cell", key,
                       written.text, cells[0][cell], cell % nx, cell / nx);
    }
    require(!(cut > 0.5), written.where,
            "{} = \"{}\": the grid cuts {:.3g} of its variance; expected less than half: {}", key, written.text, cut,
            cut > 0.5 ? finer_grid(formula, grid, degree) : "");
}

void check_mode(const Start& start, const std::vector<std::string>& names, const numerics::Grid& grid, int degree,
                const LocationOf& place) {
    require(start.component.empty() || index_of(start.component, names) >= 0, place("initial.field"),
            "initial.field = \"{}\"; expected one of {}", start.component, joined(names));
    const int parts = degree + 1;
    for (const auto& [name, number, size] :
         {std::tuple{"mode_x", start.mode_x, grid.nx}, std::tuple{"mode_y", start.mode_y, grid.ny}})
        require(std::abs(std::int64_t{number}) * parts < size, place(text("initial.{}", name)),
                "initial.{} = {}; expected a magnitude less than {:.4g}: the grid keeps modes below 1/{} of the points "
                "of that axis",
                name, number, static_cast<double>(size) / parts, parts);
}
}  // namespace

std::vector<StateComponent> components_of_state(const Equations& equations) {
    std::vector<StateComponent> result;
    for (std::size_t n = 0; n < equations.model().fields.size(); ++n) {
        const Field& field = equations.model().fields[n];
        if (field.left == LeftSide::balance) continue;
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

void check(const Start& start, const Equations& equations, const numerics::Grid& grid, int degree,
           const LocationOf& place) {
    const std::vector<std::string> names = names_of(components_of_state(equations));
    require(start.formulas.empty() || start.kind == "formula", place("initial.kind"),
            "initial.{} is given with initial.kind = \"{}\"; expected \"formula\"",
            start.formulas.empty() ? "" : start.formulas.begin()->first, start.kind);
    for (const auto& [name, formula] : start.formulas) {
        require(index_of(name, names) >= 0, formula.where,
                "initial.{} is given, and that field is in balance: it follows the others; expected one of {}", name,
                joined(names));
        check_formula("initial." + name, formula, grid, degree);
    }
    if (start.kind == "mode") check_mode(start, names, grid, degree, place);
    require(start.kind != "stationary" || equations.has_noise(), place("initial.kind"),
            "initial.kind = \"stationary\" of a model without noise; a stationary state needs noise: give a field "
            "noise, or choose another initial.kind");
}

std::vector<std::string> start_warnings(const Start& start, const Equations& equations, const numerics::Grid& grid,
                                        int degree) {
    std::vector<std::string> warnings;
    const std::vector<StateComponent> components = components_of_state(equations);
    for (const StateComponent& component : components) {
        const auto found = start.formulas.find(component.name);
        if (start.kind != "formula" || found == start.formulas.end()) continue;
        const Expression formula = in_x_and_y(found->second);
        if (const numerics::EdgeJump jump = numerics::edge_jump(formula, grid);
            jump.size > max_edge_jump * jump.range && jump.range > 0.0) {
            warnings.push_back(text(
                "initial.{} = \"{}\" jumps by {:.3g} {} at the periodic edge {} = 0, at {} = {:.4g} mm: the waves of "
                "the grid overshoot there; write a formula with the periods of the cell, grid.lx = {} and grid.ly = {}",
                component.name, found->second.text, jump.size, component.unit, jump.axis, jump.axis == 'x' ? 'y' : 'x',
                jump.at, grid.lx, grid.ly));
        } else if (const double cut = numerics::fraction_cut(formula, grid, degree); cut > max_variance_cut) {
            warnings.push_back(
                text("initial.{} = \"{}\": the grid cuts {:.2g} of its variance; expected less than {}: {}",
                     component.name, found->second.text, cut, max_variance_cut, finer_grid(formula, grid, degree)));
        }
    }
    return warnings;
}

namespace {
void set_formulas(const Start& start, const std::vector<std::string>& names, const numerics::System& system,
                  Threads& threads, numerics::Spectra& state) {
    numerics::Fields cells(system.grid, state.count());
    numerics::Spectra made(system.grid, state.count());
    for (const auto& [name, formula] : start.formulas)
        static_cast<void>(
            numerics::fill_cells(in_x_and_y(formula), system.grid, threads, cells[index_of(name, names)]));
    numerics::Transform(system.grid, system.degree, threads).forward(cells, made);
    for (const auto& [name, formula] : start.formulas) {
        const int c = index_of(name, names);
        std::copy(made[c].begin(), made[c].end(), state[c].begin());
    }
}
}  // namespace

numerics::Spectra start_spectra(const Start& start, const Equations& equations, const numerics::System& system,
                                std::uint64_t seed, Threads& threads) {
    const std::vector<std::string> names = names_of(components_of_state(equations));
    numerics::Spectra state(system.grid, static_cast<int>(names.size()));
    if (start.kind == "stationary")
        numerics::draw_stationary(system, {.seed = seed, .stream = Stream::stationary_state}, state);
    const UniformState reference = equations.reference();
    for (int c = 0; c < state.count(); ++c)
        state[c][0] += reference[static_cast<std::size_t>(equations.state_components()[static_cast<std::size_t>(c)])];
    if (start.kind == "formula") set_formulas(start, names, system, threads, state);
    if (start.kind == "random" || (start.kind == "formula" && start.amplitude > 0.0))
        numerics::add_random(system, start.amplitude, seed, threads, state);
    if (start.kind == "mode")
        numerics::add_mode(system.grid,
                           {.x = start.mode_x, .y = start.mode_y, .amplitude = start.amplitude, .phase = start.phase},
                           start.component.empty() ? 0 : index_of(start.component, names), state);
    return state;
}

}  // namespace drover::model
