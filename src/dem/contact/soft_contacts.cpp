// dem/contact/soft_contacts.cpp: search, kinematics and half-step kicks of soft contacts.
#include "dem/contact/soft_contacts.hpp"

#include <algorithm>
#include <tuple>

#include "dem/contact/contact_report.hpp"
#include "dem/impact/impact_increment.hpp"

namespace drover::dem {

namespace {
/// The number of a sphere or a body that does not change when beads are sorted.
std::uint32_t lasting(const Spheres& spheres, std::uint32_t place) {
    return place < spheres.beads.size() ? spheres.beads.number[place] : place;
}

/// The spring of the last step turned into the tangent plane of a normal, with its length.
Vector turned_into_plane(const Vector& stretch, const Vector& normal) {
    const Vector flat = stretch - dot(stretch, normal) * normal;
    const double before = length(stretch), after = length(flat);
    return after > 0.0 ? before / after * flat : Vector{};
}

/// Share of a step in which an overlap is covered at a speed > 0.
double share_of_step(double overlap, double speed, double dt) {
    return overlap < speed * dt ? overlap / (speed * dt) : 1.0;
}
}  // namespace

void SoftContacts::set_slots(const Spheres& spheres) {
    slot_.resize(spheres.beads.size());
    for (std::uint32_t s = 0; s < slot_.size(); ++s) slot_[spheres.beads.number[s]] = s;
    const std::size_t bodies = spheres.beads.size() + spheres.rods.size();
    local_.resize(bodies, -1);
    velocity_change_.resize(bodies);
    momentum_change_.resize(bodies);
}

std::int32_t SoftContacts::local_body(const Spheres& spheres, std::uint32_t body) {
    std::int32_t& local = local_[body];
    if (local < 0) {
        local = static_cast<std::int32_t>(bodies_.size());
        bodies_.push_back(impact_body_of(spheres, body));
        indices_.push_back(body);
    }
    return local;
}

void SoftContacts::clear_bodies() {
    for (const std::uint32_t body : indices_) local_[body] = -1;
    bodies_.clear();
    indices_.clear();
}

Contact SoftContacts::contact_of(const SoftRecord& record, const Spheres& spheres) {
    Contact contact{.first = local_body(spheres, spheres.body(slot_of(record.first))),
                    .second = -1,
                    .normal = record.normal,
                    .arm_first = record.arm_first,
                    .arm_second = record.arm_second,
                    .wall_velocity = record.surface_velocity};
    if (record.second < Overlap::base) contact.second = local_body(spheres, spheres.body(slot_of(record.second)));
    return contact;
}

void SoftContacts::kick(Spheres& spheres, const StepRules& rules, bool at_start, EnergyBalance& balance) {
    set_slots(spheres);
    if (at_start) {
        std::ranges::fill(velocity_change_, Vector{});
        std::ranges::fill(momentum_change_, Vector{});
    }
    std::vector<Contact> contacts;
    std::vector<Vector> before;
    for (const SoftRecord& record : records_) contacts.push_back(contact_of(record, spheres));
    for (const Contact& contact : contacts) before.push_back(relative_velocity(contact, bodies_));
    const double half = 0.5 * rules.dt;
    const auto push = [&](int local, const Vector& impulse, const Vector& arm) {
        ImpactBody& body = bodies_[static_cast<std::size_t>(local)];
        body.velocity = body.velocity + body.mass_inverse * impulse;
        body.spin = body.spin + spin_change(body, cross(arm, impulse));
        if (!at_start) return;
        const std::uint32_t number = lasting(spheres, indices_[static_cast<std::size_t>(local)]);
        velocity_change_[number] = velocity_change_[number] + body.mass_inverse * impulse;
        momentum_change_[number] = momentum_change_[number] + cross(arm, impulse);
    };
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const Vector impulse = half * records_[c].force;
        push(contacts[c].first, impulse, contacts[c].arm_first);
        if (contacts[c].second >= 0) push(contacts[c].second, -1.0 * impulse, contacts[c].arm_second);
        else balance.plates += dot(impulse, contacts[c].wall_velocity);
    }
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        // The work of a constant force is the force times the mean of the velocities before and after it.
        const Vector mean = 0.5 * (before[c] + relative_velocity(contacts[c], bodies_));
        balance.impact += half * records_[c].damping * dot(mean, contacts[c].normal);
    }
    for (std::size_t b = 0; b < bodies_.size(); ++b) store(bodies_[b], spheres, indices_[b]);
    clear_bodies();
}

