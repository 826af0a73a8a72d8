// dem/neighbours/overlaps.cpp: search for overlapping spheres, four pairs at a time.
#include "dem/neighbours/overlaps.hpp"

#include <algorithm>

namespace drover::dem {

namespace {
Overlap overlap_between(const Spheres& spheres, std::uint32_t a, std::uint32_t b, double x, double y) {
    const Vec4d &pa = spheres.position[a], &pb = spheres.position[b];
    return {.first = a,
            .second = b,
            .first_body = spheres.body(a),
            .second_body = spheres.body(b),
            .apart = {pa[0] - pb[0] - x, pa[1] - pb[1] - y, pa[2] - pb[2]},
            .reach = pa[3] + pb[3]};
}

void add_overlapping(const Spheres& spheres, const ImagePair& pair, std::vector<Overlap>& found) {
    const Overlap overlap = overlap_between(spheres, pair.first, pair.second, pair.x, pair.y);
    if (dot(overlap.apart, overlap.apart) < overlap.reach * overlap.reach) found.push_back(overlap);
}

/// Squared distances of four pairs minus the squares of their reaches: negative where they overlap.
Vec4d beyond(const Vec4d* place, const SpherePair* pairs) {
    Vec4d d[4], s[4];
    for (int k = 0; k < 4; ++k) {
        const Vec4d &a = place[pairs[k].first], &b = place[pairs[k].second];
        d[k] = a - b;
        s[k] = a + b;
        d[k] *= d[k];
    }
    // Columns of the four rows: x, y, z of the squares; the reach is the last of the sums.
    const Vec4d xy01 = __builtin_shufflevector(d[0], d[1], 0, 4, 1, 5),
                xy23 = __builtin_shufflevector(d[2], d[3], 0, 4, 1, 5);
    const Vec4d zw01 = __builtin_shufflevector(d[0], d[1], 2, 6, 3, 7),
                zw23 = __builtin_shufflevector(d[2], d[3], 2, 6, 3, 7);
    const Vec4d x = __builtin_shufflevector(xy01, xy23, 0, 1, 4, 5),
                y = __builtin_shufflevector(xy01, xy23, 2, 3, 6, 7);
    const Vec4d z = __builtin_shufflevector(zw01, zw23, 0, 1, 4, 5);
    const Vec4d r01 = __builtin_shufflevector(s[0], s[1], 3, 7, 3, 7),
                r23 = __builtin_shufflevector(s[2], s[3], 3, 7, 3, 7);
    const Vec4d reach = __builtin_shufflevector(r01, r23, 0, 1, 4, 5);
    return x + y + z - reach * reach;
}

void find_pairs(const Spheres& spheres, const std::vector<SpherePair>& pairs, std::vector<Overlap>& found) {
    const Vec4d* place = spheres.position.data();
    const std::size_t end = pairs.size();
    std::size_t p = 0;
    const auto take = [&](std::size_t q) {
        found.push_back(overlap_between(spheres, pairs[q].first, pairs[q].second, 0.0, 0.0));
    };
    for (; p + 4 <= end; p += 4) {
        const Vec4d value = beyond(place, &pairs[p]);
        const auto negative = value < 0.0;
        if (negative[0] | negative[1] | negative[2] | negative[3]) [[unlikely]]
            for (std::size_t k = 0; k < 4; ++k)
                if (value[k] < 0.0) take(p + k);
    }
    for (; p < end; ++p) add_overlapping(spheres, {pairs[p].first, pairs[p].second}, found);
}

void find_walls(const Walls& side, const Spheres& spheres, const std::vector<std::uint32_t>& near,
                std::vector<Overlap>& found) {
    WallPoint walls[4];
    for (const std::uint32_t s : near) {
        const Vec4d& place = spheres.position[s];
        const int count = side.near(place[0], place[1], place[3], walls);
        for (int w = 0; w < count; ++w) {
            if (walls[w].distance >= place[3]) continue;
            found.push_back({.first = s,
                             .second = Overlap::side_wall,
                             .first_body = spheres.body(s),
                             .second_body = Overlap::side_wall,
                             .apart = walls[w].distance * Vector{walls[w].nx, walls[w].ny, 0.0},
                             .reach = place[3],
                             .normal = {walls[w].nx, walls[w].ny, 0.0}});
        }
    }
}
}  // namespace

double smaller_radius(const Overlap& overlap, const Spheres& spheres) {
    const double first = spheres.position[overlap.first][3];
    return overlap.is_with_surface() ? first : std::min(first, spheres.position[overlap.second][3]);
}

double relative_depth(const Overlap& overlap, const Spheres& spheres) {
    // A sphere whose centre is behind a wall lies along -normal.
    const double distance = overlap.is_with_surface() ? dot(overlap.apart, overlap.normal) : length(overlap.apart);
    return (overlap.reach - distance) / smaller_radius(overlap, spheres);
}

std::vector<Overlap>& OverlapSearch::find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours,
                                          Threads& threads) {
    const std::size_t chunks = neighbours.near.size();
    found_.resize(chunks + 1);
    for (auto& list : found_) list.clear();
    threads.for_chunks(chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) find_pairs(spheres, neighbours.near[c], found_[c]);
    });
    for (const ImagePair& pair : neighbours.images) add_overlapping(spheres, pair, found_.back());
    find_walls(walls, spheres, neighbours.near_wall, found_.back());
    overlaps_.clear();
    for (const auto& list : found_) overlaps_.insert(overlaps_.end(), list.begin(), list.end());
    return overlaps_;
}

}  // namespace drover::dem
