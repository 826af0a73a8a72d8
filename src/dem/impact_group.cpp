// dem/impact_group.cpp: the springs of a group, in the space of its contacts: velocities and impulses there, and the response that joins them.
#include "impact_group.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>
#include <vector>

#include "impact_increment.hpp"
#include "vec4d.hpp"

namespace drover::dem {

namespace {
using Memory = std::pmr::memory_resource;
using Vec4dList = std::pmr::vector<Vec4d>;  // of each contact, along its normal and its tangents

/// One body of a contact: what the contact's frame does there.
struct Side {
    int body = -1;
    double sign = 0.0;
    const Lever* lever = nullptr;
};
std::array<Side, 2> sides_of(const Contact& contact, const Frame& frame) {
    return {Side{contact.first, 1.0, &frame.first}, Side{contact.second, -1.0, &frame.second}};
}

/// The velocities at contact `at` that unit impulses of another along its normal and tangents make.
struct Coupling {
    std::size_t at = 0;
    std::array<Vec4d, 3> change{};
};

/// For each contact, all those that it shares a body with, itself among them.
class Couplings {
public:
    Couplings(std::span<const ImpactBody> bodies, std::span<const Contact> contacts, std::span<const Frame> frames,
              Memory* memory)
        : start_(memory), all_(memory) {
        start_.reserve(contacts.size() + 1);
        all_.reserve(3 * contacts.size());
        for (std::size_t by = 0; by < contacts.size(); ++by) {
            start_.push_back(all_.size());
            for (std::size_t at = 0; at < contacts.size(); ++at) add(bodies, contacts, frames, by, at);
        }
        start_.push_back(all_.size());
    }
    /// Changes the velocities at all contacts by an impulse at one.
    void push(std::size_t by, double n, double x, double y, Vec4dList& slips) const {
        for (std::size_t k = start_[by]; k < start_[by + 1]; ++k) {
            const Coupling& to = all_[k];
            slips[to.at] += n * to.change[0] + x * to.change[1] + y * to.change[2];
        }
    }

private:
    void add(std::span<const ImpactBody> bodies, std::span<const Contact> contacts, std::span<const Frame> frames,
             std::size_t by, std::size_t at) {
        Coupling coupling{.at = at};
        bool shared = false;
        for (const Side& here : sides_of(contacts[at], frames[at]))
            for (const Side& there : sides_of(contacts[by], frames[by])) {
                if (here.body < 0 || here.body != there.body) continue;
                shared = true;
                const double sign = here.sign * there.sign,
                             inverse = bodies[static_cast<std::size_t>(here.body)].mass_inverse;
                for (std::size_t j = 0; j < 3; ++j)
                    for (std::size_t i = 0; i < 3; ++i)
                        coupling.change[j][i] += sign * (inverse * dot(frames[at].axes[i], frames[by].axes[j]) +
                                                         dot(here.lever->turn[i], there.lever->spin[j]));
            }
        if (shared) all_.push_back(coupling);
    }

    std::pmr::vector<std::size_t> start_;
    std::pmr::vector<Coupling> all_;
};

/// A group with all that its springs need.
struct Springs {
    std::span<const Contact> contacts;
    std::span<const Frame> frames;
    const Couplings& couplings;
    const Vec4dList& before;           ///< velocities
    double inelastic_threshold = 0.0;  ///< approaches below this times 1 - e end without rebound
};

/// One way through the impact.
struct Passage {
    Vec4dList slips, impulses;
    std::pmr::vector<double> stored;  ///< work in each spring
    double normal_work = 0.0, friction_work = 0.0;
    int sweeps = 0;

