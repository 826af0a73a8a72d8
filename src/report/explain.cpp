// report/explain.cpp: what a scene of fields or of particles holds, what any scene costs, and whether it can be run.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/boundary.hpp"
#include "dem/contact/contact_law.hpp"
#include "io/trajectory.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "jobs/sweep/sweep.hpp"
#include "model/start.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "numerics/steppers/time_method.hpp"
#include "physics/equations.hpp"
#include "report/shown.hpp"
#include "run/fields/scene_equations.hpp"
#include "run/run_scene.hpp"
#include "run/simulation_type.hpp"

namespace drover::report {

namespace {
/// Bodies of one kind: those that are used of the shapes in `bodies`.
template <class Body>
run::Record supply_of(const char* name, const std::vector<Body>& list, const dem::Bodies& bodies, double area) {
    std::vector<bool> is_used(bodies.shapes.size());
    double covered = 0.0;
    for (const Body& body : list) {
        is_used[body.shape] = true;
        covered += bodies.shapes[body.shape].projected_area;
    }
    std::vector<double> masses, lengths;
    for (std::size_t n = 0; n < is_used.size(); ++n) {
        if (!is_used[n]) continue;
        masses.push_back(bodies.shapes[n].mass);
        lengths.push_back(bodies.shapes[n].head - bodies.shapes[n].tail);
    }
    const auto range = [](const char* of, const char* unit, const std::vector<double>& values) {
        const auto [min, max] = std::ranges::minmax_element(values);
        return run::Entry{.name = of,
                          .unit = unit,
                          .meaning = "smallest and largest",
                          .value = values.empty() ? std::vector<double>{0.0, 0.0} : std::vector<double>{*min, *max},
                          .digits = 4};
    };
    return {.heading = text("{} {}", list.size(), name),
            .entries = {run::count("count", "bodies", list.size()),
                        run::number("area_fraction", "1", "area of their projections per area", covered / area, 4),
                        run::count("shapes", "different bodies", masses.size()), range("mass", "mg", masses),
                        range("length", "mm", lengths)},
            .shown = {.text = !list.empty()}};
}

std::vector<std::string> words_of_setup(const dem::Setup& setup) {
    const dem::Plates& plates = setup.plates;
    const dem::ContactControl& contacts = setup.contacts;
    return {text("{}, gap {} mm; vertical vibration: amplitude {} mm, frequency {} Hz",
                 plates.lid ? "base and lid" : "base without lid", plates.gap, plates.amplitude, plates.frequency),
            text("packing: {}", setup.packing.kind),
            dem::PairwiseLaw::is_chosen(contacts)
                ? text("contacts: {}, {}, {} friction, rod steps of at most {} s", contacts.law, contacts.order,
                       contacts.friction, contacts.rod_step)
            : contacts.model == dem::ContactModel::impulse
                ? text("contacts: {}, restitution {}", contacts.law, contacts.restitution)
                : text("contacts: {}", contacts.model)};
}

void add_calibration(const io::Scene& scene, run::Record& root) {
    if (scene.calibration.bead_area_fractions.empty()) return;
    const jobs::CalibrationLayout layout = jobs::plan_calibration(scene);
    run::List list{.name = "assays",
                   .heading = text("drover calibrate: {} measurements with {} to {} trials each", layout.units.size(),
                                   layout.goal.round * layout.goal.min_rounds,
                                   layout.goal.max_trials / layout.goal.round * layout.goal.round),
                   .row = "assay"};
    for (const calibrate::Assay& assay : layout.assays)
        list.rows.push_back(
            {.entries = {run::words("name", "what it measures", assay.name),
                         run::words("depends_on", "area fractions",
                                    assay.population == calibrate::Population::all ? "Phi_b and Phi_r" : "Phi_b")}});
    root.lists.push_back(std::move(list));
}

/// The terms of the equations and what they are called.
struct ListedTerms {
    model::Equations equations;  ///< of rods and beads without the mass, by which all forces are divided
    std::vector<std::string> written;
    std::vector<std::string> names = {};  ///< empty in a model that gives them none
    const std::string& name(std::size_t term) const { return names.empty() ? written[term] : names[term]; }
};

ListedTerms listed_terms(const io::Scene& scene, const model::Equations& equations) {
    if (scene.kind != io::SceneKind::model) {
        const physics::Equations rod_bead(scene.model);
        return {.equations = rod_bead.right_sides(),
                .written = physics::written_terms(rod_bead),
                .names = rod_bead.terms()};
    }
    ListedTerms listed{.equations = equations, .written = {}};
    for (const auto* terms : {&equations.terms(), &equations.noise_terms()})
        for (const model::TermSummary& term : *terms) listed.written.push_back(term.text);
    return listed;
}

run::List fields_of(const io::Scene& scene, const model::Equations& equations) {
    constexpr const char* ranks[] = {"scalar", "vector", "nematic"};
    run::List list{.name = "fields", .heading = "fields", .row = "field"};
    for (std::size_t n = 0; n < equations.model().fields.size(); ++n) {
        const model::Field& field = equations.model().fields[n];
        if (field.left == model::LeftSide::given) continue;
        const std::string rank = field.spin > 2 ? text("spin {}", field.spin) : ranks[field.spin];
        list.rows.push_back(
            {.entries = {run::words("name", "in figures and archives", field.name),
                         run::words("symbol", "in equations", field.symbol),
                         run::words("rank", "how it transforms under rotations", (field.odd ? "odd " : "") + rank),
                         run::words("unit", "its unit", io::renamed(field.unit, scene.units)),
                         run::words("meaning", "what it is", field.meaning),
                         run::data_only(run::words("latex", "its equation as LaTeX", equations.latex(n)))}});
    }
    return list;
}

/// Why a term is evaluated as a whole, without an exact linear part; "": it is not.
const char* why_explicit(const model::Equations& equations, std::size_t term) {
    if (term >= equations.terms().size()) return "";  // noise
    const model::TermSummary& summary = equations.terms()[term];
    if (summary.is_explicit) return "as written";
    if (summary.is_placed) return "depends on position or time";
    if (!equations.has_derivative(term, equations.reference())) return "no derivative at the references";
    return equations.is_isotropic(term) ? "" : "names a direction";
}

run::List terms_of(const model::Model& model, const ListedTerms& of) {
    run::List list{.name = "terms", .heading = "terms of the equations", .row = "term"};
    std::vector<model::TermSummary> terms = of.equations.terms();
    terms.insert(terms.end(), of.equations.noise_terms().begin(), of.equations.noise_terms().end());
    for (std::size_t n = 0; n < terms.size(); ++n) {
        const model::Field& field = model.fields[terms[n].field];
        const std::string left = field.left == model::LeftSide::balance ? "0"
                                 : field.mass.text.empty()              ? "d_t " + field.symbol
                                                                        : field.mass.text + " d_t " + field.symbol;
        run::Record row;
        if (!of.names.empty()) row.entries.push_back(run::words("name", "the key of its coefficient", of.names[n]));
        row.entries.insert(row.entries.end(),
                           {run::words("of", "left side of its equation", left),
                            run::words("term", "as written", of.written[n]),
                            run::words("explicit", "why nothing of it is in the exact linear part, if so",
                                       why_explicit(of.equations, n))});
        list.rows.push_back(std::move(row));
    }
    return list;
}

run::Record number_row(const std::string& name, const run::EntryValue& value) {
    return {.entries = {run::words("name", "in equations", name), run::words("value", "its value", value)}};
}

run::List coefficients_of(const io::Scene& scene, const model::Model& model) {
    run::List list{.name = "coefficients",
                   .heading = "coefficients",
                   .row = "coefficient",
                   .empty = "no coefficients",
                   .has_like_rows = false};
    if (scene.kind != io::SceneKind::model) {
        for (const physics::CoefficientValue& one : physics::coefficient_values(scene.model)) {
            run::Record row =
                number_row(one.key, std::visit([](const auto& v) { return run::EntryValue(v); }, one.value));
            row.entries.insert(row.entries.begin() + 1, run::words("symbol", "in equations", one.symbol));
            row.entries.push_back(run::words("unit", "its unit", io::renamed(one.unit, scene.units)));
            list.rows.push_back(std::move(row));
        }
        return list;
    }
    for (const auto& [name, value] : model.coefficients) list.rows.push_back(number_row(name, value));
    for (const io::DeclaredTable& table : scene.declared.tables)
        list.rows.push_back(number_row(table.symbol, text("a table of {}", joined(table.of))));
    for (const model::WhiteNoise& noise : model.noises)
        list.rows.push_back(number_row(noise.symbol + ", white noise", 1.0));
    for (const model::Field& field : model.fields)
        if (field.noise != 0.0)
            list.rows.push_back(
                number_row(text("{} noise of {}", field.noise_conserves ? "conserved" : "white", field.symbol),
                           field.noise));
    return list;
}

/// The method, its steps and their transforms.
void add_steps(const io::Scene& scene, const model::Integrated& what, run::Record& root) {
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    const bool is_nonlinear = what.equations.has_nonlinear_part(), has_tolerance = scene.time.tolerance > 0.0;
    const bool halves = has_tolerance && method.is_exponential && !io::has_noise(scene) &&
                        std::ranges::any_of(what.equations.terms(), &model::TermSummary::is_timed);
    const int stages = numerics::stages_per_part(method, has_tolerance, halves);
    const model::TransformCount transforms = model::transforms_of(what);
    const auto per_step = [&](const char* name, const char* meaning, int each) {
        return is_nonlinear && stages == 0 ? run::number(name, "1", meaning, NAN)
                                           : run::count(name, meaning, is_nonlinear ? stages * each : 0);
    };
    const bool is_divided = has_tolerance && (is_nonlinear || !method.is_exponential);
    root.entries.insert(
        root.entries.end(),
        {run::words("stepper", "method and its source",
                    text("{}, order {}{}: {}", method.name, method.needs_tolerance ? "1 to " : "", method.order,
                         method.citation)),
         run::number("time_step", "s",
                     !is_divided              ? "time.dt"
                     : method.needs_tolerance ? "time.dt, which does not limit the steps of the method"
                                              : "time.dt, each divided as time.tolerance requires",
                     scene.time.dt),
         per_step("right_hand_sides_per_step",
                  is_nonlinear ? "of the method" : "every term is linear and acts exactly on the Fourier modes", 1),
         per_step("transforms_per_step", "real transforms", transforms.inverse + transforms.forward)});
    root.parts.push_back({"transforms_per_right_hand_side",
                          {.heading = "real transforms per right-hand side",
                           .entries = {run::count("inverse", "to the grid", transforms.inverse),
                                       run::count("forward", "from the grid", transforms.forward)}}});
}

/// Which modes the grid keeps, and their rates by the linear part about the references.
void add_modes(const io::Scene& scene, const model::Integrated& what, const ListedTerms& of, run::Record& root) {
    const numerics::System system = what.equations.linear_system(scene.grid, what.kept_degree);
    const bool is_exact = numerics::time_method(scene.time.stepper).is_exponential;
    std::vector<std::string> without_degree, beyond_linear;
    for (std::size_t n = 0; n < of.equations.terms().size(); ++n) {
        const model::TermSummary& term = of.equations.terms()[n];
        if (!term.has_finite_degree) without_degree.push_back(of.name(n));
        if (term.is_explicit || model::has_source(of.equations.model(), term) || !of.equations.is_isotropic(n))
            beyond_linear.push_back(of.name(n));
    }
    const numerics::FastestGrowth growth = numerics::fastest_growth(system);
    const double fastest = numerics::fastest_rate(system);
    const std::string factor = text("unstable: a mode grows about the references, by a factor e^{:.3g} in this run{}",
                                    growth.rate * scene.time.end,
                                    what.equations.has_nonlinear_part() ? " unless a nonlinear term limits it"
                                                                        : "; no nonlinear term limits it");
    const auto largest_kept = [&](int points) { return (points - 1) / (system.degree + 1); };
    root.entries.insert(
        root.entries.end(),
        {run::count("degree", "of the products: modes with |k| < N/(degree + 1) on an axis are kept", system.degree),
         run::number("fastest_rate", "s-1", "|s|max of the linear terms", fastest),
         run::number("dt_times_fastest_rate", "1", is_exact ? "dt |s|max, exact for any dt" : "dt |s|max, implicit",
                     scene.time.dt * fastest),
         run::number("growth_rate", "s-1",
                     growth.rate > 0.0   ? factor
                     : growth.rate < 0.0 ? "stable: the slowest mode decays about the references"
                                         : "neutral: a mode neither grows nor decays about the references",
                     growth.rate),
         run::number("growth_wavenumber", "mm-1", "|q| of that mode", growth.q),
         run::data_only(run::words("terms_without_degree", "", without_degree)),
         run::data_only(run::words("growth_leaves_out", "", beyond_linear))});
    if (what.equations.has_product_noise())
        root.entries.push_back(
            run::number("noise_modes_per_area", "mm-2",
                        "white noise at a point, <xi^2>; drifts of Stratonovich are proportional to it",
                        model::noise_moment(scene.grid, system.degree, 0, 0)));
    root.parts.push_back({"largest_mode_kept",
                          {.heading = "largest mode number that is kept",
                           .entries = {run::count("x", "on this axis", largest_kept(scene.grid.nx)),
                                       run::count("y", "on this axis", largest_kept(scene.grid.ny))}}});
    if (!without_degree.empty())
        root.footer.push_back(
            text("no finite degree: {}; aliases are not removed exactly, see spectral_tail in the output",
                 joined(without_degree)));
    if (!beyond_linear.empty())
        root.footer.push_back(
            text("the growth rate leaves out {}, which depend on direction, position or time, have no derivative, or "
                 "are explicit: see drover stability",
                 joined(beyond_linear)));
}

/// Where the start has other conserved means than the references, about which the modes are.
void add_means_of_start(const io::Scene& scene, const model::Equations& equations, run::Record& root) try {
    if (scene.kind != io::SceneKind::model || equations.placed_term() != nullptr) return;
    const model::UniformState means = run::conserved_start(scene, equations), references = equations.reference();
    std::vector<std::string> apart;
    for (const model::StateComponent& one : model::components_of_state(equations)) {
        const auto at = static_cast<std::size_t>(model::first_components(equations.model())[one.field] + one.part);
        if (means[at] != references[at])
            apart.push_back(text("{} = {:.6g} for {:.6g}", one.name, means[at], references[at]));
    }
    if (!apart.empty())
        root.footer.push_back(
            text("the conserved means of the start differ from the references ({}): drover stability uses "
                 "those of the start",
                 joined(apart)));
} catch (const Error& error) {  // the rates are not finite about the references, and there is no such theory
    if (error.fault() != Fault::input) throw;
}

run::Record explain_fields(const io::Scene& scene) {
    const model::Integrated what = run::integrated_in_run(scene);
    const ListedTerms of = listed_terms(scene, what.equations);
    const numerics::Grid& grid = scene.grid;
    run::Record root{.heading = text("fields on {} by {} points, {} by {} {}", grid.nx, grid.ny, grid.lx, grid.ly,
                                     scene.units.length == "none" ? "" : scene.units.length)};
    root.heading.erase(root.heading.find_last_not_of(' ') + 1);
    if (scene.kind != io::SceneKind::model)
        root.entries.push_back(run::words("form", "fields of the model", physics::form_name(scene.model)));
    else if (!scene.declared.name.empty())
        root.entries.push_back(run::words("name", "of the model", scene.declared.name));
    add_steps(scene, what, root);
    add_modes(scene, what, of, root);
    add_means_of_start(scene, what.equations, root);
    root.lists = {fields_of(scene, what.equations), terms_of(what.equations.model(), of),
                  coefficients_of(scene, what.equations.model())};
    if (scene.approximation.counterterm) {
        const double rate = run::counterterm_of(scene);
        root.entries.push_back(
            run::data_only(run::number("counterterm", "s-1", "by which order grows faster in the run", rate)));
        root.footer.push_back(text("counterterm: in the run order grows faster than in theory, by {:.6g} {}", rate,
                                   io::renamed("1/s", scene.units)));
    }
    if (what.long_waves < INFINITY)
        root.footer.push_back(
            text("quasi-linear: waves with |q| > {} {} interact with the other waves, but not with each other",
                 what.long_waves, io::renamed("1/mm", scene.units)));
    return root;
}

void add_cost(const io::Scene& scene, run::Record& root) {
    const run::Needs needs = run::needs_of(scene);
    const int threads = run::simulation_type_of(scene).threads(scene);
    const std::optional<run::ExpectedTime> time =
        needs.memory_bytes < needs.memory_free ? run::expected_time(scene) : std::nullopt;
    root.entries.push_back(run::count("steps", "of time.dt", io::whole_steps(scene, "time.end", scene.time.end)));
    root.entries.push_back(run::count("threads", "of the run", threads));
    for (const run::Entry& entry :
         {run::number("memory_bytes", "1", "of the run", needs.memory_bytes),
          run::number("disk_bytes", "1", "at most", needs.disk_bytes),
          run::number("seconds_per_step_estimate", "1", "wall time of a step", time ? time->step : NAN),
          run::number("seconds_estimate", "1", "wall time of the run", time ? time->total : NAN),
          run::words("archive", "of the run", run::archive_path(scene).string())})
        root.entries.push_back(run::data_only(entry));
    root.footer.push_back(text("memory {} ({} free), disk at most {} ({} free)", bytes_text(needs.memory_bytes),
                               bytes_text(needs.memory_free), bytes_text(needs.disk_bytes),
                               bytes_text(needs.disk_free)));
    if (time)
        root.footer.push_back(
            text("wall time about {} (estimate): {:.3g} ms per step, {}", duration_text(time->total), 1e3 * time->step,
                 !time->scaled                            ? "measured on a few steps"
                 : scene.kind == io::SceneKind::particles ? "scaled from a few steps in a smaller cell"
                                                          : "scaled from a few steps on a smaller grid"));
    root.footer.push_back("archive " + run::archive_path(scene).string());
}

/// The part for particles: the bodies in their cell, its plates, and the measurements of a calibration.
run::Record explain_particles(const io::Scene& scene) {
    const dem::Setup& setup = scene.particles;
    const dem::Bodies bodies = dem::make_bodies(setup, static_cast<std::uint64_t>(scene.run.seed));
    const io::Box box = io::box_of(setup);
    const double area = dem::area(setup.cell), rate = 2.0 * std::numbers::pi * setup.plates.frequency,
                 gravity = std::abs(setup.gravity.z);
    run::Record root{.heading =
                         text("particles in a {} cell, {} by {} mm", setup.cell.shape, box.sides[0], box.sides[1]),
                     .header = words_of_setup(setup)};
    root.entries = {run::data_only(run::words("cell", "its shape", name_of(setup.cell.shape))),
                    run::number("cell_area", "mm2", "area of the cell", area),
                    run::count("spheres", "of all bodies", io::sphere_count(bodies)),
                    run::number("acceleration", "1", "of the plates, in units of gravity",
                                gravity > 0.0 ? setup.plates.amplitude * rate * rate / gravity : 0.0, 3),
                    run::number("time_step", "s", "time.dt", scene.time.dt),
                    run::number("steps_per_period", "1", "of the vibration",
                                setup.plates.frequency > 0.0 ? 1.0 / (setup.plates.frequency * scene.time.dt) : 0.0,
                                4)};
    root.parts = {{"beads", supply_of("beads", bodies.beads, bodies, area)},
                  {"rods", supply_of("rods", bodies.rods, bodies, area)}};
    add_calibration(scene, root);
    return root;
}
}  // namespace

run::Result explain(const io::Scene& scene) {
    run::Record root = scene.kind == io::SceneKind::particles ? explain_particles(scene) : explain_fields(scene);
    root.entries.insert(root.entries.begin(), run::words("kind", "of the scene", name_of(scene.kind)));
    add_cost(scene, root);
    return {.root = std::move(root)};
}

std::vector<std::string> check_scene(const io::Scene& scene) {
    const run::SimulationType& type = run::simulation_type_of(scene);
    run::check_needs(scene, {.overwrite = true, .quiet = true});
    type.check_start(scene);
    if (!scene.sweep.vary.empty()) jobs::plan_sweep(scene);
    if (!scene.calibration.bead_area_fractions.empty()) jobs::plan_calibration(scene);
    analysis::check_boundary(scene);
    std::vector<std::string> warnings = type.warnings(scene);
    if (auto warning = run::disk_warning(run::needs_of(scene))) warnings.push_back(std::move(*warning));
    return warnings;
}

}  // namespace drover::report
