// io/scene.cpp: TOML text to a Scene and back.
#include "drover/io/scene.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "io/scene_calibrated.hpp"

namespace drover::io {

namespace {
using Tables = std::map<std::string, LocatedTable>;

/// The sections of a model, in the order in which they are written: visit(name, sentence, struct).
template <class AnyModel, class Visit>
void for_model_sections(AnyModel& model, Visit visit) {
    visit("fields", "The fields of the model; the polar order p is always one.", model.fields);
    visit("uniform", "The mean densities.", model.uniform);
    visit("current", "Motion of rods along their order.", model.current);
    visit("inertia", "What the forces on the beads have to move.", model.inertia);
    visit("drag", "Friction of the beads with the plate.", model.drag);
    visit("viscosity", "Viscosity of the beads.", model.viscosity);
    visit("driving", "Rods driving beads.", model.driving);
    visit("stiffness", "Pressure on the beads.", model.stiffness);
    visit("relaxation", "Relaxation and saturation of the order.", model.relaxation);
    visit("elasticity", "Elasticity of the order.", model.elasticity);
    visit("weathercock", "Beads turning rods.", model.weathercock);
    visit("advection", "Order carried by itself.", model.advection);
    visit("pressure", "Rods turning away from crowded places.", model.pressure);
    visit("diffusion", "Diffusion of the densities.", model.diffusion);
    visit("noise", "Strengths of the noise.", model.noise);
    visit("force", "A force on the beads from outside.", model.force);
    visit("orienting_field", "A field that orients rods.", model.orienting_field);
    visit("table", "Coefficients measured on a mesh of densities.", model.table);
}

/// The same of a particle world.
template <class AnySetup, class Visit>
void for_particle_sections(AnySetup& setup, Visit visit) {
    visit("cell", "The side of the world of particles.", setup.cell);
    visit("plates", "Base and lid, which shake together.", setup.plates);
    visit("gravity", "Gravity.", setup.gravity);
    visit("beads", "Single spheres.", setup.beads);
    visit("rods", "Solids of spheres on a line, tail to head.", setup.rods);
    visit("restitution", "Coefficients of normal restitution.", setup.restitution);
    visit("friction", "Coefficients of friction.", setup.friction);
    visit("kick", "Noise of the rods.", setup.kick);
    visit("forces", "What acts on bodies besides gravity and contacts.", setup.forces);
    visit("contacts", "How contacts are resolved.", setup.contacts);
    visit("packing", "The bodies at the start.", setup.packing);
}

enum class Belongs { to_fields, to_particles, to_both };

/// All sections of all scenes.
template <class AnyScene, class Visit>
void for_sections(AnyScene& scene, Visit visit) {
    const auto of = [&](Belongs kind) {
        return [&visit, kind](const std::string& name, const char* sentence, auto& part) {
            visit(kind, name, sentence, part);
        };
    };
    const auto fields = of(Belongs::to_fields), both = of(Belongs::to_both);
    for_model_sections(scene.model, fields);
    fields("grid", "The periodic cell and its grid.", scene.grid);
    fields("dealiasing", "How products of fields are kept free of aliases.", scene.dealiasing);
    for_particle_sections(scene.particles, of(Belongs::to_particles));
    both("time", "How time advances.", scene.time);
    fields("initial", "The state at the start.", scene.initial);
    both("output", "What is written, and when.", scene.output);
    both("analysis", "How means are taken.", scene.analysis);
    both("run", "What does not change the physics, but the seed.", scene.run);
    both("sweep", "Many runs of this scene; for drover sweep alone.", scene.sweep);
    fields("stability", "Waves to look at; for drover stability alone.", scene.stability);
    const auto particles = of(Belongs::to_particles);
    particles("calibrate", "What to measure, and how well; for drover calibrate alone.", scene.calibration);
    calibrate::for_plans(scene.plans, [&](const std::string& name, const char* sentence, auto& plan) {
        particles("calibrate." + name, sentence, plan);
    });
    fields("calibrated", "A table of coefficients in place of numbers of the model.", scene.calibrated);
    fields("boundary", "A plane of two numbers of the model; for drover boundary alone.", scene.boundary);
}

/// Keys of shared sections that a scene of particles has not.
constexpr std::array keys_of_fields{"time.stepper", "time.tolerance", "output.powers"};

bool is_of(const Scene& scene, Belongs section) {
    return section == Belongs::to_both || (section == Belongs::to_particles) == (scene.kind == SceneKind::particles);
}

bool is_of(const Scene& scene, const std::string& key) {
    return scene.kind == SceneKind::fields ||
           std::find(keys_of_fields.begin(), keys_of_fields.end(), key) == keys_of_fields.end();
}

SourceLocation where_of(const toml::source_region& source, const std::string& file) {
    return {.file = file, .line = static_cast<int>(source.begin.line), .column = static_cast<int>(source.begin.column)};
}

Value list_value(const toml::array& array, const std::string& key, const SourceLocation& where) {
    std::vector<double> numbers;
    std::vector<std::string> texts;
    for (const toml::node& item : array) {
        if (const auto number = item.value<double>(); number && item.is_number()) numbers.push_back(*number);
        else if (const auto word = item.value<std::string>()) texts.push_back(*word);
        else
            fail_input(where,
                       "{} is a list with something else than numbers or texts in it; expected one kind of either",
                       key);
    }
    require(numbers.empty() || texts.empty(), where, "{} is a list of both numbers and texts; expected one kind", key);
    if (!texts.empty()) return texts;
    return numbers;
}

Value value_of(const toml::node& node, const std::string& key, const SourceLocation& where) {
    if (const auto* held = node.as_boolean()) return held->get();
    if (const auto* held = node.as_integer()) return std::int64_t{held->get()};
    if (const auto* held = node.as_floating_point()) return held->get();
    if (const auto* held = node.as_string()) return held->get();
    if (const auto* held = node.as_array()) return list_value(*held, key, where);
    fail_input(where, "{} is a table or a date; expected a number, a text, true or false, or a list", key);
}

toml::table parsed(const std::string& text, const std::string& name) {
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error& error) {
        fail_input(where_of(error.source(), name), "not TOML: {}; expected lines such as [grid] and nx = 256",
                   std::string(error.description()));
    }
}

/// The keys of one section; of [calibrate], a table within it is the section calibrate.<its name>.
void add_table(const std::string& section, const toml::table& table, const SourceLocation& where,
               const std::string& file, Tables& tables) {
    LocatedTable placed{.where = where, .values = {}};
    for (const auto& [key, value] : table) {
        const SourceLocation place = where_of(key.source(), file);
        const std::string name = section + "." + std::string(key.str());
        if (const toml::table* inner = value.as_table(); inner != nullptr && section == "calibrate")
            add_table(name, *inner, place, file, tables);
        else placed.values.emplace(std::string(key.str()), LocatedValue{value_of(value, name, place), place});
    }
    tables.emplace(section, std::move(placed));
}

Tables tables_of(const toml::table& root, const std::string& file) {
    Tables tables;
    for (const auto& [name, node] : root) {
        const std::string section(name.str());
        const SourceLocation where = where_of(name.source(), file);
        const toml::table* table = node.as_table();
        require(table != nullptr, where, "{} stands outside a table; expected it below a line such as [grid]", section);
        add_table(section, *table, where, file, tables);
    }
    return tables;
}

/// "section.key=value", blanks about each part left out.
struct Setting {
    SourceLocation where;
    std::string section, key, written;
    std::string name() const { return section + "." + key; }
};

Setting read_setting(const std::string& setting) {
    const SourceLocation where{.file = "--set " + setting};
    const std::size_t equals = setting.find('='), dot = setting.rfind('.', equals);
    require(equals != std::string::npos && dot != std::string::npos && dot > 0 && dot + 1 < equals, where,
            "expected section.key=value, such as grid.nx=128");
    const auto trimmed = [](std::string word) {
        word.erase(0, word.find_first_not_of(" \t"));
        word.erase(word.find_last_not_of(" \t") + 1);
        return word;
    };
    return {.where = where,
            .section = trimmed(setting.substr(0, dot)),
            .key = trimmed(setting.substr(dot + 1, equals - dot - 1)),
            .written = trimmed(setting.substr(equals + 1))};
}

/// The value as TOML, or as a text when it is not.
void apply_setting(const Setting& setting, Tables& tables) {
    const auto& [where, section, key, written] = setting;
    Value value = written;
    try {
        const toml::table table = toml::parse("value = " + written);
        require(table.size() == 1, where,
                "more than one key; expected section.key=value, each with a --set of its own");
        value = value_of(*table.get("value"), setting.name(), where);
    } catch (const toml::parse_error&) {
        // A bare word: it stays a text.
    }
    LocatedTable& table = tables.try_emplace(section, LocatedTable{.where = where, .values = {}}).first->second;
    table.values.insert_or_assign(key, LocatedValue{std::move(value), where});
}

std::vector<std::string> section_names(Belongs kind) {
    std::vector<std::string> names;
    const Scene standard;
    for_sections(standard, [&](Belongs belongs, const std::string& name, const char*, const auto&) {
        if (belongs == kind) names.push_back(name);
    });
    return names;
}

/// The kind of a scene, by the sections that are there.  Throws an input Error when they are of both.
SceneKind kind_of(const Tables& tables) {
    const auto first_of = [&](Belongs kind) {
        for (const std::string& name : section_names(kind))
            if (const auto table = tables.find(name); table != tables.end()) return table;
        return tables.end();
    };
    const auto particles = first_of(Belongs::to_particles), fields = first_of(Belongs::to_fields);
    if (particles == tables.end()) return SceneKind::fields;
    if (fields != tables.end())
        fail_input(fields->second.where,
                   "[{}] is of a scene of fields, and [{}] ({}) makes this one of particles; expected sections of one "
                   "kind: take out one of them",
                   fields->first, particles->first, location_text(particles->second.where));
    return SceneKind::particles;
}

void refuse_keys_of_fields(const Scene& scene) {
    for (const char* key : keys_of_fields)
        if (const auto place = scene.places.find(key); place != scene.places.end())
            fail_input(place->second,
                       "{} is for scenes of fields; this is one of particles: expected a scene without it", key);
}

Scene scene_of(const Tables& tables, const std::string& file) {
    Scene scene;
    scene.file = file;
    scene.kind = kind_of(tables);
    if (scene.kind == SceneKind::particles) scene.time.dt = dt_of_particles;
    std::vector<std::string> sections;
    for_sections(scene, [&](Belongs, const std::string& name, const char*, auto& part) {
        sections.push_back(name);
        const auto table = tables.find(name);
        if (table == tables.end()) return;
        read_table(table->second, name, part);
        for (const auto& [key, value] : table->second.values) scene.places.emplace(name + "." + key, value.where);
    });
    if (scene.kind == SceneKind::particles) refuse_keys_of_fields(scene);
    for (const auto& [name, table] : tables) {
        if (std::find(sections.begin(), sections.end(), name) != sections.end()) continue;
        const std::string near = nearest_name(name, sections);
        fail_input(table.where, "unknown table [{}]; {}", name,
                   near.empty() ? text("expected one of {}", joined(sections)) : text("did you mean [{}]?", near));
    }
    fill_from_table(scene);
    check(scene);
    return scene;
}

/// Whether a setting changes what the table has to give.
bool asks_table_anew(const Setting& setting) {
    return setting.section == "calibrated" || setting.section == "fields" || setting.name() == "current.kind" ||
           setting.name() == "weathercock.convention";
}

/// calibrated.filled of a resolved scene; none when it has none.
std::vector<std::string>* filled_of(Tables& tables) {
    const auto calibrated = tables.find("calibrated");
    if (calibrated == tables.end()) return nullptr;
    const auto filled = calibrated->second.values.find("filled");
    if (filled == calibrated->second.values.end()) return nullptr;
    return std::get_if<std::vector<std::string>>(&filled->second.value);
}

/// Another state of the table is asked for: what the one before has filled in goes, to be filled in anew.
void forget_filled(Tables& tables) {
    const std::vector<std::string>* filled = filled_of(tables);
    if (filled == nullptr) return;
    for (const std::string& written : *filled) {
        const std::string name = filled_name(written);
        const std::size_t dot = name.find('.');  // none in "table", which is filled whole
        const auto table = tables.find(name.substr(0, dot));
        if (table == tables.end()) continue;
        if (dot == std::string::npos) tables.erase(table);
        else table->second.values.erase(name.substr(dot + 1));
    }
    for (const char* own : {"filled", "expected"}) tables.at("calibrated").values.erase(own);
}

/// What a setting gives has not come from the table.
void note_given(const Setting& setting, Tables& tables) {
    if (std::vector<std::string>* filled = filled_of(tables))
        std::erase_if(*filled, [&](const std::string& written) { return filled_name(written) == setting.name(); });
}
}  // namespace

