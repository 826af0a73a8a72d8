// tests/faults/shim.cpp: makes one call of a program fail; loaded by LD_PRELOAD.
//
//   DROVER_FAULT=pwrite:12:ENOSPC:once      the 12th pwrite, counted from 1, over the program and its child processes
//   DROVER_FAULT=malloc:900:ENOMEM:always   the 900th and all later ones
//   DROVER_FAULT_WITHIN=H5Dwrite            of malloc only calls with this function or library among the innermost
//   DROVER_FAULT_UNDER=/tmp/folder          only calls on files of this folder, and in it; not for malloc
//   DROVER_FAULT_LOCKS=ENOLCK               a file system without locks: ENOLCK, EOPNOTSUPP or ENOSYS
//   DROVER_FAULT_TRACE=1                    prints the stack of calls of the first that fails
//   DROVER_FAULT_COUNT=file                 the number of each call is written there at the end (the largest of the
//                                           processes that were started by exec), and which allocations were the first
//                                           with their innermost calls
//
// Calls: read write pwrite pread fsync rename link ftruncate open malloc.  Errors: ENOSPC EIO EDQUOT ENOMEM EINTR
// ESTALE EPERM, and "short": a write or read of half of the bytes.  read and write do not count the standard streams;
// read includes readv, and not fread, whose calls are within the C library; pwrite includes posix_fallocate, open
// includes fopen, malloc includes calloc, realloc and aligned allocations, rename includes unlink.
#include <execinfo.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
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
    call_read,
    call_write,
    call_pwrite,
    call_pread,
    call_fsync,
    call_rename,
    call_link,
    call_ftruncate,
    call_open,
    call_malloc,
    calls
};
constexpr const char* names[calls] = {"read",   "write", "pwrite",    "pread", "fsync",
                                      "rename", "link",  "ftruncate", "open",  "malloc"};

/// Shared with child processes: counts[c] is the number of calls c so far.
long* counts = nullptr;
int wanted = -1, error = 0;
long at = 0;
bool always = false, is_short = false, is_traced = false;
pid_t first_process = 0;
const char *under = nullptr, *within = nullptr;

/// The stacks of calls seen so far, shared with child processes: a hash table, and the first allocation of each.
struct Stacks {
    static constexpr size_t room = 1 << 18;
    unsigned long hashes[room];
    long firsts[room];
    size_t size;
};
Stacks* stacks = nullptr;
thread_local bool walking = false;

void remember_stack(long number) {
    if (walking) return;  // backtrace may allocate
    walking = true;
    void* frames[6];  // the innermost calls
    const int depth = backtrace(frames, 6);
    unsigned long hash = 14695981039346656037UL;  // FNV-1a
    for (int k = 0; k < depth; ++k) hash = (hash ^ reinterpret_cast<unsigned long>(frames[k])) * 1099511628211UL;
    for (size_t slot = hash % Stacks::room; stacks->size < Stacks::room / 2; slot = (slot + 1) % Stacks::room) {
        unsigned long empty = 0;
        if (__atomic_compare_exchange_n(&stacks->hashes[slot], &empty, hash, false, __ATOMIC_SEQ_CST, __ATOMIC_SEQ_CST))
            stacks->firsts[__atomic_fetch_add(&stacks->size, 1, __ATOMIC_SEQ_CST)] = number;
        else if (empty != hash) continue;
        break;
    }
    walking = false;
}

void print_stack() {
    void* frames[48];
    walking = true;  // not to be counted
    backtrace_symbols_fd(frames, backtrace(frames, 48), STDERR_FILENO);
    walking = false;
}

bool is_of_name(const void* address) {
    Dl_info info{};
    return dladdr(address, &info) != 0 && (std::strstr(info.dli_fname, within) != nullptr ||
                                           (info.dli_sname != nullptr && std::strstr(info.dli_sname, within)));
}

/// Whether a function or library of this name is among the innermost calls.
bool is_within() {
    if (within == nullptr) return true;
    if (walking) return false;
    walking = true;
    struct Known {
        const void* address;
        bool is_of_name;
    };
    static thread_local Known known[1 << 12];  // names are slow to find
    void* frames[16];
    bool found = false;
    for (int k = backtrace(frames, 16) - 1; k >= 0 && !found; --k) {
        Known& one = known[reinterpret_cast<unsigned long>(frames[k]) * 11400714819323198485UL >> 52];
        if (one.address != frames[k]) one = {frames[k], is_of_name(frames[k])};
        found = one.is_of_name;
    }
    walking = false;
    return found;
}

