// dem/neighbours/neighbours.cpp: sorting by position, lists of pairs, and the search for those that overlap, four at a
// time.
#include "dem/neighbours/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "dem/bodies/walls.hpp"

namespace drover::dem {

namespace {
using Place = std::array<double, 2>;

/// Square cells of a mesh over the rectangle that contains the spheres.
struct Mesh {
    double x0 = 0.0, y0 = 0.0, per_x = 0.0, per_y = 0.0;  // per: cells per mm
    int nx = 1, ny = 1;

    std::size_t cell(const Place& place) const {
        const int i = std::clamp(static_cast<int>((place[0] - x0) * per_x), 0, nx - 1);
        const int j = std::clamp(static_cast<int>((place[1] - y0) * per_y), 0, ny - 1);
        return index(i, j);
    }
    std::size_t index(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
    }
};

Mesh mesh_of(const Cell& cell, double reach, std::size_t spheres) {
    const double half_x = half_width(cell), half_y = half_height(cell);
    // About as many cells as spheres at most: walking empty cells costs time.
    reach = std::max(reach, std::sqrt(4.0 * half_x * half_y / static_cast<double>(spheres + 16)));
    Mesh mesh{.x0 = -half_x, .y0 = -half_y};
    mesh.nx = std::max(1, static_cast<int>(2.0 * half_x / reach));
    mesh.ny = std::max(1, static_cast<int>(2.0 * half_y / reach));
    mesh.per_x = mesh.nx / (2.0 * half_x);
    mesh.per_y = mesh.ny / (2.0 * half_y);
    return mesh;
}

double largest_radius(const Spheres& spheres) {
    double largest = 0.0;
    for (const Vec4d& place : spheres.position) largest = std::max(largest, place[3]);
    return largest;
}

/// Moves a coordinate into [-side/2, side/2) by whole cells.
void wrap(double& x, std::int32_t& image, double side) {
    const double cells = std::floor(x / side + 0.5);
    x -= cells * side;
    image += static_cast<std::int32_t>(cells);
}

void check_finite(const Vec4d& place, const char* kind, std::size_t number) {
    const double sum = place[0] + place[1] + place[2];
    if (!std::isfinite(sum) || std::abs(place[0]) > 1e9 || std::abs(place[1]) > 1e9)
        fail_run("{} {} is at ({:.3g}, {:.3g}, {:.3g}) mm; expected a finite place near the cell", kind, number,
                 place[0], place[1], place[2]);
}

void wrap_bodies(const Cell& cell, Spheres& spheres) {
    for (std::size_t s = 0; s < spheres.beads.size(); ++s) {
        check_finite(spheres.position[s], "bead", spheres.beads.number[s]);
        if (!is_periodic(cell)) continue;
        double x = spheres.position[s][0], y = spheres.position[s][1];
        wrap(x, spheres.beads.image[s][0], cell.lx);
        wrap(y, spheres.beads.image[s][1], cell.ly);
        spheres.position[s][0] = x;
        spheres.position[s][1] = y;
    }
    for (std::size_t r = 0; r < spheres.rods.size(); ++r) {
        check_finite(spheres.position[spheres.rods.first[r]], "rod", r);
        if (is_periodic(cell)) {
            wrap(spheres.rods.rod[r].position.x, spheres.rods.image[r][0], cell.lx);
            wrap(spheres.rods.rod[r].position.y, spheres.rods.image[r][1], cell.ly);
        }
        set_rod_spheres(spheres, r);
    }
}

std::vector<Place> positions_of(const Spheres& spheres) {
    std::vector<Place> places(spheres.size());
    for (std::size_t s = 0; s < spheres.size(); ++s) places[s] = {spheres.position[s][0], spheres.position[s][1]};
    return places;
}

/// The spheres of each cell of the mesh.
struct Filled {
    std::vector<std::uint32_t> start, spheres;
};
Filled fill(const Mesh& mesh, const std::vector<Place>& places) {
    Filled filled;
    filled.start.assign(static_cast<std::size_t>(mesh.nx) * static_cast<std::size_t>(mesh.ny) + 1, 0);
    filled.spheres.resize(places.size());
    std::vector<std::uint32_t> cells(places.size());
    for (std::size_t s = 0; s < places.size(); ++s) {
        cells[s] = static_cast<std::uint32_t>(mesh.cell(places[s]));
        ++filled.start[cells[s] + 1];
    }
    std::partial_sum(filled.start.begin(), filled.start.end(), filled.start.begin());
    std::vector<std::uint32_t> next(filled.start.begin(), filled.start.end() - 1);
    for (std::size_t s = 0; s < places.size(); ++s) filled.spheres[next[cells[s]]++] = static_cast<std::uint32_t>(s);
    return filled;
}

template <class Item>
void reorder(const std::vector<std::uint32_t>& order, std::vector<Item>& items) {
    const std::vector<Item> before(items.begin(), items.begin() + static_cast<std::ptrdiff_t>(order.size()));
    for (std::size_t s = 0; s < order.size(); ++s) items[s] = before[order[s]];
}

/// In the order of the mesh rows, so that neighbours are close in memory.
void sort_beads(const Mesh& mesh, Spheres& spheres) {
    BeadArrays& beads = spheres.beads;
    std::vector<Place> places = positions_of(spheres);
    places.resize(beads.size());  // which come first
    const std::vector<std::uint32_t> order = fill(mesh, places).spheres;
    reorder(order, spheres.position);
    reorder(order, beads.velocity);
    reorder(order, beads.spin);
    reorder(order, beads.number);
    reorder(order, beads.shape);
    reorder(order, beads.image);
}

/// Listed positions wrapped into the cell: a rod may extend over an edge.
struct Wrapped {
    std::vector<Place> places;
    std::vector<std::array<double, 2>> moved;  ///< the displacement by wrapping [mm]
};
Wrapped wrapped(const Cell& cell, const std::vector<Place>& listed) {
    Wrapped result{listed, std::vector<std::array<double, 2>>(listed.size(), {0.0, 0.0})};
    if (!is_periodic(cell)) return result;
    for (std::size_t s = 0; s < listed.size(); ++s) {
        const double sides[2] = {cell.lx, cell.ly};
        for (std::size_t axis = 0; axis < 2; ++axis) {
            const double cells = std::floor(listed[s][axis] / sides[axis] + 0.5);
            result.moved[s][axis] = -cells * sides[axis];
            result.places[s][axis] = listed[s][axis] + result.moved[s][axis];
        }
    }
    return result;
}

class Lister {
public:
    Lister(const Cell& cell, double skin, const Spheres& spheres)
        : cell_(cell), skin_(skin), spheres_(spheres), wrapped_(wrapped(cell, spheres.listed_wide)) {}

