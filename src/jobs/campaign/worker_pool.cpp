// jobs/campaign/worker_pool.cpp: jobs in forked child processes, whose messages come through pipes; a closed pipe marks
// the end of a job.
#include "jobs/campaign/worker_pool.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <vector>

#include "base/duration.hpp"
#include "drover/base/error.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs {

namespace {
struct Worker {
    std::size_t job = 0;
    pid_t process = -1;
    int pipe = -1;             ///< read end
    std::string bytes = {};    ///< that have come, and are no complete message yet
    std::string failure = {};  ///< the sentence of an Error that ends all jobs
};

/// Before each message: its length, and whether it is the sentence of an Error that ends all jobs.
struct Head {
    std::uint64_t length = 0, is_failure = 0;
};

/// The status of a worker whose Error of this kind ends all jobs.
constexpr int status_of_fault(Fault fault) { return 64 + static_cast<int>(fault); }

/// Ends this worker where the parent cannot be reached.
void write_all(int to, std::string_view bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t written = write(to, bytes.data() + done, bytes.size() - done);
        if (written < 0 && errno != EINTR) _exit(status_of_fault(Fault::environment));
        if (written > 0) done += static_cast<std::size_t>(written);
    }
}

void write_message(int to, const std::string& message, bool is_failure) {
    const Head head{.length = message.size(), .is_failure = is_failure};
    write_all(to, {reinterpret_cast<const char*>(&head), sizeof head});
    write_all(to, message);
}

std::optional<Fault> fault_that_ends(int status) {
    const bool is_fault = status >= status_of_fault(Fault::input) && status <= status_of_fault(Fault::defect);
    return is_fault ? std::optional(static_cast<Fault>(status - status_of_fault(Fault::input))) : std::nullopt;
}

/// In the child.
int status_of_work(const Jobs& jobs, std::size_t job, int pipe) {
    return run::status_of([&] {
        try {
            return jobs.work(job, [&](const std::string& message) { write_message(pipe, message, false); });
        } catch (const std::exception& exception) {
            const Error error = error_of(exception);
            write_message(pipe, error.what(), true);
            return status_of_fault(error.fault());
        }
    });
}

Worker start_worker(std::size_t job, const Jobs& jobs) {
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC) < 0)
        fail_environment("cannot create a pipe for a worker: {}", std::strerror(errno));
    std::fflush(nullptr);  // or the child would write buffered output again
    const pid_t caller = getpid(), child = fork();
    if (child < 0) fail_environment("cannot start a worker process: {}", std::strerror(errno));
    if (child > 0) {
        close(ends[1]);
        return {.job = job, .process = child, .pipe = ends[0]};
    }
    close(ends[0]);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != caller) _exit(run::exit_run_failed);  // the parent ended before the request took effect
    const int status = status_of_work(jobs, job, ends[1]);
    std::fflush(nullptr);
    _exit(status);  // without destructors: the objects belong to the parent
}

void signal_all(const std::vector<Worker>& workers, int signal) {
    for (const Worker& worker : workers) kill(worker.process, signal);
}

/// The exit status, by the convention of shells.
int wait_for(pid_t process) {
    int state = 0;
    while (waitpid(process, &state, 0) < 0)
        if (errno != EINTR) fail_environment("waiting for a worker process failed: {}", std::strerror(errno));
    return WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
}

/// Passes complete messages on.
void take_messages(const Jobs& jobs, Worker& worker) {
    std::size_t done = 0;
    for (;;) {
        Head head;
        if (worker.bytes.size() - done < sizeof head) break;
        std::memcpy(&head, worker.bytes.data() + done, sizeof head);
        if (worker.bytes.size() - done - sizeof head < head.length) break;
        const std::string message = worker.bytes.substr(done + sizeof head, head.length);
        done += sizeof head + head.length;
        if (head.is_failure != 0) worker.failure = message;
        else jobs.received(worker.job, message);
    }
    worker.bytes.erase(0, done);
}

/// Reads messages; returns the index of a worker that has closed its pipe, that is, ended.
std::optional<std::size_t> listen(const Jobs& jobs, std::vector<Worker>& workers) {
    std::vector<pollfd> pipes;
    for (const Worker& worker : workers) pipes.push_back({.fd = worker.pipe, .events = POLLIN, .revents = 0});
    constexpr int timeout = 20;  // ms; short, so that a signal is passed on quickly
    if (poll(pipes.data(), pipes.size(), timeout) <= 0) return std::nullopt;
    for (std::size_t i = 0; i < workers.size(); ++i) {
        if (pipes[i].revents == 0) continue;
        std::array<char, 65536> bytes{};
        const ssize_t got = read(workers[i].pipe, bytes.data(), bytes.size());
        if (got > 0) workers[i].bytes.append(bytes.data(), static_cast<std::size_t>(got));
        else if (got == 0) return i;
        else if (errno != EINTR) fail_environment("reading from a worker failed: {}", std::strerror(errno));
        take_messages(jobs, workers[i]);
    }
    return std::nullopt;
}
}  // namespace

bool run_jobs(const Jobs& jobs, const PoolOptions& options) {
    std::vector<Worker> running;
    std::optional<Error> failure;            // that ends all jobs
    std::optional<Clock::time_point> asked;  // when the workers were asked to stop
    const run::StopSignals signals;
    try {
        for (;;) {
            while (run::stop_signal() == 0 && !failure && running.size() < static_cast<std::size_t>(options.workers)) {
                const std::optional<std::size_t> job = jobs.next();
                if (!job) break;
                running.push_back(start_worker(*job, jobs));
            }
            if (running.empty()) break;
            if (failure || run::stop_signal() != 0) {
                if (!asked) signal_all(running, SIGTERM);
                if (!asked) asked = Clock::now();
                if (seconds_since(*asked) > options.grace_period) signal_all(running, SIGKILL);
            }
            if (jobs.idle) jobs.idle();
            const std::optional<std::size_t> over = listen(jobs, running);
            if (!over) continue;
            const Worker worker = std::move(running[*over]);
            running.erase(running.begin() + static_cast<std::ptrdiff_t>(*over));
            close(worker.pipe);
            const int status = wait_for(worker.process);
            if (const auto fault = fault_that_ends(status); fault && run::stop_signal() == 0) {
                const std::string reason =
                    worker.failure.empty()
                        ? "a worker could not send its results to this process; run the same command again"
                        : worker.failure;
                if (!failure) failure.emplace(*fault, SourceLocation{}, reason);
            } else if (!failure || status == run::exit_done || status == run::exit_stopped) {
                jobs.ended(worker.job, status);
            }
        }
    } catch (...) {
        signal_all(running, SIGKILL);
        for (const Worker& worker : running) wait_for(worker.process);
        throw;
    }
    if (failure) throw *failure;
    return run::stop_signal() != 0;  // a worker that a signal alone stopped has left its job to the others
}

}  // namespace drover::jobs
