// run/worker_pool.cpp: jobs in child processes by fork.
#include "drover/run/worker_pool.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <map>
#include <thread>

#include "drover/base/error.hpp"
#include "drover/run/exit_status.hpp"
#include "drover/run/signals.hpp"

namespace drover::run {

namespace {
pid_t start_child(std::size_t job, const std::function<int(std::size_t)>& work) {
    std::fflush(nullptr);  // or the child would write what we have buffered once more
    const pid_t child = fork();
    if (child < 0) fail_run("cannot start a worker process: {}", std::strerror(errno));
    if (child > 0) return child;
    const int status = status_of([&] { return work(job); });
    std::fflush(nullptr);
    _exit(status);  // the parent's objects are the parent's to end
}
}  // namespace

PoolOutcome run_jobs(std::size_t count, int workers, const std::function<int(std::size_t)>& work,
                     const std::function<void(std::size_t, int)>& ended) {
    PoolOutcome outcome;
    std::map<pid_t, std::size_t> running;
    std::size_t next = 0;
    bool passed_on = false;
    while (next < count || !running.empty()) {
        while (stop_signal() == 0 && next < count && running.size() < static_cast<std::size_t>(workers)) {
            running.emplace(start_child(next, work), next);
            ++next;
        }
        if (running.empty()) break;
        if (stop_signal() != 0 && !passed_on) {
            for (const auto& [child, job] : running) kill(child, SIGTERM);
            passed_on = true;
        }
        int state = 0;
        const pid_t child = waitpid(-1, &state, WNOHANG);
        if (child < 0 && errno != EINTR) fail_run("waiting for worker processes failed: {}", std::strerror(errno));
        if (child <= 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(20));  // short, so that a signal is passed on at once
            continue;
        }
        const auto found = running.find(child);
        if (found == running.end()) continue;
        const int status = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
        ++(status == 0 ? outcome.done : outcome.failed);
        ended(found->second, status);
        running.erase(found);
    }
    outcome.stopped = stop_signal() != 0;
    return outcome;
}

}  // namespace drover::run
