// app/info.cpp: drover info ARCHIVE.
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "report/shown.hpp"

namespace drover::app {

namespace {
struct InfoOptions {
    std::string archive;
    bool json = false, scene = false;
};
}  // namespace

void add_info(CLI::App& program, Action& action) {
    const auto options = std::make_shared<InfoOptions>();
    CLI::App* command = program.add_subcommand(
        "info", "Provenance and results of an archive or a table of coefficients; contents of an XYZ file");
    command->add_option("archive", options->archive, "Archive, such as isotropic.h5")->required();
    command->add_flag("--scene", options->scene, "Print the scene too, every key with its value");
    command->add_flag("--json", options->json, "Print as JSON");
    command->callback([options, &action] {
        action = [options] {
            if (options->json) print_json(report::info_json(options->archive));
            else print(report::info_text(options->archive, options->scene));
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
