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

template <class Number>
void put(std::vector<std::byte>& to, Number value) {
    static_assert(std::is_arithmetic_v<Number>);
    const auto bytes = std::as_bytes(std::span(&value, 1));
    to.insert(to.end(), bytes.begin(), bytes.end());
}

/// The count, then the items.
template <class Item>
void put_list(std::vector<std::byte>& to, std::span<const Item> items) {
    put(to, static_cast<std::uint64_t>(items.size()));
    const auto bytes = std::as_bytes(items);
    to.insert(to.end(), bytes.begin(), bytes.end());
}

/// The length, then the characters.
inline void put_text(std::vector<std::byte>& to, const std::string& words) {
    put_list(to, std::span<const char>(words));
}

inline std::string text_of(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Takes values off the front of some bytes.  When a value does not fit, is_complete becomes false and all later values
/// are empty.
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

    template <class Number>
    Number take() {
        Number value{};
        const auto bytes = take_bytes(sizeof value);
        if (is_complete) std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }

    template <class Item>
    std::span<const std::byte> skip_list() {
        const auto count = take<std::uint64_t>();
        if (count > rest.size() / sizeof(Item)) is_complete = false;
        return take_bytes(is_complete ? count * sizeof(Item) : 0);
    }

    template <class List>
    List take_list() {
        using Item = typename List::value_type;
        const auto bytes = skip_list<Item>();
        List items(bytes.size() / sizeof(Item), Item{});
        if (!bytes.empty()) std::memcpy(items.data(), bytes.data(), bytes.size());
        return items;
    }
};

/// The bytes without the checksum at their end, if it matches.
std::optional<std::span<const std::byte>> without_checksum(std::span<const std::byte> bytes);

/// Deflated with their length in front, and back; nothing for other bytes, and for a length of more than 1 GB.
std::vector<std::byte> deflated(std::span<const std::byte> bytes);
std::optional<std::vector<std::byte>> inflated(std::span<const std::byte> bytes);

}  // namespace drover::files
