// run/signals.cpp: the flag that the signal handler sets.
#include "drover/run/signals.hpp"

namespace drover::run {

namespace {
// A global: a signal handler has no other way to report.
volatile std::sig_atomic_t requested = 0;

extern "C" void request_stop(int signal) {
    if (requested != 0 && signal == SIGINT) {
        std::signal(SIGINT, SIG_DFL);
        std::raise(SIGINT);  // takes effect when this function returns
    }
    requested = signal;
}
}  // namespace

StopSignals::StopSignals() {
    for (std::size_t i = 0; i < handled.size(); ++i) {
        sigaction(handled[i], nullptr, &before_[i]);
        if (handled[i] == SIGHUP && before_[i].sa_handler == SIG_IGN) continue;
        struct sigaction action = {};
        action.sa_handler = handled[i] == SIGPIPE ? SIG_IGN : request_stop;
        sigemptyset(&action.sa_mask);
        action.sa_flags = SA_RESTART;
        sigaction(handled[i], &action, nullptr);
    }
}

StopSignals::~StopSignals() {
    for (std::size_t i = 0; i < handled.size(); ++i) sigaction(handled[i], &before_[i], nullptr);
}

int stop_signal() { return requested; }

void ignore_file_size_signal() { std::signal(SIGXFSZ, SIG_IGN); }

}  // namespace drover::run