    /// x, y: added to the wrapped position of b.
    void consider(std::uint32_t a, std::uint32_t b, double x, double y, Neighbours& to) const {
        const double dx = wrapped_.places[b][0] + x - wrapped_.places[a][0],
                     dy = wrapped_.places[b][1] + y - wrapped_.places[a][1];
        const double reach = spheres_.position[a][3] + spheres_.position[b][3] + skin_;
        if (dx * dx + dy * dy >= reach * reach) return;
        x += wrapped_.moved[b][0] - wrapped_.moved[a][0];
        y += wrapped_.moved[b][1] - wrapped_.moved[a][1];
        const bool image = x != 0.0 || y != 0.0;
        if (image) to.images.push_back({a, b, x, y});
        else if (spheres_.body(a) != spheres_.body(b)) to.pairs.push_back({a, b});
    }

    /// For few spheres: all pairs, over every edge.
    void list_all(Neighbours& to) const {
        const auto count = static_cast<std::uint32_t>(spheres_.size());
        const int edges = is_periodic(cell_) ? 1 : 0;
        for (std::uint32_t a = 0; a < count; ++a)
            for (std::uint32_t b = a + 1; b < count; ++b)
                for (int i = -edges; i <= edges; ++i)
                    for (int j = -edges; j <= edges; ++j) consider(a, b, i * cell_.lx, j * cell_.ly, to);
    }

    void list_by(const Mesh& mesh, Threads& threads, Neighbours& to) const {
        const Filled filled = fill(mesh, wrapped_.places);
        constexpr std::size_t rows_per_chunk = 4;
        const auto rows = static_cast<std::size_t>(mesh.ny);
        std::vector<Neighbours> parts(rows / rows_per_chunk + 1);
        threads.for_chunks(rows, rows_per_chunk, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j)
                for (int i = 0; i < mesh.nx; ++i)
                    list_cell(mesh, filled, i, static_cast<int>(j), parts[begin / rows_per_chunk]);
        });
        for (const Neighbours& part : parts) {
            to.pairs.insert(to.pairs.end(), part.pairs.begin(), part.pairs.end());
            to.images.insert(to.images.end(), part.images.begin(), part.images.end());
        }
    }

