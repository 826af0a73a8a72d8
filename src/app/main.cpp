// app/main.cpp: the program drover: its commands and exit statuses.
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <span>
#include <string_view>
#include <utility>

#include "app/command.hpp"
#include "base/mapped.hpp"
#include "drover/base/version.hpp"

namespace drover::app {
namespace {

/// Checked before CLI11 asks for a command.
void reject_unknown_command(const CLI::App& program, const std::vector<std::string>& words) {
    if (words.empty() || words.front().starts_with('-')) return;
    const auto names = mapped(program.get_subcommands(nullptr), [](const CLI::App* one) { return one->get_name(); });
    require(std::ranges::find(names, words.front()) != names.end(), {}, "unknown command {}; {}", words.front(),
            suggestion(words.front(), names, text("expected one of {}; see drover --help", joined(names))));
}

/// The next file to be opened would get the number of a standard stream that is closed, and the log be written into it.
/// /dev/null takes the log; what is written to a closed standard output still fails.
void open_standard_streams() {
    for (const auto& [number, flags] :
         {std::pair{STDIN_FILENO, O_RDONLY}, std::pair{STDOUT_FILENO, O_RDONLY}, std::pair{STDERR_FILENO, O_WRONLY}})
        if (::fcntl(number, F_GETFD) < 0 && ::open("/dev/null", flags) != number) ::_exit(run::exit_run_failed);
}

/// The limit of the stack, which threads and child processes get too, is raised where it is too low and may be raised.
void allow_stack() {
    constexpr rlim_t min_bytes = rlim_t{2} << 20, usual = rlim_t{8} << 20;
    struct rlimit limit {};
    if (::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= min_bytes) return;
    const rlim_t allowed = limit.rlim_max;
    limit.rlim_cur = std::min(usual, allowed);
    require(allowed >= min_bytes && ::setrlimit(RLIMIT_STACK, &limit) == 0, {},
            "the stack is limited to {} kB (ulimit -s); expected at least {}: raise the limit", allowed / 1024,
            min_bytes / 1024);
}

/// A stack that cannot grow later, for want of memory, ends the process by a signal; so it grows now, by one access to
/// the deepest page.
[[gnu::noinline]] void grow_stack() {
    std::array<volatile char, 1 << 20> pages;
    pages.front() = 0;
}

void require_stack() {
    allow_stack();
    void* const probe =
        ::mmap(nullptr, std::size_t{2} << 20, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (probe == MAP_FAILED) throw std::bad_alloc();
    ::munmap(probe, std::size_t{2} << 20);
    grow_stack();
}

/// Memory may be short before main, where static objects are made, and in threads.
[[noreturn]] void end_without_memory() {
    const auto end = [](std::string_view sentence) {
        [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, sentence.data(), sentence.size());
        ::_exit(run::exit_run_failed);
    };
    // Where an exception leaves a noexcept function, as in some libraries, its type may not be known here.
    if (!std::current_exception() && std::uncaught_exceptions() > 0)
        end("error: drover cannot continue, probably out of memory; free some memory\n");
    try {
        if (std::current_exception()) std::rethrow_exception(std::current_exception());
    } catch (const std::bad_alloc&) {
        end("error: not enough memory; free some\n");
    } catch (...) {
    }
    std::abort();
}
constexpr int before_other_objects = 101;
[[gnu::constructor(before_other_objects)]] void watch_memory() { std::set_terminate(end_without_memory); }

/// Freed memory stays with the process: HDF5 frees and allocates megabytes for each file that it opens, and the system
/// would clear their pages each time.
void keep_freed_memory() {
    ::mallopt(M_TRIM_THRESHOLD, 64 << 20);
    ::mallopt(M_TOP_PAD, 1 << 20);
    ::mallopt(M_MMAP_THRESHOLD, 32 << 20);  // up to which malloc would raise it by itself
}

/// The exit statuses at the end of --help.
std::string footer(bool is_resumable) {
    std::vector<std::string> statuses;
    for (const auto& [status, meaning] : exit_statuses())
        if (status != run::exit_stopped || is_resumable) statuses.push_back(text("{} {}", status, meaning));
    return text("Exit status: {}.", joined(statuses, ", "));
}

/// Returns the exit status of the command that the words name.
int act(const std::vector<std::string>& words) {
    CLI::App program{
        "drover: hydrodynamics of flocks carried by a passive medium.\n"
        "A scene (input file, TOML) describes a run; drover schema lists its keys.\n"
        "drover COMMAND --help lists the options of a command.",
        "drover"};
    const Version built = version();
    program.set_version_flag("--version",
                             text("drover {} ({}{})", built.version, built.git_hash, built.dirty ? ", modified" : ""));
    program.require_subcommand(1);
    program.footer(footer(true));
    Action action;
#define DROVER_ADD(command) add_##command(program, action);
    DROVER_COMMANDS(DROVER_ADD)
#undef DROVER_ADD
    for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; }))
        if (command->get_option_no_throw("--max-time") == nullptr) command->footer(footer(false));
    reject_unknown_command(program, words);
    try {
        program.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) return program.exit(error);
        const auto chosen = program.get_subcommands();
        fail_input({}, "{}; see drover {}--help", error.what(), chosen.empty() ? "" : chosen.front()->get_name() + " ");
    }
    return action();
}

}  // namespace
}  // namespace drover::app

int main(int count, char** words) {
    using namespace drover;
    app::open_standard_streams();
    run::ignore_file_size_signal();
    files::leave_hdf5_open();
    app::keep_freed_memory();
    const std::span<char*> after_name(words + 1, words + count);
    // One capture: std::function then needs no memory, which may be what is missing.
    return run::status_of([&after_name] {
        app::require_stack();
        const int status = app::act({after_name.begin(), after_name.end()});
        if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
            fail_environment(
                "the results could not be written to standard output; check for a full disk or a closed pipe");
        return status;
    });
}
