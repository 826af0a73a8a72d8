// physics/initial_state.cpp: uniform, perturbed and stationary starts.
#include "drover/physics/initial_state.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <tuple>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/perturbation.hpp"
#include "numerics/start_formula.hpp"

namespace drover::physics {

namespace {
int component_of(const std::string& name, const Form& form) {
    const std::vector<Component> components = component_names(form);
    for (std::size_t c = 0; c < components.size(); ++c)
        if (components[c].name == name) return static_cast<int>(c);
    return -1;
}

numerics::CosineMode mode_of(const InitialState& initial) {
    return {.x = initial.mode_x, .y = initial.mode_y, .amplitude = initial.amplitude, .phase = initial.phase};
}

constexpr std::array component_keys{"bead_density",    "rod_density",   "bead_velocity_x",
                                    "bead_velocity_y", "polar_order_x", "polar_order_y"};

/// The formula of a component with its key; "" if it is not set.
std::pair<const char*, const std::string*> formula_of(const InitialState& initial, const std::string& component) {
    for (const auto& [name, key, written] :
         {std::tuple{"bead_density", "initial.bead_density", &initial.bead_density},
          std::tuple{"rod_density", "initial.rod_density", &initial.rod_density},
          std::tuple{"bead_velocity_x", "initial.bead_velocity_x", &initial.bead_velocity_x},
          std::tuple{"bead_velocity_y", "initial.bead_velocity_y", &initial.bead_velocity_y},
          std::tuple{"polar_order_x", "initial.polar_order_x", &initial.polar_order_x},
          std::tuple{"polar_order_y", "initial.polar_order_y", &initial.polar_order_y}})
        if (component == name) return {key, written};
    static const std::string none;
    return {"", &none};
}

numerics::StartFormula formula_at(const char* key, const std::string& written, SourceLocation where = {}) {
    where.column = 0;  // the column is that of the key
    return numerics::read_start_formula(key, written, where);
}

void set_formulas(const InitialState& initial, const Form& form, const numerics::System& system, Threads& threads,
                  numerics::Spectra& state) {
    const numerics::Grid& grid = system.grid;
    const std::vector<Component> components = component_names(form);
    numerics::Fields cells(grid, state.count());
    numerics::Spectra made(grid, state.count());
    for (int c = 0; c < state.count(); ++c) {
        const auto [key, written] = formula_of(initial, components[static_cast<std::size_t>(c)].name);
        if (written->empty()) continue;
        numerics::fill(formula_at(key, *written), grid, threads, cells[c]);
    }
    numerics::Transform(grid, system.degree, threads).forward(cells, made);
    for (int c = 0; c < state.count(); ++c)
        if (!formula_of(initial, components[static_cast<std::size_t>(c)].name).second->empty())
            std::copy(made[c].begin(), made[c].end(), state[c].begin());
}
}  // namespace

namespace {
void check_stationary(const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing,
                      const LocationOf& place) {
    require(
        model.noise.order > 0.0, place("initial.kind"),
        "initial.kind = \"stationary\" with noise.order = {}; a stationary state needs noise: give noise.order > 0, "
        "or choose another initial.kind",
        model.noise.order);
    const Equations equations(model);
    const std::vector<std::string> beyond = terms_beyond_propagator(equations);
    require(
        beyond.empty(), place("initial.kind"),
        "initial.kind = \"stationary\" draws from the isotropic linear theory, and {} depend on direction, position "
        "or time, have no derivative, or are explicit; expected none: choose another initial.kind",
        joined(beyond));
    require(
        equations.uniform_forces(at_rest(reference(model.uniform))).isZero(0.0), place("initial.kind"),
        "initial.kind = \"stationary\" draws about the state without order at rest, which a force or a field of this "
        "model does not leave at rest; choose another initial.kind");
    const FastestGrowth growth = fastest_growth(linear_system(model, grid, dealiasing));
    require(growth.rate < 0.0, place("initial.kind"),
            "initial.kind = \"stationary\", but there is no stationary state: a linear mode grows at {:.4g} /s at |q| "
            "= {:.3g} /mm; expected every mode to decay; choose another initial.kind",
            growth.rate, growth.q);
}
/// Formulas belong to the kind "formula"; the message names all, since a scene often gives several.
void check_kind_of_formulas(const InitialState& initial, const LocationOf& place) {
    std::vector<std::string> keys;
    for (const char* component : component_keys)
        if (const auto [key, written] = formula_of(initial, component); !written->empty()) keys.emplace_back(key);
    if (keys.empty() || initial.kind == "formula") return;
    std::string cleared;
    for (const std::string& key : keys) cleared += text(" --set '{}=\"\"'", key);
    fail_input(place(keys.front()),
               "{} {} given with initial.kind = \"{}\"; expected \"formula\"; for another start remove {}, or "
               "override {}:{}",
               joined(keys), keys.size() == 1 ? "is" : "are", initial.kind, keys.size() == 1 ? "it" : "them",
               keys.size() == 1 ? "it" : "them", cleared);
}
}  // namespace

void check(const InitialState& initial, const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing,
           const LocationOf& place) {
    if (initial.kind == "stationary") check_stationary(model, grid, dealiasing, place);
    if (initial.kind == "file")
        require(!initial.file.empty(), place("initial.kind"),
                "initial.kind = \"file\" without initial.file; name the archive");
    check_kind_of_formulas(initial, place);
    std::vector<std::string> names;
    for (const Component& component : component_names(form(model))) names.push_back(component.name);
    for (const char* component : component_keys) {
        const auto [key, written] = formula_of(initial, component);
        if (written->empty()) continue;
        require(std::find(names.begin(), names.end(), component) != names.end(), place(key),
                "{} is given, but the model has no such field; expected one of {}", key, joined(names));
        numerics::check(formula_at(key, *written, place(key)), grid, kept_degree(Equations(model), dealiasing));
    }
    if (initial.kind != "mode") return;
    require(component_of(initial.field, form(model)) >= 0, place("initial.field"),
            "initial.field = \"{}\"; expected one of {}", initial.field, joined(names));
    numerics::check(mode_of(initial), grid, kept_degree(Equations(model), dealiasing), place);
}

std::vector<std::string> initial_warnings(const InitialState& initial, const Model& model, const numerics::Grid& grid,
                                          const Dealiasing& dealiasing) {
    std::vector<std::string> warnings;
    if (initial.kind != "formula") return warnings;
    const int degree = kept_degree(Equations(model), dealiasing);
    for (const Component& component : component_names(form(model))) {
        const auto [key, written] = formula_of(initial, component.name);
        if (written->empty()) continue;
        const std::string warning = numerics::warning_of(formula_at(key, *written), component.unit, grid, degree);
        if (!warning.empty()) warnings.push_back(warning);
    }
    return warnings;
}

numerics::Spectra initial_spectra(const InitialState& initial, const Model& model, const numerics::System& system,
                                  std::uint64_t seed, Threads& threads) {
    const Form fields = form(model);
    numerics::Spectra state(system.grid, numerics::components(system.layout));
    if (initial.kind == "stationary")
        numerics::draw_stationary(system, {.seed = seed, .stream = Stream::stationary_state}, state);
    if (fields.bead_density >= 0) state[fields.bead_density][0] += model.uniform.bead_density;
    if (fields.rod_density >= 0) state[fields.rod_density][0] += model.uniform.rod_density;
    if (initial.kind == "formula") set_formulas(initial, fields, system, threads, state);
    if (initial.kind == "random" || (initial.kind == "formula" && initial.amplitude > 0.0))
        numerics::add_random(system, initial.amplitude, seed, threads, state);
    if (initial.kind == "mode")
        numerics::add_mode(system.grid, mode_of(initial), component_of(initial.field, fields), state);
    return state;
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::InitialState>>& schema<physics::InitialState>() {
    using physics::InitialState;
    static const std::vector<Row<InitialState>> rows{
        {.name = "kind",
         .member = &InitialState::kind,
         .choices = {"uniform", "random", "mode", "stationary", "formula", "file"},
         .doc =
             "uniform; random or mode: a perturbation of it; stationary: drawn from the stationary state of the linear "
             "theory; formula: fields as formulas in x, y, lx and ly; file: a frame of an archive, by its Fourier "
             "modes "
             "where the grid has other points"},
        {.name = "amplitude",
         .member = &InitialState::amplitude,
         .unit = "unit of the field",
         .range = not_negative,
         .doc = "random: standard deviation in each cell (formula: of added noise); mode: amplitude of the cosine"},
        {.name = "field", .member = &InitialState::field, .doc = "mode: the field that is perturbed"},
        {.name = "mode_x", .member = &InitialState::mode_x, .doc = "mode: wavelengths in the cell along x"},
        {.name = "mode_y", .member = &InitialState::mode_y, .doc = "mode: wavelengths in the cell along y"},
        {.name = "phase",
         .member = &InitialState::phase,
         .unit = "rad",
         .doc = "mode: phase of the cosine at the origin"},
        {.name = "bead_density",
         .member = &InitialState::bead_density,
         .unit = "1/mm^2",
         .doc = "formula: rho, such as \"2 + 0.1 * exp(-((x - 8)^2 + (y - 8)^2) / 4)\", in mm; empty: uniform"},
        {.name = "rod_density", .member = &InitialState::rod_density, .unit = "1/mm^2", .doc = "formula: sigma"},
        {.name = "bead_velocity_x", .member = &InitialState::bead_velocity_x, .unit = "mm/s", .doc = "formula: v_x"},
        {.name = "bead_velocity_y", .member = &InitialState::bead_velocity_y, .unit = "mm/s", .doc = "formula: v_y"},
        {.name = "polar_order_x", .member = &InitialState::polar_order_x, .unit = "[p]", .doc = "formula: p_x"},
        {.name = "polar_order_y", .member = &InitialState::polar_order_y, .unit = "[p]", .doc = "formula: p_y"},
        {.name = "file", .member = &InitialState::file, .doc = "file: the archive, relative to the scene"},
        {.name = "frame",
         .member = &InitialState::frame,
         .range = {.min = -1},
         .doc = "file: number of the frame from 0; -1 is the last"}};
    return rows;
}

}  // namespace drover