bool is_now(Call call) {
    if (counts == nullptr || (call == call_malloc && !is_within())) return false;
    const long number = __atomic_add_fetch(&counts[call], 1, __ATOMIC_RELAXED);
    if (stacks != nullptr && call == call_malloc) remember_stack(number);
    if (call == wanted && number == at && is_traced) print_stack();
    return call == wanted && (number == at || (always && number > at));
}

bool fails(Call call) {
    if (!is_now(call) || is_short) return false;
    errno = error;
    return true;
}

bool is_under(const char* path) {
    return under == nullptr || path[0] != '/' || std::strncmp(path, under, std::strlen(under)) == 0;
}

bool is_under(int file) {
    if (under == nullptr) return true;
    char link[64], path[4096];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t size = readlink(link, path, sizeof path - 1);
    if (size < 0) return false;
    path[size] = 0;
    return path[0] == '/' && is_under(path);
}

/// The bytes of a write or read: fewer when it is to be short; -1 with errno when it is to fail.
ssize_t size_of(Call call, size_t size) {
    if (!is_now(call)) return static_cast<ssize_t>(size);
    if (is_short) return static_cast<ssize_t>(size > 1 ? size / 2 : size);
    errno = error;
    return -1;
}

template <class Function>
Function next(Function, const char* name) {
    return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

__attribute__((constructor)) void begin() {
    first_process = getpid();
    under = std::getenv("DROVER_FAULT_UNDER");
    within = std::getenv("DROVER_FAULT_WITHIN");
    is_traced = std::getenv("DROVER_FAULT_TRACE") != nullptr;
    void* frame = nullptr;
    backtrace(&frame, 1);  // loads what it needs
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
        } errors[] = {{"ENOSPC", ENOSPC}, {"EIO", EIO},       {"EDQUOT", EDQUOT}, {"ENOMEM", ENOMEM},
                      {"EINTR", EINTR},   {"ESTALE", ESTALE}, {"EPERM", EPERM}};
        for (const auto& one : errors)
            if (std::strcmp(one.name, what) == 0) error = one.number;
        if (wanted < 0 || (error == 0 && !is_short)) std::abort();
    }
    void* memory = mmap(nullptr, calls * sizeof(long), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (std::getenv("DROVER_FAULT_COUNT") != nullptr && under == nullptr) {
        void* room = mmap(nullptr, sizeof(Stacks), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        stacks = static_cast<Stacks*>(room);
    }
    counts = static_cast<long*>(memory);
}

__attribute__((destructor)) void end() {
    const char* file = std::getenv("DROVER_FAULT_COUNT");
    if (file == nullptr || getpid() != first_process) return;
    long total[calls];
    std::memcpy(total, counts, sizeof total);
    counts = nullptr;
    if (FILE* before = next(fopen, "fopen")(file, "r")) {
        char name[16];
        long count = 0;
        for (int c = 0; c < calls && std::fscanf(before, "%15s %ld", name, &count) == 2; ++c)
            if (count > total[c]) total[c] = count;
        std::fclose(before);
    }
    const int to = static_cast<int>(syscall(SYS_open, file, O_WRONLY | O_CREAT | O_TRUNC, 0666));
    for (int c = 0; c < calls; ++c) dprintf(to, "%s %ld\n", names[c], total[c]);
    dprintf(to, "stacks");
    for (size_t k = 0; stacks != nullptr && k < stacks->size; ++k) dprintf(to, " %ld", stacks->firsts[k]);
    dprintf(to, "\n");
}

ssize_t do_read(int file, void* data, size_t size) {
    const bool is_counted = file > STDERR_FILENO && is_under(file);
    const ssize_t some = is_counted ? size_of(call_read, size) : static_cast<ssize_t>(size);
    return some < 0 ? -1 : syscall(SYS_read, file, data, some);
}

ssize_t do_pwrite(int file, const void* data, size_t size, off_t offset) {
    const ssize_t some = is_under(file) ? size_of(call_pwrite, size) : static_cast<ssize_t>(size);
    return some < 0 ? -1 : syscall(SYS_pwrite64, file, data, some, offset);
}

ssize_t do_pread(int file, void* data, size_t size, off_t offset) {
    const ssize_t some = is_under(file) ? size_of(call_pread, size) : static_cast<ssize_t>(size);
    return some < 0 ? -1 : syscall(SYS_pread64, file, data, some, offset);
}

int do_open(const char* name, int flags, va_list more) {
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(more, mode_t) : 0;
    return is_under(name) && fails(call_open) ? -1 : static_cast<int>(syscall(SYS_open, name, flags, mode));
}

}  // namespace

