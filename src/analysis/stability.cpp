// analysis/stability.cpp: the uniform states of a scene and their stability as a result.
#include "analysis/stability.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/constants.hpp"
#include "calibrate/slow_order.hpp"
#include "measure/summary.hpp"
#include "physics/equations.hpp"
#include "run/fields/scene_equations.hpp"
#include "theory/instabilities.hpp"
#include "theory/state_names.hpp"

namespace drover::analysis {

namespace {
using std::numbers::pi;

/// Fields that observables have short names for: reported whole, in the frame of the order.
bool is_described(const model::Field& field) { return !field.observed.short_name.empty(); }
/// The order, the first that turns of the fields as they are drawn; nullptr: no field has a direction.
const model::Field* order_of(const model::Model& model) {
    for (const std::size_t n : model::drawn_fields(model))
        if (model.fields[n].spin > 0) return &model.fields[n];
    return nullptr;
}

std::vector<run::Entry> value_entries(const model::Model& model, const model::UniformState& values) {
    std::vector<run::Entry> entries;
    for (const auto& [field, first] : model::placed_fields(model)) {
        if (field.left == model::LeftSide::given || theory::is_given(field)) continue;
        if (is_described(field) && field.spin > 0) {
            entries.push_back({.name = field.observed.short_name,
                               .unit = field.unit,
                               .meaning = field.meaning + ", of the state",
                               .value = std::vector<double>{values[first], values[first + 1]}});
            continue;
        }
        std::size_t component = first;
        for (const std::string& name : model::dataset_names(field))
            entries.push_back(run::number(name, field.unit, name + " of the state", values[component++]));
    }
    return entries;
}

/// Parts of structure factors along and across q.
std::vector<StructurePart> parts_by_wave(const model::LinearisedAt& at) {
    std::vector<StructurePart> parts;
    std::vector<std::string> units;
    for (const model::Field& field : at.equations().model().fields)
        units.insert(units.end(), field.spin == 0 ? 1 : 2, measure::unit_product({field.unit, field.unit, "mm2"}));
    for (const std::string& name : theory::part_names(at.equations())) {
        const auto place = static_cast<Eigen::Index>(parts.size());
        parts.push_back({name, units[parts.size()], [at, place](const model::Symbol& s, const numerics::Wavevector& q) {
                             return at.along_and_across(s, q)(place, place).real();
                         }});
    }
    return parts;
}

/// Scalars, and the order along and across the direction of the state.
std::vector<StructurePart> parts_by_state(const model::LinearisedAt& at) {
    const model::Model& model = at.equations().model();
    const model::Field* const order = order_of(model);
    std::vector<StructurePart> parts;
    for (const std::size_t n : model::drawn_fields(model)) {
        const model::Field& field = model.fields[n];
        const int x = model::first_components(model)[n], y = x + 1;
        const std::string unit = measure::unit_product({field.unit, field.unit, "mm2"});
        if (field.spin == 0)
            parts.push_back({model::short_name(field), unit,
                             [x](const model::Symbol& s, const numerics::Wavevector&) { return s(x, x).real(); }});
        if (&field != order) continue;
        for (const auto& [name, turn] : {std::pair{"along", 0.0}, std::pair{"across", 0.5 * std::numbers::pi}}) {
            const double angle = field.spin * (at.direction() + turn), c = std::cos(angle), sn = std::sin(angle);
            parts.push_back({text("{}_{}_{}0", model::short_name(field), name, field.symbol), unit,
                             [=](const model::Symbol& s, const numerics::Wavevector&) {
                                 return c * c * s(x, x).real() + sn * sn * s(y, y).real() +
                                        2.0 * c * sn * s(x, y).real();
                             }});
        }
    }
    return parts;
}

AnalysedState analysed(const io::Scene& scene, const model::Equations& equations, const theory::StationaryState& state,
                       std::size_t number_of) {
    const model::Model& model = equations.model();
    const bool is_own = scene.kind == io::SceneKind::model;
    std::string group = "/" + state.name;
    std::replace_if(
        group.begin() + 1, group.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
    const std::string values = theory::values_text(model, state.values),
                      name = state.name.substr(0, state.name.find(':'));
    AnalysedState result{.name = state.name,
                         .group = is_own ? text("{}_{}", group, number_of) : group,
                         .heading = "state: " + (is_own           ? theory::state_words(model, state)
                                                 : values.empty() ? name
                                                                  : name + ", " + values),
                         .entries = value_entries(model, state.values),
                         .linear = model::LinearisedAt(equations, state.values),
                         .has_free_direction = state.has_free_direction};
    result.is_mapped_along_x = is_own && result.linear.is_isotropic();
    result.parts = is_own ? parts_by_wave(result.linear) : parts_by_state(result.linear);
    return result;
}

run::Entry row_entry(const calibrate::ResultRow& row) {
    return run::shown_as(run::number(row.name, row.unit, row.meaning, row.value), {.text = row.applies});
}

/// What only rods and beads have.
void add_slow_order(const io::Scene& scene, run::Record& root) {
    const physics::Equations equations(scene.model);
    const calibrate::SlowOrder slow = calibrate::slow_order(equations);
    const std::vector<std::string> notes = calibrate::stability_remarks(equations, slow);
    for (const calibrate::ResultRow& row : calibrate::density_rows(equations)) root.entries.push_back(row_entry(row));
    root.entries.push_back(run::data_only(run::words("notes", "", notes)));
    run::Record record{.heading = "effective coefficients"};
    for (const calibrate::ResultRow& row : calibrate::slow_order_rows(equations, slow))
        record.entries.push_back(row_entry(row));
    root.parts.emplace_back("coefficients", std::move(record));
    for (const std::string& note : notes) root.footer.push_back("\nnote: " + note);
}

/// Where and how a state is analysed.
struct Analysis {
    const io::Scene& scene;
    std::string direction;  ///< from which angles are measured: "p0"
    theory::GrowthSearch search;
    Threads* threads;  ///< of maps; nullptr: no maps
};

run::Record instability_record(const theory::Instability& found, const std::string& direction) {
    const bool is_uniform = found.q == 0.0;
    return {
        .entries = {
            run::stored_as("kind", run::choice("name", "kind of instability", name_of(found.kind),
                                               all_names<theory::InstabilityKind>())),
            run::number("rate", "s-1", "largest growth rate, Re s", found.rate),
            run::number("frequency", "s-1", "angular frequency of the fastest wave, -Im s", found.frequency),
            run::number("wavenumber", "mm-1", "|q| of the fastest wave; 0: the uniform state itself changes", found.q),
            run::number("wavelength", "mm", "2 pi/|q| of the fastest wave", is_uniform ? nan : 2.0 * pi / found.q),
            run::number("angle", "degree", "angle of q from " + direction, found.angle / radians_per_degree),
            run::number(
                "grows_from", "mm-1",
                "lower end of the band of growing |q| at this angle (for a uniform instability: at any angle); 0: the "
                "band extends below the smallest |q| searched",
                found.min),
            run::number("grows_to", "mm-1",
                        "upper end of the band of growing |q| at this angle (for a uniform instability: at any angle); "
                        "infinite: the band extends beyond the largest |q| searched",
                        found.max),
            run::data_only(run::flag("at_longest", "1: the growth rate is largest at the smallest |q| searched",
                                     found.at_longest)),
            run::data_only(run::flag("at_shortest", "1: the growth rate still increases at the largest |q| searched",
                                     found.at_shortest)),
        }};
}

run::List instability_list(const Analysis& of, const std::vector<theory::Instability>& found) {
    run::List list{.name = "instabilities",
                   .heading = text("unstable (fastest first; angles from {}; -: growth extends beyond the search)",
                                   of.direction),
                   .row = "instability",
                   .meaning = "instabilities, fastest first",
                   .prefix = "instability_",
                   .empty = text("stable against all waves from |q| = {:.3g} to {}", of.search.min,
                                 io::in_unit("{:.3g}", of.search.max, "/mm", of.scene.units))};
    for (const theory::Instability& one : found) list.rows.push_back(instability_record(one, of.direction));
    return list;
}

std::vector<std::string> instability_notes(const std::vector<theory::Instability>& found) {
    std::vector<std::string> notes;
    for (const theory::Instability& one : found) {
        if (one.at_longest)
            notes.push_back(text("{}: the growth rate is largest at the longest wave searched", one.kind));
        if (one.at_shortest)
            notes.push_back(
                text("{}: the growth rate still increases at the shortest wave searched; no term of the model "
                     "stabilises short waves",
                     one.kind));
    }
    return notes;
}

/// The share of each term in the rate of the fastest wave.
run::List share_list(const model::LinearisedAt& at, const theory::FastestWave& fastest, const io::Units& units) {
    const model::Equations& equations = at.equations();
    run::List list{.name = "shares",
                   .heading =
                       text("terms in the rate {} of the fastest wave, |q| = {}{}",
                            io::in_unit("{:.6g}", fastest.growth.rate, "/s", units),
                            io::in_unit("{:.4g}", fastest.q, "/mm", units),
                            at.is_isotropic() ? "" : text(", at {:.4g} degrees", fastest.angle / radians_per_degree)),
                   .row = "term",
                   .meaning = "terms of the equations",
                   .prefix = "share_"};
    for (std::size_t n = 0; n < fastest.shares.size(); ++n) {
        const model::TermSummary& term = equations.terms()[n];
        if (fastest.shares[n] == 0.0) continue;
        list.rows.push_back(
            {.entries = {run::words("of", "field", equations.model().fields[term.field].symbol),
                         run::words("term", "as written", term.text),
                         run::number("growth", "s-1", "its share in the growth rate", fastest.shares[n].real()),
                         run::number("frequency", "s-1", "its share in the frequency", -fastest.shares[n].imag())}});
    }
    return list;
}

/// Im gamma, without what rounding leaves of it.
double dispersion_of(const theory::SlowMode& mode) {
    constexpr double rounding = 1e-9;
    return std::abs(mode.damping.imag()) > rounding * std::abs(mode.damping) ? mode.damping.imag() : 0.0;
}

run::Record slow_mode_record(const theory::SlowMode& mode, double angle, const std::string& direction,
                             bool is_in_text) {
    return {.entries = {run::number("angle", "degree", "angle of q from " + direction, angle),
                        run::number("speed", "mm s-1", "Re u", mode.speed.real()),
                        run::number("growth", "mm s-1", "Im u", mode.speed.imag()),
                        run::number("damping", "mm2 s-1", "Re gamma; not defined where u is a defective eigenvalue",
                                    mode.damping.real()),
                        run::number("dispersion", "mm2 s-1", "Im gamma: of the frequency u q + Im gamma q^2",
                                    dispersion_of(mode))},
            .shown = {.text = is_in_text}};
}

/// Four angles; text has one where all directions are equivalent.
run::List slow_mode_list(const Analysis& of, const AnalysedState& state, std::string& why_none) {
    run::List list{.name = "slow_modes",
                   .heading =
                       text("long waves, s = -i u q - gamma q^2: u = speed + i growth, gamma = damping, angles from "
                            "{}",
                            of.direction),
                   .shown = {.archive = false}};
    const bool is_isotropic = state.linear.is_isotropic();
    bool disperses = false;
    for (const double angle : {0.0, 30.0, 60.0, 90.0}) {
        const theory::SlowModes slow = theory::slow_modes(state.linear, angle * radians_per_degree);
        if (!slow.why_none.empty()) why_none = slow.why_none;
        for (const theory::SlowMode& mode : slow.modes) {
            list.rows.push_back(slow_mode_record(mode, angle, of.direction, angle == 0.0 || !is_isotropic));
            disperses = disperses || dispersion_of(mode) != 0.0;
        }
    }
    for (run::Record& row : list.rows)
        if (!disperses) row.entries.back() = run::data_only(std::move(row.entries.back()));
    return list;
}

run::Record state_record(const Analysis& of, const AnalysedState& state) {
    Threads one(1);
    Threads& threads = of.threads != nullptr ? *of.threads : one;
    auto [found, fastest] = theory::growing_waves(state.linear, of.search, threads);
    if (std::abs(fastest.growth.rate) <= fastest.growth.rounding) {  // neither grows nor decays: no shares of nothing
        fastest.growth.rate = 0.0;
        fastest.shares.clear();
    }
    std::string no_slow_modes;
    run::List slow = slow_mode_list(of, state, no_slow_modes);
    const double diffusion =
        state.has_free_direction ? theory::direction_diffusion(state.linear, theory::long_waves(state.linear)) : 0.0;
    run::Record record{.heading = state.heading, .group = state.group};
    record.entries = {run::data_only(run::words("name", "name of the state", state.name))};
    for (const run::Entry& entry : state.entries) record.entries.push_back(run::data_only(entry));
    record.entries.insert(
        record.entries.end(),
        {run::data_only(run::flag("free_direction", "1: rotated copies of the state are stationary too",
                                  state.has_free_direction)),
         run::data_only(run::flag("stable", "1: no wave of the search grows", found.empty())),
         run::data_only(run::number("fastest_rate", "s-1", "the largest growth rate", fastest.growth.rate)),
         run::data_only(run::number("fastest_wavenumber", "mm-1", "its |q|", fastest.q)),
         run::words("slow_modes_undefined", "", no_slow_modes),
         run::shown_as(
             run::number("direction_diffusion_times_area", "rad2 mm2 s-1",
                         "D times the area of the cell; <theta^2> = 2 D t for the direction of the mean order",
                         diffusion),
             {.text = diffusion > 0.0})});
    record.lists = {instability_list(of, found), share_list(state.linear, fastest, of.scene.units), std::move(slow)};
    if (fastest.shares.empty()) record.lists[1].shown.text = false;
    record.footer = instability_notes(found);
    if (diffusion > 0.0)
        record.footer.push_back(text("in this cell the direction of the mean order diffuses with D = {:.4g} rad2 s-1",
                                     diffusion / numerics::area(of.scene.grid)));
    if (of.threads != nullptr)
        record.maps = stability_maps(of.scene.stability, of.scene.grid, state, of.direction, of.search, *of.threads);
    return record;
}
}  // namespace

double smallest_wavenumber(const numerics::Grid& grid) {
    double side = 0.0;  // an axis of one point has no waves
    if (grid.nx > 1) side = grid.lx;
    if (grid.ny > 1) side = std::max(side, grid.ly);
    return 2.0 * pi / (side > 0.0 ? side : std::max(grid.lx, grid.ly));
}

theory::GrowthSearch growth_search(const io::Scene& scene) {
    const io::StabilityPlan& plan = scene.stability;
    theory::GrowthSearch search{.min = plan.min_wavenumber,
                                .max = plan.max_wavenumber,
                                .wavenumbers = std::max(plan.wavenumbers, io::StabilityPlan{}.wavenumbers),
                                .angles = 2 * plan.angles};
    if (search.min == 0.0) search.min = 1e-3 * smallest_wavenumber(scene.grid);
    const auto largest = [](int points, double side) { return points > 1 ? pi * points / side : 0.0; };
    if (search.max == 0.0)
        search.max = std::max({largest(scene.grid.nx, scene.grid.lx), largest(scene.grid.ny, scene.grid.ly),
                               smallest_wavenumber(scene.grid)});
    const char* given = plan.min_wavenumber > 0.0 ? "stability.min_wavenumber" : "stability.max_wavenumber";
    require(search.min < search.max, io::locate(scene, given),
            "the search covers |q| = {:.4g} to {}; expected stability.min_wavenumber below "
            "stability.max_wavenumber",
            search.min, io::in_unit("{:.4g}", search.max, "/mm", scene.units));
    return search;
}

run::Result make_stability(const io::Scene& scene, Threads* threads) {
    const theory::GrowthSearch search = growth_search(scene);
    const bool is_own = scene.kind == io::SceneKind::model;
    const model::Equations equations = run::equations_of(scene);
    const theory::StationaryStates found = run::uniform_states_of(scene, equations);
    run::Record root{.entries = {is_own ? run::words("model", "its name", scene.declared.name)
                                        : run::words("form", "fields of the model", physics::form_name(scene.model))}};
    if (!found.why_none.empty()) root.footer.push_back("\nno uniform stationary state: " + found.why_none);
    if (!found.kink.empty() && found.why_none.empty()) root.footer.push_back("\nno linear theory: " + found.kink);
    if (!found.why_no_order.empty()) root.footer.push_back("\nno ordered state: " + found.why_no_order);
    if (!found.why_incomplete.empty()) root.footer.push_back("\nnote: " + found.why_incomplete);
    if (!is_own) add_slow_order(scene, root);
    for (const auto& [name, why] : {std::pair{"no_state", found.why_none}, std::pair{"no_order", found.why_no_order},
                                    std::pair{"incomplete", found.why_incomplete},
                                    std::pair{"no_theory", found.why_none.empty() ? found.kink : ""}})
        root.entries.push_back(run::data_only(run::words(name, "", why)));
    root.entries.push_back(
        run::number("searched_from", "mm-1", "smallest |q| of the search for instabilities", search.min));
    root.entries.push_back(
        run::number("searched_to", "mm-1", "largest |q| of the search for instabilities", search.max));
    const model::Field* const order = order_of(equations.model());
    const Analysis analysis{.scene = scene,
                            .direction = order != nullptr && is_described(*order) ? order->symbol + "0" : "the order",
                            .search = search,
                            .threads = threads};
    run::List states{.name = "states"};
    for (const theory::StationaryState& state : found.states)
        states.rows.push_back(state_record(analysis, analysed(scene, equations, state, states.rows.size() + 1)));
    root.lists = {std::move(states)};
    return {.root = std::move(root)};
}

}  // namespace drover::analysis
