// dem/contact/pairwise_contacts.cpp: one impulse for each contact that overlaps and approaches.
#include "dem/contact/pairwise_contacts.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "dem/bodies/rotation.hpp"
#include "dem/contact/contact_report.hpp"
#include "dem/impact/impact_increment.hpp"
#include "drover/base/random.hpp"

namespace drover::dem {

namespace {
/// Resolves an approaching contact and adds its work to the balance.  Returns its approach, or 0 for none.
double resolve_contact(const PairwiseLaw& law, Contact& contact, std::span<ImpactBody> bodies, ContactReport& report) {
    // Not ">= 0": without a normal, at a distance of 0, nothing happens.
    if (!(dot(relative_velocity(contact, bodies), contact.normal) < 0.0)) return 0.0;
    const Frame frame = frame_of(contact, bodies);
    const Slip slip{velocity_along(contact, frame, 0, bodies), velocity_along(contact, frame, 1, bodies),
                    velocity_along(contact, frame, 2, bodies)};
    if (slip.n >= 0.0 || frame.response.nn == 0.0) return 0.0;
    const PairwiseImpulse impulse = law.friction(frame.response, contact.restitution, contact.friction, slip);
    Increment part{.after = slip};
    add_impulse(frame.response, impulse.n, impulse.x, impulse.y, part);
    contact.impulse = apply(contact, frame, impulse.n, impulse.x, impulse.y, bodies);
    report.balance.impact += part.normal_work;
    report.balance.friction += part.friction_work;
    if (contact.second < 0) report.balance.plates += dot(contact.impulse, contact.wall_velocity);
    if (impulse.limited) ++report.counts.limited;
    return -slip.n;
}

/// Records an overlap with base (side +1) or lid if it is the deepest.
void record_plate(const Spheres& spheres, std::uint32_t sphere, double side, double depth, double approach,
                  ContactReport& report) {
    const double radius = spheres.position[sphere][3];
    if (depth <= report.depth * radius) return;
    const std::uint32_t plate = side > 0.0 ? Overlap::base : Overlap::lid;
    const Vector normal{0.0, 0.0, side};
    report.depth = depth / radius;
    report.deepest = {.first = sphere,
                      .second = plate,
                      .first_body = spheres.body(sphere),
                      .second_body = plate,
                      .apart = (radius - depth) * normal,
                      .reach = radius,
                      .normal = normal};
    report.closing = approach;
}

/// The contact of a bead with base (side +1) or lid.
void bounce_bead(Spheres& spheres, std::uint32_t s, double side, double depth, double plate, const StepRules& rules,
                 ContactReport& report) {
    const double opening = side * (spheres.beads.velocity[s][2] - plate);
    record_plate(spheres, s, side, depth, -opening, report);
    if (opening >= 0.0) return;
    if (opening < -rules.counted_plate_speed) ++report.counts.bead_plate;
    bounce_on_plate(spheres.beads.velocity[s], spheres.beads.spin[s], spheres.position[s][3], side, plate,
                    rules.restitution.bead_plate, rules.friction.bead_plate, report.balance);
}

/// One step of a rod: the velocity first, then the position with the new velocity.  The gravity's work is that on the
/// velocity, which is less than that on the displacement by m a^2 h^2/2.
void move_freely(Rod& rod, const Shape& shape, const Vector& acceleration, double h, EnergyBalance& balance) {
    const Vector change = h * acceleration;
    balance.gravity += shape.mass * dot(change, rod.velocity + 0.5 * change);
    rod.velocity = rod.velocity + change;
    rod.position = rod.position + h * rod.velocity;
    rod.axis = turned_freely(rod.axis, rod.angular_momentum, shape.inertia_across, h);
}

/// Overlaps of a rod with the plates, from tail to head, of each sphere the base before the lid.
void find_plates(const Rod& rod, const RodKind& kind, const PlateState& base, const PlateMotion& plates,
                 std::vector<RodPlateOverlap>& found) {
    const double low = base.height - rod.position.z,
                 high = plates.lid() ? base.height + plates.gap() - rod.position.z : never;
    found.clear();
    for (std::size_t four = 0; four < kind.at.size(); ++four) {  // at a time, as most meet no plate
        const Vec4d z = kind.at[four] * rod.axis.z, radius = kind.radius[four];
        unsigned meet = bits((z - radius < low) | (z + radius > high));
        for (; meet != 0; meet &= meet - 1) {
            const int k = std::countr_zero(meet);
            const std::uint32_t sphere = kind.bearing[4 * four + static_cast<std::size_t>(k)];
            if (z[k] - radius[k] < low) found.push_back({sphere, 1.0, low - z[k] + radius[k]});
            if (z[k] + radius[k] > high) found.push_back({sphere, -1.0, z[k] + radius[k] - high});
        }
    }
}

/// A random order, a pure function of (seed, step, part of the step, rod).
void shuffle(const RandomKey& key, std::uint64_t rod, std::vector<RodPlateOverlap>& overlaps) {
    std::vector<double> uniform(overlaps.size());
    fill_uniform(key, rod, uniform.size(), uniform);
    for (std::size_t i = overlaps.size(); i > 1; --i)
        std::swap(overlaps[i - 1],
                  overlaps[std::min(i - 1, static_cast<std::size_t>(uniform[i - 1] * static_cast<double>(i)))]);
}

/// Moves the fastest approach of overlaps[i], ... to i.
void bring_fastest(std::vector<RodPlateOverlap>& overlaps, std::size_t i, const ImpactBody& body, const Shape& shape,
                   double plate) {
    const auto opening = [&](const RodPlateOverlap& o) {
        // The arm's vertical part does not move the point of contact up or down.
        return o.side * (body.velocity.z + cross(body.spin, shape.at[o.sphere] * body.axis).z - plate);
    };
    const auto fastest =
        std::min_element(overlaps.begin() + static_cast<std::ptrdiff_t>(i), overlaps.end(),
                         [&](const RodPlateOverlap& a, const RodPlateOverlap& b) { return opening(a) < opening(b); });
    std::rotate(overlaps.begin() + static_cast<std::ptrdiff_t>(i), fastest, fastest + 1);
}

/// The contacts of a rod with the plates at one time.
void bounce_rod(const PairwiseLaw& law, Spheres& spheres, std::size_t number, const PlateState& base,
                const StepRules& rules, std::vector<RodPlateOverlap>& overlaps, ContactReport& report) {
    Rod& rod = spheres.rods.rod[number];
    const RodKind& kind = spheres.rods.kinds[spheres.rods.kind[number]];
    ImpactBody body = impact_body_of(rod, kind.shape);
    bool any = false;
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
        if (law.order == ContactOrder::fastest_first) bring_fastest(overlaps, i, body, kind.shape, base.velocity);
        const auto [k, side, depth] = overlaps[i];
        Contact contact = plate_contact(rod, kind, k, side, base);
        const double approach = resolve_contact(law, contact, {&body, 1}, report);
        record_plate(spheres, spheres.rods.first[number] + k, side, depth, approach, report);
        if (approach == 0.0) continue;
        any = true;
        if (approach > rules.counted_plate_speed) ++report.counts.rod_plate;
        if (rules.kick > 0.0)
            kick_spin(body, rules.kick * approach, spheres.rods.memory[number], number, rules.seed, report.balance);
    }
    if (!any) return;
    rod.velocity = body.velocity;
    rod.angular_momentum = angular_momentum(body);
}

/// The contact of two beads that overlap, without a frame.
void resolve_beads(const Overlap& overlap, Spheres& spheres, const StepRules& rules, ContactReport& report) {
    const Vector apart =
        vector_of(spheres.beads.velocity[overlap.first]) - vector_of(spheres.beads.velocity[overlap.second]);
    if (dot(apart, overlap.apart) >= 0.0) return;
    const double distance = length(overlap.apart), half = 0.5 * (overlap.reach - distance);
    const double ra = spheres.position[overlap.first][3] - half, rb = spheres.position[overlap.second][3] - half;
    bounce_beads(overlap, apart, 1.0 / distance * overlap.apart, ra, rb, spheres, rules, report);
}

/// A contact with a rod or a side wall.
void resolve_any(const PairwiseLaw& law, const Overlap& overlap, Spheres& spheres, const StepRules& rules,
                 ContactReport& report) {
    const bool surface = overlap.is_with_surface(), image = !surface && overlap.second_body == overlap.first_body;
    const Coefficients c = coefficients_of(overlap, spheres, rules.restitution, rules.friction);
    const double distance = length(overlap.apart), half = surface ? 0.0 : 0.5 * (overlap.reach - distance);
    const Vector normal = surface ? overlap.normal : 1.0 / distance * overlap.apart;
    // Both bodies feel the impulse in the middle of the overlap: angular momentum is conserved.
    std::array<ImpactBody, 2> bodies{impact_body_of(spheres, overlap.first_body), {}};
    Contact contact{.first = 0,
                    .second = surface ? -1 : (image ? 0 : 1),
                    .normal = normal,
                    .arm_first = arm_of(spheres, overlap.first, 1.0, normal, half),
                    .restitution = c.restitution,
                    .friction = c.friction};
    if (!surface) contact.arm_second = arm_of(spheres, overlap.second, -1.0, normal, half);
    if (contact.second == 1) bodies[1] = impact_body_of(spheres, overlap.second_body);
    const double approach = resolve_contact(law, contact, bodies, report);
    if (approach == 0.0) return;
    if (approach > counted_speed) count_impact(overlap, spheres, report.counts);
    store(bodies[0], spheres, overlap.first_body);
    if (contact.second == 1) store(bodies[1], spheres, overlap.second_body);
}
}  // namespace

