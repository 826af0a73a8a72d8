// io/scene_declared.cpp: a declared model between TOML tables and a scene; a search through the formulas of a model.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/mapped.hpp"
#include "drover/base/expression.hpp"
#include "io/declared_model.hpp"
#include "io/scene_parts.hpp"
#include "numerics/algebra/spline_table.hpp"

namespace drover::io {

namespace {
bool is_complex(const DeclaredField& field) { return field.rank == FieldRank::complex; }

/// Calls `read` with each table of a list, list[1] and so on, and with its name.
template <class Read>
void for_list(const LocatedTables& tables, const char* list, Read read) {
    for (std::size_t n = 1;; ++n) {
        const std::string section = text("{}[{}]", list, n);
        const auto table = tables.find(section);
        if (table == tables.end()) return;
        read(table->second, section);
    }
}

/// Keys of a field that may be a number or a formula of the coefficients.
bool is_formula_key(const std::string& key) { return key == "noise" || key == "reference"; }

/// The place of the first character of a text, or of its key.
SourceLocation text_place(const LocatedValue& found) { return found.items.empty() ? found.where : found.items[0]; }

std::map<std::string, model::Text> texts_of_section(const LocatedTables& tables, const std::string& section) {
    const auto table = tables.find(section);
    return table == tables.end() ? std::map<std::string, model::Text>{} : texts_of(table->second, section);
}

void read_field(const LocatedTable& table, const std::string& section, DeclaredModel& model) {
    LocatedTable with_texts = table;
    DeclaredField& field = model.fields.emplace_back();
    field.places.emplace("", table.where);
    for (auto& [key, found] : with_texts.values) {
        require(key != "equation" && key != "equations", found.where,
                "unknown key {}.{}; expected the equation below [equations], by the symbol of the field, as phi = "
                "\"lap phi\"",
                section, key);
        if (is_formula_key(key) && !std::holds_alternative<std::string>(found.value))
            found.value = toml_text(found.value);
        field.places.emplace(key, text_place(found));
    }
    read_table(with_texts, section, field);
    require(!field.symbol.empty(), table.where, "{} has no symbol; expected one, such as symbol = \"phi\"", section);
}

SourceLocation place_of(const DeclaredField& field, const std::string& key) {
    const auto found = field.places.find(key);
    return found == field.places.end() ? field.places.at("") : found->second;
}

double number_of(const std::string& written, const DeclaredModel& declared, const SourceLocation& where) {
    const Expression formula =
        parse_expression(written,
                         {.variables = {}, .constants = {declared.coefficients.begin(), declared.coefficients.end()}},
                         where);
    return evaluate(formula, {});
}

int spin_of_rank(FieldRank rank) { return rank == FieldRank::complex ? 0 : static_cast<int>(rank); }

int spin_of_field(const DeclaredField& field) {
    const int rank = spin_of_rank(field.rank);
    require(field.spin < 0 || !is_complex(field), place_of(field, "spin"),
            "{} has rank = \"complex\" and spin = {}; expected no spin: it does not turn", field.symbol, field.spin);
    require(field.spin < 0 || !field.places.contains("rank") || field.spin == rank, place_of(field, "spin"),
            "{} has rank = \"{}\" and spin = {}; expected one of them", field.symbol, field.rank, field.spin);
    return field.spin >= 0 ? field.spin : rank;
}

/// Each field has an equation, and each equation a field.
void check_equations(const DeclaredModel& declared) {
    const std::vector<std::string> symbols = mapped(declared.fields, &DeclaredField::symbol);
    for (const auto& [symbol, equation] : declared.equations) {
        if (std::ranges::find(symbols, symbol) != symbols.end()) continue;
        fail_input(equation.where, "equations.{} is the equation of no field; {}", symbol,
                   suggestion(symbol, symbols,
                              symbols.empty() ? text("expected [[field]] with symbol = \"{}\"", symbol)
                                              : text("expected one of {}", joined(symbols))));
    }
    for (const DeclaredField& field : declared.fields) {
        require(std::ranges::count(symbols, field.symbol) == 1, place_of(field, "symbol"),
                "{} is the symbol of two fields; expected one of its own for each", field.symbol);
        require(declared.equations.contains(field.symbol), place_of(field, "symbol"),
                "{0} has no equation; expected {0} = \"...\" in [equations], or \"\" for a field that does not change",
                field.symbol);
    }
}

/// Components are datasets of an archive, beside its own, and keys of [initial].
void check_dataset_names(const model::Model& model, const DeclaredModel& declared) {
    std::vector<std::string> taken{"time", "x", "y", "observables", "summary", "step_bias"};
    const std::vector<std::string> keys = mapped(descriptions<model::Start>(), &Description::name);
    std::size_t n = 0;
    for (std::size_t k = 0; k < model.fields.size(); n += model.fields[k++].part != model::Part::real)
        for (const std::string& name : model::dataset_names(model.fields[k])) {
            require(std::ranges::find(taken, name) == taken.end(), place_of(declared.fields[n], "name"),
                    "{} would be {} in archives, which is the name of something else there; expected another name",
                    model.fields[k].symbol, name);
            require(std::ranges::find(keys, name) == keys.end(), place_of(declared.fields[n], "name"),
                    "{} would start as initial.{}, which is another key; expected another name", model.fields[k].symbol,
                    name);
            taken.push_back(name);
        }
}

/// A complex field is two scalars, of which its symbol is a definition; its equation belongs to both.
void add_complex(model::Field field, model::Model& result) {
    const std::string symbol = field.symbol, name = field.name;
    result.definitions.push_back({symbol, {text("{}_re + i {}_im", symbol, symbol), field.where}});
    for (const char* function : {"re", "im", "conj"}) result.functions[function] = {};
    const double reference = field.reference;
    for (const auto& [end, part] : {std::pair{"_re", model::Part::real}, std::pair{"_im", model::Part::imaginary}}) {
        field.symbol = symbol + end;
        field.name = name + end;
        field.part = part;
        field.reference = part == model::Part::real ? reference : 0.0;
        result.fields.push_back(field);
    }
}

/// The value of a table at points of a run, where a refusal names the place; in one uniform state, which theory may
/// only try, it is NaN.
model::GivenFunction function_of(const DeclaredTable& declared) {
    const std::vector<double> second = declared.second.empty() ? std::vector<double>{0.0} : declared.second;
    const auto table = [&] {
        try {
            return std::make_shared<const numerics::SplineTable>(declared.first, second, declared.values,
                                                                 declared.outside);
        } catch (const Error& error) {
            fail_input(declared.where, "{}: {}", declared.symbol, error.message());
        }
    }();
    const auto at = [table, declared](std::span<const double> place, bool is_of_run) {
        const numerics::TableValue found = table->at(place[0], place.size() > 1 ? place[1] : 0.0);
        if (!is_of_run || std::isfinite(found.value) || !std::isfinite(place[0] + place.back())) return found;
        for (std::size_t k = 0; k < place.size(); ++k) {
            const std::vector<double>& nodes = k == 0 ? declared.first : declared.second;
            if (place[k] >= nodes.front() && place[k] <= nodes.back()) continue;
            throw Error(Fault::run, declared.where,
                        text("the table {} is read at {} = {:.6g}; expected {} to {}: give a wider table, or outside "
                             "= \"hold\"",
                             declared.symbol, declared.of[k], place[k], nodes.front(), nodes.back()));
        }
        return found;
    };
    const int arguments = static_cast<int>(declared.of.size());
    return {.arguments = arguments,
            .has_finite_degree = false,
            .values =
                [at](std::size_t size, std::span<const model::PointArgument> given, std::span<double* const> out) {
                    std::array<double, 2> place{};
                    for (std::size_t i = 0; i < size; ++i) {
                        for (std::size_t a = 0; a < given.size(); ++a)
                            place[a] = given[a].values != nullptr ? given[a].values[i] : given[a].number;
                        out[0][i] = at(std::span(place).first(given.size()), size > 1).value;
                    }
                },
            .slopes =
                [at](std::span<const double> place) {
                    const numerics::TableValue found = at(place, false);
                    std::vector<double> slopes{found.by_first, found.by_second};
                    slopes.resize(place.size());
                    return slopes;
                }};
}

/// A table is a function, and its symbol is a definition of its value.
void add_table(const DeclaredTable& table, model::Model& result) {
    const SourceLocation& where = table.where;
    require(!table.symbol.empty(), where, "[[tabulated]] has no symbol; expected one, such as symbol = \"a\"");
    require(table.of.size() == 1 || table.of.size() == 2, where,
            "{} is a table of {} scalars; expected of = [\"rho\"] or of = [\"rho\", \"sigma\"]", table.symbol,
            table.of.size());
    require((table.of.size() == 2) == !table.second.empty(), where,
            "{} is a table of {} and has {} numbers in `second`; expected {}", table.symbol, joined(table.of),
            table.second.size(), table.of.size() == 2 ? "the values of the second one" : "none");
    require(table.first.size() != 1 && table.second.size() != 1, where,
            "{} is a table with one number along an axis; expected two or more: without a slope it is a coefficient",
            table.symbol);
    const std::string function = "tabulated_" + table.symbol;
    result.functions[function] = function_of(table);
    result.definitions.push_back({table.symbol, {text("{}({})", function, joined(table.of)), where}, true});
}

/// Of a field or a noise, with its rank or its spin.
template <class Declared>
WrittenTable written_item(const char* list, std::size_t number, const Declared& one) {
    WrittenTable table{.name = text("{}[{}]", list, number), .values = values_of(one)};
    std::erase_if(table.values, [&](const auto& value) { return value.first == (one.spin >= 0 ? "rank" : "spin"); });
    return table;
}

/// What a scene declares for its equations.
struct DeclaredName {
    std::string place;                  ///< for people
    std::vector<std::string> names;     ///< in formulas
    std::vector<std::string> formulas;  ///< of what it is
};

std::vector<DeclaredName> declared_names(const DeclaredModel& model) {
    std::vector<DeclaredName> all;
    for (const auto& [name, value] : model.coefficients) all.push_back({"coefficients." + name, {name}, {}});
    for (const auto& [name, value] : model.definitions) all.push_back({"define." + name, {name}, {value.text}});
    for (const DeclaredTable& table : model.tables)
        all.push_back({"[[tabulated]] " + table.symbol, {table.symbol}, table.of});
    for (const DeclaredNoise& noise : model.noises) {
        all.push_back({"[[white_noise]] " + noise.symbol, {noise.symbol}, {}});
        for (const int spin : {1, 2, 3})
            for (std::string& name : component_names(model::Field{.symbol = noise.symbol, .spin = spin}))
                all.back().names.push_back(std::move(name));
    }
    return all;
}
}  // namespace

std::map<std::string, model::Text> texts_of(const LocatedTable& table, const std::string& section) {
    std::map<std::string, model::Text> texts;
    for (const auto& [name, found] : table.values) {
        const auto* written = std::get_if<std::string>(&found.value);
        const auto number = std::get_if<double>(&found.value);
        const auto whole = std::get_if<std::int64_t>(&found.value);
        require(written || number || whole, found.where, "{}.{} = {}; expected a formula in quotes", section, name,
                toml_text(found.value));
        texts.emplace(name, model::Text{written ? *written : toml_text(found.value), text_place(found)});
    }
    return texts;
}

bool is_in_declared_list(const std::string& name) {
    return std::any_of(std::begin(declared_lists), std::end(declared_lists),
                       [&](const std::string& list) { return name.starts_with(list + "["); });
}

bool is_declared_table(const std::string& name) {
    return is_in_declared_list(name) ||
           std::find(std::begin(declared_tables), std::end(declared_tables), name) != std::end(declared_tables);
}

void read_declared(const LocatedTables& tables, DeclaredModel& model, std::map<std::string, SourceLocation>& places) {
    if (const auto table = tables.find("model"); table != tables.end()) read_table(table->second, "model", model);
    model.file.clear();  // its content is among the tables
    for_list(tables, "field",
             [&](const LocatedTable& table, const std::string& section) { read_field(table, section, model); });
    for_list(tables, "white_noise", [&](const LocatedTable& table, const std::string& section) {
        read_table(table, section, model.noises.emplace_back());
        require(!model.noises.back().symbol.empty(), table.where,
                "{} has no symbol; expected one, such as symbol = \"xi\"", section);
        model.noises.back().where = table.where;
    });
    for_list(tables, "tabulated", [&](const LocatedTable& table, const std::string& section) {
        read_table(table, section, model.tables.emplace_back());
        model.tables.back().where = table.where;
    });
    model.equations = texts_of_section(tables, "equations");
    model.definitions = texts_of_section(tables, "define");
    if (const auto table = tables.find("coefficients"); table != tables.end())
        for (const auto& [name, found] : table->second.values) {
            const Description row{.name = name, .default_value = 0.0, .doc = "a coefficient of the equations"};
            model.coefficients[name] = std::get<double>(checked_value(row, "coefficients", found));
            places.emplace("coefficients." + name, found.where);
        }
}

std::vector<std::string> component_names(const DeclaredModel& model) {
    std::vector<std::string> components;
    for (const DeclaredField& declared : model.fields) {
        model::Field field{.symbol = declared.symbol, .spin = spin_of_field(declared)};
        field.name = declared.name.empty() ? field.symbol : declared.name;
        std::vector<std::string> names = model::dataset_names(field);
        if (is_complex(declared)) names = {field.name + "_re", field.name + "_im"};
        components.insert(components.end(), names.begin(), names.end());
    }
    return components;
}

model::Model model_of(const DeclaredModel& declared) {
    model::Model result{.coefficients = declared.coefficients,
                        .chiral = declared.chiral,
                        .noise_moment = declared.noise_moment};
    for (const DeclaredField& given : declared.fields) {
        model::Field field{.name = given.name.empty() ? given.symbol : given.name,
                           .symbol = given.symbol,
                           .spin = spin_of_field(given),
                           .odd = given.parity == FieldParity::odd,
                           .unit = given.unit,
                           .meaning = given.meaning,
                           .left = given.balance ? model::LeftSide::balance : model::LeftSide::rate,
                           .mass = {given.mass, place_of(given, "mass")},
                           .conserved = given.conserved,
                           .solenoidal = given.solenoidal,
                           .reference = number_of(given.reference, declared, place_of(given, "reference")),
                           .noise = number_of(given.noise, declared, place_of(given, "noise")),
                           .noise_conserves = given.conserved_noise,
                           .observed = {.energy = given.energy, .mass_unit = given.mass_unit},
                           .where = place_of(given, "")};
        if (const auto equation = declared.equations.find(given.symbol); equation != declared.equations.end())
            field.equation = equation->second;
        if (is_complex(given)) add_complex(std::move(field), result);
        else result.fields.push_back(std::move(field));
    }
    for (const DeclaredNoise& noise : declared.noises)
        result.noises.push_back({.symbol = noise.symbol,
                                 .spin = noise.spin >= 0 ? noise.spin : spin_of_rank(noise.rank),
                                 .odd = noise.parity == FieldParity::odd,
                                 .where = noise.where});
    for (const DeclaredTable& table : declared.tables) add_table(table, result);
    check_equations(declared);
    check_dataset_names(result, declared);
    for (const auto& [name, value] : declared.definitions) result.definitions.push_back({name, value});
    return result;
}

WrittenTables written_model(const DeclaredModel& model) {
    WrittenTables tables{{.name = "model", .values = values_of(model)}};
    for (std::size_t n = 0; n < model.fields.size(); ++n)
        tables.push_back(written_item("field", n + 1, model.fields[n]));
    for (std::size_t n = 0; n < model.noises.size(); ++n)
        tables.push_back(written_item("white_noise", n + 1, model.noises[n]));
    for (std::size_t n = 0; n < model.tables.size(); ++n)
        tables.push_back({.name = text("tabulated[{}]", n + 1), .values = values_of(model.tables[n])});
    for (const auto& [section, texts] :
         {std::pair{"equations", &model.equations}, std::pair{"define", &model.definitions}}) {
        if (texts->empty()) continue;
        tables.push_back({.name = section, .values = {}});
        for (const auto& [name, value] : *texts) tables.back().values.emplace_back(name, value.text);
    }
    if (!model.coefficients.empty())
        tables.push_back({.name = "coefficients", .values = {model.coefficients.begin(), model.coefficients.end()}});
    return tables;
}

Rows<DeclaredModel> DeclaredModel::rows() {
    return Rows<DeclaredModel>{
        {"name", &DeclaredModel::name, "its name"},
        {"file", &DeclaredModel::file,
         "a file in the folder of the scene, or among the installed models, with [[field]], [equations], [define] and "
         "[coefficients], to which the scene adds its own; of a number or an equation that both have, that of the "
         "scene counts; of a whole scene the model alone"},
        {"chiral", &DeclaredModel::chiral,
         "the equations may distinguish left and right: terms whose parity differs from that of the field"},
        {"calculus", &DeclaredModel::calculus,
         "the sense of noise that multiplies fields; the drift of stratonovich is proportional to the number of modes "
         "per area, so it depends on the grid: drover explain prints both"},
    };
}

Rows<DeclaredField> DeclaredField::rows() {
    return Rows<DeclaredField>{
        {"symbol", &DeclaredField::symbol, "its name in equations: \"phi\""},
        {"name", &DeclaredField::name, "its name in figures and archives: \"rod_density\"; empty: the symbol"},
        {"rank", &DeclaredField::rank,
         "how it transforms under rotations: a scalar (spin 0), a vector (1), a nematic Q_xx + i Q_xy (2); complex: "
         "two scalars, A = A_re + i A_im"},
        {"spin", &DeclaredField::spin,
         "in place of rank: the field rotates by this many times the angle of a rotation; -1: as rank says", "",
         within(-1, 6)},
        {"parity", &DeclaredField::parity,
         "odd: a reflection changes its sign, besides what its rank does: a pseudoscalar, such as a vorticity"},
        {"unit", &DeclaredField::unit, "its unit, for figures and archives"},
        {"meaning", &DeclaredField::meaning, "what it is, for people"},
        {"mass", &DeclaredField::mass, "m of m d_t F = equation, a formula of the fields: \"m rho\"; empty: 1"},
        {"mass_unit", &DeclaredField::mass_unit, "unit of the mass, for its energy"},
        {"energy", &DeclaredField::energy,
         "what output.powers calls its energy, the integral of m F^2/2: energy_flow of \"flow\"; empty: the name "
         "of the field; none: it is not measured"},
        {"balance", &DeclaredField::balance, "0 = equation: the field follows the others at every instant"},
        {"solenoidal", &DeclaredField::solenoidal,
         "a vector without divergence: a pressure, which is eliminated, keeps it so at every instant"},
        {"conserved", &DeclaredField::conserved,
         "its mean does not change; an equation that is not a divergence is then an error"},
        {"reference", &DeclaredField::reference,
         "of a scalar: its uniform value at the start, about which the linear part is exact; a number, or a "
         "formula of the coefficients"},
        {"noise", &DeclaredField::noise,
         "D: noise f of its own in d_t F with <f f> = D delta(r - r') delta(t - t') for each component; a "
         "number, or a formula of the coefficients"},
        {"conserved_noise", &DeclaredField::conserved_noise,
         "the noise is the divergence of a random flux: D q^2 in place of D"},
    };
}

Rows<DeclaredNoise> DeclaredNoise::rows() {
    return Rows<DeclaredNoise>{
        {"symbol", &DeclaredNoise::symbol,
         "its name in equations: \"xi\" of unit strength, <xi xi> = delta(r - r') delta(t - t') for each "
         "component; equations that have it are driven by the same noise"},
        {"rank",
         &DeclaredNoise::rank,
         "how it transforms under rotations, as for a field",
         "",
         any_number,
         {"scalar", "vector", "nematic"}},
        {"spin", &DeclaredNoise::spin, "in place of rank; -1: as rank says", "", within(-1, 6)},
        {"parity", &DeclaredNoise::parity, "odd: of equations of pseudoscalars and the like"},
    };
}

Rows<DeclaredTable> DeclaredTable::rows() {
    return Rows<DeclaredTable>{
        {"symbol", &DeclaredTable::symbol,
         "its name in equations: a coefficient that is a smooth function of one or two scalars"},
        {"of", &DeclaredTable::of, "the scalars, as formulas of the fields: [\"rho\"], [\"rho\", \"sigma\"]"},
        {"first", &DeclaredTable::first, "values of the first scalar, ascending"},
        {"second", &DeclaredTable::second, "values of the second one, ascending"},
        {"values", &DeclaredTable::values,
         "values of the coefficient: for each of `first` those of all of `second`; between them a cubic spline"},
        {"outside", &DeclaredTable::outside, "beyond the table: refuse: an error; hold: the value at its edge"},
    };
}

bool mentions(const std::string& formula, const std::vector<std::string>& names) {
    const auto in_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    const char *at = formula.data(), *const last = at + formula.size();
    while (at < last) {
        if (std::isdigit(static_cast<unsigned char>(*at)) != 0 || *at == '.') {  // "2k" is 2 times k
            double number = 0.0;
            at = std::max(at + 1, std::from_chars(at, last, number).ptr);
            continue;
        }
        const char* const end = std::find_if_not(at, last, in_name);
        if (std::ranges::find(names, std::string(at, end)) != names.end()) return true;
        at = std::max(at + 1, end);
    }
    return false;
}

std::vector<std::string> without_effect(const DeclaredModel& model) {
    std::vector<DeclaredName> idle = declared_names(model);
    std::vector<std::string> formulas;
    for (const auto& [symbol, equation] : model.equations) formulas.push_back(equation.text);
    for (const DeclaredField& field : model.fields)
        formulas.insert(formulas.end(), {field.reference, field.noise, field.mass});
    while (!formulas.empty()) {
        const std::string formula = std::move(formulas.back());
        formulas.pop_back();
        std::erase_if(idle, [&](const DeclaredName& one) {
            const bool is_there = mentions(formula, one.names);
            if (is_there) formulas.insert(formulas.end(), one.formulas.begin(), one.formulas.end());
            return is_there;
        });
    }
    return mapped(idle, &DeclaredName::place);
}

}  // namespace drover::io
