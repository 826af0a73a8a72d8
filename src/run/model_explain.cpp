// run/model_explain.cpp: a declared model as a result: fields, terms, numbers, cost.
#include "drover/run/model_explain.hpp"

#include "drover/numerics/time_method.hpp"
#include "drover/run/explain.hpp"

namespace drover::run {

namespace {
Entry count(const char* name, const char* meaning, std::int64_t value) {
    return {.name = name, .unit = "1", .meaning = meaning, .value = value};
}

const char* rank_of(const model::Field& field) {
    constexpr const char* ranks[] = {"scalar", "vector", "nematic"};
    return field.spin <= 2 ? ranks[field.spin] : "spin";
}

List fields_of(const model::Equations& equations) {
    List list{.name = "fields", .heading = "fields", .row = "field"};
    for (std::size_t n = 0; n < equations.model().fields.size(); ++n) {
        const model::Field& field = equations.model().fields[n];
        const std::string rank = field.spin > 2 ? text("spin {}", field.spin) : rank_of(field);
        list.rows.push_back(
            {.entries = {words("name", "in figures and archives", field.name),
                         words("symbol", "in equations", field.symbol),
                         words("rank", "how it turns", (field.odd ? "odd " : "") + rank),
                         words("unit", "its unit", field.unit), words("meaning", "what it is", field.meaning),
                         words("latex", "its equation as LaTeX", equations.latex(n))}});
        list.rows.back().entries.back().shown.text = false;
    }
    return list;
}

/// Why a term is evaluated as a whole, without an exact linear part; "": it is not.
const char* why_explicit(const model::Equations& equations, std::size_t term) {
    if (term >= equations.terms().size()) return "";  // noise
    const model::TermSummary& summary = equations.terms()[term];
    if (summary.is_explicit) return "as written";
    if (summary.is_placed) return "depends on position or time";
    return equations.has_derivative(term, equations.reference()) ? "" : "no derivative at the references";
}

List terms_of(const model::Equations& equations) {
    List list{.name = "terms", .heading = "terms of the equations", .row = "term"};
    std::vector<model::TermSummary> terms = equations.terms();
    terms.insert(terms.end(), equations.noise_terms().begin(), equations.noise_terms().end());
    for (std::size_t n = 0; n < terms.size(); ++n) {
        const model::TermSummary& term = terms[n];
        const model::Field& field = equations.model().fields[term.field];
        const std::string left = field.left == model::LeftSide::balance ? "0"
                                 : field.mass.text.empty()              ? "d_t " + field.symbol
                                                                        : field.mass.text + " d_t " + field.symbol;
        list.rows.push_back(
            {.entries = {words("of", "left side of its equation", left), words("term", "as written", term.text),
                         words("explicit", "why nothing of it is in the exact linear part, if so",
                               why_explicit(equations, n))}});
    }
    return list;
}

List coefficients_of(const model::Model& model, const std::vector<io::DeclaredTable>& tables) {
    List list{.name = "coefficients", .heading = "coefficients", .row = "coefficient", .empty = "no coefficients"};
    for (const auto& [name, value] : model.coefficients)
        list.rows.push_back(
            {.entries = {words("name", "in equations", name), number("value", "1", "its value", value)}});
    for (const io::DeclaredTable& table : tables)
        list.rows.push_back({.entries = {words("name", "in equations", table.symbol),
                                         words("value", "its value", text("a table of {}", joined(table.of)))}});
    for (const model::WhiteNoise& noise : model.noises)
        list.rows.push_back({.entries = {words("name", "in equations", noise.symbol + ", white noise"),
                                         number("value", "1", "its strength", 1.0)}});
    for (const model::Field& field : model.fields)
        if (field.noise != 0.0)
            list.rows.push_back(
                {.entries = {words("name", "in equations",
                                   text("{} noise of {}", field.noise_conserves ? "conserved" : "white", field.symbol)),
                             number("value", "1", "its strength", field.noise)}});
    return list;
}
}  // namespace

Result explain_model(const io::Scene& scene) {
    const model::Equations equations(io::model_of(scene.declared));
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    const model::TransformCount transforms = equations.transforms();
    const int degree = io::kept_degree(scene, equations);
    const Cost cost = cost_of(scene);
    Result result;
    Record& root = result.root;
    root.heading = text("{}, on {} by {} points, {} by {} mm",
                        scene.declared.name.empty() ? "a model of its own" : scene.declared.name, scene.grid.nx,
                        scene.grid.ny, scene.grid.lx, scene.grid.ly);
    root.entries = {
        words("stepper", "method and its source", text("{}: {}", method.name, method.citation)),
        number("time_step", "s", "time.dt", scene.time.dt),
        count("steps", "of time.dt", cost.steps),
        count("inverse_transforms", "real transforms to the grid of one right-hand side", transforms.inverse),
        count("forward_transforms", "real transforms from the grid of one right-hand side", transforms.forward),
        count("degree", "of the products: modes with |k| < N/(degree + 1) on an axis are kept", degree),
        count("threads", "of the run", cost.threads),
        words("memory", "of the run, and what is free",
              text("{} ({} free)", bytes_text(cost.needs.memory_bytes), bytes_text(cost.needs.memory_free))),
        words("disk", "at most, and what is free",
              text("{} ({} free)", bytes_text(cost.needs.disk_bytes), bytes_text(cost.needs.disk_free)))};
    if (cost.time) {
        root.entries.push_back(
            words("wall_time", "of the run, estimated",
                  text("{}, {:.3g} ms per step", duration_text(cost.time->total), 1e3 * cost.time->step)));
        root.entries.push_back(number("seconds_a_step", "s", "wall time of a step, estimated", cost.time->step));
        root.entries.push_back(number("seconds", "s", "wall time of the run, estimated", cost.time->total));
        for (Entry* entry : {&root.entries.back(), &root.entries.end()[-2]}) entry->shown.text = false;
    }
    root.lists = {fields_of(equations), terms_of(equations), coefficients_of(equations.model(), scene.declared.tables)};
    return result;
}

}  // namespace drover::run