    Passage(const Springs& springs, Memory* memory)
        : slips(springs.before, memory),
          impulses(springs.contacts.size(), Vec4d{}, memory),
          stored(springs.contacts.size(), 0.0, memory) {}
};

/// Changes all velocities by what one contact gave.
void take(const Springs& springs, std::size_t c, const Bounce& bounce, Passage& passage) {
    springs.couplings.push(c, bounce.n, bounce.x, bounce.y, passage.slips);
    passage.impulses[c] += Vec4d{bounce.n, bounce.x, bounce.y, 0.0};
    passage.normal_work += bounce.normal_work;
    passage.friction_work += bounce.friction_work;
}

/// Ends a slow approach at once and without rebound.
void stop(const Springs& springs, std::size_t c, Slip slip, Passage& passage) {
    const Response& w = springs.frames[c].response;
    Bounce bounce;
    bool stopped = false;
    add(increment_to_speed(w, springs.contacts[c].friction, slip, -2.0 * slip.n / w.nn, 0.0, stopped), bounce, slip);
    take(springs, c, bounce, passage);
}

/// One contact over a time h of the springs' own clock: pressed until it turns, then giving back.
void press(const Springs& springs, std::size_t c, double h, double enough, Passage& passage) {
    double& stored = passage.stored[c];
    const Vec4d& now = passage.slips[c];
    Slip slip{now[0], now[1], now[2]};
    if (std::abs(slip.n) < enough) slip.n = 0.0;  // turned, but for rounding
    if (slip.n >= 0.0 && stored == 0.0) return;
    const Contact& contact = springs.contacts[c];
    if (stored == 0.0 && -slip.n < (1.0 - contact.restitution) * springs.inelastic_threshold)
        return stop(springs, c, slip, passage);
    const double mu = contact.friction, e2 = contact.restitution * contact.restitution;
    const Response& w = springs.frames[c].response;
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
    take(springs, c, bounce, passage);
}

/// All contacts together, pressed one after another in each moment: as they stand, or the other way round.
Passage press_all(const Springs& springs, const ImpactLaw& law, double approach, bool forth, Memory* memory) {
    Passage passage(springs, memory);
    const std::size_t count = springs.contacts.size();
    const double enough = law.tolerance * approach, rounding = 1e-12 * approach;
    double stiffest = 0.0;
    for (const Frame& frame : springs.frames) stiffest = std::max(stiffest, frame.response.nn);
    // A quarter of a period takes about half of `increments` sweeps; one that gives back is 1/e times faster.
    const double step = 3.0 / (law.increments * std::sqrt(stiffest));
    constexpr double fastest_release = 0.05;
    constexpr int max_sweeps = 3000;
    for (; passage.sweeps < max_sweeps; ++passage.sweeps) {
        double h = step;
        bool any = false;
        for (std::size_t c = 0; c < count; ++c) {
            const double n = passage.slips[c][0];
            any = any || passage.stored[c] > 0.0 || n < -enough;
            if (passage.stored[c] > 0.0 && n > 0.0)
                h = std::min(h, step * std::max(springs.contacts[c].restitution, fastest_release));
        }
        if (!any) break;
        for (std::size_t i = 0; i < count; ++i) press(springs, forth ? i : count - 1 - i, h, rounding, passage);
    }
    return passage;
}

/// The mean of two impacts from one start.  Its energy is the mean of theirs, less that of half their difference: half the impulses that differ
/// times half the velocities that do.
void take_mean(Passage& one, const Passage& other) {
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
    return std::all_of(contacts.begin(), contacts.end(),
                       [](const Contact& c) { return c.restitution == 1.0 && c.friction == 0.0; });
}

/// Stretches the impulses of a group that may lose nothing until it has lost nothing: impulses p that change normal velocities from u to u + w
/// do the work p.u + p.w/2, which is zero for s p with s = -p.u/(p.w/2).
void give_back(const Springs& springs, Passage& passage) {
    passage.slips = springs.before;
    for (std::size_t c = 0; c < passage.impulses.size(); ++c)
        springs.couplings.push(c, passage.impulses[c][0], 0.0, 0.0, passage.slips);
    double first = 0.0, second = 0.0;
    for (std::size_t c = 0; c < passage.impulses.size(); ++c) {
        const double before = springs.before[c][0], impulse = passage.impulses[c][0];
        first += impulse * before;
        second += 0.5 * impulse * (passage.slips[c][0] - before);
    }
    const double stretch = second > 0.0 ? -first / second : 1.0;
    for (Vec4d& impulse : passage.impulses) impulse *= stretch;
    passage.normal_work = stretch * first + stretch * stretch * second;
}
}  // namespace

void resolve_simultaneously(std::span<ImpactBody> bodies, std::span<Contact> contacts, std::span<const Frame> frames,
                            const ImpactLaw& law, ImpactOutcome& outcome) {
    alignas(32) std::array<std::byte, 8192> few;  // what up to half a dozen contacts need
    std::pmr::monotonic_buffer_resource memory(few.data(), few.size());
    const Couplings couplings(bodies, contacts, frames, &memory);
    Vec4dList before(contacts.size(), Vec4d{}, &memory);
    for (std::size_t c = 0; c < contacts.size(); ++c)
        for (std::size_t i = 0; i < 3; ++i) before[c][i] = velocity_along(contacts[c], frames[c], i, bodies);
    const Springs springs{.contacts = contacts,
                          .frames = frames,
                          .couplings = couplings,
                          .before = before,
                          .inelastic_threshold = law.inelastic_threshold * outcome.approach};
    Passage mean = press_all(springs, law, outcome.approach, true, &memory);
    take_mean(mean, press_all(springs, law, outcome.approach, false, &memory));
    if (is_elastic(contacts)) give_back(springs, mean);
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
