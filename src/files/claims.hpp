// files/claims.hpp: work that processes on several machines claim in a common folder, without locks.
#pragma once
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace drover::files {

/// A process that claims work, as it describes itself.
struct Claimant {
    std::string id;       ///< random
    std::string host;     ///< for people
    std::string machine;  ///< what process ids are of: one start of a kernel, and a name space; "" if not known
    std::int64_t process = 0;
    std::uint64_t start = 0;  ///< of the process, in ticks since the start of the kernel
    std::int64_t share = 1, shares = 1, workers = 1;
};

/// How the death of a process on another machine is known.
struct ClaimTimes {
    std::chrono::milliseconds renewal{5000};  ///< between two heartbeats
    std::chrono::milliseconds death{60000};   ///< a process whose heartbeat stands still for longer is dead
};

/// What is known of a claim that this process did not get.
enum class Held {
    no,        ///< nobody has it now
    maybe,     ///< by a process on another machine that has shown no heartbeat since this one first looked
    certainly  ///< by a process that runs
};

/// The claims of one process.  A claim is a hard link `key.generation` to a file of its owner, which link() makes for
/// one process only, on NFS too.  The time of that file is the heartbeat: it is set by the file server, and compared
/// with that of this process's own file, so that the clocks of the machines do not matter.  Where a file system shows
/// the clocks of its clients all the same, a process that renews its heartbeat lives.  A process on the same machine is
/// dead when its id, with its start, is gone.  A claim whose owner is dead is claimed as the next
/// generation, which again one process gets.
///
/// A process that was stopped for longer than ClaimTimes::death, or whose file server was, counts as dead although it
/// continues: two processes may then do the same work.  The caller lets the same work give the same result.
class Claims {
public:
    /// Creates the folder if there is none.  Throws an input Error where the file system has no hard links.
    Claims(const std::filesystem::path& folder, Claimant about, ClaimTimes times = {});
    ~Claims();  ///< releases all claims
    Claims(const Claims&) = delete;
    Claims& operator=(const Claims&) = delete;

    /// True if this process has the key now.  The key is a plain file name.
    bool claim(const std::string& key);
    void release(const std::string& key);
    /// Removes what dead processes left, when there is no work any more.
    void remove_dead();
    /// Sets the heartbeat when it is due: call it often.
    void renew();
    /// Of a key that claim() did not get.
    Held holder(const std::string& key) const;
    /// This process as others see it.
    const Claimant& claimant() const;

private:
    struct Folder;
    std::unique_ptr<Folder> folder_;
};

/// The processes that have files in a folder of claims, and how many keys each has.
struct ClaimHolder {
    Claimant claimant;
    std::size_t keys = 0;
    double silence = 0.0;  ///< seconds since its last heartbeat, by the clock of the file server
    bool is_alive = true;
};
/// Writes nothing but a file that it removes again, for the time of the file server, if the folder may be written.
std::vector<ClaimHolder> claim_holders(const std::filesystem::path& folder, ClaimTimes times = {});

std::string host_name();  ///< "unknown" if it has none

/// This process, for Claims.
Claimant this_process(std::int64_t share, std::int64_t shares, std::int64_t workers);

}  // namespace drover::files
