// app/info.cpp: drover info ARCHIVE.
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "report/shown.hpp"

namespace drover::app {

void add_info(CLI::App& program, Action& action) {
    struct Options {
        std::string archive;
        bool json = false, scene = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "info", "Provenance and results of an archive or a table of coefficients; contents of an XYZ file");
    command->add_option("archive", options->archive, "Archive, such as isotropic.h5")->required();
    command->add_flag("--scene", options->scene, "Print the scene too, every key with its value");
    command->add_flag("--json", options->json, "Print as JSON");
    when_chosen(*command, action, options, [](const Options& given) {
        if (given.json) print_json(report::info_json(given.archive));
        else print(report::info_text(given.archive, given.scene));
        return run::exit_done;
    });
}

}  // namespace drover::app
