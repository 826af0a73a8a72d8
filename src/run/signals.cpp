// run/signals.cpp: the flag that the signal handler sets.
#include "drover/run/signals.hpp"

#include <csignal>
#include <initializer_list>

namespace drover::run {

namespace {
// A global: a signal handler has no other way to report.
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
    std::signal(SIGXFSZ, SIG_IGN);  // exceeding a file-size limit then fails the write, as a full disk does
}

int stop_signal() { return requested; }

}  // namespace drover::run
