// files/claims.cpp: claims as hard links to files of their owners, whose times are heartbeats.
#include "files/claims.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <map>
#include <sstream>

#include "base/duration.hpp"
#include "base/mapped.hpp"
#include "files/bytes.hpp"
#include "files/input_file.hpp"
#include "files/system_calls.hpp"

namespace drover::files {

namespace {
namespace fs = std::filesystem;

constexpr const char* owner_prefix = "owner-";
constexpr std::uint64_t claim_magic = 0x316d6c63767264;  // "drvclm1"

/// The members in their order in a file, for a ByteWriter and a ByteReader.
template <class Order, class Of>
void members(Order& order, Of& claimant) {
    order(claimant.id, claimant.host, claimant.machine, claimant.process, claimant.start, claimant.share,
          claimant.shares, claimant.workers);
}

std::vector<std::byte> encoded(const Claimant& claimant) {
    ByteWriter to;
    to(claim_magic);
    members(to, claimant);
    return with_checksum(std::move(to.bytes));
}

std::optional<Claimant> decoded_claim(Bytes bytes) {
    const auto content = without_checksum(bytes);
    if (!content) return std::nullopt;
    ByteReader reader{*content};
    Claimant claimant;
    const bool is_ours = reader.take<std::uint64_t>() == claim_magic;
    members(reader, claimant);
    return is_ours && reader.has_ended() ? std::optional(claimant) : std::nullopt;
}

/// What /proc knows of a process; nothing if there is none.
struct Process {
    bool has_ended = false;  ///< and waits for its parent
    std::uint64_t start = 0;
};
std::optional<Process> process_of(std::int64_t id) {
    const std::string status = read_start(text("/proc/{}/stat", id), 4096);
    const std::size_t name_end = status.rfind(')');  // of a program whose name may hold anything
    if (name_end == std::string::npos) return std::nullopt;
    std::istringstream words(status.substr(name_end + 1));
    std::string word, state;
    constexpr int state_field = 3, start_field = 22;  // of proc(5)
    words >> state;
    for (int field = state_field + 1; field < start_field; ++field) words >> word;
    Process found{.has_ended = state == "Z" || state == "X"};
    if (!(words >> word) || std::from_chars(word.data(), word.data() + word.size(), found.start).ec != std::errc{})
        return std::nullopt;
    return found;
}

/// Nothing where /proc hides the process, as it may those of other users: then heartbeats tell.
std::optional<bool> is_running(const Claimant& claimant) {
    if (const auto found = process_of(claimant.process)) return !found->has_ended && found->start == claimant.start;
    const bool is_hidden = ::kill(static_cast<pid_t>(claimant.process), 0) == 0 || errno == EPERM;
    return is_hidden ? std::nullopt : std::optional(false);
}

/// Nothing where heartbeats must tell.
std::optional<bool> is_running_here(const Claimant& other, const Claimant& here) {
    return here.machine.empty() || other.machine != here.machine ? std::nullopt : is_running(other);
}

/// A file of a claimant, as it is now: opened anew, since a client of NFS asks the server for its time then.
struct Seen {
    std::optional<Claimant> claimant;  ///< nothing while it is being written
    std::chrono::nanoseconds time{};   ///< of its last heartbeat, by the clock of the file server
    std::uint64_t number = 0, links = 0;