void SoftContacts::add_overlap(Overlap overlap, const Spheres& spheres) {
    const std::uint32_t first = lasting(spheres, overlap.first);
    if (!overlap.is_with_surface() && lasting(spheres, overlap.second) < first) {
        std::swap(overlap.first, overlap.second);
        std::swap(overlap.first_body, overlap.second_body);
        overlap.apart = -1.0 * overlap.apart;
    }
    overlaps_.push_back(overlap);
}

void SoftContacts::add_plates(const Spheres& spheres, const PlateMotion& plates, double dt) {
    const double base = plates.base(dt).height, lid = base + plates.gap();
    const auto add = [&](std::uint32_t s) {
        const double z = spheres.position[s][2], radius = spheres.position[s][3];
        Overlap overlap{.first = s, .first_body = spheres.body(s), .reach = radius};
        for (const bool upper : {false, true}) {
            const double side = upper ? -1.0 : 1.0, distance = upper ? lid - z : z - base;
            if (distance >= radius || (upper && !plates.lid())) continue;
            overlap.second = overlap.second_body = upper ? Overlap::lid : Overlap::base;
            overlap.normal = {0.0, 0.0, side};
            overlap.apart = distance * overlap.normal;
            overlaps_.push_back(overlap);
        }
    };
    for (std::uint32_t s = 0; s < spheres.beads.size(); ++s) add(s);
    const RodArrays& rods = spheres.rods;
    for (std::size_t r = 0; r < rods.size(); ++r)
        for (const std::uint32_t k : rods.kinds[rods.kind[r]].bearing) add(rods.first[r] + k);
}

void SoftContacts::sort_overlaps(const Spheres& spheres) {
    const auto key = [&](const Overlap& o) {
        return std::tuple(lasting(spheres, o.first), o.is_with_surface() ? o.second : lasting(spheres, o.second),
                          o.apart.x, o.apart.y);
    };
    std::ranges::sort(overlaps_, [&](const Overlap& a, const Overlap& b) { return key(a) < key(b); });
}

const SoftRecord* SoftContacts::previous_of(const SoftRecord& record) const {
    // A sphere may touch two side walls.
    constexpr double same_wall = 0.5;
    const auto pair = [](const SoftRecord& one) { return std::pair(one.first, one.second); };
    for (const SoftRecord& previous : std::ranges::equal_range(last_, pair(record), {}, pair))
        if (dot(previous.normal, record.normal) > same_wall) return &previous;
    return nullptr;
}

ImpactBody SoftContacts::predicted(const Spheres& spheres, std::size_t local) const {
    const std::uint32_t number = lasting(spheres, indices_[local]);
    ImpactBody body = bodies_[local];
    body.velocity = body.velocity + velocity_change_[number];
    body.spin = body.spin + spin_change(body, momentum_change_[number]);
    return body;
}

SoftRecord SoftContacts::record_of(const Overlap& overlap, const Spheres& spheres, const PlateState& base) const {
    const bool surface = overlap.is_with_surface();
    const double distance = surface ? dot(overlap.apart, overlap.normal) : length(overlap.apart);
    SoftRecord record{.first = lasting(spheres, overlap.first),
                      .second = surface ? overlap.second : lasting(spheres, overlap.second),
                      .overlap = overlap.reach - distance,
                      .normal = surface ? overlap.normal : 1.0 / distance * overlap.apart};
    // Both bodies feel the force in the middle of the overlap: angular momentum is conserved.
    const double half = 0.5 * record.overlap;
    record.arm_first = arm_of(spheres, overlap.first, 1.0, record.normal, half);
    if (!surface) record.arm_second = arm_of(spheres, overlap.second, -1.0, record.normal, half);
    if (overlap.second == Overlap::base || overlap.second == Overlap::lid)
        record.surface_velocity = {0.0, 0.0, base.velocity};
    return record;
}

