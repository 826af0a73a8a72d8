// python/model.cpp: models of declared fields and equations for Python.
#include <pybind11/complex.h>
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>

#include "base/formula.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/model/evolution.hpp"
#include "drover/theory/theory.hpp"
#include "io/declared_model.hpp"
#include "model/lowering.hpp"
#include "python/bindings.hpp"

namespace drover::python {

namespace py = pybind11;

namespace {
/// A text of the field of a symbol; errors call its place "symbol.key".
model::Text text_of(const std::string& symbol, const std::string& key, const std::string& text) {
    return {text, {.file = symbol + "." + key, .line = 1, .column = 1}};
}

/// A number, or a formula of the coefficients.
std::string formula_of(const py::handle& given) {
    return py::isinstance<py::str>(given) ? given.cast<std::string>() : toml_text(given.cast<double>());
}

io::FieldParity parity_of(const py::dict& given) {
    return given["odd"].cast<bool>() ? io::FieldParity::odd : io::FieldParity::even;
}

void add_field(const py::dict& given, io::DeclaredModel& model) {
    const auto symbol = given["symbol"].cast<std::string>();
    std::map<std::string, SourceLocation> places{{"", {.file = symbol}}};
    for (const char* key : {"mass", "reference", "noise"}) places.emplace(key, text_of(symbol, key, "").where);
    model.fields.push_back({.name = given["name"].cast<std::string>(),
                            .symbol = symbol,
                            .rank = given["complex"].cast<bool>() ? io::FieldRank::complex : io::FieldRank::scalar,
                            .spin = given["complex"].cast<bool>() ? -1 : given["spin"].cast<int>(),
                            .parity = parity_of(given),
                            .unit = given["unit"].cast<std::string>(),
                            .meaning = given["meaning"].cast<std::string>(),
                            .mass = given["mass"].cast<std::string>(),
                            .mass_unit = given["mass_unit"].cast<std::string>(),
                            .energy = given["energy"].cast<std::string>(),
                            .balance = given["balance"].cast<bool>(),
                            .conserved = given["conserved"].cast<bool>(),
                            .solenoidal = given["solenoidal"].cast<bool>(),
                            .reference = formula_of(given["reference"]),
                            .noise = formula_of(given["noise"]),
                            .conserved_noise = given["conserved_noise"].cast<bool>(),
                            .places = std::move(places)});
    model.equations.emplace(symbol, text_of(symbol, "equation", given["equation"].cast<std::string>()));
}

void add_noise(const py::dict& given, io::DeclaredModel& model) {
    const auto symbol = given["symbol"].cast<std::string>();
    model.noises.push_back(
        {.symbol = symbol, .spin = given["spin"].cast<int>(), .parity = parity_of(given), .where = {.file = symbol}});
}

void add_table(const py::dict& given, io::DeclaredModel& model) {
    const auto symbol = given["symbol"].cast<std::string>(), outside = given["outside"].cast<std::string>();
    const auto found = value_named<numerics::Outside>(outside);
    require(found.has_value(), {.file = symbol}, "{} has outside = \"{}\"; expected refuse or hold", symbol, outside);
    model.tables.push_back({.symbol = symbol,
                            .of = given["of"].cast<std::vector<std::string>>(),
                            .first = given["first"].cast<std::vector<double>>(),
                            .second = given["second"].cast<std::vector<double>>(),
                            .values = given["values"].cast<std::vector<double>>(),
                            .outside = *found,
                            .where = {.file = symbol}});
}

/// Warns of those of the `named` coefficients that no equation has.
model::Equations equations_from(const py::list& fields, const py::list& noises, const py::list& tables,
                                const std::map<std::string, std::string>& definitions,
                                const std::map<std::string, double>& coefficients, bool chiral,
                                const std::vector<std::string>& named) {
    io::DeclaredModel model;
    model.chiral = chiral;
    model.coefficients = coefficients;
    for (const py::handle& field : fields) add_field(field.cast<py::dict>(), model);
    for (const py::handle& noise : noises) add_noise(noise.cast<py::dict>(), model);
    for (const py::handle& table : tables) add_table(table.cast<py::dict>(), model);
    for (const auto& [name, text] : definitions)
        model.definitions.emplace(name, model::Text{text, {.file = name, .line = 1, .column = 1}});
    model::Equations equations(io::model_of(model));
    const std::vector<std::string> idle = io::without_effect(model);
    for (const std::string& name : named) {
        if (std::ranges::find(idle, "coefficients." + name) == idle.end()) continue;
        const std::string warning =
            text("{} has no effect: no equation of this model has it, and it is no argument", name);
        if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 2) != 0) throw py::error_already_set();
    }
    return equations;
}

py::list terms_of(const model::Equations& equations) {
    py::list terms;
    for (const model::TermSummary& term : equations.terms()) terms.append(py::make_tuple(term.field, term.text));
    return terms;
}

/// An evolution, and the shape of its fields.
struct ShapedEvolution {
    ShapedEvolution(const model::Equations& equations, const model::EvolutionControl& control)
        : evolution(equations, control),
          shape{static_cast<py::ssize_t>(equations.state_components().size()), control.grid.ny, control.grid.nx} {}

    model::Evolution evolution;
    std::vector<py::ssize_t> shape;
};
using Evolution = Guarded<ShapedEvolution>;

