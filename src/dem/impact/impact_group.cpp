// dem/impact/impact_group.cpp: simultaneous impacts, solved for the velocities and impulses at the contacts of a
// group.
#include "dem/impact/impact_group.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>

#include "dem/impact/impact_couplings.hpp"
#include "dem/impact/impact_increment.hpp"

namespace drover::dem {

namespace {
using Memory = std::pmr::memory_resource;

/// A group of contact springs.
struct Springs {
    std::span<const Contact> contacts;
    std::span<const Frame> frames;
    const Couplings& couplings;
    const ContactVectors& before;      ///< velocities
    double inelastic_threshold = 0.0;  ///< approaches below this times 1 - e end without rebound
};

/// The course of an impact.
struct ImpactPath {
    ContactVectors slips, impulses;
    std::pmr::vector<double> stored;  ///< energy of each spring
    double normal_work = 0.0, friction_work = 0.0;
    int sweeps = 0;

    ImpactPath(const Springs& springs, Memory* memory)
        : slips(springs.before, memory),
          impulses(springs.contacts.size(), Vec4d{}, memory),
          stored(springs.contacts.size(), 0.0, memory) {}
};

/// Applies the impulse of one contact.
void apply_bounce(const Springs& springs, std::size_t c, const Bounce& bounce, ImpactPath& path) {
    springs.couplings.push(c, bounce.n, bounce.x, bounce.y, path.slips);
    path.impulses[c] += Vec4d{bounce.n, bounce.x, bounce.y, 0.0};
    path.normal_work += bounce.normal_work;
    path.friction_work += bounce.friction_work;
}

/// Stops a slow approach at once, without rebound.
void stop_approach(const Springs& springs, std::size_t c, Slip slip, ImpactPath& path) {
    const Response& w = springs.frames[c].response;
    Bounce bounce;
    bool stopped = false;
    add(increment_to_speed(w, springs.contacts[c].friction, slip, -2.0 * slip.n / w.nn, 0.0, stopped), bounce, slip);
    apply_bounce(springs, c, bounce, path);
}

/// Advances one contact by a time h of the springs' clock: compression until the approach ends, then restitution.
void advance_contact(const Springs& springs, std::size_t c, double h, double enough, ImpactPath& path) {
    double& stored = path.stored[c];
    const Vec4d& now = path.slips[c];
    Slip slip{now[0], now[1], now[2]};
    if (std::abs(slip.n) < enough) slip.n = 0.0;  // zero up to rounding
    const Response& w = springs.frames[c].response;
    if (slip.n >= 0.0 && stored * w.nn <= enough * enough) {  // it would give back a speed that is zero up to rounding
        stored = 0.0;
        return;
    }
    const Contact& contact = springs.contacts[c];
    if (stored == 0.0 && -slip.n < (1.0 - contact.restitution) * springs.inelastic_threshold)
        return stop_approach(springs, c, slip, path);
    const double mu = contact.friction, e2 = contact.restitution * contact.restitution;
    Bounce bounce;
    if (slip.n < 0.0) {
        bool reversed = false;
        const double dp = (std::sqrt(2.0 * stored) - 0.5 * slip.n * h) * h;
        const Increment part = increment_to_speed(w, mu, slip, dp, 0.0, reversed);
        stored = std::max(0.0, stored - part.normal_work);
        add(part, bounce, slip);
        h = reversed ? h * (1.0 - part.n / dp) : 0.0;
    }
    if (e2 == 0.0 && h > 0.0) stored = 0.0;  // nothing is given back: the contact ends when its approach does
    if (h > 0.0 && stored > 0.0) {
        const double energy = e2 * stored, force = std::sqrt(2.0 * stored);
        const double parting = std::max(0.0, slip.n), later = force - parting * h / std::max(e2, 1e-300);
        // When the force would end within h: all of the remaining energy, exactly.
        const double dp = later > 0.0 ? 0.5 * (force + later) * h : 2.0 * impulse_of_work(w.nn, parting, energy);
        bool ended = false;
        const Increment part = increment_to_work(w, mu, slip, dp, energy, ended);
        stored = ended || later <= 0.0 ? 0.0 : std::max(0.0, stored - part.normal_work / e2);
        add(part, bounce, slip);
    }
    apply_bounce(springs, c, bounce, path);
}

/// The largest response of a contact that is compressed or approaches: its spring has the shortest period.
double active_response(const Springs& springs, const ImpactPath& path, double rounding) {
    double max_response = 0.0;
    for (std::size_t c = 0; c < path.stored.size(); ++c)
        if (path.stored[c] > 0.0 || path.slips[c][0] < -rounding)
            max_response = std::max(max_response, springs.frames[c].response.nn);
    return max_response;
}

/// Advances all contacts until none approaches.  Within a sweep they follow one another, from the first to the last or
/// in reverse.
ImpactPath follow_impact(const Springs& springs, const ImpactLaw& law, double approach, bool ascending,
                         Memory* memory) {
    ImpactPath path(springs, memory);
    const std::size_t count = springs.contacts.size();
    const double enough = law.tolerance * approach, rounding = 1e-12 * approach;
    const auto [softest, stiffest] = std::ranges::minmax_element(springs.frames, [](const Frame& a, const Frame& b) {
        return a.response.nn < b.response.nn;
    });
    const double ratio = std::sqrt(stiffest->response.nn / softest->response.nn);  // of periods
    const int max_sweeps = static_cast<int>(std::clamp(300.0 * ratio, 3000.0, 30000.0));
    constexpr int patience = 2000;  // sweeps for which light bodies set the clock even when they are at rest
    constexpr double fastest_release = 0.05;
    for (; path.sweeps < max_sweeps; ++path.sweeps) {
        const double response =
            path.sweeps < patience ? stiffest->response.nn : active_response(springs, path, rounding);
        // A quarter of a period takes about half of `increments` sweeps; restitution is 1/e times faster.
        const double step = 3.0 / (law.increments * std::sqrt(response));
        double h = step;
        bool any = false;
        for (std::size_t c = 0; c < count; ++c) {
            const double n = path.slips[c][0];
            any = any || path.stored[c] > 0.0 || n < -enough;
            if (path.stored[c] > 0.0 && n > 0.0)
                h = std::min(h, step * std::max(springs.contacts[c].restitution, fastest_release));
        }
        if (!any) break;
        for (std::size_t i = 0; i < count; ++i)
            advance_contact(springs, ascending ? i : count - 1 - i, h, rounding, path);
    }
    return path;
}

/// Replaces one by the mean of two paths with the same start.  Its energy is the mean of theirs minus the energy of
/// half their difference.
void average(ImpactPath& one, const ImpactPath& other) {
    double apart = 0.0;
    for (std::size_t c = 0; c < one.slips.size(); ++c) {
        const Vec4d d = 0.25 * (one.impulses[c] - other.impulses[c]) * (one.slips[c] - other.slips[c]);
        apart += 0.5 * (d[0] + d[1] + d[2]);
        one.impulses[c] = 0.5 * (one.impulses[c] + other.impulses[c]);
    }
    one.normal_work = 0.5 * (one.normal_work + other.normal_work) - apart;
    one.friction_work = 0.5 * (one.friction_work + other.friction_work);
    one.sweeps += other.sweeps;
}

bool is_elastic(std::span<const Contact> contacts) {
    return std::ranges::all_of(contacts, [](const Contact& c) { return c.restitution == 1.0 && c.friction == 0.0; });
}

/// Scales the impulses of a lossless group so that it loses nothing: impulses p that change normal velocities from u to
/// u + w do the work p.u + p.w/2, which is zero for s p with s = -p.u/(p.w/2).
void restore_energy(const Springs& springs, ImpactPath& path) {
    path.slips = springs.before;
    for (std::size_t c = 0; c < path.impulses.size(); ++c)
        springs.couplings.push(c, path.impulses[c][0], 0.0, 0.0, path.slips);
    double first = 0.0, second = 0.0;
    for (std::size_t c = 0; c < path.impulses.size(); ++c) {
        const double before = springs.before[c][0], impulse = path.impulses[c][0];
        first += impulse * before;
        second += 0.5 * impulse * (path.slips[c][0] - before);
    }
    const double stretch = second > 0.0 ? -first / second : 1.0;
    for (Vec4d& impulse : path.impulses) impulse *= stretch;
    path.normal_work = stretch * first + stretch * stretch * second;
}
}  // namespace

void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome) {
    alignas(32) std::array<std::byte, 8192> few;  // enough for six contacts
    std::pmr::monotonic_buffer_resource memory(few.data(), few.size());
    const Couplings couplings(bodies, contacts, frames, &memory);
    ContactVectors before(contacts.size(), Vec4d{}, &memory);
    for (std::size_t c = 0; c < contacts.size(); ++c)
        for (std::size_t i = 0; i < 3; ++i) before[c][i] = velocity_along(contacts[c], frames[c], i, bodies);
    const Springs springs{.contacts = contacts,
                          .frames = frames,
                          .couplings = couplings,
                          .before = before,
                          .inelastic_threshold = law.inelastic_threshold * outcome.approach};
    ImpactPath mean = follow_impact(springs, law, outcome.approach, true, &memory);
    average(mean, follow_impact(springs, law, outcome.approach, false, &memory));
    if (is_elastic(contacts)) restore_energy(springs, mean);
    outcome.normal = mean.normal_work;
    outcome.friction = mean.friction_work;
    outcome.sweeps = mean.sweeps;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const Vec4d& p = mean.impulses[c];
        contacts[c].impulse = apply(contacts[c], frames[c], p[0], p[1], p[2], bodies);
        if (contacts[c].second < 0) outcome.walls += dot(contacts[c].impulse, contacts[c].wall_velocity);
    }
}

}  // namespace drover::dem