SourceLocation location_of(const Scene& scene, const std::string& key) {
    const auto found = scene.places.find(key);
    return found != scene.places.end() ? found->second : SourceLocation{.file = scene.file};
}

ModelNumber model_number(const std::string& key, const SourceLocation& where) {
    ModelNumber found;
    std::vector<std::string> numbers;
    const physics::Model standard;
    for_model_sections(standard, [&](const std::string& section, const char*, const auto& part) {
        using Part = std::remove_cvref_t<decltype(part)>;
        for (const Row<Part>& row : schema<Part>()) {
            const auto* member = std::get_if<double Part::*>(&row.member);
            if (!member) continue;
            numbers.push_back(section + "." + row.name);
            if (numbers.back() != key) continue;
            found = {.unit = row.unit,
                     .range = row.range,
                     .in = [section, held = *member](physics::Model& model) -> double& {
                         double* number = nullptr;
                         for_model_sections(model, [&](const std::string& name, const char*, auto& its) {
                             if constexpr (std::is_same_v<std::remove_cvref_t<decltype(its)>, Part>)
                                 if (name == section) number = &(its.*held);
                         });
                         return *number;
                     }};
        }
    });
    const std::string near = nearest_name(key, numbers);
    require(static_cast<bool>(found.in), where, "{} is no number of the model; {}", key,
            near.empty() ? text("expected one such as {} (see drover schema)", "driving.strength")
                         : text("did you mean {}?", near));
    return found;
}

