// app/diff.cpp: drover diff ONE OTHER.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "run/loop/provenance.hpp"

namespace drover::app {

namespace {
struct DiffOptions {
    std::string one, other;
    bool json = false;
};

int compare(const DiffOptions& options) {
    const std::vector<files::TextDifference> found = run::scene_differences(options.one, options.other);
    if (options.json) {
        nlohmann::json rows = nlohmann::json::array();
        const auto value = [](const std::optional<std::string>& written) {
            return written ? nlohmann::json(*written) : nlohmann::json(nullptr);
        };
        for (const files::TextDifference& row : found)
            rows.push_back({{"key", row.key}, {"one", value(row.one)}, {"other", value(row.other)}});
        print_json(rows);
        return run::exit_done;
    }
    std::size_t widest = 0;
    for (const files::TextDifference& row : found) widest = std::max(widest, row.key.size());
    for (const files::TextDifference& row : found)
        print(text("{:<{}}  {} | {}\n", row.key, widest, files::shown(row.one), files::shown(row.other)));
    if (found.empty()) print(text("{} and {}: the same scene\n", options.one, options.other));
    return run::exit_done;
}
}  // namespace

void add_diff(CLI::App& program, Action& action) {
    const auto options = std::make_shared<DiffOptions>();
    CLI::App* command =
        program.add_subcommand("diff", "Print the keys in which two scenes, or those of archives, differ");
    command->add_option("one", options->one, "A scene, or an archive, whose scene it stores")->required();
    command->add_option("other", options->other, "The one that it is compared with")->required();
    command->add_flag("--json", options->json, "Print the differences as JSON");
    when_chosen(*command, action, options, compare);
}

}  // namespace drover::app
