// base/threads.cpp: distributes the chunks of a loop over a thread team.
#include "drover/base/threads.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <list>
#include <thread>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

namespace {
/// Polls a condition for some tens of microseconds: consecutive loops then need no sleep in between.
template <class Holds>
bool holds_soon(Holds holds) {
    constexpr int polls = 2000;
    for (int poll = 0; poll < polls; ++poll) {
        if (holds()) return true;
#if defined(__x86_64__)
        __builtin_ia32_pause();
#endif
    }
    return false;
}

/// fork() copies the calling thread alone, with the mutexes that other threads hold.
struct Forks {
    std::mutex mutex;
    std::list<std::mutex> waited_for;
    std::atomic<std::uint64_t> count = 0;
};

Forks& forks() {
    static Forks* const all = [] {
        auto made = std::make_unique<Forks>();
        static constexpr auto release = [] {
            for (std::mutex& one : forks().waited_for) one.unlock();
            forks().mutex.unlock();
        };
        const int failure = ::pthread_atfork(
            [] {
                forks().mutex.lock();
                for (std::mutex& one : forks().waited_for) one.lock();
            },
            release,
            [] {
                ++forks().count;
                release();
            });
        if (failure != 0) throw std::bad_alloc();
        return made.release();  // never destroyed: a process may fork while it ends
    }();
    return *all;
}
}  // namespace

std::uint64_t fork_count() { return forks().count; }

std::mutex& new_mutex_over_forks() {
    const std::lock_guard lock(forks().mutex);
    return forks().waited_for.emplace_back();
}

struct Threads::Team {
    /// The chunks that one thread takes first: the same in every loop, so that their data stay in its cache.  A thread
    /// that has finished its share takes chunks from the others.
    struct alignas(64) Share {
        std::atomic<std::size_t> next = 0;
        std::size_t end = 0;
    };

    explicit Team(std::size_t count) : shares(count) {
        try {
            for (std::size_t i = 1; i < count; ++i) helpers.emplace_back([this, i] { help(i); });
        } catch (...) {
            end_helpers();
            throw;
        }
    }
    ~Team() { end_helpers(); }
    Team(const Team&) = delete;
    Team& operator=(const Team&) = delete;

    const std::uint64_t forks = fork_count();  // in a later one, the helpers are threads of its parent
    std::mutex mutex;
    std::condition_variable started, ended;
    std::vector<std::thread> helpers;
    std::atomic<std::uint64_t> loop_number = 0;  // a helper works when this differs from its last loop
    std::atomic<std::size_t> working = 0;
    std::atomic<bool> leaving = false;

    const std::function<void(std::size_t, std::size_t)>* body = nullptr;
    std::size_t length = 0, chunk = 1;
    std::vector<Share> shares;
    std::exception_ptr failure;

    void end_helpers() {
        {
            const std::lock_guard lock(mutex);
            leaving = true;
        }
        started.notify_all();
        for (std::thread& helper : helpers) helper.join();
    }

    void distribute() {
        const std::size_t chunks = (length + chunk - 1) / chunk;
        for (std::size_t s = 0; s < shares.size(); ++s) {
            shares[s].next = s * chunks / shares.size();
            shares[s].end = (s + 1) * chunks / shares.size();
        }
    }

    void work(std::size_t me) {
        for (std::size_t k = 0; k < shares.size(); ++k) {
            Share& share = shares[(me + k) % shares.size()];
            for (;;) {
                const std::size_t taken = share.next.fetch_add(1);
                if (taken >= share.end) break;
                try {
                    (*body)(taken * chunk, std::min((taken + 1) * chunk, length));
                } catch (...) {
                    const std::lock_guard lock(mutex);
                    if (!failure) failure = std::current_exception();
                    for (Share& other : shares) other.next = other.end;
                }
            }
        }
    }

    void help(std::size_t me) {
        std::uint64_t done = 0;
        const auto called = [&] { return leaving.load() || loop_number.load() != done; };
        for (;;) {
            if (!holds_soon(called)) {
                std::unique_lock lock(mutex);
                started.wait(lock, called);
            }
            if (leaving) return;
            done = loop_number;
            work(me);
            if (working.fetch_sub(1) == 1) {
                const std::lock_guard lock(mutex);  // the caller may be between its last poll and its sleep
                ended.notify_one();
            }
        }
    }
};

Threads::Threads(int count) {
    require(count >= 1, {}, "threads = {}; expected at least 1", count);
    team_ = std::make_unique<Team>(static_cast<std::size_t>(count));
}

Threads::~Threads() { forget_team_of_parent(); }

/// Nobody can end its helpers, nor unlock what they hold.
void Threads::forget_team_of_parent() {
    if (team_->forks != fork_count()) static_cast<void>(team_.release());
}

int Threads::count() const { return static_cast<int>(team_->shares.size()); }

void Threads::for_chunks(std::size_t length, std::size_t chunk,
                         const std::function<void(std::size_t, std::size_t)>& body) {
    chunk = std::max<std::size_t>(chunk, 1);
    if (team_->helpers.empty() || length <= chunk) {
        for (std::size_t begin = 0; begin < length; begin += chunk) body(begin, std::min(begin + chunk, length));
        return;
    }
    if (team_->forks != fork_count()) {
        auto team = std::make_unique<Team>(team_->shares.size());
        forget_team_of_parent();
        team_ = std::move(team);
    }
    {
        const std::lock_guard lock(team_->mutex);
        team_->body = &body;
        team_->length = length;
        team_->chunk = chunk;
        team_->distribute();
        team_->failure = nullptr;
        team_->working = team_->helpers.size();
        ++team_->loop_number;
    }
    team_->started.notify_all();
    team_->work(0);
    const auto all_ended = [&] { return team_->working.load() == 0; };
    if (!holds_soon(all_ended)) {
        std::unique_lock lock(team_->mutex);
        team_->ended.wait(lock, all_ended);
    }
    const std::lock_guard lock(team_->mutex);
    if (team_->failure) std::rethrow_exception(team_->failure);
}

int usable_cores() {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof(set), &set) != 0) return 1;
    return std::max(1, CPU_COUNT(&set));
}

}  // namespace drover
