// dem/bodies/shape.cpp: mass, centre and inertia of a union of spheres on an axis.
#include "drover/dem/bodies.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace drover::dem {

namespace {
using std::numbers::pi;

/// A stretch of the axis on which one sphere is the widest.
struct Stretch {
    double from = 0.0, to = 0.0;
    const AxisSphere* sphere = nullptr;
};

/// The stretches of a solid, from tail to head.
std::vector<Stretch> stretches(const std::vector<AxisSphere>& spheres) {
    std::vector<double> places;
    for (const AxisSphere& a : spheres) {
        places.insert(places.end(), {a.at - a.radius, a.at + a.radius});
        for (const AxisSphere& b : spheres)
            if (b.at > a.at)  // where they are equally wide: the difference of r^2 is linear in z
                places.push_back((a.radius * a.radius - b.radius * b.radius - a.at * a.at + b.at * b.at) /
                                 (2.0 * (b.at - a.at)));
    }
    std::ranges::sort(places);
    const auto square = [](const AxisSphere& s, double z) { return s.radius * s.radius - (z - s.at) * (z - s.at); };
    std::vector<Stretch> result;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
        const double middle = 0.5 * (places[i] + places[i + 1]);
        const auto widest = std::ranges::max_element(spheres, [&](const AxisSphere& a, const AxisSphere& b) {
            return square(a, middle) < square(b, middle);
        });
        if (places[i] < places[i + 1] && square(*widest, middle) > 0.0)
            result.push_back({places[i], places[i + 1], &*widest});
    }
    return result;
}

/// Integrals over a stretch of r^2, r^2 z, r^2 z^2, r^4 (z from the sphere's own centre) and r.
struct Moments {
    double square = 0.0, first = 0.0, second = 0.0, fourth = 0.0, width = 0.0;
};
Moments moments(const Stretch& stretch) {
    const double radius = stretch.sphere->radius, r2 = radius * radius;
    const auto at = [&](double z) -> Moments {
        const double z2 = z * z, inside = std::clamp(z / radius, -1.0, 1.0);
        return {.square = z * (r2 - z2 / 3.0),
                .first = z2 * (r2 / 2.0 - z2 / 4.0),
                .second = z2 * z * (r2 / 3.0 - z2 / 5.0),
                .fourth = z * (r2 * r2 - 2.0 * r2 * z2 / 3.0 + z2 * z2 / 5.0),
                .width = 0.5 * (z * std::sqrt(std::max(0.0, r2 - z2)) + r2 * std::asin(inside))};
    };
    const Moments low = at(stretch.from - stretch.sphere->at), high = at(stretch.to - stretch.sphere->at);
    return {high.square - low.square, high.first - low.first, high.second - low.second, high.fourth - low.fourth,
            high.width - low.width};
}
}  // namespace

Shape make_shape(std::vector<AxisSphere> spheres, const SourceLocation& where) {
    require(!spheres.empty(), where, "a body of no spheres; expected at least one");
    for (const AxisSphere& sphere : spheres) {
        require(std::isfinite(sphere.at) && std::isfinite(sphere.radius) && sphere.radius > 0.0, where,
                "a sphere of radius {} mm at {} mm; expected a radius > 0", sphere.radius, sphere.at);
        require(std::isfinite(sphere.density) && sphere.density >= 0.0, where, "a density of {} mg/mm^3; expected >= 0",
                sphere.density);
    }
    std::ranges::stable_sort(spheres, [](const AxisSphere& a, const AxisSphere& b) { return a.at < b.at; });
    const std::vector<Stretch> parts = stretches(spheres);
    Shape shape;
    double first = 0.0;
    for (const Stretch& part : parts) {
        const Moments m = moments(part);
        shape.volume += pi * m.square;
        shape.projected_area += 2.0 * m.width;
        shape.mass += pi * part.sphere->density * m.square;
        first += pi * part.sphere->density * (m.first + part.sphere->at * m.square);
    }
    require(shape.mass > 0.0, where, "a body without mass; expected a density > 0 somewhere");
    const double centre = first / shape.mass;
    for (const Stretch& part : parts) {
        // Relative to the centre of mass: z = position in the sphere + offset.
        const Moments m = moments(part);
        const double offset = part.sphere->at - centre, density = pi * part.sphere->density;
        shape.inertia_along += 0.5 * density * m.fourth;
        shape.inertia_across +=
            density * (0.25 * m.fourth + m.second + 2.0 * offset * m.first + offset * offset * m.square);
    }
    shape.tail = parts.front().from - centre;
    shape.head = parts.back().to - centre;
    for (const AxisSphere& sphere : spheres) {
        shape.at.push_back(sphere.at - centre);
        shape.radius.push_back(sphere.radius);
    }
    return shape;
}

Shape make_rod(const std::vector<double>& diameters, double length, double density, const SourceLocation& where) {
    require(!diameters.empty(), where, "a rod of no spheres; expected at least one diameter");
    if (diameters.size() == 1) return make_ball(diameters.front(), density, where);
    const double tips = 0.5 * (diameters.front() + diameters.back());
    require(length > tips, where,
            "a rod {} mm long whose first and last spheres reach {} mm beyond their centres together; expected a "
            "longer one",
            length, tips);
    std::vector<AxisSphere> spheres;
    const double spacing = (length - tips) / static_cast<double>(diameters.size() - 1);
    for (std::size_t i = 0; i < diameters.size(); ++i)
        spheres.push_back({.at = spacing * static_cast<double>(i), .radius = 0.5 * diameters[i], .density = density});
    const Shape rod = make_shape(std::move(spheres), where);
    constexpr double rounding = 1e-12;
    require(rod.head - rod.tail <= length * (1.0 + rounding), where,
            "a rod {} mm long of which a sphere between the first and the last reaches beyond them, {} mm in all; "
            "expected a longer one, or larger first and last spheres",
            length, rod.head - rod.tail);
    return rod;
}

Shape make_ball(double diameter, double density, const SourceLocation& where) {
    return make_shape({{.at = 0.0, .radius = 0.5 * diameter, .density = density}}, where);
}

}  // namespace drover::dem