Scene parse_scene(const std::string& toml, const std::string& name, std::span<const std::string> overrides) {
    Tables tables = tables_of(parsed(toml, name), name);
    std::vector<Setting> settings;
    for (const std::string& written : overrides) settings.push_back(read_setting(written));
    if (std::any_of(settings.begin(), settings.end(), asks_table_anew)) forget_filled(tables);
    for (const Setting& setting : settings) {
        note_given(setting, tables);
        apply_setting(setting, tables);
    }
    return scene_of(tables, name);
}

Scene read_scene(const std::filesystem::path& file, std::span<const std::string> overrides) {
    const SourceLocation where{.file = file.string()};
    std::error_code problem;
    require(std::filesystem::exists(file, problem), where,
            "no such file; expected a scene, such as models/isotropic.toml");
    require(std::filesystem::is_regular_file(file, problem), where, "not a file; expected a scene in TOML");
    constexpr std::uintmax_t most = 1 << 20;
    require(std::filesystem::file_size(file, problem) <= most, where, "larger than 1 MiB; expected a scene in TOML");
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream content;
    if (stream) content << stream.rdbuf();
    require(static_cast<bool>(stream), where, "cannot be read; check its permissions");
    return parse_scene(content.str(), file.string(), overrides);
}

void require_kind(const Scene& scene, SceneKind kind, const std::string& command) {
    const auto words = [](SceneKind one) { return one == SceneKind::fields ? "fields" : "particles"; };
    require(scene.kind == kind, {.file = scene.file},
            "this is a scene of {}, and drover {} is for scenes of {} alone; see drover explain", words(scene.kind),
            command, words(kind));
}

