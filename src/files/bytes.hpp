// files/bytes.hpp: numbers and lists as little-endian bytes, followed by a checksum.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace drover::files {

static_assert(std::endian::native == std::endian::little, "files are little-endian; other machines are not supported");

/// XXH3, 64 bits.
std::uint64_t checksum(std::span<const std::byte> bytes);

/// Appends numbers; bools and enums, a byte each; texts and lists of numbers, after their length.
struct ByteWriter {
    std::vector<std::byte> bytes = {};

    template <class... Values>
    void operator()(const Values&... values) {
        (add(values), ...);
    }

    void add_bytes(std::span<const std::byte> more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

private:
    template <class Value>
    void add(const Value& value) {
        if constexpr (std::is_same_v<Value, bool> || std::is_enum_v<Value>) {
            add(static_cast<std::uint8_t>(value));
        } else if constexpr (std::is_arithmetic_v<Value>) {
            add_bytes(std::as_bytes(std::span(&value, 1)));
        } else {
            add(static_cast<std::uint64_t>(value.size()));
            add_bytes(std::as_bytes(std::span(value)));
        }
    }
};

inline std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Takes off the front of some bytes what a ByteWriter has appended.  When a value does not fit, is_complete becomes
/// false and all later values are empty.
struct ByteReader {
    std::span<const std::byte> rest;
    bool is_complete = true;

    std::span<const std::byte> take_bytes(std::uint64_t count) {
        if (!is_complete || count > rest.size()) {
            is_complete = false;
            return {};
        }
        const auto taken = rest.first(static_cast<std::size_t>(count));
        rest = rest.subspan(static_cast<std::size_t>(count));
        return taken;
    }

    template <class... Values>
    void operator()(Values&... values) {
        ((values = take<Values>()), ...);
    }

    template <class Value>
    Value take() {
        if constexpr (std::is_same_v<Value, bool> || std::is_enum_v<Value>) {
            return static_cast<Value>(take<std::uint8_t>());
        } else if constexpr (std::is_arithmetic_v<Value>) {
            Value value{};
            const auto bytes = take_bytes(sizeof value);
            if (is_complete) std::memcpy(&value, bytes.data(), sizeof value);
            return value;
        } else {
            using Item = typename Value::value_type;
            const auto bytes = skip_list<Item>();
            Value items(bytes.size() / sizeof(Item), Item{});
            if (!bytes.empty()) std::memcpy(items.data(), bytes.data(), bytes.size());
            return items;
        }
    }

    template <class Item>
    std::span<const std::byte> skip_list() {
        const auto count = take<std::uint64_t>();
        if (count > rest.size() / sizeof(Item)) is_complete = false;
        return take_bytes(is_complete ? count * sizeof(Item) : 0);
    }

    bool has_ended() const { return is_complete && rest.empty(); }
};

/// The bytes with their checksum at the end; without it, if it matches.
std::vector<std::byte> with_checksum(std::vector<std::byte> bytes);
std::optional<std::span<const std::byte>> without_checksum(std::span<const std::byte> bytes);

/// Deflated with their length in front, and back; nothing for other bytes, and for a length of more than 1 GB.
std::vector<std::byte> deflated(std::span<const std::byte> bytes);
std::optional<std::vector<std::byte>> inflated(std::span<const std::byte> bytes);

}  // namespace drover::files
