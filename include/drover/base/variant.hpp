// base/variant.hpp: a std::variant whose copying may fail.
#pragma once
#include <variant>

namespace drover {

/// std::variant, copied by assignment: libstdc++ 12 takes a variant of numbers, texts and vectors for one that always
/// holds a value, and where its copy constructor finds no memory it destroys a value that was never made.
template <class... Types>
struct Variant : std::variant<Types...> {
    using std::variant<Types...>::variant;
    Variant() = default;
    Variant(const Variant& other) : std::variant<Types...>() { std::variant<Types...>::operator=(other); }
    Variant(Variant&&) noexcept = default;
    Variant& operator=(const Variant&) = default;
    Variant& operator=(Variant&&) noexcept = default;
    ~Variant() = default;
};

}  // namespace drover
