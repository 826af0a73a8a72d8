// app/info.cpp: drover info ARCHIVE.
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "command.hpp"

namespace drover::app {

namespace {
void print(const io::ArchiveReader& archive, const run::Report& report, bool scene) {
    for (const auto& [name, value] : archive.attributes()) {
        if (name == "scene") continue;
        const std::string written = std::visit([](const auto& held) { return text("{}", held); }, value);
        std::printf("%-20s %s\n", name.c_str(), written.c_str());
    }
    const std::vector<std::size_t> frames = archive.shape("/time");
    std::printf("%-20s %zu\n\n", "frames", frames.empty() ? std::size_t{0} : frames.front());
    if (scene) std::printf("%s\n", archive.text_attribute("scene").c_str());
    std::fputs(run::report_text(report).c_str(), stdout);
}
}  // namespace

void add_info(CLI::App& program, Action& action) {
    struct Options {
        std::string archive;
        bool json = false, scene = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand("info", "where an archive came from, and its results so far");
    command->add_option("archive", options->archive, "the archive, such as isotropic.h5")->required();
    command->add_flag("--scene", options->scene, "also the scene, every key with its value");
    command->add_flag("--json", options->json, "as JSON");
    command->callback([options, &action] {
        action = [options] {
            const io::ArchiveReader archive(options->archive);
            const run::Report report = run::make_report(archive);
            if (!options->json) {
                print(archive, report, options->scene);
                return run::exit_done;
            }
            nlohmann::json result = report_json(report);
            result["attributes"] = attributes_json(archive);
            std::puts(result.dump(2).c_str());
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
