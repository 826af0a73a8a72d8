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
ComputeAll on_threads(Threads& threads);

}  // namespace drover