bool step_beads(Spheres& spheres, std::size_t begin, std::size_t end, const PlateState& base, const PlateMotion& plates,
                const StepRules& rules, ContactReport& report) {
    const double low = base.height, high = plates.lid() ? low + plates.gap() : never;
    const double far = 0.25 * rules.skin * rules.skin;
    const Vec4d time{rules.dt, rules.dt, rules.dt, 0.0};
    bool left_skin = false;
    double beyond = 0.0;
    for (std::size_t s = begin; s < end; ++s) {
        Vec4d& velocity = spheres.beads.velocity[s];
        const Vec4d change = rules.acceleration_of(velocity[3]) * time;
        velocity += change;
        spheres.position[s] += velocity * time;
        beyond += (change[0] * change[0] + change[1] * change[1] + change[2] * change[2]) / velocity[3];
        left_skin |= has_left_skin(spheres.position[s], spheres.listed[s], far);
        const double z = spheres.position[s][2], radius = spheres.position[s][3];
        const auto bead = static_cast<std::uint32_t>(s);
        if (z - radius < low) bounce_bead(spheres, bead, 1.0, low - z + radius, base.velocity, rules, report);
        if (z + radius > high) bounce_bead(spheres, bead, -1.0, z + radius - high, base.velocity, rules, report);
    }
    report.balance.gravity -= 0.5 * beyond;  // a step ends a dt^2/2 beyond the exact motion: see move_freely()
    return left_skin;
}

