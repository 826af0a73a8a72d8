// app/serve.cpp: drover serve SCENE|ARCHIVE: a page in a browser that shows a run, by the Python package.
#include "app/command.hpp"

namespace drover::app {

void add_serve(CLI::App& program, Action& action) {
    struct Options {
        std::string run;
        std::vector<std::string> settings;
        int port = 0;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = program.add_subcommand(
        "serve", "Show a run in a browser on this machine; a scene runs in memory and can be steered; needs python3");
    command->add_option("run", options->run, "Scene (.toml), which is run in memory, or archive of a run")->required();
    command->add_option("--set", options->settings, "Override a key of the scene, section.key=value; repeatable")
        ->type_name("KEY=VALUE");
    command->add_option("--port", options->port, "Port on 127.0.0.1; default: a free one")->check(CLI::Range(1, 65535));
    when_chosen(*command, action, options, [](const Options& given) {
        std::vector<std::string> words;
        if (given.port != 0) words.insert(words.end(), {"--port", std::to_string(given.port)});
        for (const std::string& setting : given.settings) words.push_back("--set=" + setting);
        words.insert(words.end(), {"--", given.run});
        return run_python_package("serve", "server", words);
    });
}

}  // namespace drover::app