std::string resolved_text(const Scene& scene) {
    std::string result;
    for_sections(scene, [&](Belongs belongs, const std::string& name, const char*, const auto& part) {
        if (!is_of(scene, belongs)) return;
        if (!result.empty()) result += '\n';
        result += "[" + name + "]\n";
        for (const auto& [key, value] : values_of(part))
            if (is_of(scene, name + "." + key)) result += key + " = " + toml_text(value) + "\n";
    });
    return result;
}

std::vector<SectionDescription> scene_schema() {
    std::vector<SectionDescription> sections;
    const Scene standard;
    for_sections(standard, [&](Belongs belongs, const std::string& name, const char* sentence, const auto& part) {
        const char* kind = belongs == Belongs::to_fields      ? "fields"
                           : belongs == Belongs::to_particles ? "particles"
                                                              : "";
        sections.push_back({name, sentence, descriptions<std::remove_cvref_t<decltype(part)>>(), kind});
    });
    return sections;
}

std::vector<SectionDescription> scene_schema(SceneKind kind) {
    const bool fields = kind == SceneKind::fields;
    std::vector<SectionDescription> sections;
    for (SectionDescription& section : scene_schema()) {
        if (section.kind == (fields ? "particles" : "fields")) continue;
        std::erase_if(section.rows, [&](const Description& row) {
            const auto is_key = [&](const char* key) { return key == section.name + "." + row.name; };
            return !fields && std::any_of(keys_of_fields.begin(), keys_of_fields.end(), is_key);
        });
        for (Description& row : section.rows)
            if (!fields && section.name == "time" && row.name == "dt") row.default_value = dt_of_particles;
        sections.push_back(std::move(section));
    }
    return sections;
}

}  // namespace drover::io
