// physics/initial_state.cpp: uniform, perturbed and stationary starts.
#include "drover/physics/initial_state.hpp"

#include <algorithm>
#include <array>

namespace drover::physics {

namespace {
struct Formula {
    const char* component;
    std::string InitialState::*written;
};
constexpr std::array formulas{Formula{"bead_density", &InitialState::bead_density},
                              Formula{"rod_density", &InitialState::rod_density},
                              Formula{"bead_velocity_x", &InitialState::bead_velocity_x},
                              Formula{"bead_velocity_y", &InitialState::bead_velocity_y},
                              Formula{"polar_order_x", &InitialState::polar_order_x},
                              Formula{"polar_order_y", &InitialState::polar_order_y}};

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
    std::string cleared;
    for (const auto& [component, written] : formulas) {
        if ((initial.*written).empty()) continue;
        keys.push_back(text("initial.{}", component));
        cleared += text(" --set '{}=\"\"'", keys.back());
    }
    if (keys.empty() || initial.kind == "formula") return;
    fail_input(place(keys.front()),
               "{} {} given with initial.kind = \"{}\"; expected \"formula\"; for another start remove {}, or "
               "override {}:{}",
               joined(keys), keys.size() == 1 ? "is" : "are", initial.kind, keys.size() == 1 ? "it" : "them",
               keys.size() == 1 ? "it" : "them", cleared);
}
}  // namespace

model::Start start_of(const InitialState& initial, const LocationOf& place) {
    model::Start start{.kind = initial.kind,
                       .amplitude = initial.amplitude,
                       .component = initial.field,
                       .mode_x = initial.mode_x,
                       .mode_y = initial.mode_y,
                       .phase = initial.phase};
    for (const auto& [component, written] : formulas) {
        if ((initial.*written).empty()) continue;
        SourceLocation where = place(text("initial.{}", component));
        where.column = 0;  // the column is that of the key
        start.formulas.emplace(component, model::Text{initial.*written, where});
    }
    return start;
}

void check(const InitialState& initial, const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing,
           const LocationOf& place) {
    if (initial.kind == "file")
        require(!initial.file.empty(), place("initial.kind"),
                "initial.kind = \"file\" without initial.file; name the archive");
    check_kind_of_formulas(initial, place);
    if (initial.kind == "stationary") return check_stationary(model, grid, dealiasing, place);
    if (initial.kind != "formula" && initial.kind != "mode") return;
    std::vector<std::string> names;
    for (const Component& component : component_names(form(model))) names.push_back(component.name);
    const model::Start start = start_of(initial, place);
    for (const auto& [component, formula] : start.formulas)
        require(std::find(names.begin(), names.end(), component) != names.end(), place(text("initial.{}", component)),
                "initial.{} is given, but the model has no such field; expected one of {}", component, joined(names));
    const Equations equations(model);
    model::check(start, equations.solver(reference(model.uniform)), grid, kept_degree(equations, dealiasing), place);
}

numerics::Spectra initial_spectra(const InitialState& initial, const Model& model, const numerics::System& system,
                                  std::uint64_t seed, Threads& threads) {
    return model::start_spectra(start_of(initial), Equations(model).solver(reference(model.uniform)), system, seed,
                                threads);
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
