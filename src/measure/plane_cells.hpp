// measure/plane_cells.hpp: points in the plane sorted into cells, to visit those near a point.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "dem/neighbours/nearest_image.hpp"

namespace drover::measure {

class PlaneCells {
public:
    /// Cells no smaller than `reach`.
    PlaneCells(const dem::Cell& cell, const std::vector<double>& x, const std::vector<double>& y, double reach);

    /// Calls visit(i, dx, dy) once for each point i nearer to (x, y) than `reach`, including one at (x, y) itself.  In
    /// a periodic cell reach must be at most half the shorter side.
    template <class Visit>
    void for_near(double x, double y, double reach, const Visit& visit) const {
        const Range columns = range(x, reach, across_), rows = range(y, reach, up_);
        const double max_square = reach * reach;
        for (int r = rows.first; r <= rows.last; ++r)
            for (int c = columns.first; c <= columns.last; ++c) {
                const std::size_t cell = slot(wrapped(c, across_.count), wrapped(r, up_.count));
                for (std::size_t k = start_[cell]; k < start_[cell + 1]; ++k) {
                    const double dx = nearest_.x(x_[k] - x), dy = nearest_.y(y_[k] - y);
                    if (dx * dx + dy * dy < max_square) visit(index_[k], dx, dy);
                }
            }
    }

private:
    struct Row {
        double from = 0.0, width = 1.0;
        int count = 1;
    };
    struct Range {
        int first, last;
    };

    static Row make_row(double from, double to, double reach, std::size_t points);
    static int wrapped(int i, int count) { return i < 0 ? i + count : i >= count ? i - count : i; }
    std::size_t slot(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(across_.count) +
               static_cast<std::size_t>(column);
    }
    int at(double x, const Row& row) const {
        return std::clamp(static_cast<int>((x - row.from) / row.width), 0, row.count - 1);
    }
    Range range(double x, double reach, const Row& row) const;

    dem::NearestImage nearest_;
    bool periodic_;
    Row across_, up_;
    std::vector<std::size_t> start_;
    std::vector<std::uint32_t> index_;
    std::vector<double> x_, y_;  ///< in the order of the cells
};

}  // namespace drover::measure