    /// The pairs of one cell of the mesh with itself and with half of the cells around it.
    void list_cell(const Mesh& mesh, const Filled& filled, int i, int j, Neighbours& to) const {
        constexpr int half[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};
        const bool periodic = is_periodic(cell_);
        const std::size_t here = mesh.index(i, j);
        for (std::uint32_t k = filled.start[here]; k < filled.start[here + 1]; ++k)
            for (std::uint32_t l = k + 1; l < filled.start[here + 1]; ++l)
                consider(filled.spheres[k], filled.spheres[l], 0.0, 0.0, to);
        for (const auto& step : half) {
            int column = i + step[0], row = j + step[1];
            double x = 0.0, y = 0.0;
            if (!periodic && (column < 0 || column >= mesh.nx || row >= mesh.ny)) continue;
            if (column < 0 || column >= mesh.nx) {
                x = column < 0 ? -cell_.lx : cell_.lx;
                column += column < 0 ? mesh.nx : -mesh.nx;
            }
            if (row >= mesh.ny) {
                y = cell_.ly;
                row -= mesh.ny;
            }
            const std::size_t there = mesh.index(column, row);
            for (std::uint32_t k = filled.start[here]; k < filled.start[here + 1]; ++k)
                for (std::uint32_t l = filled.start[there]; l < filled.start[there + 1]; ++l)
                    consider(filled.spheres[k], filled.spheres[l], x, y, to);
        }
    }

    void list_walls(Neighbours& to) const {
        if (is_periodic(cell_)) return;
        const Walls walls(cell_);
        WallPoint found[4];
        for (std::uint32_t s = 0; s < spheres_.size(); ++s)
            if (const Place& at = spheres_.listed_wide[s];
                walls.near(at[0], at[1], spheres_.position[s][3] + skin_, found) > 0)
                to.near_wall.push_back(s);
    }

private:
    const Cell& cell_;
    double skin_;
    const Spheres& spheres_;
    Wrapped wrapped_;
};

void list_wide(const Cell& cell, double skin, const Spheres& spheres, Neighbours& neighbours, Threads& threads) {
    neighbours.pairs.clear();
    neighbours.images.clear();
    neighbours.near_wall.clear();
    const Lister lister(cell, skin, spheres);
    const Mesh mesh = mesh_of(cell, 2.0 * largest_radius(spheres) + skin, spheres.size());
    if (mesh.nx < 3 || mesh.ny < 3) lister.list_all(neighbours);
    else lister.list_by(mesh, threads, neighbours);
    lister.list_walls(neighbours);
}

/// The pairs of the wide list that were within the near skin when the spheres were listed last.
void list_near(double skin, const Spheres& spheres, Neighbours& neighbours, Threads& threads) {
    constexpr std::size_t pairs_per_chunk = 4096;
    const std::vector<SpherePair>& pairs = neighbours.pairs;
    const std::size_t chunks = pairs.size() / pairs_per_chunk + 1;
    neighbours.near.resize(chunks);
    threads.for_chunks(chunks, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const std::size_t from = c * pairs_per_chunk, to = std::min(from + pairs_per_chunk, pairs.size());
            std::vector<SpherePair>& near = neighbours.near[c];
            near.resize(to - from);
            std::size_t count = 0;
            for (std::size_t p = from; p < to; ++p) {
                const Place &a = spheres.listed[pairs[p].first], &b = spheres.listed[pairs[p].second];
                const double dx = a[0] - b[0], dy = a[1] - b[1];
                const double reach = spheres.position[pairs[p].first][3] + spheres.position[pairs[p].second][3] + skin;
                near[count] = pairs[p];
                count += dx * dx + dy * dy < reach * reach ? 1 : 0;  // no branch: it would be mispredicted
            }
            near.resize(count);
        }
    });
}

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

void list_again(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads) {
    list_wide(cell, skin, spheres, neighbours, threads);
    list_near(near_skin(skin), spheres, neighbours, threads);
}

void make_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads) {
    wrap_bodies(cell, spheres);
    sort_beads(mesh_of(cell, 2.0 * largest_radius(spheres) + skin, spheres.size()), spheres);
    spheres.listed = spheres.listed_wide = positions_of(spheres);
    list_again(cell, skin, spheres, neighbours, threads);
}

bool renew_neighbours(const Cell& cell, double skin, Spheres& spheres, Neighbours& neighbours, Threads& threads) {
    // The wide list contains all pairs within the near skin until a sphere has moved by half of the difference of the
    // skins.
    const double left = skin - near_skin(skin), square = 0.25 * left * left;
    for (std::size_t s = 0; s < spheres.size(); ++s)
        if (has_left_skin(spheres.position[s], spheres.listed_wide[s], square)) {
            make_neighbours(cell, skin, spheres, neighbours, threads);
            return true;
        }
    spheres.listed = positions_of(spheres);
    list_near(near_skin(skin), spheres, neighbours, threads);
    return false;
}

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
