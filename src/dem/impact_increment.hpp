// dem/impact_increment.hpp: an increment of the normal impulse of one contact, with its friction.
#pragma once
#include <cmath>

#include "impact_frame.hpp"

namespace drover::dem {

/// Relative velocity of a contact in its frame: along the normal and the tangents [mm/s].
struct Slip {
    double n = 0.0, x = 0.0, y = 0.0;
};

/// An increment of impulse and its effects.
struct Increment {
    double n = 0.0, x = 0.0, y = 0.0;
    Slip after;
    double normal_work = 0.0, friction_work = 0.0;
};

/// The tangential impulse up to max_impulse that dissipates the most energy of a slip s: the minimum of p.s + p.W p/2
/// on a disc, found by Newton's method on the Lagrange multiplier of its edge.
inline void max_dissipation(const Response& w, double sx, double sy, double max_impulse, double& px, double& py) {
    if (const double square = sx * sx + sy * sy;
        max_impulse * max_impulse * (w.xx + w.yy) * (w.xx + w.yy) < 1e-2 * square) {
        // It keeps sliding, and friction opposes the slip; the turn of the slip within the increment is of second
        // order.
        const double scale = -max_impulse / std::sqrt(square);
        px = scale * sx;
        py = scale * sy;
        return;
    }
    double added = 0.0;
    for (int round = 0; round < 50; ++round) {
        const double a = w.xx + added, b = w.xy, c = w.yy + added, determinant = a * c - b * b;
        px = -(c * sx - b * sy) / determinant;
        py = -(a * sy - b * sx) / determinant;
        const double size = std::sqrt(px * px + py * py);
        if (size <= max_impulse * (1.0 + 1e-12)) return;
        // |p|^2 = p.p falls with the multiplier at the rate -2 p.(W + added)^-1 p; Newton on 1/|p| does not overshoot.
        const double slope = (c * px * px - 2.0 * b * px * py + a * py * py) / determinant;
        added += (size / max_impulse - 1.0) * size * size / slope;
    }
    const double size = std::sqrt(px * px + py * py);
    px *= max_impulse / size;
    py *= max_impulse / size;
}

/// One increment `dp` of the normal impulse with its friction.
inline Increment increment(const Response& w, double friction, const Slip& before, double dp) {
    Increment result{.n = dp, .x = 0.0, .y = 0.0, .after = {}};
    const double max_friction = friction * dp;
    if (max_friction > 0.0) {
        // The impulse that ends in sticking, if it is within the limit and dissipates; else that which dissipates the
        // max_friction.
        const double sx = before.x + w.nx * dp, sy = before.y + w.ny * dp;
        double px = -(w.ixx * sx + w.ixy * sy), py = -(w.ixy * sx + w.iyy * sy);
        if (px * px + py * py > max_friction * max_friction || px * before.x + py * before.y > 0.0)
            max_dissipation(w, before.x + 0.5 * w.nx * dp, before.y + 0.5 * w.ny * dp, max_friction, px, py);
        result.x = px;
        result.y = py;
    }
    result.after = {before.n + w.nn * dp + w.nx * result.x + w.ny * result.y,
                    before.x + w.nx * dp + w.xx * result.x + w.xy * result.y,
                    before.y + w.ny * dp + w.xy * result.x + w.yy * result.y};
    result.normal_work = 0.5 * dp * (before.n + result.after.n);
    result.friction_work = 0.5 * (result.x * (before.x + result.after.x) + result.y * (before.y + result.after.y));
    return result;
}

/// The increment between none and `whole` at which excess(increment) is zero; it is negative for none and not for
/// `whole`. guess(increment) gives a better size.
template <class Excess, class Guess>
Increment increment_between(const Response& w, double friction, const Slip& before, const Increment& whole,
                            double enough, Excess excess, Guess guess) {
    Increment part = whole;
    double low = 0.0, high = whole.n;
    for (int round = 0; round < 60; ++round) {
        const double value = excess(part);
        if (std::abs(value) <= enough) break;
        (value < 0.0 ? low : high) = part.n;
        const double next = guess(part);
        part = increment(w, friction, before, next > low && next < high ? next : 0.5 * (low + high));
    }
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

/// The total of one impact.
struct Bounce {
    double n = 0.0, x = 0.0, y = 0.0;
    double normal_work = 0.0, friction_work = 0.0;
};
inline void add(const Increment& part, Bounce& bounce, Slip& slip) {
    bounce.n += part.n;
    bounce.x += part.x;
    bounce.y += part.y;
    bounce.normal_work += part.normal_work;
    bounce.friction_work += part.friction_work;
    slip = part.after;
}

}  // namespace drover::dem
