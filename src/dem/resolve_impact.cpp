// dem/resolve_impact.cpp: the impulses of a single contact and of a group.
#include "drover/dem/impact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "impact_group.hpp"
#include "impact_increment.hpp"
#include "sphere_impact.hpp"

namespace drover::dem {

namespace {
/// Friction keeps the direction of the slip before the impact, and is at most what stops the slip without the normal
/// impulse.
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

/// The impact of a contact for which is_sphere_like() holds.
Bounce bounce_sphere(const Response& w, const Contact& contact, const Slip& slip) {
    const double size = std::sqrt(slip.x * slip.x + slip.y * slip.y);
    const SphereImpact impact =
        sphere_impact(slip.n, size, {.denominator = w.nn}, w.xx, contact.restitution, contact.friction);
    Bounce bounce{.n = impact.normal, .normal_work = 0.5 * impact.normal * (slip.n + (slip.n + w.nn * impact.normal))};
    if (size > 0.0) {
        bounce.x = -impact.tangential / size * slip.x;
        bounce.y = -impact.tangential / size * slip.y;
        bounce.friction_work = impact.friction_work;
    }
    return bounce;
}

/// Number of increments needed to follow the turning of the slip: one where it keeps its direction.
int increments_needed(const Response& w, const Contact& contact, const Slip& slip, int max_increments) {
    if (contact.friction == 0.0) return 1;
    const double impulse = -(1.0 + contact.restitution) * slip.n / w.nn;
    const double change = impulse * (std::sqrt(w.nx * w.nx + w.ny * w.ny) + contact.friction * std::max(w.xx, w.yy));
    const double size = std::sqrt(slip.x * slip.x + slip.y * slip.y),
                 wanted = std::ceil(2.0 * max_increments * change / std::max(size, 1e-300));
    return wanted >= max_increments ? max_increments : std::max(1, static_cast<int>(wanted));
}

/// The impact of one approaching contact.
Bounce bounce_of(const Response& w, const Contact& contact, Slip slip, const ImpactLaw& law) {
    if (!law.track_slip) return bounce_plain(w, contact, slip);
    if (is_sphere_like(w)) return bounce_sphere(w, contact, slip);
    Bounce bounce;
    const double before = slip.n, e = contact.restitution, mu = contact.friction;
    const double part = -before / w.nn / increments_needed(w, contact, slip, law.increments);
    const int max_rounds = 100 * law.increments;
    bool reached = false;
    for (int round = 0; round < max_rounds && !reached; ++round)
        add(increment_to_speed(w, mu, slip, part, 0.0, reached), bounce, slip);
    const double taken = -bounce.normal_work, pressed = bounce.n;
    double given = 0.0;
    reached = e == 0.0;
    for (int round = 0; round < max_rounds && !reached; ++round) {
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
    void push(std::size_t c, const Bounce& bounce, ImpactOutcome& outcome) {
        const Vector impulse = apply(contacts[c], frames[c], bounce.n, bounce.x, bounce.y, bodies);
        contacts[c].impulse = contacts[c].impulse + impulse;
        outcome.normal += bounce.normal_work;
        outcome.friction += bounce.friction_work;
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
    Group group{bodies, contacts, frames};
    ImpactOutcome outcome;
    outcome.approach = group.approach();
    if (outcome.approach <= 0.0) return outcome;
    if (contacts.size() == 1) {
        const Bounce b = bounce_of(frames[0].response, contacts[0], group.slip(0), law);
        group.push(0, b, outcome);
        outcome.sweeps = 1;
    } else if (law.group == GroupLaw::simultaneous) {
        resolve_simultaneously(bodies, contacts, frames, law, outcome);
    } else {
        resolve_in_turn(group, law, outcome);
    }
    outcome.residual = group.approach();
    return outcome;
}

}  // namespace drover::dem
