// io/scene.cpp: the sections of a scene: read from tables, written as TOML, described.
#include "io/scene.hpp"

#include <algorithm>
#include <iterator>
#include <tuple>

#include "base/mapped.hpp"
#include "io/scene_parts.hpp"
#include "physics/integrated.hpp"
#include "physics/model_values.hpp"

namespace drover::io {

namespace {
/// The kinds of scenes that have a section.
enum SectionOf : unsigned { fields = 1, particles = 2, declared = 4, grids = fields | declared, all = 7 };

constexpr std::array scene_kinds{SceneKind::fields, SceneKind::particles, SceneKind::model};

SectionOf section_of(SceneKind kind) {
    return std::array{fields, particles, declared}.at(static_cast<std::size_t>(kind));
}

const char* words(SceneKind kind) { return kind == SceneKind::model ? "a model of its own" : name_of(kind); }

constexpr const char* initial_section = "initial";

/// All sections of all scenes but those of the model, which come first in a scene of fields.
template <class AnyScene, class Visit>
void for_sections(AnyScene& scene, Visit visit) {
    const auto of = [&](SectionOf kind) {
        return [&visit, kind](const std::string& name, const char* doc, auto& part) { visit(kind, name, doc, part); };
    };
    const auto of_fields = of(fields), of_particles = of(particles), of_grids = of(grids), of_all = of(all);
    of_grids("grid", "The periodic cell and its grid.", scene.grid);
    of_grids("dealiasing", "Dealiasing of products of fields.", scene.dealiasing);
    of_grids("approximation", "What the equations leave out.", scene.approximation);
    dem::for_sections(scene.particles, of_particles);
    of_all("time", "Time stepping.", scene.time);
    of_grids(initial_section, "The initial state.", scene.initial);
    of_all("output", "Output files and intervals.", scene.output);
    of_all("analysis", "Time averages.", scene.analysis);
    of_grids("accuracy", "The errors of the results of a run.", scene.accuracy);
    of_grids("units", "Names of the units in results.", scene.units);
    of_all("run", "Seed and threads.", scene.run);
    of_all("sweep", "Many runs of this scene; used by drover sweep only.", scene.sweep);
    of_grids("stability", "Wavevectors of the linear stability analysis; used by drover stability only.",
             scene.stability);
    of_particles("calibrate", "Measurements and their target errors; used by drover calibrate only.",
                 scene.calibration);
    calibrate::for_plans(scene.plans, [&](const std::string& name, const char* doc, auto& plan) {
        of_particles("calibrate." + name, doc, plan);
    });
    of_fields("calibrated", "A table of coefficients that replaces numbers of the model.", scene.calibrated);
    of_grids("boundary", "A plane of two model numbers; used by drover boundary only.", scene.boundary);
}

/// Keys of shared sections that not all scenes with the section have.
struct KeyOf {
    const char* key;
    SectionOf kinds;
};
constexpr std::array keys_of_kinds{KeyOf{"time.stepper", grids},   KeyOf{"time.tolerance", grids},
                                   KeyOf{"time.max_error", grids}, KeyOf{"time.chosen", grids},
                                   KeyOf{"time.pilot", grids},     KeyOf{"output.powers", grids}};

/// The keys of a section that drover writes, its last; their defaults are what was found.
std::vector<Description> found_keys(const std::string& section, const Found& found = {}) {
    if (section == "time")
        return {{.name = "chosen",
                 .default_value = std::string(name_of(found.step.by)),
                 .choices = all_names<ChosenBy>(),
                 .doc = "written by drover: dt was left out and chosen for the error of the fields, of time means "
                        "(with noise, or chaotic), or for a linear model, of which every step is exact; empty: dt "
                        "was given; fields only"},
                {.name = "pilot",
                 .default_value = found.step.pilot,
                 .doc = "written by drover: the error and the pilot runs from which dt was chosen"}};
    if (section != "calibrated") return {};
    const std::vector<std::string> filled = mapped(found.filled, [](const calibrate::FilledNumber& one) {
        return one.origin.empty() ? one.key : one.key + ": " + one.origin;
    });
    return {{.name = "filled",
             .default_value = filled,
             .doc = "written by drover: what came from the table, its origin and its error; leave it out"},
            {.name = "expected",
             .default_value = found.expected,
             .doc = "written by drover: what the mean field of the table expects; leave it out"}};
}

bool is_of(SceneKind kind, SectionOf section) { return (section & section_of(kind)) != 0; }

bool is_of(SceneKind kind, const std::string& key) {
    const auto found = std::ranges::find_if(keys_of_kinds, [&](const KeyOf& one) { return key == one.key; });
    return found == keys_of_kinds.end() || is_of(kind, found->kinds);
}

std::string kinds_text(SectionOf kinds) {
    std::string result;
    for (const SceneKind kind : scene_kinds)
        if (is_of(kind, kinds) && !(kinds == grids && kind == SceneKind::model))
            result += (result.empty() ? "" : " or ") + std::string(words(kind));
    return result;
}

std::vector<std::string> section_names(SectionOf kind) {
    std::vector<std::string> names;
    if (kind == fields)
        for (const physics::ModelSection& section : physics::model_sections()) names.push_back(section.name);
    if (kind == declared) names.insert(names.end(), std::begin(declared_tables), std::end(declared_tables));
    const Scene defaults;
    for_sections(defaults, [&](SectionOf belongs, const std::string& name, const char*, const auto&) {
        if (belongs == kind) names.push_back(name);
    });
    return names;
}

/// The kind of a scene, from its sections.  Throws an input Error when sections of two kinds are present.
SceneKind kind_of(const LocatedTables& tables) {
    const auto first_of = [&](SectionOf kind) {
        for (const std::string& name : section_names(kind))
            if (const auto table = tables.find(name); table != tables.end()) return table;
        if (kind == fields) return tables.find("terms[1]");
        return kind == declared ? tables.find("field[1]") : tables.end();
    };
    SceneKind kind = SceneKind::fields;
    auto decisive = tables.end();
    const auto reject = [&](const auto& found, SectionOf belongs) {
        fail_input(
            found->second.where,
            "[{}] belongs to a scene of {}, [{}] ({}) to one of {}; expected sections of one kind: remove one of "
            "them",
            found->first, kinds_text(belongs), decisive->first, location_text(decisive->second.where), words(kind));
    };
    for (const SceneKind one : {SceneKind::model, SceneKind::particles, SceneKind::fields}) {
        const auto found = first_of(section_of(one));
        if (found == tables.end()) continue;
        if (decisive != tables.end()) reject(found, section_of(one));
        kind = one;
        decisive = found;
    }
    if (const auto found = first_of(grids); kind == SceneKind::particles && found != tables.end()) reject(found, grids);
    return kind;
}

void reject_keys_of_others(const Scene& scene) {
    for (const KeyOf& one : keys_of_kinds) {
        if (is_of(scene.kind, one.kinds)) continue;
        if (const auto place = scene.places.find(one.key); place != scene.places.end())
            fail_input(place->second, "{} is for scenes of {}, and this is a scene of {}; remove it", one.key,
                       kinds_text(one.kinds), words(scene.kind));
    }
}

/// Of the modes that the products of the equations keep, those of the drift included.
std::function<double(int x, int y)> noise_moment_of(const Scene& scene) {
    DeclaredModel any = scene.declared;
    any.noise_moment = [](int, int) { return 1.0; };
    const int degree = kept_degree(scene, model::Equations(model_of(any)));
    return [grid = scene.grid, degree](int x, int y) { return model::noise_moment(grid, degree, x, y); };
}

/// The chosen part of a scene, without its model.
WrittenTables written_sections(const Scene& scene, const std::function<bool(const std::string&)>& is_chosen) {
    WrittenTables tables;
    for_sections(scene, [&](SectionOf belongs, const std::string& name, const char*, const auto& part) {
        if (!is_of(scene.kind, belongs) || !is_chosen(name)) return;
        tables.push_back(
            {.name = name,
             .values = name == initial_section ? initial_values(scene.initial, scene.kind) : values_of(part)});
        for (const Description& row : found_keys(name, scene.found))
            tables.back().values.emplace_back(row.name, row.default_value);
        std::erase_if(tables.back().values, [&](const auto& value) {
            const std::string whole = name + "." + value.first;
            return !is_of(scene.kind, whole) || !is_chosen(whole);
        });
    });
    return tables;
}

/// All of a scene.
WrittenTables written_scene(const Scene& scene) {
    WrittenTables tables;
    if (scene.kind == SceneKind::fields) tables = written_model(scene.model);
    if (scene.kind == SceneKind::model) tables = written_model(scene.declared);
    // Without a step the run chooses its method too, unless the scene gives one.
    const bool is_method_open = has_grid(scene.kind) && scene.time.dt == 0.0 && !scene.places.contains("time.stepper");
    std::ranges::move(written_sections(scene,
                                       [&](const auto& key) { return !(is_method_open && key == "time.stepper"); }),
                      std::back_inserter(tables));
    return tables;
}

/// As TOML, with the parameters of terms in the terms that have them.
std::string text_of(const WrittenTables& tables, const std::map<std::string, double>& parameters = {}) {
    std::string result;
    for (const auto& [name, values] : tables) {
        if (name == parameter_table) continue;
        const std::size_t number = name.find('[');  // of an item of a list
        result += result.empty() ? "" : "\n";
        result += number == std::string::npos ? "[" + name + "]\n" : "[[" + name.substr(0, number) + "]]\n";
        for (const auto& [key, value] : values) {
            if (key != parameter_names) {
                result += key + " = " + toml_text(value) + "\n";
                continue;
            }
            const auto written = [&](const std::string& one) { return one + " = " + toml_text(parameters.at(one)); };
            const auto& names = std::get<std::vector<std::string>>(value);
            result += "parameters = { " + joined(mapped(names, written)) + " }\n";
        }
    }
    return result;
}

/// Without the factors [p]: "mm^2/s" of "[p]^2 mm^2/s", "mm/s" of "mm/s/[p]", "1/s" of "[p]/s".
std::string without_order(std::string unit) {
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) {
        std::size_t end = at + 3;
        if (end < unit.size() && unit[end] == '^') end = std::min(unit.find_first_of(" /", end), unit.size());
        const bool divides = at > 0 && unit[at - 1] == '/', multiplies = end < unit.size() && unit[end] == ' ';
        if (divides) unit.erase(at - 1, end - at + 1);
        else if (multiplies) unit.erase(at, end - at + 1);
        else unit.replace(at, end - at, "1");
    }
    return unit;
}

}  // namespace

