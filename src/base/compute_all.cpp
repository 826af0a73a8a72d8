// base/compute_all.cpp: numbers of many items by the threads of this process.
#include "base/compute_all.hpp"

namespace drover {

ComputeAll on_threads(Threads& threads) {
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
