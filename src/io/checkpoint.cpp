// io/checkpoint.cpp: "drvchkp1", version, length of the file, write counter, the fields, checksum of all before it.
#include "drover/io/checkpoint.hpp"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>

#include "drover/base/log.hpp"
#include "io/durable.hpp"
#include "io/durable_bytes.hpp"

namespace drover::io {
namespace {

constexpr std::uint64_t magic = 0x31706b6863767264;  // "drvchkp1"
constexpr std::uint32_t version = 1;

/// A checkpoint as its file holds it.
struct Stored {
    std::uint64_t counter = 0;  ///< counts the writes of a run: settles which of two at the same step is newer
    Checkpoint checkpoint;
};

std::vector<std::byte> encoded(const Stored& stored) {
    const Checkpoint& checkpoint = stored.checkpoint;
    std::vector<std::byte> bytes;
    bytes.reserve(128 + checkpoint.scene.size() + sizeof(double) * (checkpoint.rows.size() + checkpoint.state.size()));
    put(bytes, magic);
    put(bytes, version);
    const std::size_t place_of_length = bytes.size();
    put(bytes, std::uint64_t{0});
    put(bytes, stored.counter);
    put(bytes, checkpoint.step);
    put(bytes, checkpoint.time);
    put_list(bytes, std::span<const char>(checkpoint.scene));
    put_list(bytes, std::span<const std::uint64_t>(checkpoint.rows));
    put_list(bytes, std::span<const double>(checkpoint.state));
    const std::uint64_t length = bytes.size() + sizeof(std::uint64_t);
    std::memcpy(bytes.data() + place_of_length, &length, sizeof length);
    put(bytes, checksum(bytes));
    return bytes;
}

/// Throws an input Error that says what is wrong with the bytes.
Stored decoded(Bytes bytes, const std::filesystem::path& file) {
    const SourceLocation where{file.string()};
    ByteReader reader{bytes};
    require(reader.take<std::uint64_t>() == magic, where, "is not a checkpoint of drover; expected one");
    const auto found_version = reader.take<std::uint32_t>();
    require(reader.is_whole && found_version == version, where,
            "is a checkpoint of version {}; expected version {}: use the drover that wrote it", found_version, version);
    const auto length = reader.take<std::uint64_t>();
    require(reader.is_whole && length == bytes.size(), where, "has {} bytes; expected {}: it was cut short or added to",
            bytes.size(), length);
    require(without_checksum(bytes).has_value(), where, "has a wrong checksum; expected a whole file: it is damaged");
    reader.rest = reader.rest.first(reader.rest.size() - sizeof(std::uint64_t));
    Stored stored;
    stored.counter = reader.take<std::uint64_t>();
    stored.checkpoint.step = reader.take<std::int64_t>();
    stored.checkpoint.time = reader.take<double>();
    stored.checkpoint.scene = reader.take_list<std::string>();
    stored.checkpoint.rows = reader.take_list<std::vector<std::uint64_t>>();
    stored.checkpoint.state = reader.take_list<std::vector<double>>();
    require(reader.is_whole && reader.rest.empty(), where,
            "has lists that do not fit its length; expected a whole file");
    return stored;
}

/// Nothing when the file is not there.  Throws an input Error when it cannot be read or is damaged.
std::optional<Stored> read_stored(const std::filesystem::path& file) try {
    const auto bytes = read_whole(file);
    if (!bytes) return std::nullopt;
    return decoded(*bytes, file);
} catch (const std::system_error& cause) {
    fail_input({file.string()}, "cannot be read: {}; expected a checkpoint", std::string(cause.what()));
}

bool is_newer(const Stored& a, const Stored& b) {
    return std::tuple(a.checkpoint.step, a.counter) > std::tuple(b.checkpoint.step, b.counter);
}

/// Where the next checkpoint goes: over a slot that is empty, else damaged, else the older.  With its counter.
struct Slot {
    std::filesystem::path file;
    std::uint64_t counter = 1;
};

Slot next_slot(const std::filesystem::path& archive) {
    const auto files = checkpoint_files(archive);
    std::array<std::optional<Stored>, 2> there;
    for (std::size_t i = 0; i < 2; ++i) {
        try {
            there[i] = read_stored(files[i]);
            if (there[i]) there[i]->checkpoint.state = {};  // not needed, and large
        } catch (const Error& damage) {
            log_warning("{}; it will be written over", std::string(damage.what()));
        }
    }
    const std::size_t older = !there[0] ? 0 : !there[1] ? 1 : is_newer(*there[0], *there[1]) ? 1 : 0;
    Slot slot{files[older]};
    for (const auto& stored : there)
        if (stored) slot.counter = std::max(slot.counter, stored->counter + 1);
    return slot;
}

std::filesystem::path unfinished(const std::filesystem::path& file) { return file.string() + ".partial"; }

}  // namespace

std::vector<std::filesystem::path> checkpoint_files(const std::filesystem::path& archive) {
    return {archive.string() + ".checkpoint-a", archive.string() + ".checkpoint-b"};
}

void write_checkpoint(const std::filesystem::path& archive, const Checkpoint& checkpoint) {
    const Slot slot = next_slot(archive);
    const std::vector<std::byte> bytes = encoded({slot.counter, checkpoint});
    const std::filesystem::path partial = unfinished(slot.file);
    try {
        {
            const Descriptor file = open_file(partial, O_RDWR | O_CREAT | O_TRUNC);
            allocate(file, 0, bytes.size());
            write_at(file, 0, bytes);
            sync(file);
        }
        rename_over(partial, slot.file);
        sync_folder_of(slot.file);
    } catch (const std::system_error& cause) {
        std::error_code ignored;
        std::filesystem::remove(partial, ignored);
        throw write_failure(slot.file, cause, bytes.size(), "the checkpoint before it is whole");
    }
}

Checkpoint read_newest_checkpoint(const std::filesystem::path& archive) {
    std::optional<Stored> newest;
    std::vector<std::string> damages;
    const auto files = checkpoint_files(archive);
    for (const auto& file : files) {
        try {
            auto stored = read_stored(file);
            if (stored && (!newest || is_newer(*stored, *newest))) newest = std::move(stored);
        } catch (const Error& damage) {
            damages.emplace_back(damage.what());
        }
    }
    if (!newest && damages.empty())
        fail_input({archive.string()}, "has no checkpoint; expected {} or {} beside it: start the run anew",
                   files[0].string(), files[1].string());
    if (!newest)
        fail_input({archive.string()}, "has no whole checkpoint; {}; expected one that is whole: start the run anew",
                   joined(damages, "; "));
    for (const std::string& damage : damages)
        log_warning("{}; the other one, of step {}, is taken", damage, newest->checkpoint.step);
    return std::move(newest->checkpoint);
}

void remove_checkpoints(const std::filesystem::path& archive) {
    try {
        for (const auto& file : checkpoint_files(archive)) {
            remove_if_there(file);
            remove_if_there(unfinished(file));
        }
    } catch (const std::system_error& cause) {
        throw write_failure(archive, cause, 0, "an old checkpoint stays beside it");
    }
}

}  // namespace drover::io