void SoftContacts::set_contact(std::size_t c, const Spheres& spheres, const std::vector<ImpactBody>& end_bodies,
                               const StepRules& rules, ContactReport& report) {
    const Overlap& overlap = overlaps_[c];
    SoftRecord& record = records_[c];
    const Contact contact = contact_of(record, spheres);
    const Vector& n = record.normal;
    const Vector velocity = relative_velocity(contact, bodies_), at_end = relative_velocity(contact, end_bodies);
    const double opening = dot(velocity, n), opening_at_end = dot(at_end, n);
    const SoftRecord* previous = previous_of(record);
    const double since = previous ? 1.0 : share_of_step(record.overlap, -opening, rules.dt);
    // Half of the next step, or all that is left of a contact that is expected to end in it.
    const double left = share_of_step(record.overlap, opening_at_end, rules.dt);
    record.ahead = left < 1.0 ? left : 0.5;
    const Coefficients e = coefficients_of(overlap, spheres, rules.restitution, rules.friction);
    contacts_[c] = {.overlap = record.overlap,
                    .opening_speed = opening_at_end,
                    .mass = 1.0 / frame_of(contact, bodies_).response.nn,
                    .restitution = e.restitution,
                    .friction = e.friction,
                    .stretch = previous ? turned_into_plane(previous->stretch, n) : Vector{},
                    .slip = since * rules.dt * (velocity - opening * n),
                    .edge_weight = (previous ? 1.0 - previous->ahead : since) + record.ahead};
    record_depth(overlap, spheres, report);
    if (previous || opening >= 0.0) return;
    const bool plate = overlap.is_with_surface() && overlap.second != Overlap::side_wall;
    if (-opening > (plate ? rules.counted_plate_speed : counted_speed)) count_impact(overlap, spheres, report.counts);
    if (plate && !spheres.is_bead(overlap.first))
        starts_.push_back({.rod = spheres.rod(overlap.first), .approach = -opening});
}

void SoftContacts::find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours,
                        const PlateMotion& plates, const StepRules& rules, Threads& threads, ContactReport& report) {
    set_slots(spheres);
    overlaps_.clear();
    starts_.clear();
    for (const Overlap& overlap : search_.find(walls, spheres, neighbours, threads)) add_overlap(overlap, spheres);
    add_plates(spheres, plates, rules.dt);
    sort_overlaps(spheres);
    std::swap(last_, records_);
    records_.clear();
    const PlateState base = plates.base(rules.dt);
    for (const Overlap& overlap : overlaps_) {
        records_.push_back(record_of(overlap, spheres, base));
        contact_of(records_.back(), spheres);
    }
    std::vector<ImpactBody> end_bodies;
    for (std::size_t b = 0; b < bodies_.size(); ++b) end_bodies.push_back(predicted(spheres, b));
    contacts_.resize(records_.size());
    for (std::size_t c = 0; c < records_.size(); ++c) set_contact(c, spheres, end_bodies, rules, report);
    clear_bodies();
}

void SoftContacts::set_force(const SoftForce& force, SoftRecord& record, ContactReport& report) {
    record.force = (force.elastic + force.damping) * record.normal + force.tangential;
    record.damping = force.damping;
    record.stretch = force.stretch;
    record.stored = force.stored;
    report.balance.friction -= force.slipped;
}

void SoftContacts::kick_rods(Spheres& spheres, const StepRules& rules, ContactReport& report) const {
    if (rules.kick == 0.0) return;
    for (const Start& start : starts_) {
        Rod& rod = spheres.rods.rod[start.rod];
        ImpactBody body = impact_body_of(rod, spheres.shape_of_rod(start.rod));
        kick_spin(body, rules.kick * start.approach, spheres.rods.memory[start.rod], start.rod, rules.seed,
                  report.balance);
        rod.angular_momentum = angular_momentum(body);
    }
}

double SoftContacts::energy() const {
    double total = 0.0;
    for (const SoftRecord& record : records_) total += record.stored;
    return total;
}

}  // namespace drover::dem
