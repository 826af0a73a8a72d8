// dem/neighbours/bins.hpp: displacements to the nearest periodic image; a grid of squares over a cell, for searches
// near a point.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dem/bodies/walls.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// The shortest displacement between images, or the plain displacement in a cell that is not periodic.
class NearestImage {
public:
    explicit NearestImage(const Cell& cell) {
        if (!is_periodic(cell)) return;
        lx_ = cell.lx, ly_ = cell.ly, per_x_ = 1.0 / cell.lx, per_y_ = 1.0 / cell.ly;
    }
    double x(double dx) const { return dx - lx_ * __builtin_roundeven(dx * per_x_); }
    double y(double dy) const { return dy - ly_ * __builtin_roundeven(dy * per_y_); }
    Vector operator()(const Vector& from, const Vector& to) const {
        const Vector d = to - from;
        return {x(d.x), y(d.y), d.z};
    }

private:
    double lx_ = 0.0, ly_ = 0.0, per_x_ = 0.0, per_y_ = 0.0;  // sides [mm] and their inverses, 0 where not periodic
};

/// Numbered points in squares at least `reach` wide: all points within reach of one are in nine squares.
class Bins {
public:
    Bins(const Cell& cell, double reach) : periodic_(is_periodic(cell)) {
        const double width = 2.0 * half_width(cell), height = 2.0 * half_height(cell);
        // A limit: many empty squares cost more than they save.
        constexpr double max_cells = 2048.0;
        columns_ = static_cast<int>(std::clamp(width / reach, 1.0, max_cells));
        rows_ = static_cast<int>(std::clamp(height / reach, 1.0, max_cells));
        per_x_ = columns_ / width;
        per_y_ = rows_ / height;
        head_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), none);
    }

    void add(const Vector& place) {
        std::uint32_t& head = head_[square(column_of(place.x), row_of(place.y))];
        next_.push_back(head);
        head = static_cast<std::uint32_t>(next_.size() - 1);
    }

    /// Calls visit(number) once for every point in the squares around this one.
    template <class Visit>
    void for_near(const Vector& place, const Visit& visit) const {
        const Span across = span(column_of(place.x), columns_), along = span(row_of(place.y), rows_);
        for (int j = along.first; j <= along.last; ++j)
            for (int i = across.first; i <= across.last; ++i)
                for (std::uint32_t n = head_[square(wrapped(i, columns_), wrapped(j, rows_))]; n != none; n = next_[n])
                    visit(n);
    }

private:
    static constexpr std::uint32_t none = 0xffffffffU;
    struct Span {
        int first = 0, last = 0;
    };

    static int wrapped(int i, int count) { return i < 0 ? i + count : i >= count ? i - count : i; }
    /// With fewer than three squares along a periodic side each is visited once.
    Span span(int i, int count) const {
        if (periodic_) return count < 3 ? Span{0, count - 1} : Span{i - 1, i + 1};
        return {std::max(i - 1, 0), std::min(i + 1, count - 1)};
    }
    int place_in(double scaled, int count) const {
        const double turns = periodic_ ? scaled / count + 0.5 - std::floor(scaled / count + 0.5) : scaled / count + 0.5;
        return std::clamp(static_cast<int>(std::clamp(turns, 0.0, 1.0) * count), 0, count - 1);
    }
    int column_of(double x) const { return place_in(x * per_x_, columns_); }
    int row_of(double y) const { return place_in(y * per_y_, rows_); }
    std::size_t square(int i, int j) const {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(i);
    }

    bool periodic_;
    int columns_ = 1, rows_ = 1;
    double per_x_ = 0.0, per_y_ = 0.0;
    std::vector<std::uint32_t> head_, next_;
};

}  // namespace drover::dem
