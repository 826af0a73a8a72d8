// run/signals.cpp: the one flag that a signal handler may set.
#include "drover/run/signals.hpp"

#include <csignal>
#include <initializer_list>

namespace drover::run {

namespace {
// A signal handler has no argument to reach anything else by.
volatile std::sig_atomic_t requested = 0;

void request_stop(int signal) {
    if (requested != 0 && signal == SIGINT) std::signal(SIGINT, SIG_DFL);
    requested = signal;
}
}  // namespace

void catch_stop_signals() {
    struct sigaction action = {};
    action.sa_handler = request_stop;
    sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM, SIGUSR1}) sigaction(signal, &action, nullptr);
    std::signal(SIGXFSZ, SIG_IGN);  // a limit on file sizes then is an error of the write, as a full disk is
}

int stop_signal() { return requested; }

}  // namespace drover::run
