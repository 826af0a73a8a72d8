// numerics/steppers/isotropic.cpp: layouts, and the places of their parts.
#include "numerics/steppers/isotropic.hpp"

#include "drover/base/error.hpp"

namespace drover::numerics {

Layout scalars_and_vectors(int scalars, int vectors) {
    Layout layout;
    layout.fields.assign(static_cast<std::size_t>(scalars), {.spin = 0});
    layout.fields.resize(static_cast<std::size_t>(scalars + vectors), {.spin = 1});
    return layout;
}

int components(const Layout& layout) {
    int count = 0;
    for (const FieldKind& kind : layout.fields) count += components(kind);
    return count;
}

std::vector<int> scalar_components(const Layout& layout) {
    std::vector<int> result;
    int component = 0;
    for (const FieldKind& kind : layout.fields) {
        if (kind.spin == 0) result.push_back(component);
        component += components(kind);
    }
    return result;
}

BlockParts block_parts(const Layout& layout) {
    require(!layout.fields.empty(), {}, "a layout without fields; expected at least one");
    BlockParts parts;
    parts.even.reserve(2 * layout.fields.size());
    parts.odd.reserve(layout.fields.size());
    int component = 0;
    for (const FieldKind& kind : layout.fields) {
        require(kind.spin >= 0 && kind.spin <= max_spin, {}, "a field of spin {}; expected 0 to {}", kind.spin,
                max_spin);
        for (int part = 0; part < components(kind); ++part)
            (kind.odd == (part == 1) ? parts.even : parts.odd).push_back({component++, kind.spin});
    }
    if (layout.chiral) {
        parts.even.insert(parts.even.end(), parts.odd.begin(), parts.odd.end());
        parts.odd.clear();
    }
    require(std::max(parts.even.size(), parts.odd.size()) <= std::size_t{max_block}, {},
            "fields with a block of {} rows; expected at most {}: choose fewer fields",
            std::max(parts.even.size(), parts.odd.size()), max_block);
    return parts;
}

AnyKernel::AnyKernel(const Layout& layout) {
    const BlockParts of_layout = block_parts(layout);
    even = of_layout.even.size();
    odd = of_layout.odd.size();
    parts = even + odd;
    entries = even * even + odd * odd;
    std::vector<std::size_t> place_of(parts);  // of the part of each component
    for (std::size_t k = 0; k < parts; ++k)
        place_of[static_cast<std::size_t>((k < even ? of_layout.even[k] : of_layout.odd[k - even]).component)] = k;
    std::size_t component = 0;
    for (const FieldKind& kind : layout.fields) {
        const auto count = static_cast<std::size_t>(components(kind));
        places.push_back({component, place_of[component], place_of[component + count - 1], kind.spin});
        component += count;
        largest_spin = std::max(largest_spin, static_cast<std::size_t>(kind.spin));
    }
}

AnyKernel::Frame AnyKernel::frame(const Direction& d) const {
    Frame frame;
    for (std::size_t m = 1; m <= largest_spin; ++m) {
        const Turn<int>& before = frame[m - 1];
        frame[m] = {.cosine = d.x * before.cosine - d.y * before.sine,
                    .sine = d.y * before.cosine + d.x * before.sine,
                    .power = d.turned ? static_cast<int>(m & 3) : 0};
    }
    return frame;
}

namespace {
IsotropicBlocks checked(IsotropicBlocks blocks, const Layout& layout) {
    const BlockParts parts = block_parts(layout);
    const auto even = static_cast<int>(parts.even.size()), odd = static_cast<int>(parts.odd.size());
    require(blocks.even.size == even && blocks.odd.size == odd, {},
            "an operator with blocks of {} and {} rows; expected {} and {}, as its fields have", blocks.even.size,
            blocks.odd.size, even, odd);
    return blocks;
}
}  // namespace

IsotropicBlocks linear_blocks(const System& system, double q) {
    require(static_cast<bool>(system.linear), {},
            "the system has no function linear; expected one, of zeros if need be");
    return checked(system.linear(q), system.layout);
}
IsotropicBlocks noise_blocks(const System& system, double q) { return checked(system.noise(q), system.layout); }

Block of_rows(const Block& m, const std::vector<int>& rows) {
    Block result(static_cast<int>(rows.size()));
    for (int i = 0; i < result.size; ++i)
        for (int k = 0; k < result.size; ++k)
            result(i, k) = m(rows[static_cast<std::size_t>(i)], rows[static_cast<std::size_t>(k)]);
    return result;
}

void append_entries(const IsotropicBlocks& blocks, std::vector<double>& to) {
    for (const Block* block : {&blocks.even, &blocks.odd}) {
        const std::span<const double> values = block->values();
        to.insert(to.end(), values.begin(), values.end());
    }
}

std::size_t block_entries(const Layout& layout) {
    const BlockParts parts = block_parts(layout);
    return parts.even.size() * parts.even.size() + parts.odd.size() * parts.odd.size();
}

int fixed_kernel(const Layout& layout) {
    int scalars = 0;
    while (scalars < static_cast<int>(layout.fields.size()) &&
           layout.fields[static_cast<std::size_t>(scalars)].spin == 0)
        ++scalars;
    const int vectors = static_cast<int>(layout.fields.size()) - scalars;
    const bool is_small = scalars <= 2 && vectors <= 2;
    return is_small && layout == scalars_and_vectors(scalars, vectors) ? 10 * scalars + vectors : -1;
}

}  // namespace drover::numerics
