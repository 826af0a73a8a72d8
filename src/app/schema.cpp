// app/schema.cpp: drover schema.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "physics/model_keys.hpp"
#include "report/shown.hpp"

namespace drover::app {

namespace {
void print_sections(const std::vector<io::SectionDescription>& sections) {
    std::printf("# Units are mm, s and mg.\n");
    for (const io::SectionDescription& section : sections) {
        std::string scenes;
        for (const io::SceneKind kind : section.kinds)
            scenes += (scenes.empty() ? "" : " and ") + std::string(name_of(kind));
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
# A term of an equation as text, as many as wanted; see the manual, "Terms as text".
# [[terms]]
# of = "order"               # whose equation: bead_density, rod_density, bead_velocity (a force), order
# value = ["...", "..."]     # x and y components; of a density one text
# flux = ["...", "..."]      # of a density instead of a value: d_t = -div flux
# explicit = true            # nothing of it is in the exact linear part: evaluated at points, as products are
# parameters = { W = 0.7 }   # numbers in the texts: terms.W for --set, sweep and boundary
)",
               stdout);
}

/// "field" of "[[field]]", a list of tables.
std::string without_brackets(std::string name) {
    std::erase_if(name, [](char c) { return c == '[' || c == ']'; });
    return name;
}

/// The section, or the one key, that "grid" or "grid.nx" names.
std::vector<io::SectionDescription> part_of(std::vector<io::SectionDescription> sections, const std::string& given) {
    const std::string name = without_brackets(given);
    std::vector<std::string> names;
    const auto key_of = [](const io::SectionDescription& section, const Description& row) {
        return without_brackets(section.name) + "." + row.name;
    };
    for (const io::SectionDescription& section : sections) {
        names.push_back(without_brackets(section.name));
        for (const Description& row : section.rows) names.push_back(key_of(section, row));
    }
    require(std::ranges::find(names, name) != names.end(), {}, "there is no section or key {}; {}", given,
            suggestion(name, names, "drover schema lists all"));
    std::erase_if(sections, [&](io::SectionDescription& section) {
        if (without_brackets(section.name) == name) return false;
        std::erase_if(section.rows, [&](const Description& row) { return key_of(section, row) != name; });
        return section.rows.empty();
    });
    return sections;
}

nlohmann::json option_json(const CLI::Option& option) {
    const bool is_positional = option.get_positional();
    nlohmann::json names = nlohmann::json::array();
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return {{"name", is_positional ? option.get_name(true) : option.get_name()},
            {"names", names},
            {"positional", is_positional},
            {"required", option.get_required()},
            {"value", option.get_items_expected_max() == 0 ? "" : option.get_type_name()},
            {"repeatable", option.get_items_expected_max() > 1},
            {"doc", option.get_description()}};
}

/// Every command with its options and exit statuses, from what the command line is parsed with.
nlohmann::json commands_json(const CLI::App& program) {
    nlohmann::json result = nlohmann::json::array();
    for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
        nlohmann::json options = nlohmann::json::array(), statuses = nlohmann::json::array();
        for (const CLI::Option* option : command->get_options()) options.push_back(option_json(*option));
        const bool is_resumable = command->get_option_no_throw("--max-time") != nullptr;
        for (const auto& [status, meaning] : exit_statuses())
            if (status != run::exit_stopped || is_resumable)
                statuses.push_back({{"status", status}, {"meaning", meaning}});
        result.push_back({{"name", command->get_name()},
                          {"doc", command->get_description()},
                          {"options", options},
                          {"exit_statuses", statuses}});
    }
    return result;
}
}  // namespace

void add_schema(CLI::App& program, Action& action) {
    struct Options {
        bool json = false, coefficients = false, commands = false;
        std::string kind, part;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("schema", "List all input keys: types, units, ranges, defaults, meaning");
    command->add_option("part", options->part, "Only this section or key: grid, or grid.nx");
    command->add_flag("--json", options->json, "Print as JSON");
    command->add_flag("--commands", options->commands, "All commands with their options and exit statuses, as JSON");
    command
        ->add_option("--kind", options->kind,
                     "Only the keys of scenes of fields, of particles, or of a model of one's own")
        ->check(CLI::IsMember({"fields", "particles", "model"}));
    command->add_flag("--coefficients", options->coefficients,
                      "The coefficients of the equations as a table in Markdown");
    command->callback([options, &action, &program] {
        action = [options, &program] {
            const bool narrows = !options->part.empty() || !options->kind.empty() || options->json;
            require(options->commands + options->coefficients + (narrows ? 1 : 0) <= 1, {},
                    "--commands and --coefficients list other things than keys; expected one of them alone, or a "
                    "section or key, --kind and --json");
            if (options->commands) {
                print_json(commands_json(program));
                return run::exit_done;
            }
            if (options->coefficients) {
                std::fputs(physics::coefficient_documentation().c_str(), stdout);
                return run::exit_done;
            }
            std::optional<io::SceneKind> kind;
            if (!options->kind.empty()) kind = io::kind_of_name(options->kind);
            std::vector<io::SectionDescription> sections = kind ? io::scene_schema(*kind) : io::scene_schema();
            if (!options->part.empty()) sections = part_of(std::move(sections), options->part);
            if (options->json) {
                print_json(report::schema_json(sections));
                return run::exit_done;
            }
            print_sections(sections);
            if (options->part.empty() && kind.value_or(io::SceneKind::fields) == io::SceneKind::fields) print_terms();
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
