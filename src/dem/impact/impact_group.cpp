// dem/impact/impact_group.cpp: simultaneous impacts, solved for the velocities and impulses at the contacts of a
// group, and a frictionless inelastic impact of a group, by an active set.
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory_resource>

#include "dem/bodies/vec4d.hpp"
#include "dem/impact/impact_increment.hpp"

namespace drover::dem {

namespace {
using Memory = std::pmr::memory_resource;
using ContactVectors = std::pmr::vector<Vec4d>;  ///< of each contact: components along its normal and its tangents

/// One of the bodies of a contact.
struct Side {
    int body = -1;
    double sign = 0.0;
    const Lever* lever = nullptr;
};
std::array<Side, 2> sides_of(const Contact& contact, const Frame& frame) {
    return {Side{contact.first, 1.0, &frame.first}, Side{contact.second, -1.0, &frame.second}};
}

/// Changes of the velocities at contact `at` by unit impulses of another contact along its normal and tangents.
struct Coupling {
    std::size_t at = 0;
    std::array<Vec4d, 3> change{};
};

/// For each contact, the couplings to all contacts that share a body with it, itself included.
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
    void push(std::size_t by, double n, double x, double y, ContactVectors& slips) const {
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
void apply_bounce(const Springs& springs, std::size_t c, const Increment& bounce, ImpactPath& path) {
    springs.couplings.push(c, bounce.n, bounce.x, bounce.y, path.slips);
    path.impulses[c] += Vec4d{bounce.n, bounce.x, bounce.y, 0.0};
    path.normal_work += bounce.normal_work;
    path.friction_work += bounce.friction_work;
}

/// Stops a slow approach at once, without rebound.
void stop_approach(const Springs& springs, std::size_t c, const Slip& slip, ImpactPath& path) {
    const Response& w = springs.frames[c].response;
    bool stopped = false;
    apply_bounce(springs, c,
                 increment_to_speed(w, springs.contacts[c].friction, slip, -2.0 * slip.n / w.nn, 0.0, stopped), path);
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
    Increment bounce{.after = slip};
    if (slip.n < 0.0) {
        bool reversed = false;
        const double dp = (std::sqrt(2.0 * stored) - 0.5 * slip.n * h) * h;
        bounce = increment_to_speed(w, mu, slip, dp, 0.0, reversed);
        stored = std::max(0.0, stored - bounce.normal_work);
        h = reversed ? h * (1.0 - bounce.n / dp) : 0.0;
    }
    if (e2 == 0.0 && h > 0.0) stored = 0.0;  // nothing is given back: the contact ends when its approach does
    if (h > 0.0 && stored > 0.0) {
        const double energy = e2 * stored, force = std::sqrt(2.0 * stored);
        const double parting = std::max(0.0, bounce.after.n), later = force - parting * h / std::max(e2, 1e-300);
        // When the force would end within h: all of the remaining energy, exactly.
        const double dp = later > 0.0 ? 0.5 * (force + later) * h : 2.0 * impulse_of_work(w.nn, parting, energy);
        bool ended = false;
        const Increment part = increment_to_work(w, mu, bounce.after, dp, energy, ended);
        stored = ended || later <= 0.0 ? 0.0 : std::max(0.0, stored - part.normal_work / e2);
        add(part, bounce);
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

/// Change of the velocity along each normal by a unit impulse along each.
Eigen::MatrixXd normal_responses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                 std::span<const Frame> frames) {
    Memory* const memory = std::pmr::get_default_resource();
    const Couplings couplings(bodies, contacts, frames, memory);
    const auto count = static_cast<Eigen::Index>(contacts.size());
    Eigen::MatrixXd responses(count, count);
    for (Eigen::Index by = 0; by < count; ++by) {
        ContactVectors changes(contacts.size(), Vec4d{}, memory);
        couplings.push(static_cast<std::size_t>(by), 1.0, 0.0, 0.0, changes);
        for (Eigen::Index at = 0; at < count; ++at) responses(at, by) = changes[static_cast<std::size_t>(at)][0];
    }
    return responses;
}

/// The p >= 0 with the least p.u + p.A p/2, for a positive definite A: Lawson & Hanson, Solving Least Squares Problems
/// (1974), ch. 23.
Eigen::VectorXd least_energy(const Eigen::MatrixXd& a, const Eigen::VectorXd& u) {
    Eigen::VectorXd p = Eigen::VectorXd::Zero(u.size());
    std::vector<Eigen::Index> active;
    const double rounding = 1e-15 * u.lpNorm<Eigen::Infinity>();
    const double enough = std::max(1e-10 * -u.minCoeff(), rounding);
    for (Eigen::Index round = 0; round < 10 * u.size(); ++round) {
        const Eigen::VectorXd after = u + a * p;
        Eigen::Index next = -1;
        for (Eigen::Index c = 0; c < u.size(); ++c)
            if (std::ranges::find(active, c) == active.end() && after[c] < -enough &&
                (next < 0 || after[c] < after[next]))
                next = c;
        if (next < 0) break;
        active.push_back(next);
        while (!active.empty()) {
            const Eigen::VectorXd wanted = a(active, active).ldlt().solve(-u(active));
            double fraction = 1.0;  // of the way to `wanted` until a contact would pull
            for (std::size_t k = 0; k < active.size(); ++k)
                if (const double now = p[active[k]], then = wanted[static_cast<Eigen::Index>(k)]; then <= 0.0)
                    fraction = std::min(fraction, now / (now - then));
            for (std::size_t k = 0; k < active.size(); ++k)
                p[active[k]] += fraction * (wanted[static_cast<Eigen::Index>(k)] - p[active[k]]);
            if (fraction == 1.0) break;
            std::erase_if(active, [&](Eigen::Index c) {
                const bool pulls = p[c] <= 1e-14 * p.lpNorm<Eigen::Infinity>();
                if (pulls) p[c] = 0.0;
                return pulls;
            });
        }
    }
    return p;
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
    if (std::ranges::all_of(contacts, [](const Contact& c) { return c.restitution == 1.0 && c.friction == 0.0; }))
        restore_energy(springs, mean);
    outcome.normal = mean.normal_work;
    outcome.friction = mean.friction_work;
    outcome.sweeps = mean.sweeps;
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const Vec4d& p = mean.impulses[c];
        contacts[c].impulse = apply(contacts[c], frames[c], p[0], p[1], p[2], bodies);
        if (contacts[c].second < 0) outcome.walls += dot(contacts[c].impulse, contacts[c].wall_velocity);
    }
}

std::vector<double> inelastic_impulses(std::span<const ImpactBody> bodies, std::span<const Contact> contacts,
                                       std::span<const Frame> frames, std::span<const double> velocities) {
    Eigen::MatrixXd a = normal_responses(bodies, contacts, frames);
    const Eigen::VectorXd scale = a.diagonal().cwiseSqrt().cwiseInverse();
    a = (scale.asDiagonal() * a * scale.asDiagonal()).eval();
    // Makes the impulses unique: contacts in one place share theirs, and those that do nothing are zero.
    constexpr double regularisation = 1e-13, max_ratio = 1e9;
    a.diagonal().array() += regularisation;
    const Eigen::VectorXd u = scale.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(velocities.data(), scale.size()));
    const Eigen::VectorXd p = least_energy(a, u);
    if (!(p.maxCoeff() <= max_ratio * u.lpNorm<Eigen::Infinity>())) return {};
    const Eigen::VectorXd impulses = scale.cwiseProduct(p);
    return {impulses.begin(), impulses.end()};
}

}  // namespace drover::dem