void advance_evolution(Evolution& guarded, std::int64_t steps) {
    require(steps >= 0, {}, "steps = {}; expected 0 or more: a run does not go back", steps);
    const Use use(guarded);
    constexpr std::int64_t steps_at_a_time = 16;  // Python handles signals in between
    for (std::int64_t done = 0; done < steps; done += steps_at_a_time) {
        {
            const py::gil_scoped_release unlocked;
            use->evolution.advance(std::min(steps_at_a_time, steps - done));
        }
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    }
}

using Wave = std::pair<double, double>;  // q_x and q_y
}  // namespace

void bind_model(py::module_& module) {
    py::class_<model::Equations>(module, "Equations")
        .def(py::init(&equations_from))
        .def("terms", &terms_of)
        .def("components",
             [](const model::Equations& e) {
                 std::vector<std::string> names;
                 for (const model::Field& field : e.model().fields)
                     if (field.left != model::LeftSide::given)
                         for (const std::string& name : model::dataset_names(field)) names.push_back(name);
                 return names;
             })
        .def("state_components", &model::Equations::state_components)
        .def("reference", &model::Equations::reference)
        .def("degree", &model::Equations::degree)
        .def("has_finite_degree", &model::Equations::has_finite_degree)
        .def("transforms",
             [](const model::Equations& e) {
                 const model::TransformCount count = e.transforms();
                 return py::make_tuple(count.inverse, count.forward);
             })
        .def("uniform_rates",
             [](const model::Equations& e, const model::UniformState& at) {
                 const model::TermSummary* placed = e.placed_term();
                 require(placed == nullptr, placed ? placed->where : SourceLocation{},
                         "the term \"{}\" depends on position or time, so that no state is uniform; expected a term "
                         "of the fields alone",
                         placed ? placed->text : "");
                 return e.uniform_rates(at);
             })
        .def("symbol",
             [](const model::Equations& e, const model::UniformState& about, double qx, double qy) {
                 return e.symbol(about, {qx, qy});
             })
        .def("term_symbol",
             [](const model::Equations& e, std::size_t term, const model::UniformState& about, double qx, double qy) {
                 return e.term_symbol(term, about, {qx, qy});
             })
        .def("noise",
             [](const model::Equations& e, const model::UniformState& about, double qx, double qy) {
                 return e.noise(about, {qx, qy});
             })
        .def("mode_rates",
             [](const model::Equations& e, const model::UniformState& about, const std::vector<Wave>& waves) {
                 const model::LinearisedAt at(e, about);
                 return mapped(waves, [&](const Wave& q) { return theory::mode_rates(at, {q.first, q.second}); });
             })
        .def("covariances",
             [](const model::Equations& e, const model::UniformState& about, const std::vector<Wave>& waves) {
                 const model::LinearisedAt at(e, about);
                 std::vector<model::Symbol> matrices;
                 for (const auto& [qx, qy] : waves) {
                     const theory::Covariance found = theory::covariance(at, {qx, qy});
                     require(found.why_none.empty(), {},
                             "{}; expected a state in which all modes decay, where the noise is balanced",
                             found.why_none);
                     matrices.push_back(found.matrix(e.state_components(), e.state_components()));
                     require(matrices.back().allFinite(), {},
                             "the noise of the model is not finite in this uniform state; expected another state");
                 }
                 return matrices;
             })
        .def("latex", &model::Equations::latex)
        .def("noise_strengths",
             [](const model::Equations& e) { return mapped(e.model().fields, &model::Field::noise); });
    module.def("latex_of_name", &latex_of_name);
    module.def("latex_of", [](const std::string& formula, const std::map<std::string, std::string>& names) {
        return latex_of(parse_formula(FormulaText(formula, {}), model::equation_notation()), [&](const std::string& n) {
            const auto found = names.find(n);
            return found == names.end() ? latex_of_name(n) : found->second;
        });
    });
    py::class_<Evolution>(module, "Evolution")
        .def(py::init([](const model::Equations& equations, int nx, int ny, double lx, double ly, double dt,
                         const std::string& method, std::uint64_t seed, int threads) {
            return std::make_unique<Evolution>(equations,
                                               model::EvolutionControl{.grid = {.nx = nx, .ny = ny, .lx = lx, .ly = ly},
                                                                       .dt = dt,
                                                                       .method = method,
                                                                       .seed = seed,
                                                                       .threads = threads});
        }))
        .def("advance", &advance_evolution)
        .def("step", [](Evolution& g) { return Use(g)->evolution.step(); })
        .def("time", [](Evolution& g) { return Use(g)->evolution.time(); })
        .def("fields",
             [](Evolution& g) { return py::array_t<double>(g.held.shape, Use(g)->evolution.fields().values.data()); })
        .def("balanced",
             [](Evolution& g) {
                 const numerics::Fields fields = Use(g)->evolution.balanced();
                 const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(fields.values.size() / fields.size),
                                                      g.held.shape[1], g.held.shape[2]};
                 return py::array_t<double>(shape, fields.values.data());
             })
        .def("set_fields", [](Evolution& g, const py::array_t<double, py::array::c_style>& values) {
            numerics::Fields fields;
            fields.values.assign(values.data(), values.data() + values.size());
            fields.size = static_cast<std::size_t>(g.held.shape[1]) * static_cast<std::size_t>(g.held.shape[2]);
            Use(g)->evolution.set_fields(fields);
        });
}

}  // namespace drover::python
