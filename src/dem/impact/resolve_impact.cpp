// dem/impact/resolve_impact.cpp: the impulses of a single contact and of a group.
#include "dem/impact/impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "dem/impact/impact_increment.hpp"

namespace drover::dem {

namespace {
/// Friction keeps the direction of the slip before the impact, and is at most what stops the slip without the normal
/// impulse.
Increment bounce_plain(const Response& w, const Contact& contact, const Slip& slip) {
    const double normal = -(1.0 + contact.restitution) * slip.n / w.nn,
                 size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    Increment part{.n = normal};
    if (size > 0.0 && w.ixx > 0.0) {
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
    return part;
}

/// The impact of a contact for which is_sphere_like() holds.
Increment bounce_sphere(const Response& w, const Contact& contact, const Slip& slip) {
    const double size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    const SphereImpact impact =
        sphere_impact(slip.n, size, {.denominator = w.nn}, w.xx, contact.restitution, contact.friction);
    Increment bounce{.n = impact.normal,
                     .normal_work = 0.5 * impact.normal * (slip.n + (slip.n + w.nn * impact.normal))};
    if (size > 0.0) {
        bounce.x = -impact.tangential / size * slip.x;
        bounce.y = -impact.tangential / size * slip.y;
        bounce.friction_work = impact.friction_work;
    }
    return bounce;
}

/// Number of increments that leave no turn of the slip unnoticed: one where it keeps its direction.
int increments_needed(const Response& w, const Contact& contact, const Slip& slip) {
    constexpr double max_pieces = 4.0;
    const double impulse = -(1.0 + contact.restitution) * slip.n / w.nn;
    const double change = impulse * (std::sqrt(w.nx * w.nx + w.ny * w.ny) + contact.friction * std::max(w.xx, w.yy));
    const double size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    if (contact.friction == 0.0) return 1;
    return static_cast<int>(std::clamp(std::ceil(2.0 * max_pieces * change / std::max(size, 1e-300)), 1.0, max_pieces));
}

/// One phase of an impact, in increments whose size follows their error.
struct Phase {
    const Response& w;
    double largest = 0.0;  ///< increment of the normal impulse
    double allowed = 0.0;  ///< error of the relative velocity by an increment [mm/s]
};

/// Advances a phase to its end.  advance(slip, work and impulse of the phase so far, size, whether the phase ends)
/// makes an increment of at most that size.  Each increment is compared with its two halves, which are taken where they
/// differ by no more than allowed.
template <class Advance>
void follow_phase(const Phase& phase, const Advance& advance, Increment& bounce) {
    constexpr int max_rounds = 2000;
    constexpr double smallest = 0x1p-30;
    const double start = bounce.n;
    double size = phase.largest, work = 0.0;
    bool ended = false, is_known = false, whole_ends = false;
    Increment whole;
    for (int round = 0; round < max_rounds && !ended; ++round) {
        if (!is_known) {
            whole = advance(bounce.after, work, bounce.n - start, size, whole_ends);
            bounce.evaluations += whole.evaluations;
        }
        bool first_ends = false, second_ends = false;
        const double half = 0.5 * whole.n;
        const Increment first = advance(bounce.after, work, bounce.n - start, half, first_ends);
        const Increment second = advance(first.after, work + first.normal_work, bounce.n - start + first.n,
                                         whole_ends ? whole.n : half, second_ends);
        const double error =
            std::max({std::abs(whole.after.n - second.after.n), std::abs(whole.after.x - second.after.x),
                      std::abs(whole.after.y - second.after.y), phase.w.nn * std::abs(whole.n - first.n - second.n)});
        is_known = size > smallest * phase.largest && (error > phase.allowed || (first_ends && half > 0.0));
        if (is_known) {  // the first half is the next attempt
            bounce.evaluations += first.evaluations + second.evaluations;
            whole = first;
            whole_ends = first_ends;
            size = half;
            continue;
        }
        work += first.normal_work + second.normal_work;
        add(first, bounce);
        if (!first_ends) add(second, bounce);
        ended = first_ends || second_ends;
        // The error of an increment is of third order in its size.
        if (error < 0.1 * phase.allowed) size = std::min(phase.largest, 2.0 * size);
    }
}

/// The impact of one approaching contact.
Increment bounce_of(const Response& w, const Contact& contact, const Slip& slip, const ImpactLaw& law) {
    if (!law.track_slip) return bounce_plain(w, contact, slip);
    if (is_sphere_like(w)) return bounce_sphere(w, contact, slip);
    Increment bounce{.after = slip};
    const double before = slip.n, e = contact.restitution, mu = contact.friction;
    const Phase phase{.w = w,
                      .largest = -before / w.nn / increments_needed(w, contact, slip),
                      .allowed = ImpactLaw::increment_error * -before};
    const auto to_speed = [&](double target) {
        return [&w, mu, target](const Slip& from, double, double, double size, bool& ended) {
            return increment_to_speed(w, mu, from, size, target, ended);
        };
    };
    follow_phase(phase, to_speed(0.0), bounce);
    if (e == 0.0) return bounce;
    const double energy = -e * e * bounce.normal_work, impulse = e * bounce.n;
    const auto to_work = [&](const Slip& from, double work, double, double size, bool& ended) {
        return increment_to_work(w, mu, from, size, energy - work, ended);
    };
    const auto to_impulse = [&](const Slip& from, double, double given, double size, bool& ended) {
        ended = impulse - given <= size;
        return increment(w, mu, from, std::min(size, impulse - given));
    };
    if (law.restitution == RestitutionKind::energetic) follow_phase(phase, to_work, bounce);
    else if (law.restitution == RestitutionKind::kinematic) follow_phase(phase, to_speed(-e * before), bounce);
    else follow_phase(phase, to_impulse, bounce);
    return bounce;
}

/// A group of contacts.
struct Group {
    std::span<ImpactBody> bodies;
    std::span<Contact> contacts;
    std::span<const Frame> frames;

    double normal(std::size_t c) const { return velocity_along(contacts[c], frames[c], 0, bodies); }
    Slip slip(std::size_t c) const {
        return {normal(c), velocity_along(contacts[c], frames[c], 1, bodies),
                velocity_along(contacts[c], frames[c], 2, bodies)};
    }
    void push(std::size_t c, const Increment& bounce, ImpactOutcome& outcome) {
        const Vector impulse = apply(contacts[c], frames[c], bounce.n, bounce.x, bounce.y, bodies);
        contacts[c].impulse = contacts[c].impulse + impulse;
        outcome.normal += bounce.normal_work;
        outcome.friction += bounce.friction_work;
        if (contacts[c].second < 0) outcome.walls += dot(impulse, contacts[c].wall_velocity);
    }
    double approach() const {
        double max_approach = 0.0;
        for (std::size_t c = 0; c < contacts.size(); ++c) max_approach = std::max(max_approach, -normal(c));
        return max_approach;
    }
};

/// Largest error by rounding of a relative velocity of bodies that move together [mm/s].
double rounding_of(std::span<const Contact> contacts, std::span<const ImpactBody> bodies) {
    const auto size = [](const Vector& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); };
    const auto speed = [&](int body, const Vector& arm) {
        const ImpactBody& b = bodies[static_cast<std::size_t>(body)];
        return size(b.velocity) + size(b.spin) * size(arm);
    };
    double largest = 0.0;
    for (const Contact& c : contacts)
        largest = std::max(largest, speed(c.first, c.arm_first) +
                                        (c.second < 0 ? size(c.wall_velocity) : speed(c.second, c.arm_second)));
    constexpr double rest = 1e-100;  // squares of slower speeds underflow [mm/s]
    return std::max(rest, 1e-15 * largest);
}

/// One contact after another.
void resolve_in_turn(Group& group, const ImpactLaw& law, ImpactOutcome& outcome) {
    const std::vector<ImpactBody> start(group.bodies.begin(), group.bodies.end());
    const std::size_t count = group.contacts.size();
    const double enough = law.tolerance * outcome.approach;
    const auto hit = [&](std::size_t c) {
        const Slip slip = group.slip(c);
        if (slip.n >= -enough) return false;
        const Increment b = bounce_of(group.frames[c].response, group.contacts[c], slip, law);
        group.push(c, b, outcome);
        return true;
    };
    constexpr int max_sweeps = 2000;
    for (bool any = true; any && outcome.sweeps < max_sweeps; ++outcome.sweeps) {
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
    // The total impulses at once: thousands of them, added one by one, would lose digits of the momentum.
    std::ranges::copy(start, group.bodies.begin());
    for (std::size_t c = 0; c < count; ++c) {
        const auto& axes = group.frames[c].axes;
        const Vector& p = group.contacts[c].impulse;
        apply(group.contacts[c], group.frames[c], dot(p, axes[0]), dot(p, axes[1]), dot(p, axes[2]), group.bodies);
    }
}

/// Ends an approach that the law has left, without rebound or friction, if that is possible.
void end_approach(Group& group, ImpactOutcome& outcome) {
    std::vector<double> velocities;
    for (std::size_t c = 0; c < group.contacts.size(); ++c) velocities.push_back(group.normal(c));
    const std::vector<double> impulses = inelastic_impulses(group.bodies, group.contacts, group.frames, velocities);
    for (std::size_t c = 0; c < impulses.size(); ++c) {
        const double before = group.normal(c);
        const double work = impulses[c] * (before + 0.5 * group.frames[c].response.nn * impulses[c]);
        group.push(c, {.n = impulses[c], .normal_work = work}, outcome);
    }
}

/// The impacts of the contacts that respond to impulses.
ImpactOutcome resolve_responding(std::span<ImpactBody> bodies, std::span<Contact> contacts,
                                 std::span<const Frame> frames, const ImpactLaw& law) {
    std::vector<Contact> responding;
    for (std::size_t c = 0; c < contacts.size(); ++c)
        if (frames[c].response.nn > 0.0) responding.push_back(contacts[c]);
    const ImpactOutcome outcome = resolve(bodies, responding, law);
    for (std::size_t c = 0, r = 0; c < contacts.size(); ++c)
        if (frames[c].response.nn > 0.0) contacts[c].impulse = responding[r++].impulse;
    return outcome;
}
}  // namespace

Vector relative_velocity(const Contact& contact, std::span<const ImpactBody> bodies) {
    const ImpactBody& first = bodies[static_cast<std::size_t>(contact.first)];
    const Vector at_first = first.velocity + cross(first.spin, contact.arm_first);
    if (contact.second < 0) return at_first - contact.wall_velocity;
    const ImpactBody& second = bodies[static_cast<std::size_t>(contact.second)];
    return at_first - second.velocity - cross(second.spin, contact.arm_second);
}

double energy_kinetic(const ImpactBody& impact_body) {
    const double along = dot(impact_body.spin, impact_body.axis), spin2 = dot(impact_body.spin, impact_body.spin);
    return 0.5 * (dot(impact_body.velocity, impact_body.velocity) / impact_body.mass_inverse +
                  std::max(0.0, spin2 - along * along) / impact_body.across_inverse +
                  along * along / impact_body.along_inverse);
}

ImpactOutcome resolve(std::span<ImpactBody> bodies, std::span<Contact> contacts, const ImpactLaw& law) {
    constexpr std::size_t few = 8;
    std::array<Frame, few> few_frames;
    std::vector<Frame> many_frames(contacts.size() > few ? contacts.size() : 0);
    const std::span<Frame> frames =
        many_frames.empty() ? std::span(few_frames).first(contacts.size()) : std::span(many_frames);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        contacts[c].impulse = {};
        frames[c] = frame_of(contacts[c], bodies);
    }
    if (std::ranges::any_of(frames, [](const Frame& frame) { return frame.response.nn == 0.0; }))
        return resolve_responding(bodies, contacts, frames, law);
    Group group{bodies, contacts, frames};
    ImpactOutcome outcome;
    outcome.approach = group.approach();
    if (outcome.approach <= rounding_of(contacts, bodies)) return {};
    if (contacts.size() == 1) {
        const Increment b = bounce_of(frames[0].response, contacts[0], group.slip(0), law);
        group.push(0, b, outcome);
        outcome.sweeps = 1;
        outcome.increments = b.evaluations;
    } else if (law.group == GroupLaw::simultaneous) {
        resolve_simultaneously(bodies, contacts, frames, law, outcome);
    } else {
        resolve_in_turn(group, law, outcome);
    }
    outcome.residual = outcome.left = group.approach();
    if (contacts.size() > 1 && outcome.left > law.tolerance * outcome.approach) {
        end_approach(group, outcome);
        outcome.residual = group.approach();
    }
    return outcome;
}

}  // namespace drover::dem
