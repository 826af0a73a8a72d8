// app/restart.cpp: drover restart ARCHIVE.
#include "app/command.hpp"

namespace drover::app {

void add_restart(CLI::App& program, Action& action) {
    struct Options {
        std::string archive;
        std::vector<std::string> overrides;
        int threads = 0;
        bool json = false, quiet = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        program.add_subcommand("restart", "Resume a run from its latest valid checkpoint; bitwise reproducible");
    command->add_option("archive", options->archive, "Archive of the run, such as isotropic.h5")->required();
    command->add_option("--set", options->overrides, "Override time.end, output.checkpoint_minutes or run.threads")
        ->type_name("KEY=VALUE");
    add_threads(*command, options->threads);
    add_max_time(*command);
    command->add_flag("--json", options->json, "Print the results as JSON");
    command->add_flag("-q,--quiet", options->quiet, "Print no log and no progress");
    when_chosen(*command, action, options, [](const Options& given) {
        std::vector<std::string> overrides = given.overrides;
        if (given.threads > 0) overrides.push_back(text("run.threads={}", given.threads));
        return print_outcome(run::restart_run(given.archive, overrides, {.overwrite = false, .quiet = given.quiet}),
                             given.json);
    });
}

}  // namespace drover::app
