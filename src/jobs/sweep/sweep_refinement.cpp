// jobs/sweep/sweep_refinement.cpp: cells that are halved until no more points are wanted.
#include <algorithm>
#include <cstdint>
#include <map>
#include <set>

#include "base/mapped.hpp"
#include "jobs/sweep/sweep_plan.hpp"
#include "run/number_lists.hpp"

namespace drover::jobs {

namespace {
/// Along each axis, in units of the finest step.
using Place = std::vector<std::int64_t>;

/// Counts through all places below `counts`, last axis fastest.
void for_places(const Place& counts, const std::function<void(const Place&)>& visit) {
    Place at(counts.size(), 0);
    for (;;) {
        visit(at);
        std::size_t axis = at.size();
        while (axis-- > 0 && ++at[axis] == counts[axis]) at[axis] = 0;
        if (axis == static_cast<std::size_t>(-1)) return;
    }
}

struct RefinedPoint {
    Place place;
    std::vector<double> values;
};

class Refinement {
public:
    Refinement(const Axes& axes, int levels, const Differs& differs)
        : axes_(axes), size_(std::int64_t{1} << levels), differs_(differs) {
        for (const auto& values : axes) cells_.push_back(static_cast<std::int64_t>(values.size()) - 1);
        Place corners = cells_;
        for (std::int64_t& count : corners) ++count;
        for_places(corners, [&](Place at) {
            for (std::int64_t& place : at) place *= size_;
            places_.insert(at);
        });
    }

    std::vector<std::vector<double>> points() {
        for (std::size_t before = 0; before < places_.size();) {
            before = places_.size();
            for (const auto& [cell, points] : points_of_cells()) {
                Place lower = cell;
                for (std::int64_t& place : lower) place *= size_;
                halve(lower, size_, points);
            }
        }
        return mapped(places_, [this](const Place& place) { return values_at(place); });
    }

private:
    /// A point on a border belongs to the cells on both sides.
    std::map<Place, std::vector<RefinedPoint>> points_of_cells() const {
        std::map<Place, std::vector<RefinedPoint>> found;
        for (const Place& place : places_) {
            const std::vector<double> values = values_at(place);
            for_places(Place(place.size(), 2), [&](Place cell) {
                for (std::size_t axis = 0; axis < cell.size(); ++axis) {
                    const bool is_on_border = place[axis] % size_ == 0;
                    if (cell[axis] == 1 && !is_on_border) return;
                    cell[axis] = place[axis] / size_ - cell[axis];
                    if (cell[axis] < 0 || cell[axis] >= cells_[axis]) return;
                }
                found[cell].push_back({place, values});
            });
        }
        return found;
    }

    std::vector<double> values_at(const Place& place) const {
        std::vector<double> values;
        for (std::size_t axis = 0; axis < place.size(); ++axis) {
            const auto cell = static_cast<std::size_t>(place[axis] / size_);
            const auto steps = static_cast<double>(place[axis] % size_);
            const double from = axes_[axis][cell];
            values.push_back(steps == 0.0 ? from
                                          : run::rounded(run::between(from, axes_[axis][cell + 1], steps,
                                                                      static_cast<double>(size_))));
        }
        return values;
    }

    /// A cell with its border.
    void halve(const Place& lower, std::int64_t size, const std::vector<RefinedPoint>& around) {
        if (size == 1) return;
        std::vector<RefinedPoint> inside;
        for (const RefinedPoint& point : around)
            if (std::equal(lower.begin(), lower.end(), point.place.begin(),
                           [size](std::int64_t low, std::int64_t at) { return low <= at && at <= low + size; }))
                inside.push_back(point);
        if (!has_change(inside)) return;
        const std::int64_t half = size / 2;
        for_places(Place(lower.size(), 3), [&](Place at) {
            for (std::size_t axis = 0; axis < at.size(); ++axis) at[axis] = lower[axis] + half * at[axis];
            places_.insert(at);
        });
        for_places(Place(lower.size(), 2), [&](Place at) {
            for (std::size_t axis = 0; axis < at.size(); ++axis) at[axis] = lower[axis] + half * at[axis];
            halve(at, half, inside);
        });
    }

    bool has_change(const std::vector<RefinedPoint>& points) const {
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (differs_(points[i].values, points[j].values)) return true;
        return false;
    }

    const Axes& axes_;
    std::int64_t size_;  ///< of a cell of the grid
    const Differs& differs_;
    Place cells_;
    std::set<Place> places_;
};
}  // namespace

std::vector<std::vector<double>> refined_points(const Axes& axes, int levels, const Differs& differs) {
    return Refinement(axes, levels, differs).points();
}

}  // namespace drover::jobs
