// dem/flight/rod_flight.cpp: a rod between base and lid.
#include "dem/flight/rod_flight.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "dem/bodies/rotation.hpp"
#include "drover/base/random.hpp"

namespace drover::dem {

namespace {
/// Gaps of all bearing spheres when the base is at `base`.
void find_gaps(const Rod& rod, const RodKind& kind, double gravity, const PlateMotion& plates, const PlateState& base,
               std::vector<PlateGap>& gaps) {
    const Shape& shape = kind.shape;
    const double across = 1.0 / shape.inertia_across;
    // The axis precesses about L: n' = L x n/I, n'' = L x n'/I.
    const Vector& l = rod.angular_momentum;
    const Vector turn = across * cross(l, rod.axis);
    const double lift = across * (l.x * turn.y - l.y * turn.x);
    gaps.clear();
    for (const std::uint32_t k : kind.bearing) {
        const double a = shape.at[k], z = rod.position.z + a * rod.axis.z, speed = rod.velocity.z + a * turn.z;
        const double acceleration = gravity + a * lift;
        gaps.push_back(
            {k, 1.0, z - shape.radius[k] - base.height, speed - base.velocity, acceleration - base.acceleration});
        if (plates.lid())
            gaps.push_back({k, -1.0, base.height + plates.gap() - z - shape.radius[k], base.velocity - speed,
                            base.acceleration - acceleration});
    }
}

/// +1 or -1 with equal probability, a pure function of (seed, rod, number of the hit).
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

/// Removes overlaps of the rod with the plates.  The rod moves and turns as impulses at the contacts would move it; its
/// kinetic energy stays, and what it gains in height is work of the plates.
void remove_plate_overlaps(Rod& rod, const RodKind& kind, const Vector& acceleration, const PlateMotion& plates,
                           const PlateState& base, EnergyBalance& balance) {
    const Shape& shape = kind.shape;
    const double middle = base.height + 0.5 * plates.gap(), half = 0.5 * plates.gap();
    const Vector upright{0.0, 0.0, 1.0};
    for (int round = 0; round < 4; ++round) {
        bool any = false;
        for (const std::uint32_t k : kind.bearing) {
            const double a = shape.at[k], nz = rod.axis.z, z = rod.position.z + a * nz;
            const double side = plates.lid() && z > middle ? -1.0 : 1.0;
            const double gap = half - shape.radius[k] + side * (z - middle);
            if (gap >= 0.0) continue;
            any = true;
            const double shift = -side * gap / (1.0 / shape.mass + a * a * (1.0 - nz * nz) / shape.inertia_across);
            rod.position.z += shift / shape.mass;
            balance.gravity += acceleration.z * shift;
            balance.plates -= acceleration.z * shift;
            const double rise = a * shift / shape.inertia_across;  // of the axis, across itself
            const Vector axis = rod.axis + rise * (upright - nz * rod.axis);
            // The angular momentum turns with the axis, which keeps the energy.
            const Vector before = rod.axis, l = rod.angular_momentum;
            rod.axis = 1.0 / length(axis) * axis;
            const Vector turn = cross(before, rod.axis), change = cross(turn, l);
            rod.angular_momentum = l + change + 1.0 / (1.0 + dot(before, rod.axis)) * cross(turn, change);
        }
        if (!any) return;
    }
}

/// The impact of all contacts that are closed now, and of those that overlapped: removing an overlap leaves a gap.
void resolve_plate_impact(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind,
                          const StepRules& rules, const PlateState& base, FlightSpace& space, EnergyBalance& balance,
                          Counts& counts) {
    space.contacts.clear();
    space.approach.clear();
    bool any = false;
    for (std::size_t n = 0; n < space.gaps.size(); ++n) {
        const PlateGap& gap = space.gaps[n];
        if (gap.gap > rules.simultaneity_gap && space.overlapped[n] == 0) continue;
        space.contacts.push_back(plate_contact(rod, kind, gap.sphere, gap.side, base));
        space.approach.push_back(-gap.speed);
        any = any || gap.speed < 0.0;
    }
    if (!any) return;
    ImpactBody body = impact_body_of(rod, kind.shape);
    const ImpactOutcome outcome = resolve({&body, 1}, space.contacts, rules.law);
    balance.plates += outcome.walls;
    balance.impact += outcome.normal;
    balance.friction += outcome.friction;
    for (const double approach : space.approach) {
        if (approach <= 0.0) continue;
        if (approach > rules.counted_plate_speed) ++counts.rod_plate;
        if (rules.kick > 0.0) kick_spin(body, rules.kick * approach, memory, number, rules.seed, balance);
    }
    rod.velocity = body.velocity;
    rod.angular_momentum = angular_momentum(body);
}
}  // namespace

ImpactBody impact_body_of(const Rod& rod, const Shape& shape) {
    return {.velocity = rod.velocity,
            .spin = angular_velocity(rod, shape),
            .axis = rod.axis,
            .mass_inverse = 1.0 / shape.mass,
            .across_inverse = 1.0 / shape.inertia_across,
            .along_inverse = 1.0 / shape.inertia_along};
}

Vector angular_momentum(const ImpactBody& body) {
    const double along = dot(body.spin, body.axis);
    return 1.0 / body.across_inverse * (body.spin - along * body.axis) + along / body.along_inverse * body.axis;
}

void drift_rod(Rod& rod, const Shape& shape, const Vector& acceleration, double tau, EnergyBalance& balance) {
    const Vector shift = tau * rod.velocity + (0.5 * tau * tau) * acceleration;
    balance.gravity += shape.mass * dot(acceleration, shift);
    rod.position = rod.position + shift;
    rod.velocity = rod.velocity + tau * acceleration;
    rod.axis = turned_freely(rod.axis, rod.angular_momentum, shape.inertia_across, tau);
}

void kick_spin(ImpactBody& rod, double size, PlateMemory& memory, std::uint64_t number, std::uint64_t seed,
               EnergyBalance& balance) {
    const double before = energy_kinetic(rod);
    rod.spin.z += size * sign_of_kick(memory, number, seed);
    balance.kicks += energy_kinetic(rod) - before;
}

RodKind make_rod_kind(const Shape& shape, double restitution, double friction, bool all_bear) {
    RodKind kind{.shape = shape, .restitution = restitution, .friction = friction};
    const std::size_t count = shape.at.size();
    for (std::size_t k = 0; k < count; ++k) {
        // A sphere inside the cone of two others does not reach the hull.
        bool covered = false;
        for (std::size_t i = 0; i < k && !covered && !all_bear; ++i)
            for (std::size_t j = k + 1; j < count && !covered; ++j) {
                const double part = (shape.at[k] - shape.at[i]) / (shape.at[j] - shape.at[i]);
                covered = shape.radius[k] <= (1.0 - part) * shape.radius[i] + part * shape.radius[j] + 1e-12;
            }
        if (covered) continue;
        const std::size_t place = kind.bearing.size() % 4;
        if (place == 0) {
            constexpr double none = -infinite;
            kind.at.emplace_back();
            kind.radius.push_back(Vec4d{none, none, none, none});
        }
        kind.at.back()[place] = shape.at[k];
        kind.radius.back()[place] = shape.radius[k];
        kind.bearing.push_back(static_cast<std::uint32_t>(k));
    }
    return kind;
}

void fly_rod(Rod& rod, PlateMemory& memory, std::uint64_t number, const RodKind& kind, const Vector& acceleration,
             const PlateMotion& plates, const StepRules& rules, FlightSpace& space, EnergyBalance& balance,
             Counts& counts) {
    const double dt = rules.dt;
    double now = 0.0;
    PlateState base = plates.base(0.0);
    for (;;) {
        find_gaps(rod, kind, acceleration.z, plates, base, space.gaps);
        double next = never;
        for (const PlateGap& gap : space.gaps)
            next = std::min(next, closing_time(gap.gap, gap.speed, gap.acceleration));
        next = std::max(next, rules.substep - memory.since_impact);
        if (now + next >= dt) break;
        if (next > 0.0) {
            drift_rod(rod, kind.shape, acceleration, next, balance);
            now += next;
            base = plates.base(now);
        }
        find_gaps(rod, kind, acceleration.z, plates, base, space.gaps);
        space.overlapped.clear();
        for (const PlateGap& gap : space.gaps) space.overlapped.push_back(gap.gap < 0.0 ? 1 : 0);
        if (std::ranges::count(space.overlapped, 1) > 0) {
            remove_plate_overlaps(rod, kind, acceleration, plates, base, balance);
            find_gaps(rod, kind, acceleration.z, plates, base, space.gaps);
        }
        resolve_plate_impact(rod, memory, number, kind, rules, base, space, balance, counts);
        memory.since_impact = 0.0;
    }
    drift_rod(rod, kind.shape, acceleration, dt - now, balance);
    memory.since_impact += dt - now;
}

}  // namespace drover::dem
