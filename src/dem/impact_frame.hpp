// dem/impact_frame.hpp: a contact in its own frame: how velocities there answer impulses there.
#pragma once
#include <cmath>
#include <span>
#include <vector>

#include "drover/dem/impact.hpp"

namespace drover::dem {

/// Change of the relative velocity by a unit impulse, normal n and tangents x, y: a symmetric positive matrix [1/mg].
struct Response {
    double nn = 0.0, nx = 0.0, ny = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
    double ixx = 0.0, ixy = 0.0, iyy = 0.0;  ///< the inverse of its tangential part [mg]
};

struct Frame {
    Vector x, y;  ///< tangents: n, x, y are right-handed
    Response response;
};

/// Normal and slip do not feel each other, and no direction of slip differs from another.
inline bool is_sphere_like(const Response& w) {
    const double small = 1e-12 * w.nn;
    return std::abs(w.nx) < small && std::abs(w.ny) < small && std::abs(w.xy) < small && std::abs(w.xx - w.yy) < small;
}

/// Angular velocity that an angular impulse gives.
inline Vector spin_of(const Mover& mover, const Vector& angular) {
    return mover.across_inverse * angular +
           ((mover.along_inverse - mover.across_inverse) * dot(angular, mover.axis)) * mover.axis;
}

inline void apply(const Contact& contact, const Vector& impulse, std::span<Mover> movers) {
    Mover& first = movers[static_cast<std::size_t>(contact.first)];
    first.velocity = first.velocity + first.mass_inverse * impulse;
    first.spin = first.spin + spin_of(first, cross(contact.arm_first, impulse));
    if (contact.second < 0) return;
    Mover& second = movers[static_cast<std::size_t>(contact.second)];
    second.velocity = second.velocity - second.mass_inverse * impulse;
    second.spin = second.spin - spin_of(second, cross(contact.arm_second, impulse));
}

/// Relative velocity at the contact after a unit impulse along d, everything at rest before.
inline Vector answer(const Contact& contact, std::span<const Mover> movers, const Vector& d) {
    const Mover& first = movers[static_cast<std::size_t>(contact.first)];
    const Vector turn_first = spin_of(first, cross(contact.arm_first, d));
    if (contact.second == contact.first) {  // a body and its own image
        const Vector turn = turn_first - spin_of(first, cross(contact.arm_second, d));
        return cross(turn, contact.arm_first - contact.arm_second);
    }
    Vector result = first.mass_inverse * d + cross(turn_first, contact.arm_first);
    if (contact.second < 0) return result;
    const Mover& second = movers[static_cast<std::size_t>(contact.second)];
    return result + second.mass_inverse * d + cross(spin_of(second, cross(contact.arm_second, d)), contact.arm_second);
}

/// A tangent that turns with the scene, so that a turned scene gives turned results: along the slip, else along the arm.
inline Vector tangent(const Contact& contact, std::span<const Mover> movers) {
    const Vector& n = contact.normal;
    for (const Vector& v : {relative_velocity(contact, movers), contact.arm_first}) {
        const Vector across = v - dot(v, n) * n;
        if (dot(across, across) > 1e-18 * dot(v, v)) return across;
    }
    return std::abs(n.z) > 0.7 ? Vector{n.z, 0.0, -n.x} : Vector{-n.y, n.x, 0.0};
}

inline Frame frame_of(const Contact& contact, std::span<const Mover> movers) {
    const Vector& n = contact.normal;
    Vector x = tangent(contact, movers);
    x = x - dot(x, n) * n;
    x = 1.0 / length(x) * x;
    Frame frame{.x = x, .y = cross(n, x), .response = {}};
    const Vector to_n = answer(contact, movers, n), to_x = answer(contact, movers, frame.x),
                 to_y = answer(contact, movers, frame.y);
    frame.response = {.nn = dot(n, to_n),
                      .nx = dot(frame.x, to_n),
                      .ny = dot(frame.y, to_n),
                      .xx = dot(frame.x, to_x),
                      .xy = dot(frame.x, to_y),
                      .yy = dot(frame.y, to_y)};
    Response& w = frame.response;
    const double inverse = 1.0 / (w.xx * w.yy - w.xy * w.xy);
    w.ixx = inverse * w.yy;
    w.ixy = -inverse * w.xy;
    w.iyy = inverse * w.xx;
    return frame;
}

}  // namespace drover::dem