    /// Of its owner: not the number of the file, which some file systems give to each link anew.
    std::string owner() const { return claimant ? claimant->id : text("file {}", number); }
};
std::chrono::nanoseconds time_of(const FileState& state) {
    return std::chrono::seconds(state.seconds) + std::chrono::nanoseconds(state.nanoseconds);
}

/// Nothing if there is no such file.
std::optional<Seen> look(const fs::path& file) {
    const Descriptor open = try_open(file, O_RDONLY | O_NOFOLLOW);
    if (!open.is_open() && errno == ENOENT) return std::nullopt;
    if (!open.is_open()) throw std::system_error(errno, std::generic_category(), "open");
    std::array<std::byte, 1024> bytes{};
    const std::size_t count = read_at(open, 0, bytes);
    const FileState state = state_of(open);
    return Seen{.claimant = decoded_claim(Bytes(bytes).first(count)),
                .time = time_of(state),
                .number = state.number,
                .links = link_count(open)};
}

std::string claim_name(const std::string& key, int generation) { return text("{}.{}", key, generation); }

/// What happened in the folder of claims, as an Error.
[[noreturn]] void fail(const fs::path& folder, const std::system_error& cause) {
    const int error = cause.code().value();
    if (error == EPERM)  // of a folder where owners alone remove their files
        throw Error(
            Fault::unavailable, {folder.string()},
            text("a file of another user there cannot be removed ({}); expected a folder without the sticky bit: "
                 "chmod -t",
                 std::string(cause.what())));
    if (error == EACCES || error == EROFS)
        throw Error(Fault::unavailable, {folder.string()},
                    text("cannot be written: {}; check the permissions of the folder, or choose another with --output",
                         std::string(cause.what())));
    throw write_failure(folder, cause, 0, "nothing of what has ended is lost");
}

}  // namespace

std::string host_name() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

Claimant this_process(std::int64_t share, std::int64_t shares, std::int64_t workers) {
    Claimant claimant{.id = draw_run_id(),
                      .host = host_name(),
                      .machine = {},
                      .process = ::getpid(),
                      .start = 0,
                      .share = share,
                      .shares = shares,
                      .workers = workers};
    std::error_code unknown;
    const std::string kernel = read_start("/proc/sys/kernel/random/boot_id", 36);
    const std::string processes = fs::read_symlink("/proc/self/ns/pid", unknown).string();
    const auto process = process_of(claimant.process);
    if (kernel.empty() || processes.empty() || !process) return claimant;  // then heartbeats alone tell
    claimant.machine = kernel + " " + processes;
    claimant.start = process->start;
    return claimant;
}

struct Claims::Folder {
    fs::path path;
    Claimant claimant;
    ClaimTimes times;
    Descriptor owner = {};
    Clock::time_point renewed = {};
    std::map<std::string, int> generations = {};  ///< of the keys that this process has

    /// Of another process: its heartbeat when it was first seen, and the last one.
    struct Watched {
        std::chrono::nanoseconds first{}, last{};
        Clock::time_point changed = Clock::now();
    };
    std::map<std::string, Watched> watched = {};

    fs::path owner_file() const { return path / (owner_prefix + claimant.id); }

