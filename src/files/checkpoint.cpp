// files/checkpoint.cpp: "drvchkp1", version, file length, write counter, the members of Checkpoint, checksum.
#include "files/checkpoint.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

#include "base/log.hpp"
#include "files/bytes.hpp"
#include "files/new_file.hpp"
#include "files/system_calls.hpp"

namespace drover::files {
namespace {

constexpr std::uint64_t checkpoint_magic = 0x31706b6863767264;  // "drvchkp1"
constexpr std::uint32_t version = 2;

/// The content of a checkpoint file.
struct Stored {
    std::uint64_t counter = 0;  ///< number of writes of the run: decides which of two at the same step is newer
    Checkpoint checkpoint;
};
enum class Part { all, without_state };  // which may be large

std::vector<std::byte> encoded(std::uint64_t counter, const Checkpoint& checkpoint) {
    ByteWriter to;
    to.bytes.reserve(256 + checkpoint.scene.size() +
                     sizeof(double) * (checkpoint.rows.size() + checkpoint.state.size()));
    to(checkpoint_magic, version);
    const std::size_t offset_of_length = to.bytes.size();
    to(std::uint64_t{0}, counter, checkpoint.step, checkpoint.time, checkpoint.scene, checkpoint.rows, checkpoint.state,
       checkpoint.run_id, checkpoint.program, checkpoint.row_checksums);
    const std::uint64_t length = to.bytes.size() + sizeof(std::uint64_t);
    std::memcpy(to.bytes.data() + offset_of_length, &length, sizeof length);
    return with_checksum(std::move(to.bytes));
}

/// Throws an input Error that describes the damage.
Stored decoded(Bytes bytes, const std::filesystem::path& file, Part part) {
    const SourceLocation where{file.string()};
    ByteReader reader{bytes};
    require(reader.take<std::uint64_t>() == checkpoint_magic, where, "is not a checkpoint of drover; expected one");
    const auto found_version = reader.take<std::uint32_t>();
    require(reader.is_complete && found_version == version, where,
            "is a checkpoint of version {}; expected version {}: use the drover that wrote it", found_version, version);
    const auto length = reader.take<std::uint64_t>();
    require(reader.is_complete && length == bytes.size(), where,
            "has {} bytes; expected {}: it is truncated or extended", bytes.size(), length);
    require(without_checksum(bytes).has_value(), where,
            "has a wrong checksum: it is damaged; expected a valid checkpoint");
    reader.rest = reader.rest.first(reader.rest.size() - sizeof(std::uint64_t));
    Stored stored;
    Checkpoint& checkpoint = stored.checkpoint;
    reader(stored.counter, checkpoint.step, checkpoint.time, checkpoint.scene, checkpoint.rows);
    if (part == Part::all) reader(checkpoint.state);
    else reader.skip_list<double>();
    reader(checkpoint.run_id, checkpoint.program, checkpoint.row_checksums);
    require(reader.has_ended(), where,
            "has lists that do not fit its length: it is damaged; expected a valid checkpoint");
    return stored;
}

/// Nothing if the file does not exist.  Throws an input Error when it is unreadable or damaged.
std::optional<Stored> read_stored(const std::filesystem::path& file, Part part) try {
    const auto bytes = read_file(file);
    if (!bytes) return std::nullopt;
    return decoded(*bytes, file, part);
} catch (const std::system_error& cause) {
    throw access_failure(file, cause, "cannot be read", "expected a checkpoint");
}

bool is_newer(const Stored& a, const Stored& b) {
    return std::tuple(a.checkpoint.step, a.counter) > std::tuple(b.checkpoint.step, b.counter);
}

/// The file that the next checkpoint replaces, and its counter: an absent or damaged file, else the older one.
struct Slot {
    std::filesystem::path file;
    std::uint64_t counter = 1;
};

Slot next_slot(const std::filesystem::path& archive) {
    const auto files = checkpoint_files(archive);
    std::array<std::optional<Stored>, 2> found;
    for (std::size_t i = 0; i < 2; ++i) {
        try {
            found[i] = read_stored(files[i], Part::without_state);
        } catch (const Error& damage) {
            log_warning("{}; it will be overwritten", std::string(damage.what()));
        }
    }
    const std::size_t older = !found[0] ? 0 : !found[1] ? 1 : is_newer(*found[0], *found[1]) ? 1 : 0;
    Slot slot{files[older]};
    for (const auto& stored : found)
        if (stored) slot.counter = std::max(slot.counter, stored->counter + 1);
    return slot;
}

}  // namespace

std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& archive) {
    const std::string file = behind_links(archive).string();
    return {file + ".checkpoint-a", file + ".checkpoint-b"};
}

void require_checkpoint_names(const std::filesystem::path& archive, const SourceLocation& where) {
    const std::filesystem::path longest = partial_name(checkpoint_files(archive).front());
    const long limit = ::pathconf(folder_of(longest).c_str(), _PC_NAME_MAX);  // -1: none
    const auto length = static_cast<long>(longest.filename().string().size());
    if (limit >= 0 && length > limit)
        throw Error(Fault::unavailable, where,
                    text("the names of the checkpoints beside this archive are {} bytes too long; expected a shorter "
                         "name of the archive",
                         length - limit));
}

bool has_checkpoint(const std::filesystem::path& archive) {
    const auto files = checkpoint_files(archive);
    std::error_code unknown;
    return std::ranges::any_of(files, [&](const auto& file) { return std::filesystem::exists(file, unknown); });
}

void write_checkpoint(const std::filesystem::path& archive, const Checkpoint& checkpoint) {
    const Slot slot = next_slot(archive);
    const std::vector<std::byte> bytes = encoded(slot.counter, checkpoint);
    const std::filesystem::path partial = partial_name(slot.file);
    try {
        {
            const Descriptor file = create_file(partial);
            allocate(file, 0, bytes.size());
            write_at(file, 0, bytes);
            sync(file);
        }
        rename_over(partial, slot.file);
        sync_folder_of(slot.file);
    } catch (const std::system_error& cause) {
        std::error_code ignored;
        std::filesystem::remove(partial, ignored);
        throw write_failure(slot.file, cause, bytes.size(), "the previous checkpoint is still valid");
    }
}

Checkpoint read_newest_checkpoint(const std::filesystem::path& archive) {
    std::optional<Stored> newest;
    std::vector<std::string> damages;
    const auto files = checkpoint_files(archive);
    for (const auto& file : files) {
        try {
            auto stored = read_stored(file, Part::all);
            if (stored && (!newest || is_newer(*stored, *newest))) newest = std::move(stored);
        } catch (const Error& damage) {
            if (damage.fault() == Fault::environment) throw;  // the file may be valid
            damages.emplace_back(damage.what());
        }
    }
    if (!newest && damages.empty())
        fail_input({archive.string()}, "has no checkpoint; expected {} or {} beside it: run the scene again",
                   files[0].string(), files[1].string());
    if (!newest)
        fail_input({archive.string()}, "has no valid checkpoint; {}; expected at least one: run the scene again",
                   joined(damages, "; "));
    for (const std::string& damage : damages)
        log_warning("{}; using the other one, of step {}", damage, newest->checkpoint.step);
    return std::move(newest->checkpoint);
}

void remove_checkpoints(const std::filesystem::path& archive) {
    try {
        for (const auto& file : checkpoint_files(archive)) {
            remove_if_exists(file);
            remove_if_exists(partial_name(file));
        }
    } catch (const std::system_error& cause) {
        throw write_failure(archive, cause, 0, "an old checkpoint remains beside it");
    }
}

}  // namespace drover::files