extern "C" {
/// For a process that has forked: reads the variables anew, and counts from 1.
void drover_fault_begin() { begin(); }

ssize_t read(int file, void* data, size_t size) { return do_read(file, data, size); }
ssize_t __read_chk(int file, void* data, size_t size, size_t) { return do_read(file, data, size); }
ssize_t readv(int file, const struct iovec* parts, int count) {
    const bool is_counted = file > STDERR_FILENO && is_under(file);
    if (is_counted && fails(call_read)) return -1;
    return syscall(SYS_readv, file, parts, count);
}
ssize_t write(int file, const void* data, size_t size) {
    const bool is_counted = file > STDERR_FILENO && is_under(file);
    const ssize_t some = is_counted ? size_of(call_write, size) : static_cast<ssize_t>(size);
    return some < 0 ? -1 : syscall(SYS_write, file, data, some);
}
ssize_t pwrite(int file, const void* data, size_t size, off_t offset) { return do_pwrite(file, data, size, offset); }
ssize_t pwrite64(int file, const void* data, size_t size, off64_t offset) {
    return do_pwrite(file, data, size, offset);
}
ssize_t pread(int file, void* data, size_t size, off_t offset) { return do_pread(file, data, size, offset); }
ssize_t pread64(int file, void* data, size_t size, off64_t offset) { return do_pread(file, data, size, offset); }
int posix_fallocate(int file, off_t offset, off_t length) {
    if (is_under(file) && fails(call_pwrite)) return errno;
    return syscall(SYS_fallocate, file, 0, offset, length) == 0 ? 0 : errno;
}
int fsync(int file) { return is_under(file) && fails(call_fsync) ? -1 : static_cast<int>(syscall(SYS_fsync, file)); }
int rename(const char* from, const char* to) noexcept {
    return is_under(to) && fails(call_rename) ? -1 : static_cast<int>(syscall(SYS_rename, from, to));
}
int link(const char* from, const char* to) noexcept {
    return is_under(to) && fails(call_link) ? -1 : static_cast<int>(syscall(SYS_link, from, to));
}
int unlink(const char* name) noexcept {
    return is_under(name) && fails(call_rename) ? -1 : static_cast<int>(syscall(SYS_unlink, name));
}
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
    return is_under(name) && fails(call_open) ? nullptr : next(fopen, "fopen")(name, mode);
}
FILE* fopen64(const char* name, const char* mode) {
    return is_under(name) && fails(call_open) ? nullptr : next(fopen64, "fopen64")(name, mode);
}
void* malloc(size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_malloc(size); }
void* calloc(size_t count, size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) noexcept { return fails(call_malloc) ? nullptr : __libc_realloc(old, size); }
void* aligned_alloc(size_t alignment, size_t size) noexcept {
    return fails(call_malloc) ? nullptr : __libc_memalign(alignment, size);
}
void* memalign(size_t alignment, size_t size) noexcept {
    return fails(call_malloc) ? nullptr : __libc_memalign(alignment, size);
}
int posix_memalign(void** to, size_t alignment, size_t size) noexcept {
    if (fails(call_malloc)) return ENOMEM;
    *to = __libc_memalign(alignment, size);
    return *to == nullptr ? ENOMEM : 0;
}
int fcntl(int file, int command, ...) {
    va_list more;
    va_start(more, command);
    void* argument = va_arg(more, void*);
    va_end(more);
    const bool is_lock = command == F_OFD_SETLK || command == F_OFD_GETLK || command == F_SETLK || command == F_SETLKW;
    const char* reason = is_lock ? std::getenv("DROVER_FAULT_LOCKS") : nullptr;
    if (reason == nullptr) return static_cast<int>(syscall(SYS_fcntl, file, command, argument));
    errno = std::strcmp(reason, "ENOLCK") == 0 ? ENOLCK : std::strcmp(reason, "ENOSYS") == 0 ? ENOSYS : EOPNOTSUPP;
    return -1;
}
int fcntl64(int file, int command, ...) __attribute__((alias("fcntl")));
}
