// app/export.cpp: drover export ARCHIVE: frames of a particle run as extended XYZ.
#include <cstdio>
#include <memory>

#include "command.hpp"
#include "drover/io/xyz.hpp"

namespace drover::app {

void add_export(CLI::App& program, Action& action) {
    struct Options {
        std::string archive, output;
        io::XyzPlan plan;
        bool overwrite = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("export", "Export frames of a particle run as extended XYZ text, for viewers");
    command->add_option("archive", options->archive, "Archive of a particle run")->required();
    command->add_option("-o,--output", options->output, "File to write, such as tapered.xyz")->required();
    CLI::Option* frame = command->add_option("--frame", options->plan.frame, "Export only this frame, counted from 0")
                             ->check(CLI::Range(std::int64_t{0}, std::int64_t{1000000000000}));
    command->add_option("--every", options->plan.every, "Export every k-th frame, starting with the first")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000000000}))
        ->excludes(frame);
    command->add_flag("--bodies", options->plan.bodies,
                      "Write one line per body, with its direction, instead of one per sphere");
    command->add_flag("--overwrite", options->overwrite, "Replace an existing file");
    command->callback([options, &action] {
        action = [options] {
            const files::ArchiveReader archive(options->archive);
            const std::size_t frames =
                io::write_xyz(archive, options->archive, options->plan, options->output, options->overwrite);
            std::printf("%s: %zu frame%s of %s\n", options->output.c_str(), frames, frames == 1 ? "" : "s",
                        options->plan.bodies ? "bodies" : "spheres");
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
