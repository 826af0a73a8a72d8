// theory/draw_field.cpp: margins over draws of uncertain numbers, and the band that they give.
#include "theory/boundary.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "base/draws.hpp"

namespace drover::theory {

namespace {
constexpr int stride = 4, max_blocks = 10;

/// Of the margins of all draws at one point.
struct PointDraws {
    double share = BandEnds::none, deviation = BandEnds::none;
};

PointDraws of_margins(std::span<const double> of_draws) {
    const std::size_t draws = of_draws.size();
    std::vector<double> margins(of_draws.begin(), of_draws.end());
    std::erase_if(margins, [](double margin) { return std::isnan(margin); });
    if (margins.empty() || 2 * margins.size() < draws) return {};
    std::ranges::sort(margins);
    const auto unstable = std::ranges::lower_bound(margins, 0.0) - margins.begin();
    return {.share = static_cast<double>(unstable) / static_cast<double>(margins.size()),
            .deviation = over_error(margins)};
}

void margins_at(const numerics::PlanePoint& point, const std::vector<MarginOf>& draws, std::span<double> margins) {
    for (std::size_t k = 0; k < draws.size(); ++k) margins[k] = draws[k](point).value;
}

enum class Sign : signed char { unstable = -1, undefined = 0, stable = 1 };

Sign sign_of(double margin) {
    return std::isnan(margin) ? Sign::undefined : margin < 0.0 ? Sign::unstable : Sign::stable;
}

/// Signs of one margin at all points of a square mesh.
class Signs {
public:
    explicit Signs(int side) : side_(side), signs_(static_cast<std::size_t>(side * side)) {}
    Sign& at(std::size_t i) { return signs_[i]; }
    Sign at(std::size_t i) const { return signs_[i]; }

    /// Pairs of connected regions of opposite sign that touch: the lines between them.
    std::size_t count_lines() const {
        const std::vector<int> regions = regions_of();
        std::set<std::pair<int, int>> pairs;
        for (int i = 0; i < side_ * side_; ++i)
            for (const int other : neighbours(i))
                if (product(i, other) < 0) pairs.insert(std::minmax(regions[index(i)], regions[index(other)]));
        return pairs.size();
    }

private:
    static std::size_t index(int i) { return static_cast<std::size_t>(i); }
    int product(int i, int j) const { return static_cast<int>(at(index(i))) * static_cast<int>(at(index(j))); }
    std::vector<int> neighbours(int i) const {
        std::vector<int> found;
        if (i % side_ > 0) found.push_back(i - 1);
        if (i % side_ + 1 < side_) found.push_back(i + 1);
        if (i >= side_) found.push_back(i - side_);
        if (i + side_ < side_ * side_) found.push_back(i + side_);
        return found;
    }
    std::vector<int> regions_of() const {
        std::vector<int> regions(signs_.size(), -1), open;
        for (int first = 0; first < side_ * side_; ++first) {
            if (regions[index(first)] >= 0) continue;
            regions[index(first)] = first;
            for (open.assign(1, first); !open.empty();) {
                const int i = open.back();
                open.pop_back();
                for (const int other : neighbours(i))
                    if (regions[index(other)] < 0 && at(index(other)) == at(index(i))) {
                        regions[index(other)] = first;
                        open.push_back(other);
                    }
            }
        }
        return regions;
    }

    int side_;
    std::vector<Sign> signs_;
};

/// Margins of all draws on a mesh: at every fourth point, and at those between where any draw changes its sign.
class Sampler {
public:
    Sampler(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<MarginOf>& draws, int blocks,
            const ComputeAll& compute)
        : plane_(plane),
          draws_(draws),
          blocks_(blocks),
          side_(stride * blocks + 1),
          points_(count()),
          signs_(draws.size() + 1, Signs(side_)) {
        all_.push_back(margin);
        all_.insert(all_.end(), draws.begin(), draws.end());
        std::vector<std::size_t> coarse, fine;
        for (int y = 0; y < side_; y += stride)
            for (int x = 0; x < side_; x += stride) coarse.push_back(index(x, y));
        evaluate(coarse, compute);
        std::vector<bool> is_wanted(count(), false);
        for_blocks([&](int x, int y) {
            if (!is_uniform(x, y))
                for_inner(x, y, [&](int i, int j, double, double) { is_wanted[index(i, j)] = true; });
        });
        for (std::size_t i = 0; i < is_wanted.size(); ++i)
            if (is_wanted[i] && !is_coarse(i)) fine.push_back(i);
        evaluate(fine, compute);
        for_blocks([&](int x, int y) {
            if (is_uniform(x, y))
                for_inner(x, y, [&](int i, int j, double u, double v) {
                    if (!is_wanted[index(i, j)] && !is_coarse(index(i, j))) interpolate(x, y, i, j, u, v);
                });
        });
    }

