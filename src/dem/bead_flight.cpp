// dem/bead_flight.cpp: beads between base and lid.
#include "bead_flight.hpp"

#include <algorithm>
#include <array>

namespace drover::dem {

namespace {
/// The impact of a sphere on a plate of velocity `plate`: normal and slip do not feel each other.
void bounce(Lane& velocity, Lane& spin, double radius, double side, double plate, const BeadRules& rules,
            EnergyBalance& balance) {
    const double mass = 1.0 / velocity[3], turn = radius * spin[3];  // spin[3]: 1/inertia
    const double approach = side * (velocity[2] - plate);
    const double normal = -(1.0 + rules.restitution) * approach * mass;
    // Place of contact: -side radius z from the centre.  Slip there: v + omega x arm.
    const double sx = velocity[0] - side * radius * spin[1], sy = velocity[1] + side * radius * spin[0];
    const double slip = std::sqrt(sx * sx + sy * sy), response = velocity[3] + radius * turn;
    double tangential = 0.0;
    if (slip > 0.0) {
        tangential = std::min(rules.friction * normal, slip / response);
        const double px = -tangential / slip * sx, py = -tangential / slip * sy;
        velocity[0] += velocity[3] * px;
        velocity[1] += velocity[3] * py;
        spin[0] += side * turn * py;
        spin[1] -= side * turn * px;
    }
    velocity[2] += side * velocity[3] * normal;
    balance.impact += 0.5 * normal * (approach + side * (velocity[2] - plate));
    balance.friction -= tangential * (slip - 0.5 * response * tangential);
    balance.plates += side * normal * plate;
}

void drift(Lane& place, Lane& velocity, const Vector& acceleration, double tau) {
    const Lane push{acceleration.x, acceleration.y, acceleration.z, 0.0};
    Lane flow = velocity;
    flow[3] = 0.0;
    place += flow * tau + push * (0.5 * tau * tau);
    velocity += push * tau;
}

/// One bead that meets a plate in this step, from its state at the start.
void fly_bead(Lane& place, Lane& velocity, Lane& spin, const Vector& acceleration, const PlateMotion& plates,
              Flight base, double dt, const BeadRules& rules, EnergyBalance& balance, Counts& counts) {
    const double radius = place[3];
    double now = 0.0, least = 0.0;
    for (;;) {
        const double speed = velocity[2] - base.speed, push = acceleration.z - base.push;
        const double below = place[2] - radius - base.at, above = base.at + plates.gap() - radius - place[2];
        const double to_base = closing_time(below, speed, push);
        const double to_lid = plates.lid() ? closing_time(above, -speed, -push) : never;
        const double next = std::max(std::min(to_base, to_lid), least);
        if (now + next >= dt) break;
        drift(place, velocity, acceleration, next);
        now += next;
        base = plates.base(now);
        const double side = to_base <= to_lid ? 1.0 : -1.0;
        const double surface = side > 0.0 ? base.at + radius : base.at + plates.gap() - radius;
        if (side * (place[2] - surface) < 0.0) {
            balance.gravity -= acceleration.z / velocity[3] * (surface - place[2]);
            place[2] = surface;
        }
        if (side * (velocity[2] - base.speed) < 0.0) {
            if (side * (velocity[2] - base.speed) < -counted_speed) ++counts.bead_plate;
            bounce(velocity, spin, radius, side, base.speed, rules, balance);
        }
        least = 0.5 * dt;  // a bead that comes to rest on a plate hops no oftener
    }
    drift(place, velocity, acceleration, dt - now);
}
/// Which of four spheres reach beyond base or lid.
unsigned beyond_plates(const Lane (&place)[4], double low, double high) {
    const Lane zr01 = __builtin_shufflevector(place[0], place[1], 2, 6, 3, 7),
               zr23 = __builtin_shufflevector(place[2], place[3], 2, 6, 3, 7);
    const Lane z = __builtin_shufflevector(zr01, zr23, 0, 1, 4, 5), r = __builtin_shufflevector(zr01, zr23, 2, 3, 6, 7);
    return bits((z - r < low) | (z + r > high));
}

/// Whether one of four spheres is_astray().
bool is_one_astray(const Lane (&place)[4], const std::array<double, 2>* listed, double square) {
    using Loose = double __attribute__((vector_size(32), aligned(8), may_alias));  // two places, where they stand
    const Lane at[2] = {*reinterpret_cast<const Loose*>(listed), *reinterpret_cast<const Loose*>(listed + 2)};
    Lane d01 = __builtin_shufflevector(place[0], place[1], 0, 1, 4, 5) - at[0];
    Lane d23 = __builtin_shufflevector(place[2], place[3], 0, 1, 4, 5) - at[1];
    d01 *= d01;
    d23 *= d23;
    const Lane squares = __builtin_shufflevector(d01, d23, 0, 4, 2, 6) + __builtin_shufflevector(d01, d23, 1, 5, 3, 7);
    return bits(squares < square) != 0xfu;
}
}  // namespace

bool fly_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateMotion& plates, double dt,
               const BeadRules& rules, EnergyBalance& balance, Counts& counts) {
    BeadArrays& beads = spheres.beads;
    const Flight start = plates.base(0.0), end_base = plates.base(dt);
    const double low = end_base.at, high = plates.lid() ? end_base.at + plates.gap() : never;
    const double far = 0.25 * rules.skin * rules.skin;
    const Lane gravity{rules.acceleration.x, rules.acceleration.y, rules.acceleration.z, 0.0};
    const Lane force{rules.force.x, rules.force.y, rules.force.z, 0.0};
    const Lane time{dt, dt, dt, 0.0}, half{0.5 * dt * dt, 0.5 * dt * dt, 0.5 * dt * dt, 0.0};
    const auto push_on = [&](std::size_t s) { return gravity + force * beads.velocity[s][3]; };
    const auto bounce_one = [&](std::size_t s) {
        fly_bead(spheres.place[s], beads.velocity[s], beads.spin[s], vector_of(push_on(s)), plates, start, dt, rules,
                 balance, counts);
    };
    bool astray = false;
    std::size_t s = begin;
    for (; s + 4 <= end; s += 4) {  // four at a time, as most meet no plate
        Lane place[4], velocity[4];
        for (std::size_t k = 0; k < 4; ++k) {
            const Lane push = push_on(s + k);
            velocity[k] = beads.velocity[s + k] + push * time;
            place[k] = spheres.place[s + k] + beads.velocity[s + k] * time + push * half;
        }
        const unsigned meet = beyond_plates(place, low, high);
        for (std::size_t k = 0; k < 4; ++k) {
            if (meet >> k & 1u) [[unlikely]] {
                bounce_one(s + k);
                place[k] = spheres.place[s + k];
            } else {
                spheres.place[s + k] = place[k];
                beads.velocity[s + k] = velocity[k];
            }
        }
        if (is_one_astray(place, &spheres.listed[s], far)) [[unlikely]]
            astray = true;
    }
    for (; s < end; ++s) {
        const Lane velocity = beads.velocity[s], push = push_on(s);
        const Lane place = spheres.place[s] + velocity * time + push * half;
        if (place[2] - place[3] < low || place[2] + place[3] > high) {
            bounce_one(s);
        } else {
            spheres.place[s] = place;
            beads.velocity[s] = velocity + push * time;
        }
        astray = astray || is_astray(spheres.place[s], spheres.listed[s], far);
    }
    return astray;
}

}  // namespace drover::dem