Found found_in(const LocatedTables& tables) {
    using Texts = std::vector<std::string>;
    std::vector<Value> values;
    for (const char* section : {"time", "calibrated"})
        for (const Description& row : found_keys(section)) {
            values.push_back(row.default_value);
            const auto table = tables.find(section);
            if (table == tables.end() || !table->second.values.contains(row.name)) continue;
            values.back() = checked_value(row, section, table->second.values.at(row.name));
        }
    Found found{.step = {.by = value_named<ChosenBy>(std::get<std::string>(values[0])).value(),
                         .pilot = std::get<std::string>(values[1])},
                .filled = {},
                .expected = std::get<Texts>(values[3])};
    for (const std::string& line : std::get<Texts>(values[2])) {
        const std::size_t colon = line.find(':');
        found.filled.push_back(
            {line.substr(0, colon), line.substr(std::min(line.size(), line.find_first_not_of(": ", colon)))});
    }
    return found;
}

Scene scene_of(const LocatedTables& given, const std::string& file) {
    LocatedTables tables = given;
    Scene scene;
    scene.file = file;
    scene.kind = kind_of(tables);
    scene.found = found_in(tables);
    if (scene.kind == SceneKind::particles) scene.time.dt = dt_of_particles;
    std::vector<std::string> sections = section_names(scene.kind == SceneKind::model ? declared : fields);
    if (scene.kind == SceneKind::fields) read_model(tables, scene.model, scene.places);
    if (scene.kind == SceneKind::model) read_declared(tables, scene.declared, scene.places);
    scene.initial = default_start(scene.kind);
    if (const auto table = tables.find(initial_section); table != tables.end()) take_formulas(table->second, scene);
    for_sections(scene, [&](SectionOf, const std::string& name, const char*, auto& part) {
        sections.push_back(name);
        const auto table = tables.find(name);
        if (table == tables.end()) return;
        scene.places.emplace(name, table->second.where);
        for (const auto& [key, value] : table->second.values) scene.places.emplace(name + "." + key, value.where);
        for (const Description& row : found_keys(name)) table->second.values.erase(row.name);
        read_table(table->second, name, part);
    });
    reject_keys_of_others(scene);
    if (scene.declared.calculus == Calculus::stratonovich) scene.declared.noise_moment = noise_moment_of(scene);
    const auto is_read = [&](const std::string& name) {
        return std::ranges::find(sections, name) != sections.end() ||
               (scene.kind == SceneKind::model ? is_declared_table(name) : is_model_table(name));
    };
    for (const auto& [name, table] : tables) {
        if (is_read(name)) continue;
        require(!is_in_declared_list(name + "["), table.where, "unknown table [{}]; expected [[{}]], one for each",
                name, name);
        fail_input(table.where, "unknown table [{}]; {}", name,
                   suggestion(name, sections, text("expected one of {}", joined(sections)), "did you mean [{}]?"));
    }
    return scene;
}

