// dem/impact.cpp: the impulses of a single contact and of a group.
#include "drover/dem/impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "impact_frame.hpp"

namespace drover::dem {

namespace {
/// The state of one contact in its frame: normal first.
struct Slip {
    double n = 0.0, x = 0.0, y = 0.0;
};

/// An increment of impulse and what it does.
struct Increment {
    double n = 0.0, x = 0.0, y = 0.0;
    Slip after;
    double normal_work = 0.0, friction_work = 0.0;
};

/// The tangential impulse of at most `most` that takes the most energy from a slip s: the least of p.s + p.W p/2 on a disc, found by
/// Newton's method on the multiplier of its edge.
void brake(const Response& w, double sx, double sy, double most, double& px, double& py) {
    if (const double square = sx * sx + sy * sy; most * most * (w.xx + w.yy) * (w.xx + w.yy) < 1e-2 * square) {
        // It slides on: against the slip, whose turn within the increment counts at the second order alone.
        const double scale = -most / std::sqrt(square);
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
        if (size <= most * (1.0 + 1e-12)) return;
        // |p|^2 = p.p falls with the multiplier at the rate -2 p.(W + added)^-1 p; Newton on 1/|p| does not overshoot.
        const double slope = (c * px * px - 2.0 * b * px * py + a * py * py) / determinant;
        added += (size / most - 1.0) * size * size / slope;
    }
    const double size = std::sqrt(px * px + py * py);
    px *= most / size;
    py *= most / size;
}

/// One increment `dp` of the normal impulse with its friction.
Increment increment(const Response& w, double friction, const Slip& before, double dp) {
    Increment result{.n = dp, .x = 0.0, .y = 0.0, .after = {}};
    const double most = friction * dp;
    if (most > 0.0) {
        // To stick to the end, if that is allowed and takes energy; else what takes the most energy.
        const double sx = before.x + w.nx * dp, sy = before.y + w.ny * dp;
        double px = -(w.ixx * sx + w.ixy * sy), py = -(w.ixy * sx + w.iyy * sy);
        if (px * px + py * py > most * most || px * before.x + py * before.y > 0.0)
            brake(w, before.x + 0.5 * w.nx * dp, before.y + 0.5 * w.ny * dp, most, px, py);
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

/// The increment between none and `whole` for which lack(increment) is zero: negative at none, not at `whole`.  guess(increment): a better size.
template <class Lack, class Guess>
Increment increment_between(const Response& w, double friction, const Slip& before, const Increment& whole,
                            double enough, Lack lack, Guess guess) {
    Increment part = whole;
    double low = 0.0, high = whole.n;
    for (int round = 0; round < 60; ++round) {
        const double value = lack(part);
        if (std::abs(value) <= enough) break;
        (value < 0.0 ? low : high) = part.n;
        const double next = guess(part);
        part = increment(w, friction, before, next > low && next < high ? next : 0.5 * (low + high));
    }
    return part;
}

/// The increment of at most `most` after which the normal velocity is `target`, which lies above that before; all of `most` when that is not
/// enough.
Increment increment_to_speed(const Response& w, double friction, const Slip& before, double most, double target,
                             bool& reached) {
    const Increment whole = increment(w, friction, before, most);
    reached = whole.after.n >= target;
    if (!reached) return whole;
    const double wanted = target - before.n;
    return increment_between(
        w, friction, before, whole, 1e-14 * wanted, [&](const Increment& i) { return i.after.n - target; },
        [&](const Increment& i) { return i.n * wanted / (i.after.n - before.n); });
}

/// The impulse p that does the work p (u + W p/2).
double impulse_of_work(double response, double speed, double work) {
    return 2.0 * work / (speed + std::sqrt(std::max(0.0, speed * speed + 2.0 * response * work)));
}

/// The increment of at most `most` in which the normal impulse gives back `work`, from a normal velocity >= 0.
Increment increment_to_work(const Response& w, double friction, const Slip& before, double most, double work,
                            bool& reached) {
    const Increment whole = increment(w, friction, before, most);
    reached = whole.normal_work >= work;
    if (!reached || work <= 0.0) return reached ? increment(w, friction, before, 0.0) : whole;
    return increment_between(
        w, friction, before, whole, 1e-14 * work, [&](const Increment& i) { return i.normal_work - work; },
        [&](const Increment& i) { return impulse_of_work((i.after.n - before.n) / i.n, before.n, work); });
}

/// What one impact gave.
struct Bounce {
    double n = 0.0, x = 0.0, y = 0.0;
    double normal_work = 0.0, friction_work = 0.0;
};
void add(const Increment& part, Bounce& bounce, Slip& slip) {
    bounce.n += part.n;
    bounce.x += part.x;
    bounce.y += part.y;
    bounce.normal_work += part.normal_work;
    bounce.friction_work += part.friction_work;
    slip = part.after;
}

/// Friction along the slip before the impact, at most what stops it without the normal impulse: the plain law.
Bounce bounce_plain(const Response& w, const Contact& contact, Slip slip) {
    const double normal = -(1.0 + contact.restitution) * slip.n / w.nn,
                 size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    Increment part{.n = normal, .x = 0.0, .y = 0.0, .after = {}};
    if (size > 0.0) {
        const double ex = slip.x / size, ey = slip.y / size;
        const double stop = size / (w.xx * ex * ex + 2.0 * w.xy * ex * ey + w.yy * ey * ey);
        const double tangential = std::min(contact.friction * normal, stop);
        part.x = -tangential * ex;
        part.y = -tangential * ey;
    }
    part.after = {slip.n + w.nn * part.n + w.nx * part.x + w.ny * part.y,
                  slip.x + w.nx * part.n + w.xx * part.x + w.xy * part.y,
                  slip.y + w.ny * part.n + w.xy * part.x + w.yy * part.y};
    part.normal_work = 0.5 * part.n * (slip.n + part.after.n);
    part.friction_work = 0.5 * (part.x * (slip.x + part.after.x) + part.y * (slip.y + part.after.y));
    Bounce bounce;
    add(part, bounce, slip);
    return bounce;
}

/// A sphere's contact: normal and slip do not feel each other, and the slip keeps its direction.
Bounce bounce_sphere(const Response& w, const Contact& contact, const Slip& slip) {
    Bounce bounce{.n = -(1.0 + contact.restitution) * slip.n / w.nn};
    const double after = slip.n + w.nn * bounce.n, size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    bounce.normal_work = 0.5 * bounce.n * (slip.n + after);
    if (size > 0.0) {
        const double tangential = std::min(contact.friction * bounce.n, size / w.xx);
        bounce.x = -tangential / size * slip.x;
        bounce.y = -tangential / size * slip.y;
        bounce.friction_work = -tangential * (size - 0.5 * w.xx * tangential);
    }
    return bounce;
}

/// Increments that follow the turning of the slip: none needed where it keeps its direction.
int increments_needed(const Response& w, const Contact& contact, const Slip& slip, int most) {
    if (contact.friction == 0.0) return 1;
    const double impulse = -(1.0 + contact.restitution) * slip.n / w.nn;
    const double change = impulse * (std::sqrt(w.nx * w.nx + w.ny * w.ny) + contact.friction * std::max(w.xx, w.yy));
    const double size = std::sqrt(slip.x * slip.x + slip.y * slip.y),
                 wanted = std::ceil(2.0 * most * change / std::max(size, 1e-300));
    return wanted >= most ? most : std::max(1, static_cast<int>(wanted));
}

/// The impact of one contact that approaches.
Bounce bounce_of(const Response& w, const Contact& contact, Slip slip, const ImpactLaw& law) {
    if (!law.track_slip) return bounce_plain(w, contact, slip);
    if (is_sphere_like(w)) return bounce_sphere(w, contact, slip);
    Bounce bounce;
    const double before = slip.n, e = contact.restitution, mu = contact.friction;
    const double part = -before / w.nn / increments_needed(w, contact, slip, law.increments);
    const int rounds_most = 100 * law.increments;
    bool reached = false;
    for (int round = 0; round < rounds_most && !reached; ++round)
        add(increment_to_speed(w, mu, slip, part, 0.0, reached), bounce, slip);
    const double taken = -bounce.normal_work, pressed = bounce.n;
    double given = 0.0;
    reached = e == 0.0;
    for (int round = 0; round < rounds_most && !reached; ++round) {
        Increment next;
        if (law.restitution == RestitutionKind::energetic) {
            next = increment_to_work(w, mu, slip, part, e * e * taken - given, reached);
        } else if (law.restitution == RestitutionKind::kinematic) {
            next = increment_to_speed(w, mu, slip, part, -e * before, reached);
        } else {
            const double left = (1.0 + e) * pressed - bounce.n;
            next = increment(w, mu, slip, std::min(part, left));
            reached = left <= part;
        }
        given += next.normal_work;
        add(next, bounce, slip);
    }
    return bounce;
}

/// A group with all that its contacts need.
struct Group {
    std::span<Mover> movers;
    std::span<Contact> contacts;
    std::span<const Frame> frames;

    double normal(std::size_t c) const { return velocity_along(contacts[c], frames[c], 0, movers); }
    Slip slip(std::size_t c) const {
        return {normal(c), velocity_along(contacts[c], frames[c], 1, movers),
                velocity_along(contacts[c], frames[c], 2, movers)};
    }
    void push(std::size_t c, double n, double x, double y, double normal_work, double friction_work,
              ImpactOutcome& outcome) {
        const Vector impulse = apply(contacts[c], frames[c], n, x, y, movers);
        contacts[c].impulse = contacts[c].impulse + impulse;
        outcome.normal += normal_work;
        outcome.friction += friction_work;
        if (contacts[c].second < 0) outcome.walls += dot(impulse, contacts[c].wall_velocity);
    }
    double approach() const {
        double most = 0.0;
        for (std::size_t c = 0; c < contacts.size(); ++c) most = std::max(most, -normal(c));
        return most;
    }
};

/// One contact after another.
void resolve_in_turn(Group& group, const ImpactLaw& law, ImpactOutcome& outcome) {
    const std::size_t count = group.contacts.size();
    const double enough = law.tolerance * outcome.approach;
    const auto hit = [&](std::size_t c) {
        const Slip slip = group.slip(c);
        if (slip.n >= -enough) return false;
        const Bounce b = bounce_of(group.frames[c].response, group.contacts[c], slip, law);
        group.push(c, b.n, b.x, b.y, b.normal_work, b.friction_work, outcome);
        return true;
    };
    constexpr int sweeps_most = 2000;
    for (bool any = true; any && outcome.sweeps < sweeps_most; ++outcome.sweeps) {
        any = false;
        if (law.group == GroupLaw::approaching_first) {
            std::size_t fastest = 0;
            for (std::size_t c = 1; c < count; ++c)
                if (group.normal(c) < group.normal(fastest)) fastest = c;
            any = hit(fastest);
        } else {
            for (std::size_t i = 0; i < count; ++i)
                any = hit(law.group == GroupLaw::first_to_last ? i : count - 1 - i) || any;
        }
    }
}

/// One contact over a time h of the springs' own clock: pressed until it turns, then giving back.
void press(Group& group, std::size_t c, double h, double& stored, ImpactOutcome& outcome) {
    if (stored == 0.0 && group.normal(c) >= 0.0) return;
    Slip slip = group.slip(c);
    if (std::abs(slip.n) < 1e-12 * outcome.approach) slip.n = 0.0;  // turned, but for rounding
    if (slip.n >= 0.0 && stored == 0.0) return;
    const double mu = group.contacts[c].friction, e2 = group.contacts[c].restitution * group.contacts[c].restitution;
    const Response& w = group.frames[c].response;
    Bounce bounce;
    if (slip.n < 0.0) {
        bool turned = false;
        const double dp = (std::sqrt(2.0 * stored) - 0.5 * slip.n * h) * h;
        const Increment part = increment_to_speed(w, mu, slip, dp, 0.0, turned);
        stored = std::max(0.0, stored - part.normal_work);
        add(part, bounce, slip);
        h = turned ? h * (1.0 - part.n / dp) : 0.0;
    }
    if (h > 0.0 && stored > 0.0) {
        const double energy = e2 * stored, force = std::sqrt(2.0 * stored);
        const double parting = std::max(0.0, slip.n), later = force - parting * h / std::max(e2, 1e-300);
        // Once its force would end, all it has left, exactly.
        const double dp = later > 0.0 ? 0.5 * (force + later) * h : 2.0 * impulse_of_work(w.nn, parting, energy);
        bool ended = false;
        const Increment part = increment_to_work(w, mu, slip, dp, energy, ended);
        stored = ended || later <= 0.0 ? 0.0 : std::max(0.0, stored - part.normal_work / e2);
        add(part, bounce, slip);
    }
    group.push(c, bounce.n, bounce.x, bounce.y, bounce.normal_work, bounce.friction_work, outcome);
}

/// All contacts together, pressed one after another in each moment: as they stand, or the other way round.
void press_all(Group& group, const ImpactLaw& law, bool forth, std::span<double> stored, ImpactOutcome& outcome) {
    const std::size_t count = group.contacts.size();
    const double enough = law.tolerance * outcome.approach;
    double stiffest = 0.0;
    for (const Frame& frame : group.frames) stiffest = std::max(stiffest, frame.response.nn);
    // A quarter of a period takes about half of `increments` sweeps; one that gives back is 1/e times faster.
    const double step = 3.0 / (law.increments * std::sqrt(stiffest));
    constexpr double fastest_release = 0.05;
    constexpr int sweeps_most = 3000;
    std::fill(stored.begin(), stored.end(), 0.0);
    for (; outcome.sweeps < sweeps_most; ++outcome.sweeps) {
        double h = step;
        bool any = false;
        for (std::size_t c = 0; c < count; ++c) {
            const double n = group.normal(c);
            any = any || stored[c] > 0.0 || n < -enough;
            if (stored[c] > 0.0 && n > 0.0)
                h = std::min(h, step * std::max(group.contacts[c].restitution, fastest_release));
        }
        if (!any) break;
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t c = forth ? i : count - 1 - i;
            press(group, c, h, stored[c], outcome);
        }
    }
}

bool is_elastic(std::span<const Contact> contacts) {
    return std::all_of(contacts.begin(), contacts.end(),
                       [](const Contact& c) { return c.restitution == 1.0 && c.friction == 0.0; });
}

/// Stretches the impulses of a group that may lose nothing until it has lost nothing: impulses p that change normal velocities from u to u + w
/// do the work p.u + p.w/2, which is zero for s p with s = -p.u/(p.w/2).
void give_back(Group& group, ImpactOutcome& outcome) {
    const std::size_t count = group.contacts.size();
    std::vector<double> after(count), impulse(count);
    for (std::size_t c = 0; c < count; ++c) {
        after[c] = group.normal(c);
        impulse[c] = dot(group.contacts[c].impulse, group.frames[c].axes[0]);
    }
    for (std::size_t c = 0; c < count; ++c)
        apply(group.contacts[c], group.frames[c], -impulse[c], 0.0, 0.0, group.movers);
    double first = 0.0, second = 0.0;
    for (std::size_t c = 0; c < count; ++c) {
        const double before = group.normal(c);
        first += impulse[c] * before;
        second += 0.5 * impulse[c] * (after[c] - before);
    }
    const double stretch = second > 0.0 ? -first / second : 1.0;
    for (std::size_t c = 0; c < count; ++c) {
        apply(group.contacts[c], group.frames[c], stretch * impulse[c], 0.0, 0.0, group.movers);
        group.contacts[c].impulse = stretch * group.contacts[c].impulse;
    }
    outcome.walls *= stretch;
    outcome.normal = stretch * first + stretch * stretch * second;
}

/// Both ways from the same start, and the mean of the two: it does not know in which order the contacts stand, and has no more energy than they
/// have on average.
void resolve_together(Group& group, const ImpactLaw& law, std::span<double> stored, std::span<Mover> start,
                      std::span<Vector> impulses, ImpactOutcome& outcome) {
    std::copy(group.movers.begin(), group.movers.end(), start.begin());
    press_all(group, law, true, stored, outcome);
    for (std::size_t c = 0; c < group.contacts.size(); ++c) {
        impulses[c] = group.contacts[c].impulse;
        group.contacts[c].impulse = {};
    }
    std::swap_ranges(group.movers.begin(), group.movers.end(), start.begin());
    ImpactOutcome back{.approach = outcome.approach};
    press_all(group, law, false, stored, back);
    double apart = 0.0;
    for (std::size_t m = 0; m < group.movers.size(); ++m) {
        Mover &one = group.movers[m], half = one;
        half.velocity = 0.5 * (one.velocity - start[m].velocity);
        half.spin = 0.5 * (one.spin - start[m].spin);
        apart += energy_kinetic(half);
        one.velocity = 0.5 * (one.velocity + start[m].velocity);
        one.spin = 0.5 * (one.spin + start[m].spin);
    }
    for (std::size_t c = 0; c < group.contacts.size(); ++c)
        group.contacts[c].impulse = 0.5 * (group.contacts[c].impulse + impulses[c]);
    outcome.walls = 0.5 * (outcome.walls + back.walls);
    outcome.friction = 0.5 * (outcome.friction + back.friction);
    outcome.normal = 0.5 * (outcome.normal + back.normal) - apart;
    outcome.sweeps += back.sweeps;
    if (is_elastic(group.contacts)) give_back(group, outcome);
}
}  // namespace

Vector relative_velocity(const Contact& contact, std::span<const Mover> movers) {
    const Mover& first = movers[static_cast<std::size_t>(contact.first)];
    const Vector at_first = first.velocity + cross(first.spin, contact.arm_first);
    if (contact.second < 0) return at_first - contact.wall_velocity;
    const Mover& second = movers[static_cast<std::size_t>(contact.second)];
    return at_first - second.velocity - cross(second.spin, contact.arm_second);
}

double energy_kinetic(const Mover& mover) {
    const double along = dot(mover.spin, mover.axis), spin2 = dot(mover.spin, mover.spin);
    return 0.5 * (dot(mover.velocity, mover.velocity) / mover.mass_inverse +
                  std::max(0.0, spin2 - along * along) / mover.across_inverse + along * along / mover.along_inverse);
}

ImpactOutcome resolve(std::span<Mover> movers, std::span<Contact> contacts, const ImpactLaw& law) {
    constexpr std::size_t small = 8;
    std::array<Frame, small> few_frames;
    std::array<double, small> few_stored;
    std::array<Vector, small> few_impulses;
    std::array<Mover, 2 * small> few_movers;
    std::vector<Frame> many_frames;
    std::vector<double> many_stored;
    std::vector<Vector> many_impulses;
    std::vector<Mover> many_movers;
    const std::size_t count = contacts.size();
    if (count > small) {
        many_frames.resize(count);
        many_stored.resize(count);
        many_impulses.resize(count);
    }
    if (movers.size() > few_movers.size()) many_movers.resize(movers.size());
    const std::span<Frame> frames = count > small ? std::span(many_frames) : std::span(few_frames).first(count);
    const std::span<double> stored = count > small ? std::span(many_stored) : std::span(few_stored).first(count);
    const std::span<Vector> impulses = count > small ? std::span(many_impulses) : std::span(few_impulses).first(count);
    const std::span<Mover> start =
        many_movers.empty() ? std::span(few_movers).first(movers.size()) : std::span(many_movers);
    for (std::size_t c = 0; c < count; ++c) {
        contacts[c].impulse = {};
        frames[c] = frame_of(contacts[c], movers);
    }
    Group group{movers, contacts, frames};
    ImpactOutcome outcome;
    outcome.approach = group.approach();
    if (outcome.approach <= 0.0) return outcome;
    if (count == 1) {
        const Bounce b = bounce_of(frames[0].response, contacts[0], group.slip(0), law);
        group.push(0, b.n, b.x, b.y, b.normal_work, b.friction_work, outcome);
        outcome.sweeps = 1;
    } else if (law.group == GroupLaw::simultaneous) {
        resolve_together(group, law, stored, start, impulses, outcome);
    } else {
        resolve_in_turn(group, law, outcome);
    }
    outcome.residual = group.approach();
    return outcome;
}

}  // namespace drover::dem
