// io/scene.cpp: the sections of a scene: read from tables, written as TOML, described.
#include "drover/io/scene.hpp"

#include <algorithm>
#include <array>

#include "drover/physics/coefficient_registry.hpp"
#include "io/scene_model.hpp"

namespace drover::io {

namespace {
/// The sections of a particle world.
template <class AnySetup, class Visit>
void for_particle_sections(AnySetup& setup, Visit visit) {
    visit("cell", "The side wall of the particle world.", setup.cell);
    visit("plates", "Base and lid, which vibrate together.", setup.plates);
    visit("gravity", "Gravity.", setup.gravity);
    visit("beads", "Single spheres.", setup.beads);
    visit("rods", "Rigid bodies of spheres on a line, tail to head.", setup.rods);
    visit("restitution", "Coefficients of normal restitution.", setup.restitution);
    visit("friction", "Coefficients of friction.", setup.friction);
    visit("kick", "Noise of the rods.", setup.kick);
    visit("forces", "Forces on bodies other than gravity and contacts.", setup.forces);
    visit("contacts", "How contacts are resolved.", setup.contacts);
    visit("packing", "Initial positions of the bodies.", setup.packing);
}

enum class SectionOf { fields, particles, both };

/// All sections of all scenes but those of the model, which come first in a scene of fields.
template <class AnyScene, class Visit>
void for_sections(AnyScene& scene, Visit visit) {
    const auto of = [&](SectionOf kind) {
        return [&visit, kind](const std::string& name, const char* doc, auto& part) { visit(kind, name, doc, part); };
    };
    const auto fields = of(SectionOf::fields), both = of(SectionOf::both);
    fields("grid", "The periodic cell and its grid.", scene.grid);
    fields("dealiasing", "Dealiasing of products of fields.", scene.dealiasing);
    for_particle_sections(scene.particles, of(SectionOf::particles));
    both("time", "Time stepping.", scene.time);
    fields("initial", "The initial state.", scene.initial);
    both("output", "Output files and intervals.", scene.output);
    both("analysis", "Time averages.", scene.analysis);
    fields("accuracy", "The errors of the results of a run.", scene.accuracy);
    both("run", "Seed and threads.", scene.run);
    both("sweep", "Many runs of this scene; used by drover sweep only.", scene.sweep);
    fields("stability", "Wavevectors of the linear stability analysis; used by drover stability only.",
           scene.stability);
    const auto particles = of(SectionOf::particles);
    particles("calibrate", "Measurements and their target errors; used by drover calibrate only.", scene.calibration);
    calibrate::for_plans(scene.plans, [&](const std::string& name, const char* doc, auto& plan) {
        particles("calibrate." + name, doc, plan);
    });
    fields("calibrated", "A table of coefficients that replaces numbers of the model.", scene.calibrated);
    fields("boundary", "A plane of two model numbers; used by drover boundary only.", scene.boundary);
}

/// Keys of shared sections that only scenes of fields have.
constexpr std::array keys_of_fields{"time.stepper", "time.tolerance", "time.max_error",
                                    "time.chosen",  "time.pilot",     "output.powers"};

bool is_of(const Scene& scene, SectionOf section) {
    return section == SectionOf::both || (section == SectionOf::particles) == (scene.kind == SceneKind::particles);
}

bool is_of(const Scene& scene, const std::string& key) {
    return scene.kind == SceneKind::fields ||
           std::find(keys_of_fields.begin(), keys_of_fields.end(), key) == keys_of_fields.end();
}

std::vector<std::string> section_names(SectionOf kind) {
    std::vector<std::string> names;
    if (kind == SectionOf::fields)
        for (const physics::ModelSection& section : physics::model_sections()) names.push_back(section.name);
    const Scene defaults;
    for_sections(defaults, [&](SectionOf belongs, const std::string& name, const char*, const auto&) {
        if (belongs == kind) names.push_back(name);
    });
    return names;
}

/// The kind of a scene, from its sections.  Throws an input Error when sections of both kinds are present.
SceneKind kind_of(const LocatedTables& tables) {
    const auto first_of = [&](SectionOf kind) {
        for (const std::string& name : section_names(kind))
            if (const auto table = tables.find(name); table != tables.end()) return table;
        return kind == SectionOf::fields ? tables.find("terms[1]") : tables.end();
    };
    const auto particles = first_of(SectionOf::particles), fields = first_of(SectionOf::fields);
    if (particles == tables.end()) return SceneKind::fields;
    if (fields != tables.end())
        fail_input(fields->second.where,
                   "[{}] belongs to a scene of fields, [{}] ({}) to one of particles; expected sections of one kind: "
                   "remove one of them",
                   fields->first, particles->first, location_text(particles->second.where));
    return SceneKind::particles;
}

void reject_keys_of_fields(const Scene& scene) {
    for (const char* key : keys_of_fields)
        if (const auto place = scene.places.find(key); place != scene.places.end())
            fail_input(place->second, "{} is for scenes of fields, and this is a scene of particles; remove it", key);
}

}  // namespace

Scene scene_of(const LocatedTables& tables, const std::string& file) {
    Scene scene;
    scene.file = file;
    scene.kind = kind_of(tables);
    if (scene.kind == SceneKind::particles) scene.time.dt = dt_of_particles;
    std::vector<std::string> sections = section_names(SectionOf::fields);
    if (scene.kind == SceneKind::fields) read_model(tables, scene.model, scene.places);
    for_sections(scene, [&](SectionOf, const std::string& name, const char*, auto& part) {
        sections.push_back(name);
        const auto table = tables.find(name);
        if (table == tables.end()) return;
        read_table(table->second, name, part);
        for (const auto& [key, value] : table->second.values) scene.places.emplace(name + "." + key, value.where);
    });
    if (scene.kind == SceneKind::particles) reject_keys_of_fields(scene);
    for (const auto& [name, table] : tables) {
        if (std::find(sections.begin(), sections.end(), name) != sections.end() || is_model_table(name)) continue;
        const std::string near = nearest_name(name, sections);
        fail_input(table.where, "unknown table [{}]; {}", name,
                   near.empty() ? text("expected one of {}", joined(sections)) : text("did you mean [{}]?", near));
    }
    return scene;
}

SourceLocation location_of(const Scene& scene, const std::string& key) {
    const auto found = scene.places.find(key);
    return found != scene.places.end() ? found->second : SourceLocation{.file = scene.file};
}

ModelNumber model_number(const std::string& key, const SourceLocation& where, const physics::Model& model) {
    std::vector<std::string> numbers;
    for (const auto& [name, value] : model.parameters) {
        numbers.push_back(std::string(parameter_table) + "." + name);
        if (numbers.back() == key)
            return {.unit = "", .range = any_number, .in = [name = name](physics::Model& m) -> double& {
                        return m.parameters.at(name);
                    }};
    }
    for (const auto& [name, density] : {std::pair{"uniform.rod_density", &physics::UniformState::rod_density},
                                        std::pair{"uniform.bead_density", &physics::UniformState::bead_density}}) {
        numbers.emplace_back(name);
        if (name == key)
            return {.unit = "1/mm^2", .range = positive, .in = [density](physics::Model& m) -> double& {
                        return m.uniform.*density;
                    }};
    }
    for (const physics::ModelSection& section : physics::model_sections())
        for (const physics::ModelKey& one : section.keys) {
            if (!one.number) continue;
            numbers.push_back(section.name + "." + one.description.name);
            if (numbers.back() == key)
                return {.unit = one.description.unit, .range = one.description.range, .in = one.number};
        }
    const std::string near = nearest_name(key, numbers);
    fail_input(where, "{} is not a number of the model; {}", key,
               near.empty() ? text("expected one such as {} (see drover schema)", "driving.strength")
                            : text("did you mean {}?", near));
}

void require_kind(const Scene& scene, SceneKind kind, const std::string& command) {
    const auto words = [](SceneKind one) { return one == SceneKind::fields ? "fields" : "particles"; };
    require(scene.kind == kind, {.file = scene.file},
            "this is a scene of {}; drover {} needs a scene of {}: see drover explain", words(scene.kind), command,
            words(kind));
}

std::string resolved_text(const Scene& scene) {
    std::string result = scene.kind == SceneKind::fields ? model_text(scene.model) : "";
    for_sections(scene, [&](SectionOf belongs, const std::string& name, const char*, const auto& part) {
        if (!is_of(scene, belongs)) return;
        if (!result.empty()) result += '\n';
        result += "[" + name + "]\n";
        for (const auto& [key, value] : values_of(part))
            if (is_of(scene, name + "." + key)) result += key + " = " + toml_text(value) + "\n";
    });
    return result;
}

std::vector<SectionDescription> scene_schema(const physics::CoefficientRegistry& registry) {
    std::vector<SectionDescription> sections;
    for (const physics::ModelSection& section : physics::model_sections(registry)) {
        sections.push_back({section.name, section.doc, {}, "fields"});
        for (const physics::ModelKey& key : section.keys) sections.back().rows.push_back(key.description);
    }
    const Scene defaults;
    for_sections(defaults, [&](SectionOf belongs, const std::string& name, const char* doc, const auto& part) {
        const char* kind = belongs == SectionOf::fields ? "fields" : belongs == SectionOf::particles ? "particles" : "";
        sections.push_back({name, doc, descriptions<std::remove_cvref_t<decltype(part)>>(), kind});
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
