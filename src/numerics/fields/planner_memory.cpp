// numerics/fields/planner_memory.cpp: FFTW's functions that allocate, replaced.
#include "numerics/fields/planner_memory.hpp"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <functional>
#include <new>
#include <thread>

namespace drover::numerics {

namespace {
constexpr std::size_t alignment = 64;  // at least that of FFTW's own

/// The head of a block of memory.  One that was used is kept for good: FFTW may keep tables in it.
struct alignas(alignment) Block {
    Block* before;
    std::size_t size, used = sizeof(Block);

    char* begin() { return reinterpret_cast<char*>(this); }
    bool holds(const void* address) {
        const std::less<const void*> before_in_memory;
        return !before_in_memory(address, begin()) && before_in_memory(address, begin() + size);
    }
};

// Globals, since FFTW's planner is one.
std::atomic<Block*> kept = nullptr;  // read by any thread, at any time
std::atomic<std::thread::id> planning_thread;
Block* current = nullptr;  // of that thread alone: another one must not look into what it may free

void* take(Block& block, std::size_t size) {
    size = (size + alignment - 1) / alignment * alignment;
    if (size > block.size - block.used) return nullptr;
    block.used += size;
    return block.begin() + block.used - size;
}
}  // namespace

PlannerMemory::PlannerMemory(std::size_t length) {
    // Measured with FFTW 3.3.10: its planner takes 0.3 MB at first, and up to 272 bytes for each point of a line whose
    // length is a prime.
    const std::size_t size = (std::size_t{1} << 20) + 512 * length;
    void* const memory = ::memalign(alignment, size);
    if (memory == nullptr) throw std::bad_alloc();
    current = new (memory) Block{.before = nullptr, .size = size};
    planning_thread = std::this_thread::get_id();
}

PlannerMemory::~PlannerMemory() {
    planning_thread = std::thread::id();
    if (was_short()) {
        current->before = kept;
        kept = current;
    } else {
        std::free(current);
    }
    current = nullptr;
}

bool PlannerMemory::was_short() const { return current->used > sizeof(Block); }

}  // namespace drover::numerics

// FFTW calls these by name, and the dynamic linker finds ours before its own.
extern "C" {
void* fftw_kernel_malloc(std::size_t size);
void fftw_kernel_free(void* memory);

void* fftw_kernel_malloc(std::size_t size) {
    using namespace drover::numerics;
    if (void* const memory = ::memalign(alignment, size)) return memory;
    if (planning_thread.load() != std::this_thread::get_id()) throw std::bad_alloc();
    return take(*current, size);
}

void fftw_kernel_free(void* memory) {
    using namespace drover::numerics;
    if (planning_thread.load() == std::this_thread::get_id() && current->holds(memory)) return;
    for (Block* block = kept; block != nullptr; block = block->before)
        if (block->holds(memory)) return;
    std::free(memory);
}
}