    void make_owner() {
        owner = open_file(owner_file(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW);
        write_at(owner, 0, encoded(claimant));
        sync(owner);
        renewed = Clock::now();
    }

    /// Does something with the owner's file, which is made again where another process took this one for dead, and
    /// removed it.
    template <class Action>
    auto with_owner(Action action) {
        try {
            return action();
        } catch (const std::system_error& cause) {
            if (cause.code().value() != ENOENT && cause.code().value() != ESTALE) throw;
            remove_if_exists(owner_file());  // the name may be there: a file server that was started again
            make_owner();
            generations.clear();  // others take them in time; a unit that is done twice has the same result
            return action();
        }
    }

    bool link(const std::string& name) {
        return with_owner([&] { return link_to(owner, owner_file(), path / name); });
    }

    /// Whether the owner of a claim lives.  A claim is taken only from one that showed no heartbeat while this process
    /// watched: the times of some file systems are those of the clocks of their clients.
    bool is_alive(const Seen& seen) { return is_alive(seen, 2 * times.renewal); }
    /// The same at first sight, for what does no harm where it is wrong.
    bool seems_alive(const Seen& seen) { return is_alive(seen, {}); }

private:
    bool is_alive(const Seen& seen, std::chrono::milliseconds min_watch) {
        if (seen.claimant)
            if (const auto known = is_running_here(*seen.claimant, claimant)) return *known;
        const auto [at, is_new] = watched.try_emplace(seen.owner(), Watched{.first = seen.time, .last = seen.time});
        Watched& other = at->second;
        const auto now = Clock::now();
        if (seen.time != other.last) {
            other.last = seen.time;
            other.changed = now;
        }
        // By the clock of the server, and, in case that is set, by the time that this process has watched.
        const std::chrono::nanoseconds server_time = with_owner([&] { return time_of(state_of(owner)); });
        const auto silence = now - other.changed;
        const bool is_overdue = server_time - seen.time > times.death || silence > times.death;
        return !is_overdue || silence < min_watch;
    }
};

Claims::Claims(const fs::path& folder, Claimant about, ClaimTimes times) try
    : folder_(std::make_unique<Folder>(Folder{.path = folder, .claimant = std::move(about), .times = times})) {
    fs::create_directories(folder);
    folder_->make_owner();
    for (const auto& entry : fs::directory_iterator(folder)) {  // what killed processes left
        if (!entry.path().filename().string().starts_with(owner_prefix)) continue;
        const auto seen = look(entry.path());
        if (seen && seen->links == 1 && !folder_->seems_alive(*seen)) remove_if_exists(entry.path());
    }
} catch (const std::system_error& cause) {
    fail(folder, cause);
}

Claims::~Claims() {
    try {
        for (const auto& [key, generation] : folder_->generations)
            for (int g = generation; g >= 0; --g) remove_if_exists(folder_->path / claim_name(key, g));
        remove_if_exists(folder_->owner_file());
    } catch (const std::exception&) {  // then others find them without their owner
    }
}

const Claimant& Claims::claimant() const { return folder_->claimant; }

void Claims::renew() {
    const auto now = Clock::now();
    if (now - folder_->renewed < folder_->times.renewal) return;
    try {
        folder_->with_owner([&] { touch(folder_->owner); });
        folder_->renewed = now;
    } catch (const std::system_error& cause) {
        fail(folder_->path, cause);
    }
}

bool Claims::claim(const std::string& key) try {
    if (folder_->generations.contains(key)) return true;
    constexpr int max_generations = 10000;
    for (int g = 0; g < max_generations; ++g) {
        const std::string name = claim_name(key, g);
        if (folder_->link(name)) {
            folder_->generations[key] = g;
            return true;
        }
        const auto seen = look(folder_->path / name);
        if (!seen || folder_->is_alive(*seen)) return false;  // released a moment ago, or held
    }
    fail_environment("{}: {} processes died at {}; find out why, then remove its files there", folder_->path.string(),
                     max_generations, key);
} catch (const std::system_error& cause) {
    fail(folder_->path, cause);
}

void Claims::release(const std::string& key) try {
    const auto found = folder_->generations.find(key);
    if (found == folder_->generations.end()) return;
    for (int g = found->second; g >= 0; --g) remove_if_exists(folder_->path / claim_name(key, g));
    folder_->generations.erase(found);
} catch (const std::system_error& cause) {
    fail(folder_->path, cause);
}

void Claims::remove_dead() try {
    for (const auto& entry : fs::directory_iterator(folder_->path)) {
        const auto seen = look(entry.path());
        if (seen && !folder_->seems_alive(*seen)) remove_if_exists(entry.path());
    }
} catch (const std::system_error& cause) {
    fail(folder_->path, cause);
}

Held Claims::holder(const std::string& key) const try {
    std::optional<Seen> last;
    for (int g = 0;; ++g) {
        auto seen = look(folder_->path / claim_name(key, g));
        if (!seen) break;
        last = std::move(seen);
    }
    if (!last || !folder_->is_alive(*last)) return Held::no;
    const auto watched = folder_->watched.find(last->owner());
    const bool is_certain = watched == folder_->watched.end() || watched->second.last != watched->second.first;
    return is_certain ? Held::certainly : Held::maybe;
} catch (const std::system_error& cause) {
    fail(folder_->path, cause);
}

std::vector<ClaimHolder> claim_holders(const fs::path& folder, ClaimTimes times) try {
    std::error_code problem;
    if (!fs::is_directory(folder, problem)) return {};
    const Claimant me = this_process(1, 1, 0);
    std::optional<Claims> here;
    std::chrono::nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
    try {
        here.emplace(folder, me, times);
        now = time_of(state_of(folder / (owner_prefix + me.id)));
    } catch (const Error& error) {
        if (error.fault() != Fault::unavailable) throw;  // else the folder may only be read: the time of this machine
    }
    std::map<std::string, ClaimHolder> by_owner;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const auto seen = look(entry.path());
        if (!seen || !seen->claimant || seen->owner() == me.id) continue;
        ClaimHolder& holder = by_owner[seen->owner()];
        holder.claimant = *seen->claimant;
        holder.silence = std::chrono::duration<double>(now - seen->time).count();
        const bool is_silent = holder.silence > std::chrono::duration<double>(times.death).count();
        holder.is_alive = is_running_here(holder.claimant, me).value_or(!is_silent);
        if (!entry.path().filename().string().starts_with(owner_prefix)) ++holder.keys;
    }
    return mapped(by_owner, [](const auto& one) { return one.second; });
} catch (const std::system_error& cause) {
    fail(folder, cause);
}

}  // namespace drover::files
