// tests/base/variant.cpp: a copy of a variant for which there is no memory.
#include "drover/base/schema.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace drover::variant_tests {
namespace {

/// As a text for which there is no memory.
struct Fragile {
    Fragile() = default;
    Fragile(const Fragile&) { throw std::bad_alloc(); }
    Fragile(Fragile&&) noexcept = default;
    Fragile& operator=(const Fragile&) = default;
    Fragile& operator=(Fragile&&) noexcept = default;
    ~Fragile() = default;
};

// The bytes are such that the failed copy, were it destroyed, would be a vector at the address 0x0101010101010101.
TEST(Variant, ACopyThatFailsIsNotDestroyed) {
    using Held = Variant<int, std::vector<Fragile>>;
    const Held original = std::vector<Fragile>(1);
    alignas(Held) std::array<std::byte, sizeof(Held)> place;
    place.fill(std::byte{1});
    EXPECT_THROW(std::construct_at(reinterpret_cast<Held*>(place.data()), original), std::bad_alloc);
}

TEST(Variant, CopiesAndMovesLikeStdVariant) {
    using Held = Variant<int, std::string, std::vector<double>>;
    const Held words = std::string(100, 'w');
    Held copy = words;
    EXPECT_EQ(copy, words);
    copy = std::vector{1.0, 2.0};
    const Held moved = std::move(copy);
    ASSERT_TRUE(std::holds_alternative<std::vector<double>>(moved));
    EXPECT_EQ(std::get<std::vector<double>>(moved).size(), 2U);
    EXPECT_EQ(std::visit([](const auto& held) { return sizeof(held); }, Held(3)), sizeof(int));
}

}  // namespace
}  // namespace drover::variant_tests
