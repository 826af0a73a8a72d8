// app/main.cpp: the program drover: its commands and exit statuses.
#include <cstdio>

#include "command.hpp"
#include "drover/base/version.hpp"
#include "drover/run/signals.hpp"

int main(int count, char** words) {
    using namespace drover;
    CLI::App program{"drover: hydrodynamics of flocks carried by a passive medium"};
    const Version built = version();
    program.set_version_flag("--version",
                             text("drover {} ({}{})", built.version, built.git_hash, built.dirty ? ", changed" : ""));
    program.require_subcommand(1);
    program.footer("Exit status: 0 done, 1 a run failed, 2 bad input, 3 stopped by a signal after a checkpoint.");
    app::Action action;
    for (const auto add : {app::add_run, app::add_restart, app::add_sweep, app::add_check, app::add_explain,
                           app::add_info, app::add_schema})
        add(program, action);
    try {
        program.parse(count, words);
    } catch (const CLI::ParseError& error) {
        return program.exit(error) == 0 ? run::exit_done : run::exit_bad_input;
    }
    run::catch_stop_signals();
    return run::status_of(action);
}