SceneKind kind_of_name(const std::string& name) {
    const std::optional<SceneKind> kind = value_named<SceneKind>(name);
    require(kind.has_value(), {}, "the kind \"{}\" of a scene; expected fields, particles or model", name);
    return *kind;
}

std::filesystem::path beside(const std::string& scene_file, const std::string& given) {
    const std::filesystem::path in_folder = std::filesystem::path(scene_file).parent_path() / given;
    std::error_code problem;
    return std::filesystem::exists(in_folder, problem) ? in_folder : std::filesystem::path(given);
}

SourceLocation locate(const Scene& scene, const std::string& key) {
    const auto found = scene.places.find(key);
    return found != scene.places.end() ? found->second : SourceLocation{.file = scene.file};
}

ModelNumber model_number(const std::string& key, const SourceLocation& where, const physics::ModelValues& model) {
    std::vector<std::string> numbers;
    for (const auto& [name, value] : model.parameters) {
        numbers.push_back(std::string(parameter_table) + "." + name);
        if (numbers.back() == key)
            return {.unit = "", .range = any_number, .in = [name = name](physics::ModelValues& m) -> double& {
                        return m.parameters.at(name);
                    }};
    }
    for (const physics::ModelSection& section : physics::model_sections())
        for (const physics::ModelKey& one : section.keys) {
            if (!one.is_number) continue;
            numbers.push_back(section.name + "." + one.description.name);
            if (numbers.back() == key)
                return {.unit = one.description.unit,
                        .range = one.description.range,
                        .in = [key](physics::ModelValues& m) -> double& { return physics::number_in(m, key); }};
        }
    fail_input(where, "{} is not a number of the model; {}", key,
               suggestion(key, numbers, "expected one such as driving.strength (see drover schema)"));
}

