// dem/impact/impact_frame.hpp: the frame of a contact, and the response of its relative velocity to impulses.
#pragma once
#include <array>
#include <cmath>
#include <span>

#include "dem/impact/impact.hpp"

namespace drover::dem {

/// Change of the relative velocity by a unit impulse, normal n and tangents x, y: a symmetric positive matrix [1/mg].
struct Response {
    double nn = 0.0, nx = 0.0, ny = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    double ixx = 0.0, ixy = 0.0, iyy = 0.0;  ///< the inverse of its tangential part [mg]; 0: no friction
};

/// One body of a contact: its motion along the normal and the tangents.
struct Lever {
    std::array<Vector, 3> turn;  ///< arm x direction: velocity there per angular velocity
    std::array<Vector, 3> spin;  ///< angular velocity per impulse
};

struct Frame {
    std::array<Vector, 3> axes;  ///< normal and tangents, right-handed
    Lever first, second;
    Response response;
};

/// Normal impulses do not change the slip, and all directions of slip are alike.
inline bool is_sphere_like(const Response& w) {
    const double small = 1e-12 * w.nn;
    return w.ixx > 0.0 && std::abs(w.nx) < small && std::abs(w.ny) < small && std::abs(w.xy) < small &&
           std::abs(w.xx - w.yy) < small;
}

/// A tangent along the slip, or else along the arm, so that a rotated scene gives rotated results.
inline Vector tangent(const Contact& contact, std::span<const ImpactBody> bodies) {
    const Vector& n = contact.normal;
    for (const Vector& v : {relative_velocity(contact, bodies), contact.arm_first}) {
        const Vector across = v - dot(v, n) * n;
        if (dot(across, across) > 1e-18 * dot(v, v)) return across;
    }
    return std::abs(n.z) > 0.7 ? Vector{n.z, 0.0, -n.x} : Vector{-n.y, n.x, 0.0};
}

/// Change of the angular velocity by an angular impulse.
inline Vector spin_change(const ImpactBody& body, const Vector& impulse) {
    return body.across_inverse * impulse +
           ((body.along_inverse - body.across_inverse) * dot(impulse, body.axis)) * body.axis;
}

inline Lever lever_of(const ImpactBody& body, const Vector& arm, const std::array<Vector, 3>& axes) {
    Lever lever;
    for (std::size_t i = 0; i < 3; ++i) {
        lever.turn[i] = cross(arm, axes[i]);
        lever.spin[i] = spin_change(body, lever.turn[i]);
    }
    return lever;
}

inline Response response_of(const Contact& contact, const Frame& frame, std::span<const ImpactBody> bodies) {
    const ImpactBody& first = bodies[static_cast<std::size_t>(contact.first)];
    const bool image =
        contact.second == contact.first;  // a body and its own image: the impulses turn it and cannot move it
    double mass_inverse = image ? 0.0 : first.mass_inverse;
    if (contact.second >= 0 && !image) mass_inverse += bodies[static_cast<std::size_t>(contact.second)].mass_inverse;
    const auto entry = [&](std::size_t i, std::size_t j) {
        if (image) return dot(frame.first.turn[i] - frame.second.turn[i], frame.first.spin[j] - frame.second.spin[j]);
        double value = (i == j ? mass_inverse : 0.0) + dot(frame.first.turn[i], frame.first.spin[j]);
        if (contact.second >= 0) value += dot(frame.second.turn[i], frame.second.spin[j]);
        return value;
    };
    Response w{.nn = entry(0, 0),
               .nx = entry(0, 1),
               .ny = entry(0, 2),
               .xx = entry(1, 1),
               .xy = entry(1, 2),
               .yy = entry(2, 2)};
    // The impulse of a body on its own image along the line between them does nothing.  Friction could add up with the
    // normal impulse to such a one, of any size, so there is none.
    constexpr double singular = 1e-10;
    if (image) return w.nn > singular * first.mass_inverse ? w : Response{};
    const double inverse = 1.0 / (w.xx * w.yy - w.xy * w.xy);
    w.ixx = inverse * w.yy;
    w.ixy = -inverse * w.xy;
    w.iyy = inverse * w.xx;
    return w;
}

inline Frame frame_of(const Contact& contact, std::span<const ImpactBody> bodies) {
    const Vector& n = contact.normal;
    Vector x = tangent(contact, bodies);
    x = x - dot(x, n) * n;
    x = 1.0 / length(x) * x;
    Frame frame{.axes = {n, x, cross(n, x)}};
    frame.first = lever_of(bodies[static_cast<std::size_t>(contact.first)], contact.arm_first, frame.axes);
    if (contact.second >= 0)
        frame.second = lever_of(bodies[static_cast<std::size_t>(contact.second)], contact.arm_second, frame.axes);
    frame.response = response_of(contact, frame, bodies);
    return frame;
}

/// Relative velocity along one of the axes.
inline double velocity_along(const Contact& contact, const Frame& frame, std::size_t i,
                             std::span<const ImpactBody> bodies) {
    const ImpactBody& first = bodies[static_cast<std::size_t>(contact.first)];
    const double at_first = dot(frame.first.turn[i], first.spin);
    if (contact.second < 0) return dot(frame.axes[i], first.velocity - contact.wall_velocity) + at_first;
    const ImpactBody& second = bodies[static_cast<std::size_t>(contact.second)];
    return dot(frame.axes[i], first.velocity - second.velocity) + at_first - dot(frame.second.turn[i], second.spin);
}

/// Applies an impulse of components n, x, y to both bodies; returns it as a vector.
inline Vector apply(const Contact& contact, const Frame& frame, double n, double x, double y,
                    std::span<ImpactBody> bodies) {
    const Vector impulse = n * frame.axes[0] + x * frame.axes[1] + y * frame.axes[2];
    ImpactBody& first = bodies[static_cast<std::size_t>(contact.first)];
    const bool image = contact.second == contact.first;  // its velocity does not change, not even by rounding
    if (!image) first.velocity = first.velocity + first.mass_inverse * impulse;
    first.spin = first.spin + (n * frame.first.spin[0] + x * frame.first.spin[1] + y * frame.first.spin[2]);
    if (contact.second < 0) return impulse;
    ImpactBody& second = bodies[static_cast<std::size_t>(contact.second)];
    if (!image) second.velocity = second.velocity - second.mass_inverse * impulse;
    second.spin = second.spin - (n * frame.second.spin[0] + x * frame.second.spin[1] + y * frame.second.spin[2]);
    return impulse;
}

}  // namespace drover::dem