    DrawField field() const {
        DrawField found{.draws = draws_.size(), .side = side_, .share = {}, .deviation = {}};
        for (const PointDraws& point : points_) {
            found.share.push_back(point.share);
            found.deviation.push_back(point.deviation);
        }
        const std::size_t measured = signs_.front().count_lines();
        for (std::size_t k = 1; k < signs_.size(); ++k) {
            const std::size_t lines = signs_[k].count_lines();
            if (lines > 0) found.with_line += 1.0;
            if (lines > measured) found.with_more += 1.0;
        }
        for (double* count : {&found.with_line, &found.with_more}) *count /= static_cast<double>(draws_.size());
        return found;
    }

private:
    std::size_t count() const { return static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_); }
    std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * side_ + x); }
    bool is_coarse(std::size_t i) const {
        const auto side = static_cast<std::size_t>(side_);
        return i % side % stride == 0 && i / side % stride == 0;
    }
    void evaluate(const std::vector<std::size_t>& where, const ComputeAll& compute) {
        const auto side = static_cast<std::size_t>(side_);
        const auto at = [&](double from, double to, std::size_t i) {
            return from + (to - from) * static_cast<double>(i) / static_cast<double>(side - 1);
        };
        const std::vector<double> found =
            compute(where.size(), all_.size(), [&](std::size_t n, std::span<double> margins) {
                const std::size_t i = where[n];
                margins_at({at(plane_.x0, plane_.x1, i % side), at(plane_.y0, plane_.y1, i / side)}, all_, margins);
            });
        for (std::size_t n = 0; n < where.size(); ++n) {
            const auto margins = std::span(found).subspan(n * all_.size(), all_.size());
            for (std::size_t k = 0; k < margins.size(); ++k) signs_[k].at(where[n]) = sign_of(margins[k]);
            points_[where[n]] = of_margins(margins.subspan(1));
        }
    }
    template <class Function>
    void for_blocks(Function function) const {
        for (int y = 0; y < stride * blocks_; y += stride)
            for (int x = 0; x < stride * blocks_; x += stride) function(x, y);
    }
    /// All points of a block with their place in it, 0 to 1.
    template <class Function>
    static void for_inner(int x, int y, Function function) {
        for (int j = 0; j <= stride; ++j)
            for (int i = 0; i <= stride; ++i)
                function(x + i, y + j, static_cast<double>(i) / stride, static_cast<double>(j) / stride);
    }
    /// Whether no draw changes its sign between the corners of a block.
    bool is_uniform(int x, int y) const {
        return std::ranges::all_of(signs_, [&](const Signs& one) {
            const Sign first = one.at(index(x, y));
            return first == one.at(index(x + stride, y)) && first == one.at(index(x, y + stride)) &&
                   first == one.at(index(x + stride, y + stride));
        });
    }
    void interpolate(int x, int y, int i, int j, double u, double v) {
        const std::size_t corner = index(x, y), right = index(x + stride, y), up = index(x, y + stride),
                          far = index(x + stride, y + stride), here = index(i, j);
        const auto between = [&](double PointDraws::*of) {
            return (1.0 - v) * ((1.0 - u) * points_[corner].*of + u * points_[right].*of) +
                   v * ((1.0 - u) * points_[up].*of + u * points_[far].*of);
        };
        points_[here] = {.share = between(&PointDraws::share), .deviation = between(&PointDraws::deviation)};
        for (Signs& one : signs_) one.at(here) = one.at(corner);
    }

    numerics::Rectangle plane_;
    const std::vector<MarginOf>& draws_;
    std::vector<MarginOf> all_;  // without errors, then the draws
    int blocks_, side_;
    std::vector<PointDraws> points_;
    std::vector<Signs> signs_;
};

using DeviationAt = std::function<double(double place)>;

bool is_inside(double deviation) { return std::abs(deviation) <= 1.0; }

/// Where the deviation passes -1 or 1 between a place in the band and one beyond it: by its linear interpolation and by
/// halves in turn, since it may jump.  NaN where the state ends in between.
double edge_between(double inside, double at_inside, double outside, double at_outside, const DeviationAt& deviation) {
    constexpr double tolerance = 0.1;  // the quantile of 400 draws is known to 0.08
    constexpr int max_steps = 10;
    for (int step = 0; step < max_steps; ++step) {
        const double linear = (std::copysign(1.0, at_outside) - at_inside) / (at_outside - at_inside),
                     place = inside + (step % 2 == 0 ? linear : 0.5) * (outside - inside), here = deviation(place);
        if (std::isnan(here) || std::abs(std::abs(here) - 1.0) < tolerance) return std::isnan(here) ? nan : place;
        (is_inside(here) ? inside : outside) = place;
        (is_inside(here) ? at_inside : at_outside) = here;
    }
    return 0.5 * (inside + outside);
}

