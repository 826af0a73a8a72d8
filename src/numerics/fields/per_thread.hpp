// numerics/fields/per_thread.hpp: an object of each thread.
#pragma once
#include <pthread.h>

#include <memory>
#include <new>

namespace drover::numerics {

/// An object for each thread, made at its first use and destroyed with the thread, but for that of the main thread.
/// As thread_local, but get() throws std::bad_alloc where memory is short: for a thread_local object with a destructor
/// glibc then ends the process by a signal.
template <class Object>
class PerThread {
public:
    PerThread() {
        if (pthread_key_create(&key_, [](void* mine) { delete static_cast<Object*>(mine); }) != 0)
            throw std::bad_alloc();
    }
    PerThread(const PerThread&) = delete;
    PerThread& operator=(const PerThread&) = delete;
    ~PerThread() = default;  // threads may outlive it

    Object& get() {
        if (void* const mine = pthread_getspecific(key_)) return *static_cast<Object*>(mine);
        auto made = std::make_unique<Object>();
        if (pthread_setspecific(key_, made.get()) != 0) throw std::bad_alloc();
        return *made.release();
    }

private:
    pthread_key_t key_{};
};

}  // namespace drover::numerics
