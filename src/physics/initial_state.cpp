// physics/initial_state.cpp: uniform, perturbed and stationary starts.
#include "drover/physics/initial_state.hpp"

#include <complex>
#include <cstdlib>
#include <tuple>

#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"

namespace drover::physics {

namespace {
using numerics::Complex;

void add_random(const InitialState& initial, const numerics::System& system, std::uint64_t seed, Threads& threads,
                numerics::Spectra& state) {
    numerics::Fields cells(system.grid, state.count());
    for (int c = 0; c < state.count(); ++c) {
        const RandomKey key{.seed = seed, .stream = Stream::initial_state, .substep = static_cast<std::uint32_t>(c)};
        fill_normal(key, 0, 1, cells[c]);
        for (double& value : cells[c]) value *= initial.amplitude;
    }
    numerics::Spectra noise(system.grid, state.count());
    numerics::Transform(system.grid, system.degree, threads).forward(cells, noise);
    for (int c = 0; c < system.layout.scalars; ++c) noise[c][0] = 0.0;
    for (std::size_t m = 0; m < state.values.size(); ++m) state.values[m] += noise.values[m];
}

int component_of(const std::string& name, const Form& form) {
    const std::vector<Component> components = component_names(form);
    for (std::size_t c = 0; c < components.size(); ++c)
        if (components[c].name == name) return static_cast<int>(c);
    return -1;
}

void add_mode(const InitialState& initial, const Form& form, const numerics::System& system, numerics::Spectra& state) {
    const int c = component_of(initial.field, form);
    // A real mode is its own conjugate at -q: the half with kx >= 0 is stored.
    const int sign = initial.mode_x < 0 ? -1 : 1, kx = sign * initial.mode_x, ky = sign * initial.mode_y;
    const std::size_t width = numerics::columns(system.grid), rows = static_cast<std::size_t>(system.grid.ny);
    const auto column = static_cast<std::size_t>(kx);
    const auto row = static_cast<std::size_t>(ky < 0 ? ky + system.grid.ny : ky);
    const Complex half = 0.5 * std::polar(initial.amplitude, sign * initial.phase);
    state[c][row * width + column] += half;
    if (column == 0) state[c][(rows - row) % rows * width] += std::conj(half);
}
}  // namespace

void check(const InitialState& initial, const Model& model, const numerics::Grid& grid, const PlaceOf& place) {
    if (initial.kind == "stationary") {
        require(model.noise.order > 0.0, place("initial.kind"),
                "initial.kind = \"stationary\" with noise.order = {}; a stationary state needs noise: give noise.order "
                "> 0, "
                "or another start",
                model.noise.order);
        const FastestGrowth growth = fastest_growth(make_system(model, grid));
        require(growth.rate < 0.0, place("initial.kind"),
                "initial.kind = \"stationary\", but there is no stationary state: a linear mode grows at {:.4g} /s at "
                "|q| = {:.3g} "
                "/mm; expected every mode to decay: choose another start",
                growth.rate, growth.q);
    }
    if (initial.kind == "file")
        require(!initial.file.empty(), place("initial.kind"),
                "initial.kind = \"file\" without initial.file; name the archive");
    if (initial.kind != "mode") return;
    std::vector<std::string> names;
    for (const Component& component : component_names(form(model))) names.push_back(component.name);
    require(component_of(initial.field, form(model)) >= 0, place("initial.field"),
            "initial.field = \"{}\"; expected one of {}", initial.field, joined(names));
    for (const auto& [name, number, size] :
         {std::tuple{"mode_x", initial.mode_x, grid.nx}, std::tuple{"mode_y", initial.mode_y, grid.ny}})
        require(std::abs(std::int64_t{number}) < size / 2, place(text("initial.{}", name)),
                "initial.{} = {}; expected less than {} in size, half the points of that axis", name, number, size / 2);
}

numerics::Spectra initial_spectra(const InitialState& initial, const Model& model, const numerics::System& system,
                                  std::uint64_t seed, Threads& threads) {
    check(initial, model, system.grid);
    const Form fields = form(model);
    numerics::Spectra state(system.grid, numerics::components(system.layout));
    if (initial.kind == "stationary")
        numerics::draw_stationary(system, {.seed = seed, .stream = Stream::stationary_state}, state);
    state[fields.rod_density][0] += model.uniform.rod_density;
    if (initial.kind == "random") add_random(initial, system, seed, threads, state);
    if (initial.kind == "mode") add_mode(initial, fields, system, state);
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
         .choices = {"uniform", "random", "mode", "stationary", "file"},
         .sentence =
             "uniform; random or mode: a perturbation of it; stationary: drawn from the stationary law of the linear "
             "theory; file: a frame of an archive"},
        {.name = "amplitude",
         .member = &InitialState::amplitude,
         .unit = "unit of the field",
         .range = not_negative,
         .sentence = "random: standard deviation in each cell; mode: amplitude of the cosine"},
        {.name = "field", .member = &InitialState::field, .sentence = "mode: the field that is perturbed"},
        {.name = "mode_x", .member = &InitialState::mode_x, .sentence = "mode: wavelengths in the cell along x"},
        {.name = "mode_y", .member = &InitialState::mode_y, .sentence = "mode: wavelengths in the cell along y"},
        {.name = "phase",
         .member = &InitialState::phase,
         .unit = "rad",
         .sentence = "mode: phase of the cosine at the origin"},
        {.name = "file", .member = &InitialState::file, .sentence = "file: the archive, sought beside the scene"},
        {.name = "frame",
         .member = &InitialState::frame,
         .range = {.least = -1},
         .sentence = "file: number of the frame from 0; -1 is the last"}};
    return rows;
}

}  // namespace drover
