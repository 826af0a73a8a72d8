// base/mapped.hpp: what a function gives for each item of a list.
#pragma once
#include <functional>
#include <ranges>
#include <type_traits>
#include <vector>

namespace drover {

/// function(item) of each item, in their order; `function` may be a member.
template <std::ranges::input_range Items, class Function>
auto mapped(Items&& items, Function function) {
    std::vector<std::remove_cvref_t<std::invoke_result_t<Function&, std::ranges::range_reference_t<Items>>>> result;
    for (auto&& item : items) result.push_back(std::invoke(function, item));
    return result;
}

}  // namespace drover