void step_rod(Spheres& spheres, std::size_t number, const Vector& acceleration, const PlateMotion& plates,
              std::int64_t step, const PairwiseLaw& law, const StepRules& rules, std::vector<RodPlateOverlap>& scratch,
              ContactReport& report) {
    Rod& rod = spheres.rods.rod[number];
    const RodKind& kind = spheres.rods.kinds[spheres.rods.kind[number]];
    const int steps = law.rod_steps(rules.dt);
    const double part = law.rod_step_within(rules.dt);
    for (int k = 0; k < steps; ++k) {
        move_freely(rod, kind.shape, acceleration, part, report.balance);
        const PlateState base = plates.base((k + 1) * part);
        find_plates(rod, kind, base, plates, scratch);
        if (scratch.empty()) continue;
        if (law.order == ContactOrder::random)
            shuffle({.seed = rules.seed,
                     .stream = Stream::contact_order,
                     .step = static_cast<std::uint64_t>(step),
                     .substep = static_cast<std::uint64_t>(k)},
                    number, scratch);
        bounce_rod(law, spheres, number, base, rules, scratch, report);
    }
}

ContactReport resolve_pairs(const std::vector<Overlap>& overlaps, Spheres& spheres, const PairwiseLaw& law,
                            const StepRules& rules, bool backwards) {
    ContactReport report;
    for (std::size_t i = 0; i < overlaps.size(); ++i) {
        const Overlap& overlap = overlaps[backwards ? overlaps.size() - 1 - i : i];
        record_depth(overlap, spheres, report);
        if (is_pair_of_beads(overlap, spheres)) resolve_beads(overlap, spheres, rules, report);
        else resolve_any(law, overlap, spheres, rules, report);
    }
    return report;
}

}  // namespace drover::dem