void require_kind(const Scene& scene, SceneKind kind, const std::string& command) {
    require(scene.kind == kind, {.file = scene.file},
            "this is a scene of {}; drover {} needs a scene of {}{}: see drover explain", words(scene.kind), command,
            words(kind),
            scene.kind == SceneKind::model && kind == SceneKind::fields ? " with the equations of rods and beads" : "");
}

void require_grid(const Scene& scene, const std::string& command) {
    require(has_grid(scene.kind), {.file = scene.file},
            "this is a scene of {}; drover {} needs a scene of fields: see drover explain", words(scene.kind), command);
}

int kept_degree(const Scene& scene, const model::Equations& equations) {
    return numerics::kept_degree(std::max(equations.degree(), scene.dealiasing.degree), scene.dealiasing.rule);
}

LocatedTables tables_of(const Scene& scene) {
    LocatedTables tables;
    for (const auto& [name, values] : written_scene(scene)) {
        LocatedTable& table = tables.emplace(name, LocatedTable{{.file = scene.file}, {}}).first->second;
        for (const auto& [key, value] : values)
            table.values.emplace(key, LocatedValue{value, {.file = key == parameter_names ? "" : scene.file}});
    }
    return tables;
}

std::string chosen_text(const Scene& scene, const std::function<bool(const std::string&)>& is_chosen) {
    return text_of(written_sections(scene, is_chosen));
}

