// app/schema.cpp: drover schema.
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"
#include "drover/physics/coefficient_registry.hpp"
#include "run/json.hpp"

namespace drover::app {

namespace {
void print(const std::vector<io::SectionDescription>& sections) {
    std::printf("# Units are mm, s and mg.\n");
    for (const io::SectionDescription& section : sections) {
        std::string scenes;
        for (const io::SceneKind kind : section.kinds)
            scenes += (scenes.empty() ? "" : " and ") + std::string(io::kind_name(kind));
        if (!scenes.empty()) scenes = text("scenes of {}: ", scenes);
        std::printf("\n[%s]  # %s%s\n", section.name.c_str(), scenes.c_str(), section.doc.c_str());
        for (const Description& row : section.rows) {
            std::string allowed = type_text(row.default_value);
            if (std::isfinite(row.range.min)) allowed += text(" {} {}", row.range.min_open ? ">" : ">=", row.range.min);
            if (std::isfinite(row.range.max)) allowed += text(" <= {}", row.range.max);
            if (!row.choices.empty()) allowed = joined(row.choices, " | ");
            if (!row.unit.empty()) allowed += " [" + row.unit + "]";
            std::printf("%s = %s  # %s\n    # %s\n", row.name.c_str(), toml_text(row.default_value).c_str(),
                        allowed.c_str(), row.doc.c_str());
        }
    }
}

/// The one list of tables, whose keys are not those of a section.
void print_terms() {
    std::fputs(R"(
# A term of an equation as text, as many as wanted; see the manual, models/README.md.
# [[terms]]
# of = "order"               # whose equation: bead_density, rod_density, bead_velocity (a force), order
# value = ["...", "..."]     # x and y components; of a density one text
# flux = ["...", "..."]      # of a density instead of a value: d_t = -div flux
# parameters = { W = 0.7 }   # numbers in the texts: terms.W for --set, sweep and boundary
)",
               stdout);
}
}  // namespace

void add_schema(CLI::App& program, Action& action) {
    struct Options {
        bool json = false, coefficients = false;
        std::string kind;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("schema", "List all input keys: types, units, ranges, defaults, meaning");
    command->add_flag("--json", options->json, "Print as JSON");
    command
        ->add_option("--kind", options->kind,
                     "Only the keys of scenes of fields, of particles, or of a model of one's own")
        ->check(CLI::IsMember({"fields", "particles", "model"}));
    command->add_flag("--coefficients", options->coefficients,
                      "The coefficients of the equations as a table in Markdown");
    command->callback([options, &action] {
        action = [options] {
            if (options->coefficients) {
                std::fputs(physics::coefficient_documentation().c_str(), stdout);
                return run::exit_done;
            }
            const std::vector<io::SectionDescription> sections =
                options->kind.empty() ? io::scene_schema() : io::scene_schema(io::kind_of_name(options->kind));
            if (!options->json) {
                print(sections);
                if (options->kind.empty() || options->kind == "fields") print_terms();
                return run::exit_done;
            }
            print_json(run::schema_json(sections));
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
