// dem/rod_flight.cpp: a rod between base and lid.
#include "rod_flight.hpp"

#include <algorithm>
#include <array>

#include "drover/base/random.hpp"
#include "drover/dem/rotation.hpp"

namespace drover::dem {

namespace {
constexpr std::size_t bearing_most = 16;

/// A sphere of the rod over base (side +1) or under the lid (-1): its gap and how it changes.
struct PlateGap {
    std::uint32_t sphere = 0;
    double side = 1.0;
    double gap = 0.0, speed = 0.0, push = 0.0;
};
using Gaps = std::array<PlateGap, 2 * bearing_most>;

/// Gaps of all bearing spheres at the moment at which the base is `base`.
std::size_t gaps_of(const Rod& rod, const RodKind& kind, double gravity, const PlateMotion& plates, const Flight& base,
                    Gaps& gaps) {
    const Shape& shape = kind.shape;
    const double across = 1.0 / shape.inertia_across;
    // The axis goes round L: n' = L x n/I, n'' = L x n'/I.
    const Vector& l = rod.angular_momentum;
    const Vector turn = across * cross(l, rod.axis);
    const double lift = across * (l.x * turn.y - l.y * turn.x);
    std::size_t count = 0;
    for (const std::uint32_t k : kind.bearing) {
        const double a = shape.at[k], z = rod.position.z + a * rod.axis.z, speed = rod.velocity.z + a * turn.z;
        const double push = gravity + a * lift;
        gaps[count++] = {k, 1.0, z - shape.radius[k] - base.at, speed - base.speed, push - base.push};
        if (plates.lid())
            gaps[count++] = {k, -1.0, base.at + plates.gap() - z - shape.radius[k], base.speed - speed,
                             base.push - push};
    }
    return count;
}

void move(Rod& rod, const Shape& shape, const Vector& acceleration, double tau, Ledger& ledger) {
    const Vector shift = tau * rod.velocity + (0.5 * tau * tau) * acceleration;
    ledger.gravity += shape.mass * dot(acceleration, shift);
    rod.position = rod.position + shift;
    rod.velocity = rod.velocity + tau * acceleration;
    rod.axis = turned_freely(rod.axis, rod.angular_momentum, shape.inertia_across, tau);
}

/// +1 or -1 with equal chances, a pure function of (seed, rod, number of the hit).
double sign_of_kick(PlateMemory& memory, std::uint64_t number, std::uint64_t seed) {
    constexpr std::int64_t block = 32;
    if (memory.hits % block == 0) {
        double uniform = 0.0;
        fill_uniform({.seed = seed, .stream = Stream::kick, .step = static_cast<std::uint64_t>(memory.hits / block)},
                     number, 1, {&uniform, 1});
        memory.signs = static_cast<std::uint32_t>(uniform * 0x1p32);
    }
    const bool up = (memory.signs >> (memory.hits % block)) & 1u;
    ++memory.hits;
    return up ? 1.0 : -1.0;
}

/// omega_z += turn.
void kick(Mover& mover, double turn, Ledger& ledger) {
    const double before = energy_kinetic(mover);
    mover.spin.z += turn;
    ledger.kicks += energy_kinetic(mover) - before;
}

/// Takes the rod out of the plates, without changing its kinetic energy: moved and turned as impulses would.
void take_out(Rod& rod, const RodKind& kind, const PlateMotion& plates, const Flight& base, Gaps& gaps) {
    const Shape& shape = kind.shape;
    for (int round = 0; round < 4; ++round) {
        const std::size_t count = gaps_of(rod, kind, 0.0, plates, base, gaps);
        bool any = false;
        for (std::size_t i = 0; i < count; ++i) {
            const double a = shape.at[gaps[i].sphere], nz = rod.axis.z, level = 1.0 - nz * nz;
            const double z = rod.position.z + a * nz, r = shape.radius[gaps[i].sphere];
            const double gap = gaps[i].side > 0.0 ? z - r - base.at : base.at + plates.gap() - z - r;
            if (gap >= 0.0) continue;
            any = true;
            const double response = 1.0 / shape.mass + a * a * level / shape.inertia_across;
            const double push = -gap * gaps[i].side / response;
            rod.position.z += push / shape.mass;
            const double rise = a * push / shape.inertia_across;  // of the axis, across itself
            const Vector up = Vector{0.0, 0.0, 1.0} - nz * rod.axis, axis = rod.axis + rise * up;
            // The angular momentum turns with it: the same energy.
            const Vector angle = rise * cross(rod.axis, Vector{0.0, 0.0, 1.0});
            const double size = length(rod.angular_momentum);
            const Vector turned = rod.angular_momentum + cross(angle, rod.angular_momentum);
            rod.axis = 1.0 / length(axis) * axis;
            if (size > 0.0) rod.angular_momentum = size / length(turned) * turned;
        }
        if (!any) return;
    }
}
}  // namespace

Mover mover_of(const Rod& rod, const Shape& shape) {
    return {.velocity = rod.velocity,
            .spin = angular_velocity(rod.angular_momentum, rod.axis, shape.inertia_along, shape.inertia_across),
            .axis = rod.axis,
            .mass_inverse = 1.0 / shape.mass,
            .across_inverse = 1.0 / shape.inertia_across,
            .along_inverse = 1.0 / shape.inertia_along};
}

Vector angular_momentum(const Mover& mover) {
    const double along = dot(mover.spin, mover.axis);
    return 1.0 / mover.across_inverse * (mover.spin - along * mover.axis) + along / mover.along_inverse * mover.axis;
}

namespace {
/// The impact of all that touches at this moment; false when nothing approached.
bool strike(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind, const FlightRules& rules,
            const Flight& base, const Gaps& gaps, std::size_t count, Ledger& ledger, Counts& counts) {
    std::array<Contact, 2 * bearing_most> contacts;
    std::array<double, 2 * bearing_most> approach;
    std::size_t touching = 0;
    bool any = false;
    for (std::size_t i = 0; i < count; ++i) {
        if (gaps[i].gap > rules.together) continue;
        const Vector normal{0.0, 0.0, gaps[i].side};
        const Shape& shape = kind.shape;
        contacts[touching] = {.first = 0,
                              .second = -1,
                              .normal = normal,
                              .arm_first = shape.at[gaps[i].sphere] * rod.axis - shape.radius[gaps[i].sphere] * normal,
                              .arm_second = {},
                              .wall_velocity = {0.0, 0.0, base.speed},
                              .restitution = kind.restitution,
                              .friction = kind.friction,
                              .impulse = {}};
        approach[touching++] = -gaps[i].speed;
        any = any || gaps[i].speed < 0.0;
    }
    if (!any) return false;
    Mover mover = mover_of(rod, kind.shape);
    const ImpactOutcome outcome = resolve({&mover, 1}, {contacts.data(), touching}, rules.law);
    ledger.plates += outcome.walls;
    ledger.impact += outcome.normal;
    ledger.friction += outcome.friction;
    for (std::size_t i = 0; i < touching; ++i) {
        if (approach[i] <= 0.0) continue;
        if (approach[i] > counted_speed) ++counts.rod_plate;
        if (rules.kick > 0.0) kick(mover, rules.kick * approach[i] * sign_of_kick(memory, number, rules.seed), ledger);
    }
    rod.velocity = mover.velocity;
    rod.angular_momentum = angular_momentum(mover);
    return true;
}
}  // namespace

RodKind make_rod_kind(const Shape& shape, double restitution, double friction) {
    RodKind kind{.shape = shape, .bearing = {}, .restitution = restitution, .friction = friction};
    const std::size_t count = shape.at.size();
    for (std::size_t k = 0; k < count; ++k) {
        // Left out: a sphere inside the cone of two others, or not wider than one at its own place.
        bool covered = false;
        for (std::size_t i = 0; i < k && !covered; ++i)
            for (std::size_t j = k + 1; j < count && !covered; ++j) {
                const double part = (shape.at[k] - shape.at[i]) / (shape.at[j] - shape.at[i]);
                covered = shape.radius[k] <= (1.0 - part) * shape.radius[i] + part * shape.radius[j] + 1e-12;
            }
        if (!covered) kind.bearing.push_back(static_cast<std::uint32_t>(k));
    }
    require(kind.bearing.size() <= bearing_most, {},
            "a rod with {} spheres on its hull; expected at most {}: take fewer, wider ones", kind.bearing.size(),
            bearing_most);
    return kind;
}

void fly(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind, const Vector& acceleration,
         const PlateMotion& plates, double dt, const FlightRules& rules, Ledger& ledger, Counts& counts) {
    Gaps gaps;
    double now = 0.0;
    Flight base = plates.base(0.0);
    for (;;) {
        std::size_t count = gaps_of(rod, kind, acceleration.z, plates, base, gaps);
        double next = never;
        for (std::size_t i = 0; i < count; ++i)
            next = std::min(next, closing_time(gaps[i].gap, gaps[i].speed, gaps[i].push));
        next = std::max(next, rules.substep - memory.since_impact);
        if (now + next >= dt) break;
        if (next > 0.0) {
            move(rod, kind.shape, acceleration, next, ledger);
            now += next;
            memory.since_impact += next;
            base = plates.base(now);
            count = gaps_of(rod, kind, acceleration.z, plates, base, gaps);
        }
        take_out(rod, kind, plates, base, gaps);
        count = gaps_of(rod, kind, acceleration.z, plates, base, gaps);
        strike(rod, memory, number, kind, rules, base, gaps, count, ledger, counts);
        memory.since_impact = 0.0;
    }
    move(rod, kind.shape, acceleration, dt - now, ledger);
    memory.since_impact += dt - now;
}

}  // namespace drover::dem
