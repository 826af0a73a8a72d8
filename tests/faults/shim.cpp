// tests/faults/shim.cpp: makes one call of a program fail; loaded by LD_PRELOAD.
//
//   DROVER_FAULT=pwrite:12:ENOSPC:once      the 12th pwrite, counted from 1, over the program and its child processes
//   DROVER_FAULT=malloc:900:ENOMEM:always   the 900th and all later ones
//   DROVER_FAULT_COUNT=file                 the number of each call is written there at the end
//
// Calls: write pwrite pread fsync rename ftruncate open malloc.  Errors: ENOSPC EIO EDQUOT ENOMEM EINTR, and "short": a
// write or read of half of the bytes.  write does not count the standard streams; pwrite includes posix_fallocate, open
// includes fopen, malloc includes calloc, realloc and aligned allocations, rename includes unlink.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <dlfcn.h>

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
}

namespace {

enum Call {
    call_write,
    call_pwrite,
    call_pread,
    call_fsync,
    call_rename,
    call_ftruncate,
    call_open,
    call_malloc,
    calls
};
constexpr const char* names[calls] = {"write", "pwrite", "pread", "fsync", "rename", "ftruncate", "open", "malloc"};

/// Shared with child processes: counts[c] is the number of calls c so far.
long* counts = nullptr;
int wanted = -1, error = 0;
long at = 0;
bool always = false, is_short = false;
pid_t first_process = 0;

bool is_now(Call call) {
    if (counts == nullptr) return false;
    const long number = __atomic_add_fetch(&counts[call], 1, __ATOMIC_RELAXED);
    return call == wanted && (number == at || (always && number > at));
}

bool fails(Call call) {
    if (!is_now(call) || is_short) return false;
    errno = error;
    return true;
}

/// The bytes of a write or read: fewer when it is to be short; -1 with errno when it is to fail.
ssize_t size_of(Call call, size_t size) {
    if (!is_now(call)) return static_cast<ssize_t>(size);
    if (is_short) return static_cast<ssize_t>(size > 1 ? size / 2 : size);
    errno = error;
    return -1;
}

__attribute__((constructor)) void begin() {
    first_process = getpid();
    if (const char* fault = std::getenv("DROVER_FAULT")) {
        char name[16] = "", what[16] = "", how[16] = "";
        if (std::sscanf(fault, "%15[^:]:%ld:%15[^:]:%15s", name, &at, what, how) != 4) std::abort();
        for (int c = 0; c < calls; ++c)
            if (std::strcmp(names[c], name) == 0) wanted = c;
        always = std::strcmp(how, "always") == 0;
        is_short = std::strcmp(what, "short") == 0;
        const struct {
            const char* name;
            int number;
        } errors[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO}, {"EDQUOT", EDQUOT}, {"ENOMEM", ENOMEM}, {"EINTR", EINTR}};
        for (const auto& one : errors)
            if (std::strcmp(one.name, what) == 0) error = one.number;
        if (wanted < 0 || (error == 0 && !is_short)) std::abort();
    }
    void* memory = mmap(nullptr, calls * sizeof(long), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    counts = static_cast<long*>(memory);
}

__attribute__((destructor)) void end() {
    const char* file = std::getenv("DROVER_FAULT_COUNT");
    if (file == nullptr || getpid() != first_process) return;
    long total[calls];
    std::memcpy(total, counts, sizeof total);
    counts = nullptr;
    const int to = static_cast<int>(syscall(SYS_open, file, O_WRONLY | O_CREAT | O_TRUNC, 0666));
    for (int c = 0; c < calls; ++c) dprintf(to, "%s %ld\n", names[c], total[c]);
}

template <class Function>
Function next(Function, const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

ssize_t do_pwrite(int file, const void* data, size_t size, off_t offset) {
    const ssize_t some = size_of(call_pwrite, size);
    return some < 0 ? -1 : syscall(SYS_pwrite64, file, data, some, offset);
}

ssize_t do_pread(int file, void* data, size_t size, off_t offset) {
    const ssize_t some = size_of(call_pread, size);
    return some < 0 ? -1 : syscall(SYS_pread64, file, data, some, offset);
}

int do_open(const char* name, int flags, va_list more) {
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
    return fails(call_open) ? -1 : static_cast<int>(syscall(SYS_open, name, flags, mode));
}

}  // namespace

extern "C" {
ssize_t write(int file, const void* data, size_t size) {
    const ssize_t some = file <= STDERR_FILENO ? static_cast<ssize_t>(size) : size_of(call_write, size);
    return some < 0 ? -1 : syscall(SYS_write, file, data, some);
}
ssize_t pwrite(int file, const void* data, size_t size, off_t offset) { return do_pwrite(file, data, size, offset); }
ssize_t pwrite64(int file, const void* data, size_t size, off64_t offset) {
    return do_pwrite(file, data, size, offset);
}
ssize_t pread(int file, void* data, size_t size, off_t offset) { return do_pread(file, data, size, offset); }
ssize_t pread64(int file, void* data, size_t size, off64_t offset) { return do_pread(file, data, size, offset); }
int posix_fallocate(int file, off_t offset, off_t length) {
    if (fails(call_pwrite)) return errno;
    return syscall(SYS_fallocate, file, 0, offset, length) == 0 ? 0 : errno;
}
int fsync(int file) { return fails(call_fsync) ? -1 : static_cast<int>(syscall(SYS_fsync, file)); }
int rename(const char* from, const char* to) noexcept {
    return fails(call_rename) ? -1 : static_cast<int>(syscall(SYS_rename, from, to));
}
int unlink(const char* name) noexcept { return fails(call_rename) ? -1 : static_cast<int>(syscall(SYS_unlink, name)); }
int ftruncate(int file, off_t length) noexcept {
    return fails(call_ftruncate) ? -1 : static_cast<int>(syscall(SYS_ftruncate, file, length));
}
int open(const char* name, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const int file = do_open(name, flags, more);
    va_end(more);
    return file;
}
int open64(const char* name, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const int file = do_open(name, flags, more);
    va_end(more);
    return file;
}
FILE* fopen(const char* name, const char* mode) {
    return fails(call_open) ? nullptr : next(fopen, "fopen")(name, mode);
}
FILE* fopen64(const char* name, const char* mode) {
    return fails(call_open) ? nullptr : next(fopen64, "fopen64")(name, mode);
}
void* malloc(size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_realloc(old, size); }
void* aligned_alloc(size_t alignment, size_t size) noexcept {
    return fails(call_malloc) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** to, size_t alignment, size_t size) noexcept {
    if (fails(call_malloc)) return ENOMEM;
    *to = __libc_memalign(alignment, size);
    return *to == nullptr ? ENOMEM : 0;
}
}
