// base/compute_all.hpp: numbers of many items that do not depend on each other, whoever computes them.
#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "drover/base/threads.hpp"

namespace drover {

/// Fills in the numbers of one item.  Called by several threads or processes at once: it changes nothing else.
using NumbersOf = std::function<void(std::size_t item, std::span<double> numbers)>;

/// Returns `width` numbers for each of `items`, item by item: the same ones for any number of threads or processes.
using ComputeAll = std::function<std::vector<double>(std::size_t items, std::size_t width, const NumbersOf& numbers)>;

/// By the threads of this process.
inline ComputeAll on_threads(Threads& threads) {
    return [&threads](std::size_t items, std::size_t width, const NumbersOf& numbers) {
        std::vector<double> result(items * width);
        constexpr std::size_t chunk = 4;
        threads.for_chunks(items, chunk, [&](std::size_t begin, std::size_t end) {
            for (std::size_t item = begin; item < end; ++item)
                numbers(item, std::span(result).subspan(item * width, width));
        });
        return result;
    };
}

}  // namespace drover
