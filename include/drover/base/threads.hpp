// base/threads.hpp: a thread team for loops whose results do not depend on the number of threads.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>

namespace drover {

/// A fixed team of threads.  A loop is divided into chunks that depend on its length only, so that results are
/// identical for any number of threads.  After a fork between two loops the child makes a team of its own.
/// Use it, and everything made with it, from one thread at a time.
class Threads {
public:
    /// count >= 1, including the calling thread.
    explicit Threads(int count = 1);
    ~Threads();
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;

    int count() const;

    /// Calls body(begin, end) once for each chunk [begin, end) of [0, length), in any order and on any thread; chunks
    /// have length `chunk`, except the last.  Returns when all have ended.  Rethrows the first exception of a chunk.
    /// Loops must not be nested.
    void for_chunks(std::size_t length, std::size_t chunk, const std::function<void(std::size_t, std::size_t)>& body);

private:
    struct Team;
    void forget_team_of_parent();
    std::unique_ptr<Team> team_;
};

/// The number of forks between the first process and this one.  An object made under another number belongs to a parent
/// process, as its threads do.
std::uint64_t fork_count();

/// A mutex that is never destroyed, and for which a fork waits: the child finds it unlocked.  Its holder must not wait
/// for another of them, nor for a thread that may fork.
std::mutex& new_mutex_over_forks();

/// The number of cores that this process may use (its affinity mask), at least 1.
int usable_cores();

}  // namespace drover