std::string resolved_text(const Scene& scene) { return text_of(written_scene(scene), scene.model.parameters); }

std::vector<SectionDescription> scene_schema(const physics::ModelFile& file) {
    std::vector<SectionDescription> sections;
    for (const physics::ModelSection& section : physics::model_sections(file)) {
        const auto rows = mapped(section.keys, &physics::ModelKey::description);
        sections.push_back({section.name, section.doc, rows, {SceneKind::fields}});
    }
    for (auto& [name, doc, rows] : std::vector<std::tuple<const char*, const char*, std::vector<Description>>>{
             {"model", "A model of one's own: its fields and equations.", descriptions<DeclaredModel>()},
             {"[field]", "One field; [[field]] for each.", descriptions<DeclaredField>()},
             {"[white_noise]", "One white noise that equations name; [[white_noise]] for each.",
              descriptions<DeclaredNoise>()},
             {"[tabulated]", "One coefficient as a table in scalar fields; [[tabulated]] for each.",
              descriptions<DeclaredTable>()},
             {"equations", "symbol = \"right-hand side of its equation\", for each field.", {}},
             {"define", "name = \"part of equations\".", {}},
             {"coefficients", "name = number.", {}}})
        sections.push_back({name, doc, std::move(rows), {SceneKind::model}});
    const Scene defaults;
    for_sections(defaults, [&](SectionOf belongs, const std::string& name, const char* doc, const auto& part) {
        std::vector<SceneKind> kinds;
        for (const SceneKind kind : scene_kinds)
            if (belongs != all && is_of(kind, belongs)) kinds.push_back(kind);
        std::vector<Description> rows = descriptions<std::remove_cvref_t<decltype(part)>>();
        if (name == initial_section) rows = initial_rows(SceneKind::fields);
        std::ranges::move(found_keys(name), std::back_inserter(rows));
        sections.push_back({name, doc, std::move(rows), kinds});
    });
    return sections;
}

std::vector<SectionDescription> scene_schema(SceneKind kind) {
    std::vector<SectionDescription> sections;
    for (SectionDescription& section : scene_schema()) {
        if (!section.kinds.empty() && std::ranges::find(section.kinds, kind) == section.kinds.end()) continue;
        std::erase_if(section.rows,
                      [&](const Description& row) { return !is_of(kind, section.name + "." + row.name); });
        if (section.name == initial_section) section.rows = initial_rows(kind);
        for (Description& row : section.rows)
            if (kind == SceneKind::particles && section.name == "time" && row.name == "dt")
                row.default_value = dt_of_particles;
        sections.push_back(std::move(section));
    }
    return sections;
}

std::string unit_of(SceneKind kind, const std::string& key) {
    for (const SectionDescription& section : scene_schema(kind))
        for (const Description& row : section.rows)
            if (section.name + "." + row.name == key && !row.unit.empty()) return row.unit;
    return "1";
}

std::string unit_in_results(const Scene& scene, const std::string& unit) {
    if (scene.kind != SceneKind::fields) return renamed(unit, scene.units);
    const bool has_no_unit = physics::unit_of(scene.model, "[p]") == "1";
    return renamed(has_no_unit ? without_order(unit) : physics::unit_of(scene.model, unit), scene.units);
}

Rows<Approximation> Approximation::rows() {
    return Rows<Approximation>{
        {"quasi_linear", &Approximation::quasi_linear,
         "generalised quasi-linear approximation: short waves interact with long ones, but not with each other"},
        {"quasi_linear_above", &Approximation::quasi_linear_above,
         "with quasi_linear: the largest |q| of a long wave; 0: only the means are long", "1/mm", not_negative},
        {"counterterm", &Approximation::counterterm,
         "rods with noise: the run lowers relaxation.rate by 2 b s, where s is the |p|^2 of independent rods in the "
         "kept modes, so that b saturates the order but not this noise, and results hardly depend on the grid"},
    };
}

}  // namespace drover::io