/// The deviation along one axis through a point of a line.  Places are parts of the side of the plane; between points
/// of the mesh, which tell where to look, it is that of the draws.
class Profile {
public:
    Profile(const DrawField& field, double fixed, bool along_x, DeviationAt deviation)
        : field_(field), along_x_(along_x), deviation_(std::move(deviation)) {
        const double place = std::clamp(fixed, 0.0, 1.0) * (field.side - 1);
        line_ = std::min(static_cast<int>(place), field.side - 2);
        part_ = place - line_;
    }

    /// The ends of the band through a point with this deviation; NaN where it does not end.  A point on the edge of a
    /// jump is in the band of its other side, or is the whole band.
    std::pair<double, double> ends_of_band(double from, double deviation) const {
        if (is_inside(deviation)) return {end_of_band(from, deviation, -1), end_of_band(from, deviation, 1)};
        constexpr double beside = 1e-6;
        for (const int side : {-1, 1}) {
            const double place = from + side * beside, there = place < 0.0 || place > 1.0 ? nan : deviation_(place);
            if (!is_inside(there) && !(there * deviation < 0.0)) continue;
            const double end = is_inside(there) ? end_of_band(place, there, side) : from;
            return side < 0 ? std::pair(end, from) : std::pair(from, end);
        }
        return {nan, nan};
    }

private:
    double end_of_band(double from, double deviation, int step) const {
        const double cells = field_.side - 1;
        double before = from, at_before = deviation;
        for (int i = static_cast<int>(step > 0 ? std::floor(from * cells) : std::ceil(from * cells)) + step;
             i >= 0 && i < field_.side; i += step) {
            const double place = i / cells;
            const double at_line = on_mesh(i, line_), at_next = part_ > 0.0 ? on_mesh(i, line_ + 1) : at_line;
            double here = (1.0 - part_) * at_line + part_ * at_next;
            // Between lines of the mesh the deviation may bend or jump: no less exact than at its points.
            if (part_ > 0.0 && !(is_inside(here) && std::abs(at_next - at_line) < 1.0)) here = deviation_(place);
            if (std::isnan(here)) return nan;
            if (!is_inside(here)) return edge_between(before, at_before, place, here, deviation_);
            before = place, at_before = here;
        }
        return nan;
    }
    double on_mesh(int i, int line) const {
        const int x = along_x_ ? i : line, y = along_x_ ? line : i;
        return field_.deviation[static_cast<std::size_t>(y * field_.side + x)];
    }
    const DrawField& field_;
    bool along_x_;
    DeviationAt deviation_;
    int line_ = 0;
    double part_ = 0.0;
};
}  // namespace

DrawField draw_field(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<MarginOf>& draws,
                     int cells, const ComputeAll& compute) {
    return Sampler(plane, margin, draws, std::clamp(cells / stride, 1, max_blocks), compute).field();
}

std::vector<BandEnds> band_ends(const numerics::Rectangle& plane, const DrawField& field,
                                const std::vector<MarginOf>& draws, const std::vector<numerics::PlanePoint>& points,
                                const ComputeAll& compute) {
    const double width = plane.x1 - plane.x0, height = plane.y1 - plane.y0;
    constexpr std::size_t ends_per_point = 4;
    const std::vector<double> found =
        compute(points.size(), ends_per_point, [&](std::size_t n, std::span<double> ends) {
            std::vector<double> margins(draws.size());
            const auto deviation_at = [&](double x, double y) {
                margins_at({plane.x0 + width * x, plane.y0 + height * y}, draws, margins);
                return of_margins(margins).deviation;
            };
            margins_at(points[n], draws, margins);
            const double x = (points[n].x - plane.x0) / width, y = (points[n].y - plane.y0) / height,
                         here = of_margins(margins).deviation;
            const Profile along_x(field, y, true, [&](double place) { return deviation_at(place, y); }),
                along_y(field, x, false, [&](double place) { return deviation_at(x, place); });
            std::tie(ends[0], ends[1]) = along_x.ends_of_band(x, here);
            std::tie(ends[2], ends[3]) = along_y.ends_of_band(y, here);
        });
    std::vector<BandEnds> bands;
    for (std::size_t n = 0; n < points.size(); ++n) {
        const double* const ends = &found[ends_per_point * n];
        bands.push_back({.x_low = plane.x0 + width * ends[0],
                         .x_high = plane.x0 + width * ends[1],
                         .y_low = plane.y0 + height * ends[2],
                         .y_high = plane.y0 + height * ends[3]});
    }
    return bands;
}

}  // namespace drover::theory
