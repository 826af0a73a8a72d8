// base/threads.hpp: a team of threads for loops whose result does not depend on how many there are.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>

namespace drover {

/// A fixed team of threads.  A loop is cut into chunks that depend on its length alone, never on the team,
/// so the same numbers come out for any number of threads.
class Threads {
public:
    /// count >= 1: the caller is one of them.
    explicit Threads(int count = 1);
    ~Threads();
    Threads(const Threads&) = delete;
    Threads& operator=(const Threads&) = delete;

    int count() const;

    /// Calls body(begin, end) once for each chunk [begin, end) of [0, length), chunks being `chunk` long (the last
    /// one shorter), in any order and on any thread; returns when all have ended.  The first exception thrown by a
    /// chunk is thrown again here.  Loops do not nest.
    void for_chunks(std::size_t length, std::size_t chunk, const std::function<void(std::size_t, std::size_t)>& body);

private:
    struct Team;
    std::unique_ptr<Team> team_;
};

/// The cores this process may use (its affinity mask), at least 1.
int usable_cores();

}  // namespace drover
