// dem/impact/impact_increment.hpp: the frame of a contact, and the response of its relative velocity to impulses; an
// increment of the normal impulse of one contact, with its friction; simultaneous impacts of a group of contacts, and
// the end of an approach that its law has left.
#pragma once
#include <array>
#include <cmath>
#include <span>
#include <vector>

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

/// Relative velocity of a contact in its frame: along the normal and the tangents [mm/s].
struct Slip {
    double n = 0.0, x = 0.0, y = 0.0;
};

/// An increment of impulse and its effects, or the sum of many.
struct Increment {
    double n = 0.0, x = 0.0, y = 0.0;
    Slip after;
    double normal_work = 0.0, friction_work = 0.0;
    int evaluations = 0;  ///< of increment() that it took
};

/// The tangential impulse of a sliding contact, of size max_impulse and opposite to the slip in the middle of the
/// increment, s + W p/2, where s is the slip there without friction; smaller if it stops that slip.  Found by Newton's
/// method on its ratio to the slip.  It dissipates energy: it works on the slip in the middle.
inline void sliding_friction(const Response& w, double sx, double sy, double max_impulse, double& px, double& py) {
    if (const double square = sx * sx + sy * sy;
        max_impulse * max_impulse * (w.xx + w.yy) * (w.xx + w.yy) < 1e-2 * square) {
        // The slip turns little: without the ratio, to the same order.
        const double half = -0.5 * max_impulse / std::sqrt(square);
        const double x = sx + half * (w.xx * sx + w.xy * sy), y = sy + half * (w.xy * sx + w.yy * sy);
        const double scale = -max_impulse / std::sqrt(x * x + y * y);
        px = scale * x;
        py = scale * y;
        return;
    }
    double added = 0.0;
    for (int round = 0; round < 50; ++round) {
        const double a = 0.5 * w.xx + added, b = 0.5 * w.xy, c = 0.5 * w.yy + added, determinant = a * c - b * b;
        px = -(c * sx - b * sy) / determinant;
        py = -(a * sy - b * sx) / determinant;
        const double size = std::sqrt(px * px + py * py);
        if (size <= max_impulse * (1.0 + 1e-12)) return;
        // |p|^2 = p.p falls with the ratio at the rate -2 p.(W/2 + added)^-1 p; Newton on 1/|p| does not overshoot.
        const double slope = (c * px * px - 2.0 * b * px * py + a * py * py) / determinant;
        added += (size / max_impulse - 1.0) * size * size / slope;
    }
    const double size = std::sqrt(px * px + py * py);
    px *= max_impulse / size;
    py *= max_impulse / size;
}

/// Adds impulses that act together, which work on the mean of the velocities before and after them.
inline void add_impulse(const Response& w, double n, double x, double y, Increment& to) {
    const Slip before = to.after;
    Slip& now = to.after;
    now.n += w.nn * n + w.nx * x + w.ny * y;
    now.x += w.nx * n + w.xx * x + w.xy * y;
    now.y += w.ny * n + w.xy * x + w.yy * y;
    to.n += n;
    to.x += x;
    to.y += y;
    to.normal_work += 0.5 * n * (before.n + now.n);
    to.friction_work += 0.5 * (x * (before.x + now.x) + y * (before.y + now.y));
}

/// The smallest normal impulse up to `max_impulse` after which friction in one direction has stopped the slip, or -1.
/// ax, ay: the tangential impulse that stops the slip now; bx, by: that which balances the normal impulse, per impulse.
inline double impulse_to_stop(double ax, double ay, double bx, double by, double friction, double max_impulse) {
    const double a2 = ax * ax + ay * ay, ab = ax * bx + ay * by, b2 = bx * bx + by * by, mu2 = friction * friction;
    if (a2 == 0.0) return 0.0;
    if (const double reach = (friction + std::sqrt(b2)) * max_impulse; a2 > reach * reach) return -1.0;
    // |a + b p| = mu p, as a2/p, without cancellation.
    const double d = ab * ab - (b2 - mu2) * a2;
    const double denominator = -ab + std::sqrt(std::max(0.0, d));
    return d >= 0.0 && denominator > 0.0 && a2 <= max_impulse * denominator ? a2 / denominator : -1.0;
}

