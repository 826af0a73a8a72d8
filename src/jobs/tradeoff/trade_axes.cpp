// jobs/tradeoff/trade_axes.cpp: levels of step, grid, model and cell.
#include "jobs/tradeoff/trade_axes.hpp"

#include <algorithm>

#include "dem/contact/contact_law.hpp"
#include "drover/base/error.hpp"
#include "io/declared_model.hpp"
#include "io/scene.hpp"
#include "numerics/steppers/time_method.hpp"
#include "physics/integrated.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/simulation_type.hpp"

namespace drover::jobs {

namespace {

/// A step of particles; of fields a method with steps of dt, or with `tolerance` where that is not 0.
AxisLevel step_level(const io::Scene& scene, const std::string& method, double dt, double tolerance = 0.0) {
    const std::string step = io::in_unit("{:.12g}", dt, "s", scene.units);
    if (!io::has_grid(scene.kind)) {
        const dem::ContactControl& contacts = scene.particles.contacts;
        AxisLevel level{"dt = " + step, {set("time.dt", dt)}};
        const double factor = dt / scene.time.dt;
        if (dem::PairwiseLaw::is_chosen(contacts))
            level.overrides.push_back(set("contacts.rod_step", factor * contacts.rod_step));
        else if (contacts.model == dem::ContactModel::impulse)
            level.overrides.push_back(set("contacts.substep", factor * contacts.substep));
        return level;
    }
    AxisLevel level{tolerance > 0.0 ? text("{}, tolerance {:.2g}", method, tolerance)
                                    : text("{}, dt = {}", method, step),
                    {text("time.stepper={}", method), set("time.dt", dt), set("time.tolerance", tolerance)}};
    if (tolerance == 0.0 && dt > scene.output.sample_every) {
        level.sample_every = dt;
        level.overrides.push_back(set("output.sample_every", dt));
    }
    return level;
}

void add_if_allowed(const io::Scene& scene, const AxisLevel& level, StepLadder& ladder) {
    if (!reason_against(scene, level.overrides)) ladder.levels.push_back(level);
}

StepLadder dt_ladder(const io::Scene& scene, const std::string& method) {
    StepLadder ladder{.method = method, .levels = {}};
    // Of particles, whose outputs are whole numbers of decimal steps, 5 and 2.5 too.
    for (const double times :
         io::has_grid(scene.kind) ? std::vector{8.0, 4.0, 2.0, 1.0} : std::vector{5.0, 2.5, 2.0, 1.0})
        add_if_allowed(scene, step_level(scene, method, scene.time.dt * times), ladder);
    return ladder;
}

StepLadder tolerance_ladder(const io::Scene& scene, const std::string& method, double dt, double largest,
                            double smallest) {
    StepLadder ladder{.method = method + " by tolerance", .levels = {}, .order = 1.0, .shorter = 10.0};
    for (double tolerance = largest; tolerance > 0.5 * smallest; tolerance *= 0.1)
        add_if_allowed(scene, step_level(scene, method, dt, tolerance), ladder);
    return ladder;
}

/// The override that takes a coefficient out of a scene.
std::vector<std::string> without(const physics::CoefficientRow& row) {
    std::vector<std::string> overrides{row.key() + "=0.0"};
    if (row.varies) overrides.push_back(row.key() + "_terms=[]");
    return overrides;
}

void add_all(std::vector<std::string>& to, const std::vector<std::string>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// Without the formulas of a start for a field.
void add_cleared_start(const io::Scene& scene, const physics::FieldRow& field, std::vector<std::string>& overrides) {
    const auto formulas = scene.initial.formulas;
    for (const std::string& component : model::dataset_names(field.as_field()))
        if (formulas.contains(component)) overrides.push_back("initial." + component + "=\"\"");
}

/// Without a field, and without the coefficients and the start that need it.
std::vector<std::string> without_field(const io::Scene& scene, const physics::FieldRow& field) {
    std::vector<std::string> overrides{field.present + "=false"};
    for (const physics::CoefficientRow& row : scene.model.file->coefficients)
        if (std::ranges::find(row.needs, field.symbol) != row.needs.end() && is_given(scene.model, row))
            add_all(overrides, without(row));
    add_cleared_start(scene, field, overrides);
    return overrides;
}

/// With a field in balance that has a mass.
std::vector<std::string> in_balance(const io::Scene& scene, const physics::FieldRow& field) {
    std::vector<std::string> overrides{field.present + "=slaved"};
    add_cleared_start(scene, field, overrides);
    for (const physics::KeyRow& row : scene.model.file->keys)
        if (row.needs_rate && row.needs == field.symbol)
            overrides.push_back(row.key() + "=" + toml_text(row.description.default_value));
    return overrides;
}

void add_particle_models(const io::Scene& scene, std::vector<AxisLevel>& levels) {
    const dem::ContactControl& contacts = scene.particles.contacts;
    if (contacts.model == dem::ContactModel::impulse && contacts.law == dem::GroupLaw::simultaneous) {
        const dem::ContactControl usual;
        levels.push_back({"contacts one after another",
                          {"contacts.law=approaching-first", set("contacts.increments", usual.increments),
                           set("contacts.inelastic_threshold", usual.inelastic_threshold)}});
        levels.push_back({"half the increments", {set("contacts.increments", std::max(1, contacts.increments / 2))}});
    }
    levels.push_back({"without a lid", {"plates.lid=false"}});
}

void add_declared_models(const io::DeclaredModel& declared, std::vector<AxisLevel>& levels) {
    for (const auto& [name, value] : declared.coefficients)
        if (value != 0.0) levels.push_back({"without " + name, {set("coefficients." + name, 0.0)}});
    const model::Model model = io::model_of(declared);
    for (std::size_t k = 0, n = 0; k < declared.fields.size();
         ++k, n += model.fields[n].part == model::Part::real ? 2 : 1)
        if (model.fields[n].noise != 0.0)
            levels.push_back({"without the noise of " + declared.fields[k].symbol, {text("field[{}].noise=0", k + 1)}});
}

void add_keyed_models(const io::Scene& scene, std::vector<AxisLevel>& levels) {
    const physics::ModelValues& model = scene.model;
    for (const physics::FieldRow& field : model.file->fields)
        if (!field.mass.empty() && presence(model, field) == physics::Presence::rate)
            levels.push_back({"slaved " + field.observed.short_name, in_balance(scene, field)});
    for (const physics::FieldRow& field : model.file->fields) {
        if (field.reference.empty() || presence(model, field) == physics::Presence::absent) continue;
        physics::ModelValues other = model;
        other.values[field.present] = false;
        if (is_named_form(other)) levels.push_back({form_name(other), without_field(scene, field)});
    }
    for (const physics::CoefficientRow& row : model.file->coefficients) {
        const bool may_be_zero = row.range.min < 0.0 || (row.range.min == 0.0 && !row.range.min_open);
        if (is_given(model, row) && may_be_zero) levels.push_back({"without " + row.key(), without(row)});
    }
}

/// On the modes of the full model: with others two models differ in their grids, too.
void keep_modes_of(const io::Scene& scene, AxisLevel& level) {
    const int degree = run::integrated_of(scene).kept_degree;
    if (run::integrated_of(io::changed(scene, level.overrides)).kept_degree < degree)
        level.overrides.push_back(set("dealiasing.degree", degree));
}
}  // namespace

std::string set(const std::string& key, double value) { return key + "=" + toml_text(value); }
std::string set(const std::string& key, int value) { return text("{}={}", key, value); }

std::optional<std::string> reason_against(const io::Scene& scene, const std::vector<std::string>& overrides) {
    try {
        io::changed(scene, overrides);
        return std::nullopt;
    } catch (const Error& error) {
        if (!is_of_scene(error.fault())) throw;
        return error.what();
    }
}

bool is_given(const AxisLevel& level) { return level.overrides.empty(); }

std::vector<StepLadder> step_ladders(const io::Scene& scene) {
    if (!io::has_grid(scene.kind)) return {dt_ladder(scene, "")};
    std::vector<StepLadder> ladders;
    const std::string given = scene.time.stepper;
    const bool noisy = io::has_noise(scene);
    if (scene.time.tolerance > 0.0)
        ladders.push_back(tolerance_ladder(scene, given, scene.time.dt, std::min(0.1, 100.0 * scene.time.tolerance),
                                           scene.time.tolerance));
    std::vector<std::string> methods{"etdrk2", "etdrk4-krogstad"};
    if (!noisy) methods.emplace_back("etd-abm4");
    if (scene.time.tolerance == 0.0 && !numerics::time_method(given).needs_tolerance) {
        std::erase(methods, given);
        methods.insert(methods.begin(), given);
    }
    for (const std::string& method : methods) ladders.push_back(dt_ladder(scene, method));
    if (!noisy)
        for (const std::string method : {"etdrk4-krogstad", "cvode-bdf"})
            if (method != given || scene.time.tolerance == 0.0)
                ladders.push_back(tolerance_ladder(scene, method, io::longest_step(scene), 1e-1, 1e-3));
    const bool has_products = noisy && run::equations_of(scene).has_product_noise();
    for (StepLadder& ladder : ladders)
        if (has_products) ladder.order = 1.0;
        else if (!noisy && ladder.shorter == 2.0) ladder.order = numerics::time_method(ladder.method).order;
    std::erase_if(ladders, [](const StepLadder& ladder) { return ladder.levels.empty(); });
    return ladders;
}

void add_shorter(const io::Scene& scene, StepLadder& ladder, int count) {
    for (int n = 0; n < count; ++n) {
        const io::Scene finest = io::changed(scene, ladder.levels.back().overrides);
        const bool is_of_dt = ladder.shorter == 2.0;
        const std::size_t before = ladder.levels.size();
        add_if_allowed(scene,
                       step_level(scene, finest.time.stepper, finest.time.dt / (is_of_dt ? ladder.shorter : 1.0),
                                  is_of_dt ? 0.0 : finest.time.tolerance / ladder.shorter),
                       ladder);
        if (ladder.levels.size() == before) return;
    }
}

bool has_random_start(const io::Scene& scene) {
    return scene.initial.kind == model::StartKind::random ||
           (scene.initial.kind == model::StartKind::formula && scene.initial.amplitude > 0.0);
}

AxisLevel grid_level(const io::Scene& scene, int nx, int ny) {
    AxisLevel level{.name = text("{} by {}", nx, ny), .overrides = {}, .name_of_row = text("{} by 1", nx)};
    if (nx != scene.grid.nx) level.overrides = {set("grid.nx", nx), set("grid.ny", ny)};
    return level;
}

std::vector<AxisLevel> grid_levels(const io::Scene& scene, bool same_start) {
    if (!io::has_grid(scene.kind)) return {{"the cell", {}}};
    std::vector<AxisLevel> levels;
    const bool comparable = !same_start || !has_random_start(scene);
    constexpr int fewest = 16;
    const std::size_t warnings = run::simulation_type_of(scene).warnings(scene).size();
    for (const int part : {4, 2}) {
        const int nx = scene.grid.nx / part, ny = scene.grid.ny == 1 ? 1 : scene.grid.ny / part;
        if (!comparable || nx < fewest || (ny != 1 && ny < fewest)) continue;
        const AxisLevel level = grid_level(scene, nx, ny);
        if (reason_against(scene, level.overrides)) continue;
        if (run::simulation_type_of(scene).warnings(io::changed(scene, level.overrides)).size() <= warnings)
            levels.push_back(level);
    }
    levels.push_back(grid_level(scene, scene.grid.nx, scene.grid.ny));
    if (comparable) levels.push_back(grid_level(scene, 2 * scene.grid.nx, scene.grid.ny == 1 ? 1 : 2 * scene.grid.ny));
    return levels;
}

std::vector<AxisLevel> model_levels(const io::Scene& scene) {
    std::vector<AxisLevel> levels{{"full", {}}};
    if (io::has_grid(scene.kind) && scene.grid.ny > 1)
        levels.push_back({.name = "one-dimensional", .overrides = {set("grid.ny", 1)}, .has_one_row = true});
    switch (scene.kind) {
        case io::SceneKind::particles: add_particle_models(scene, levels); break;
        case io::SceneKind::model: add_declared_models(scene.declared, levels); break;
        case io::SceneKind::fields: add_keyed_models(scene, levels); break;
    }
    // Saves no time, but tells whether the waves act on each other.
    if (io::has_grid(scene.kind) && !scene.approximation.quasi_linear && run::equations_of(scene).has_nonlinear_part())
        levels.push_back(
            {.name = "quasi-linear", .overrides = {"approximation.quasi_linear=true"}, .saves_no_time = true});
    for (AxisLevel& level : levels) {
        level.reason = reason_against(scene, level.overrides);
        if (level.reason && scene.approximation.counterterm) {  // without noise or saturation it is of nothing
            level.overrides.emplace_back("approximation.counterterm=false");
            level.reason = reason_against(scene, level.overrides);
        }
        if (io::has_grid(scene.kind) && !level.reason) keep_modes_of(scene, level);
    }
    return levels;
}

std::optional<AxisLevel> larger_cell(const io::Scene& scene) {
    if (!io::has_grid(scene.kind)) {
        const dem::Setup& setup = scene.particles;
        if (!dem::is_periodic(setup.cell)) return {};
        AxisLevel level{"twice the sides", {set("cell.lx", 2.0 * setup.cell.lx), set("cell.ly", 2.0 * setup.cell.ly)}};
        if (setup.beads.count > 0) level.overrides.push_back(set("beads.count", 4 * setup.beads.count));
        if (setup.rods.count > 0) level.overrides.push_back(set("rods.count", 4 * setup.rods.count));
        return level;
    }
    if (scene.initial.kind == model::StartKind::file || scene.initial.kind == model::StartKind::mode) return {};
    for (const auto& [component, formula] : scene.initial.formulas)
        if (io::mentions(formula.text, {"x", "y"})) return {};
    const numerics::Grid& grid = scene.grid;
    AxisLevel level{"twice the sides", {set("grid.nx", 2 * grid.nx), set("grid.lx", 2.0 * grid.lx)}};
    if (grid.ny > 1) add_all(level.overrides, {set("grid.ny", 2 * grid.ny), set("grid.ly", 2.0 * grid.ly)});
    return level;
}

}  // namespace drover::jobs
