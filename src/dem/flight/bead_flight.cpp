// dem/flight/bead_flight.cpp: beads between base and lid.
#include "dem/flight/bead_flight.hpp"

#include <algorithm>
#include <array>

namespace drover::dem {

void bounce_on_plate(Vec4d& velocity, Vec4d& spin, double radius, double side, double plate, double restitution,
                     double friction, EnergyBalance& balance) {
    const double mass = 1.0 / velocity[3], turn = radius * spin[3];  // spin[3]: 1/inertia
    const double opening = side * (velocity[2] - plate);
    // The point of contact is at -side radius z from the centre; the slip there is v + omega x arm.
    const double sx = velocity[0] - side * radius * spin[1], sy = velocity[1] + side * radius * spin[0];
    const double slip = std::sqrt(sx * sx + sy * sy);
    const SphereImpact impact =
        sphere_impact(opening, slip, {.numerator = mass}, velocity[3] + radius * turn, restitution, friction);
    if (slip > 0.0) {
        const double px = -impact.tangential / slip * sx, py = -impact.tangential / slip * sy;
        velocity[0] += velocity[3] * px;
        velocity[1] += velocity[3] * py;
        spin[0] += side * turn * py;
        spin[1] -= side * turn * px;
    }
    velocity[2] += side * velocity[3] * impact.normal;
    balance.impact += 0.5 * impact.normal * (opening + side * (velocity[2] - plate));
    balance.friction += impact.friction_work;
    balance.plates += side * impact.normal * plate;
}

namespace {
void drift(Vec4d& position, Vec4d& velocity, const Vector& acceleration, double tau) {
    const Vec4d a{acceleration.x, acceleration.y, acceleration.z, 0.0};
    Vec4d flow = velocity;
    flow[3] = 0.0;
    position += flow * tau + a * (0.5 * tau * tau);
    velocity += a * tau;
}

/// One bead that meets a plate in this step, from its state at the start.
void fly_bead(Vec4d& position, Vec4d& velocity, Vec4d& spin, const Vector& acceleration, const PlateMotion& plates,
              PlateState base, const StepRules& rules, EnergyBalance& balance, Counts& counts) {
    const double radius = position[3], dt = rules.dt;
    double now = 0.0, min_interval = 0.0;
    for (;;) {
        const double speed = velocity[2] - base.velocity, rate = acceleration.z - base.acceleration;
        const double below = position[2] - radius - base.height,
                     above = base.height + plates.gap() - radius - position[2];
        const double to_base = closing_time(below, speed, rate);
        const double to_lid = plates.lid() ? closing_time(above, -speed, -rate) : never;
        const double next = std::max(std::min(to_base, to_lid), min_interval);
        if (now + next >= dt) break;
        drift(position, velocity, acceleration, next);
        now += next;
        base = plates.base(now);
        const double side = to_base <= to_lid ? 1.0 : -1.0;
        const double surface = side > 0.0 ? base.height + radius : base.height + plates.gap() - radius;
        if (side * (position[2] - surface) < 0.0) {
            balance.plates -= acceleration.z / velocity[3] * (surface - position[2]);
            position[2] = surface;
        }
        if (side * (velocity[2] - base.velocity) < 0.0) {
            if (side * (velocity[2] - base.velocity) < -rules.counted_plate_speed) ++counts.bead_plate;
            bounce_on_plate(velocity, spin, radius, side, base.velocity, rules.restitution.bead_plate,
                            rules.friction.bead_plate, balance);
        }
        min_interval = 0.5 * dt;  // limits the bounce rate of a bead that comes to rest on a plate
    }
    drift(position, velocity, acceleration, dt - now);
}

/// Bit k is set if sphere k of four reaches beyond base or lid.
unsigned beyond_plates(const Vec4d (&position)[4], double low, double high) {
    const Vec4d zr01 = __builtin_shufflevector(position[0], position[1], 2, 6, 3, 7),
                zr23 = __builtin_shufflevector(position[2], position[3], 2, 6, 3, 7);
    const Vec4d z = __builtin_shufflevector(zr01, zr23, 0, 1, 4, 5),
                r = __builtin_shufflevector(zr01, zr23, 2, 3, 6, 7);
    return bits((z - r < low) | (z + r > high));
}

/// Whether has_left_skin() holds for one of four spheres.
bool has_any_left_skin(const Vec4d (&position)[4], const std::array<double, 2>* listed, double square) {
    // Two neighbouring (x, y) pairs, loaded without alignment.
    using Unaligned = double __attribute__((vector_size(32), aligned(8), may_alias));
    const Vec4d at[2] = {*reinterpret_cast<const Unaligned*>(listed), *reinterpret_cast<const Unaligned*>(listed + 2)};
    Vec4d d01 = __builtin_shufflevector(position[0], position[1], 0, 1, 4, 5) - at[0];
    Vec4d d23 = __builtin_shufflevector(position[2], position[3], 0, 1, 4, 5) - at[1];
    d01 *= d01;
    d23 *= d23;
    const Vec4d squares = __builtin_shufflevector(d01, d23, 0, 4, 2, 6) + __builtin_shufflevector(d01, d23, 1, 5, 3, 7);
    return bits(squares < square) != 0xfu;
}
}  // namespace

bool fly_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateMotion& plates, const StepRules& rules,
               EnergyBalance& balance, Counts& counts) {
    BeadArrays& beads = spheres.beads;
    const double dt = rules.dt;
    const PlateState start = plates.base(0.0), end_base = plates.base(dt);
    const double low = end_base.height, high = plates.lid() ? end_base.height + plates.gap() : never;
    const double far = 0.25 * rules.skin * rules.skin;
    const Vec4d time{dt, dt, dt, 0.0}, half{0.5 * dt * dt, 0.5 * dt * dt, 0.5 * dt * dt, 0.0};
    const auto acceleration = [&](std::size_t s) { return rules.acceleration_of(beads.velocity[s][3]); };
    const auto bounce_one = [&](std::size_t s) {
        fly_bead(spheres.position[s], beads.velocity[s], beads.spin[s], vector_of(acceleration(s)), plates, start,
                 rules, balance, counts);
    };
    bool left_skin = false;
    std::size_t s = begin;
    for (; s + 4 <= end; s += 4) {  // four at a time, as most meet no plate
        Vec4d position[4], velocity[4];
        for (std::size_t k = 0; k < 4; ++k) {
            const Vec4d a = acceleration(s + k);
            velocity[k] = beads.velocity[s + k] + a * time;
            position[k] = spheres.position[s + k] + beads.velocity[s + k] * time + a * half;
        }
        const unsigned meet = beyond_plates(position, low, high);
        for (std::size_t k = 0; k < 4; ++k) {
            if (meet >> k & 1u) [[unlikely]] {
                bounce_one(s + k);
                position[k] = spheres.position[s + k];
            } else {
                spheres.position[s + k] = position[k];
                beads.velocity[s + k] = velocity[k];
            }
        }
        if (has_any_left_skin(position, &spheres.listed[s], far)) [[unlikely]]
            left_skin = true;
    }
    for (; s < end; ++s) {
        const Vec4d velocity = beads.velocity[s], a = acceleration(s);
        const Vec4d position = spheres.position[s] + velocity * time + a * half;
        if (position[2] - position[3] < low || position[2] + position[3] > high) {
            bounce_one(s);
        } else {
            spheres.position[s] = position;
            beads.velocity[s] = velocity + a * time;
        }
        left_skin = left_skin || has_left_skin(spheres.position[s], spheres.listed[s], far);
    }
    return left_skin;
}

bool drift_beads(Spheres& spheres, std::size_t begin, std::size_t end, const StepRules& rules) {
    const double far = 0.25 * rules.skin * rules.skin;
    bool left_skin = false;
    for (std::size_t s = begin; s < end; ++s) {
        Vec4d& velocity = spheres.beads.velocity[s];
        drift(spheres.position[s], velocity, vector_of(rules.acceleration_of(velocity[3])), rules.dt);
        left_skin = left_skin || has_left_skin(spheres.position[s], spheres.listed[s], far);
    }
    return left_skin;
}

}  // namespace drover::dem