/// One increment `dp` of the normal impulse with its friction.  Where the slip stops on the way, it sticks from there
/// if friction can hold it, and slides on otherwise.
inline Increment increment(const Response& w, double friction, const Slip& before, double dp) {
    Increment result{.after = before, .evaluations = 1};
    double left = dp;
    if (friction * dp > 0.0 && w.ixx > 0.0) {
        const double ax = w.ixx * before.x + w.ixy * before.y, ay = w.ixy * before.x + w.iyy * before.y;
        const double bx = w.ixx * w.nx + w.ixy * w.ny, by = w.ixy * w.nx + w.iyy * w.ny;
        const double stop = impulse_to_stop(ax, ay, bx, by, friction, dp);
        const double px = -(ax + bx * stop), py = -(ay + by * stop);
        const bool stops = stop >= 0.0 && px * before.x + py * before.y <= 0.0;
        if (stops) {
            add_impulse(w, stop, px, py, result);
            result.after.x = result.after.y = 0.0;  // without rounding, or it would not stick
            left = dp - stop;
        }
        if (stops && bx * bx + by * by <= friction * friction) {
            add_impulse(w, left, -bx * left, -by * left, result);
            result.after.x = result.after.y = 0.0;
        } else if (left > 0.0) {
            double x = 0.0, y = 0.0;
            sliding_friction(w, result.after.x + 0.5 * w.nx * left, result.after.y + 0.5 * w.ny * left, friction * left,
                             x, y);
            add_impulse(w, left, x, y, result);
        }
    } else {
        add_impulse(w, dp, 0.0, 0.0, result);
    }
    return result;
}

/// The increment between none and `whole` at which excess(increment) is zero; it is negative for none and not for
/// `whole`. guess(increment) gives a better size.
template <class Excess, class Guess>
Increment increment_between(const Response& w, double friction, const Slip& before, const Increment& whole,
                            double enough, Excess excess, Guess guess) {
    Increment part = whole;
    int evaluations = whole.evaluations;
    double low = 0.0, high = whole.n;
    for (int round = 0; round < 60; ++round) {
        const double value = excess(part);
        if (std::abs(value) <= enough) break;
        (value < 0.0 ? low : high) = part.n;
        const double next = guess(part);
        part = increment(w, friction, before, next > low && next < high ? next : 0.5 * (low + high));
        ++evaluations;
    }
    part.evaluations = evaluations;
    return part;
}

/// The increment after which the normal velocity is `target`, which is above that before, or max_impulse if that is not
/// enough.
inline Increment increment_to_speed(const Response& w, double friction, const Slip& before, double max_impulse,
                                    double target, bool& reached) {
    const Increment whole = increment(w, friction, before, max_impulse);
    reached = whole.after.n >= target;
    if (!reached) return whole;
    const double wanted = target - before.n;
    return increment_between(
        w, friction, before, whole, 1e-14 * wanted, [&](const Increment& i) { return i.after.n - target; },
        [&](const Increment& i) { return i.n * wanted / (i.after.n - before.n); });
}

/// The impulse p that does the work p (u + W p/2).
inline double impulse_of_work(double response, double speed, double work) {
    return 2.0 * work / (speed + std::sqrt(std::max(0.0, speed * speed + 2.0 * response * work)));
}

/// The increment in which the normal impulse does the work `work`, from a normal velocity >= 0, or max_impulse if that
/// is not enough.
inline Increment increment_to_work(const Response& w, double friction, const Slip& before, double max_impulse,
                                   double work, bool& reached) {
    const Increment whole = increment(w, friction, before, max_impulse);
    reached = whole.normal_work >= work;
    if (!reached || work <= 0.0) return reached ? increment(w, friction, before, 0.0) : whole;
    return increment_between(
        w, friction, before, whole, 1e-14 * work, [&](const Increment& i) { return i.normal_work - work; },
        [&](const Increment& i) { return impulse_of_work((i.after.n - before.n) / i.n, before.n, work); });
}

/// Adds the increment that follows.
inline void add(const Increment& part, Increment& total) {
    total.n += part.n;
    total.x += part.x;
    total.y += part.y;
    total.after = part.after;
    total.normal_work += part.normal_work;
    total.friction_work += part.friction_work;
    total.evaluations += part.evaluations;
}

/// The law `simultaneous` of resolve(), for a group that approaches at outcome.approach.  Changes the bodies'
/// velocities, the contacts' impulses and the outcome.
void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome);

/// Normal impulses p >= 0 without rebound or friction, after which no contact approaches at `velocities` along the
/// normals: of those that do this, the ones which leave the least kinetic energy.  Empty where there are none, as for a
/// body between walls that approach each other.
std::vector<double> inelastic_impulses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                       std::span<const Frame> frames, std::span<const double> velocities);

}  // namespace drover::dem
