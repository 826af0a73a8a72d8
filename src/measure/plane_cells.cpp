// measure/plane_cells.cpp: sorts points into cells.
#include "measure/plane_cells.hpp"

namespace drover::measure {

PlaneCells::Row PlaneCells::make_row(double from, double to, double reach, std::size_t points) {
    const double max_cells = 1.0 + 2.0 * std::sqrt(static_cast<double>(points));  // memory of the order of the points
    const double fit = std::clamp((to - from) / reach, 1.0, max_cells);
    Row row{.from = from, .width = 1.0, .count = static_cast<int>(fit)};
    if (to > from) row.width = (to - from) / row.count;
    return row;
}

PlaneCells::PlaneCells(const dem::Cell& cell, const std::vector<double>& x, const std::vector<double>& y, double reach)
    : nearest_(cell), periodic_(dem::is_periodic(cell)), index_(x.size()), x_(x.size()), y_(x.size()) {
    std::vector<double> in_x(x), in_y(y);  // wrapped into the cell
    if (periodic_) {
        for (double& value : in_x) value = nearest_.x(value);
        for (double& value : in_y) value = nearest_.y(value);
        across_ = make_row(-0.5 * cell.lx, 0.5 * cell.lx, reach, x.size());
        up_ = make_row(-0.5 * cell.ly, 0.5 * cell.ly, reach, x.size());
    } else if (!x.empty()) {
        const auto [min_x, max_x] = std::minmax_element(x.begin(), x.end());
        const auto [min_y, max_y] = std::minmax_element(y.begin(), y.end());
        across_ = make_row(*min_x, *max_x, reach, x.size());
        up_ = make_row(*min_y, *max_y, reach, x.size());
    }
    std::vector<std::size_t> cell_of(x.size());
    start_.assign(static_cast<std::size_t>(across_.count) * static_cast<std::size_t>(up_.count) + 1, 0);
    for (std::size_t i = 0; i < x.size(); ++i) {
        cell_of[i] = slot(at(in_x[i], across_), at(in_y[i], up_));
        ++start_[cell_of[i] + 1];
    }
    for (std::size_t c = 1; c < start_.size(); ++c) start_[c] += start_[c - 1];
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const std::size_t k = next[cell_of[i]]++;
        index_[k] = static_cast<std::uint32_t>(i);
        x_[k] = in_x[i];
        y_[k] = in_y[i];
    }
}

PlaneCells::Range PlaneCells::range(double x, double reach, const Row& row) const {
    const int steps = static_cast<int>(std::ceil(reach / row.width * (1.0 + 1e-12)));  // rounding must not drop a cell
    if (periodic_) {
        if (2 * steps + 1 >= row.count) return {0, row.count - 1};  // visit each cell once
        const int middle = at(&row == &across_ ? nearest_.x(x) : nearest_.y(x), row);
        return {middle - steps, middle + steps};
    }
    const double from = (x - reach - row.from) / row.width, to = (x + reach - row.from) / row.width;
    return {static_cast<int>(std::clamp(from, 0.0, row.count - 1.0)),
            static_cast<int>(std::clamp(to, 0.0, row.count - 1.0))};
}

}  // namespace drover::measure
