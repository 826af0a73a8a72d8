// dem/world.cpp: the world and its step.
#include "drover/dem/world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/dem/rotation.hpp"
#include "world_state.hpp"

namespace drover::dem {

namespace {
constexpr std::size_t beads_per_chunk = 1024, rods_per_chunk = 16;

GroupLaw group_law(const std::string& name) {
    if (name == "approaching-first") return GroupLaw::approaching_first;
    if (name == "first-to-last") return GroupLaw::first_to_last;
    if (name == "last-to-first") return GroupLaw::last_to_first;
    return GroupLaw::simultaneous;
}

RestitutionKind restitution_kind(const std::string& name) {
    if (name == "kinetic") return RestitutionKind::kinetic;
    if (name == "kinematic") return RestitutionKind::kinematic;
    return RestitutionKind::energetic;
}

ImpactLaw law_of(const ContactControl& contacts) {
    return {.group = group_law(contacts.law),
            .restitution = restitution_kind(contacts.restitution),
            .track_slip = contacts.track_slip,
            .increments = contacts.increments,
            .slow = contacts.slow};
}

Spheres make_spheres(const Setup& setup, const Bodies& bodies) {
    Spheres spheres;
    BeadArrays& beads = spheres.beads;
    for (std::size_t b = 0; b < bodies.beads.size(); ++b) {
        const Bead& bead = bodies.beads[b];
        const Shape& shape = bodies.shapes[bead.shape];
        spheres.place.push_back(Lane{bead.position.x, bead.position.y, bead.position.z, shape.radius.front()});
        beads.velocity.push_back(Lane{bead.velocity.x, bead.velocity.y, bead.velocity.z, 1.0 / shape.mass});
        beads.spin.push_back(Lane{bead.spin.x, bead.spin.y, bead.spin.z, 1.0 / shape.inertia_along});
        beads.number.push_back(static_cast<std::uint32_t>(b));
        beads.shape.push_back(bead.shape);
        beads.image.push_back({0, 0});
    }
    RodArrays& rods = spheres.rods;
    for (const Shape& shape : bodies.shapes)
        rods.kinds.push_back(make_rod_kind(shape, setup.restitution.rod_plate, setup.friction.rod_plate));
    for (std::size_t r = 0; r < bodies.rods.size(); ++r) {
        const Rod& rod = bodies.rods[r];
        rods.rod.push_back(rod);
        rods.memory.push_back({});
        rods.kind.push_back(rod.shape);
        rods.image.push_back({0, 0});
        rods.first.push_back(static_cast<std::uint32_t>(spheres.place.size()));
        for (const double radius : bodies.shapes[rod.shape].radius) {
            spheres.place.push_back(Lane{0.0, 0.0, 0.0, radius});
            rods.owner.push_back(static_cast<std::uint32_t>(r));
        }
        place_spheres(spheres, r);
    }
    rods.first.push_back(static_cast<std::uint32_t>(spheres.place.size()));
    spheres.listed.resize(spheres.place.size());
    spheres.listed_wide.resize(spheres.place.size());
    return spheres;
}
}  // namespace

double sum(const EnergyBalance& balance) {
    double total = 0.0;
    for (const auto part : balance_parts) total += balance.*part;
    return total;
}

void add(const EnergyBalance& part, EnergyBalance& whole) {
    for (const auto entry : balance_parts) whole.*entry += part.*entry;
}

void add(const Counts& part, Counts& whole) {
    whole.bead_bead += part.bead_bead;
    whole.rod_bead += part.rod_bead;
    whole.rod_rod += part.rod_rod;
    whole.bead_plate += part.bead_plate;
    whole.rod_plate += part.rod_plate;
    whole.bead_wall += part.bead_wall;
    whole.rod_wall += part.rod_wall;
    whole.groups += part.groups;
    whole.largest_group = std::max(whole.largest_group, part.largest_group);
    whole.unresolved += part.unresolved;
    whole.lists += part.lists;
    whole.residual = std::max(whole.residual, part.residual);
    whole.overlap = std::max(whole.overlap, part.overlap);
}

World::State::State(const Setup& the_setup, Bodies bodies, double the_dt, std::uint64_t seed, Threads& the_threads)
    : setup(the_setup),
      dt(the_dt),
      threads(the_threads),
      shapes(std::move(bodies.shapes)),
      plates(the_setup.plates),
      walls(the_setup.cell) {
    bodies.shapes = shapes;
    spheres = make_spheres(setup, bodies);
    const ImpactLaw law = law_of(setup.contacts);
    const Vector gravity{setup.gravity.x, setup.gravity.y, setup.gravity.z};
    bead_rules = {.acceleration = gravity,
                  .force = {},
                  .restitution = setup.restitution.bead_plate,
                  .friction = setup.friction.bead_plate,
                  .skin = near_skin(setup.contacts.skin)};
    rod_rules = {.law = law,
                 .substep = setup.contacts.substep,
                 .together = setup.contacts.together,
                 .kick = setup.kick.strength,
                 .seed = seed};
    touch_rules = {.restitution = setup.restitution,
                   .friction = setup.friction,
                   .law = law,
                   .acceleration = gravity,
                   .bead_force = {},
                   .dt = dt,
                   .max_overlap = setup.contacts.max_overlap,
                   .together = setup.contacts.together,
                   .base = {}};
    set_forces(setup.forces);
}

void World::State::set_forces(const BodyForces& forces) {
    const double before = bead_potential();
    setup.forces = forces;
    rod_force = {forces.rod_x, forces.rod_y, 0.0};
    bead_rules.force = touch_rules.bead_force = {forces.bead_x, forces.bead_y, 0.0};
    bead_potential_start += bead_potential() - before;  // another zero of the potential is no work
}

/// Runs work(begin, end, part) over chunks and adds the parts in their order.
template <class Work>
void World::State::in_parts(std::size_t length, std::size_t chunk, Work work) {
    parts.assign(length / chunk + 1, {});
    threads.for_chunks(length, chunk,
                       [&](std::size_t begin, std::size_t end) { work(begin, end, parts[begin / chunk]); });
    for (const Part& part : parts) {
        add(part.balance, balance);
        add(part.counts, counts);
        astray = astray || part.astray;
    }
}

double World::State::bead_potential() const {
    double total = 0.0;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        const Vector weight = 1.0 / spheres.beads.velocity[b][3] * bead_rules.acceleration + bead_rules.force;
        total += dot(weight, unwrapped(vector_of(spheres.place[b]), spheres.beads.image[b]));
    }
    return total;
}

Vector World::State::unwrapped(const Vector& place, const std::array<std::int32_t, 2>& image) const {
    if (!is_periodic(setup.cell)) return place;
    return place + Vector{image[0] * setup.cell.lx, image[1] * setup.cell.ly, 0.0};
}

void World::State::fly_all_beads() {
    in_parts(spheres.beads.size(), beads_per_chunk, [&](std::size_t begin, std::size_t end, Part& part) {
        part.astray = fly_beads(spheres, begin, end, plates, dt, bead_rules, part.balance, part.counts);
    });
}

void World::State::fly_rods() {
    RodArrays& rods = spheres.rods;
    const double far = 0.25 * bead_rules.skin * bead_rules.skin;
    in_parts(rods.size(), rods_per_chunk, [&](std::size_t begin, std::size_t end, Part& part) {
        FlightSpace space;
        for (std::size_t r = begin; r < end; ++r) {
            const RodKind& kind = rods.kinds[rods.kind[r]];
            const Vector push = bead_rules.acceleration + 1.0 / kind.shape.mass * rod_force;
            fly(rods.rod[r], rods.memory[r], r, kind, push, plates, dt, rod_rules, space, part.balance, part.counts);
            place_spheres(spheres, r);
            // What lies between its ends went no further than one of them.
            for (const std::uint32_t s : {rods.first[r], rods.first[r + 1] - 1})
                part.astray |= is_astray(spheres.place[s], spheres.listed[s], far);
        }
    });
}

/// The torque n x h of the orienting field over the step.
void World::State::turn_rods() {
    if (setup.forces.torque == 0.0) return;
    const Vector field{std::cos(setup.forces.angle), std::sin(setup.forces.angle), 0.0};
    for (std::size_t r = 0; r < spheres.rods.size(); ++r) {
        Rod& rod = spheres.rods.rod[r];
        const Shape& shape = spheres.shape_of_rod(r);
        const auto energy = [&] {
            return rotation_energy(rod.angular_momentum, rod.axis, shape.inertia_along, shape.inertia_across);
        };
        const double before = energy();
        rod.angular_momentum = rod.angular_momentum + setup.forces.torque * dt * cross(rod.axis, field);
        balance.forces += energy() - before;
    }
}

namespace {
/// Adds a change of velocity in the plane; returns the work it takes.
double give(Lane& velocity, const Lane& change) {
    const double mass = 1.0 / velocity[3];
    const double work =
        mass * (change[0] * (velocity[0] + 0.5 * change[0]) + change[1] * (velocity[1] + 0.5 * change[1]));
    velocity += change;
    return work;
}
}  // namespace

/// All beads get the velocity that their mean lacks, or the share of it that a wave gives to their place.
void World::State::hold_beads() {
    const BodyForces& forces = setup.forces;
    if (!forces.hold_beads || spheres.beads.size() == 0) return;
    const double across = 2.0 * std::numbers::pi * forces.held_waves / setup.cell.ly;
    const auto share = [&](std::size_t b) {
        return forces.held_waves == 0 ? 1.0 : std::sin(across * spheres.place[b][1]);
    };
    Lane mean{};
    double shares = 0.0;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        const double s = share(b);
        mean += s * spheres.beads.velocity[b];
        shares += s * s;
    }
    if (shares == 0.0) return;
    mean /= shares;
    const Lane lack{forces.bead_velocity_x - mean[0], forces.bead_velocity_y - mean[1], 0.0, 0.0};
    for (std::size_t b = 0; b < spheres.beads.size(); ++b)
        balance.forces += give(spheres.beads.velocity[b], share(b) * lack);
}

/// The force wave over the step.
void World::State::push_beads() {
    if (setup.forces.push == 0.0) return;
    const double along = 2.0 * std::numbers::pi * setup.forces.push_waves / setup.cell.lx;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        Lane& velocity = spheres.beads.velocity[b];
        const double force = setup.forces.push * std::sin(along * spheres.place[b][0]);
        balance.forces += give(velocity, Lane{force * dt * velocity[3], 0.0, 0.0, 0.0});
    }
}

namespace {
Name name_of(const Spheres& spheres, std::uint32_t sphere) {
    if (sphere == Touch::no_sphere) return {};
    if (spheres.is_bead(sphere)) return {.kind = Name::Kind::bead, .number = spheres.beads.number[sphere]};
    const std::uint32_t r = spheres.rod(sphere);
    return {.kind = Name::Kind::rod, .number = r, .sphere = sphere - spheres.rods.first[r]};
}
}  // namespace

std::string name_text(const Name& name) {
    if (name.kind == Name::Kind::bead) return text("bead {}", name.number);
    if (name.kind == Name::Kind::rod) return text("rod {} (sphere {})", name.number, name.sphere);
    return "the side wall";
}

void World::State::notice(const TouchReport& report, std::int64_t step) {
    add(report.balance, balance);
    add(report.counts, counts);
    if (report.depth <= counts.overlap) return;
    counts.overlap = report.depth;
    const Touch& touch = report.deepest;
    overlap = {.depth = report.depth * smaller_radius(touch, spheres),
               .of_radius = report.depth,
               .first = name_of(spheres, touch.first),
               .second = name_of(spheres, touch.second),
               .time = static_cast<double>(step + 1) * dt};
    if (report.depth > touch_rules.max_overlap)
        fail_run(
            "{} and {} overlap by {:.2g} mm, {:.2g} of a radius, at step {} (t = {:.6g} s); contacts.max_overlap = "
            "{}: the step of dt = "
            "{} s is too long for their speed, choose a smaller time.dt",
            name_text(overlap.first), name_text(overlap.second), overlap.depth, overlap.of_radius, step + 1,
            overlap.time, touch_rules.max_overlap, dt);
}

World::World(const Setup& setup, Bodies bodies, double dt, std::uint64_t seed, Threads& threads,
             const LocationOf& place) {
    check(setup, place);
    state_ = std::make_unique<State>(setup, std::move(bodies), dt, seed, threads);
    make_neighbours(setup.cell, setup.contacts.skin, state_->spheres, state_->neighbours, threads);
    state_->astray = false;
    state_->bead_potential_start = state_->bead_potential();
}
World::World(World&&) noexcept = default;
World::~World() = default;

void World::advance(std::int64_t step) {
    State& s = *state_;
    s.plates.set_time(static_cast<double>(step) * s.dt);
    s.turn_rods();
    s.hold_beads();
    s.push_beads();
    s.fly_all_beads();
    s.fly_rods();
    if (s.astray) {
        if (renew_neighbours(s.setup.cell, s.setup.contacts.skin, s.spheres, s.neighbours, s.threads)) ++s.counts.lists;
        s.astray = false;
    }
    s.touch_rules.base = s.plates.base(s.dt);
    s.touch_rules.lid = s.plates.lid() ? s.touch_rules.base.at + s.plates.gap() : never;
    s.notice(s.touches.step(s.walls, s.spheres, s.neighbours, s.touch_rules, s.threads), step);
}

void World::set_forces(const BodyForces& forces) {
    Setup changed = state_->setup;
    changed.forces = forces;
    check(changed);
    state_->set_forces(forces);
}

EnergyBalance World::balance() const {
    EnergyBalance balance = state_->balance;
    balance.gravity += state_->bead_potential() - state_->bead_potential_start;
    return balance;
}

Bodies World::bodies() const {
    const Spheres& spheres = state_->spheres;
    Bodies bodies{.shapes = state_->shapes, .beads = std::vector<Bead>(spheres.beads.size()), .rods = spheres.rods.rod};
    for (std::size_t s = 0; s < spheres.beads.size(); ++s)
        bodies.beads[spheres.beads.number[s]] = {.position = state_->unwrapped(vector_of(spheres.place[s]),
                                                                               spheres.beads.image[s]),
                                                 .velocity = vector_of(spheres.beads.velocity[s]),
                                                 .spin = vector_of(spheres.beads.spin[s]),
                                                 .shape = spheres.beads.shape[s]};
    for (std::size_t r = 0; r < bodies.rods.size(); ++r)
        bodies.rods[r].position = state_->unwrapped(bodies.rods[r].position, spheres.rods.image[r]);
    return bodies;
}

double World::energy_kinetic() const {
    const Spheres& spheres = state_->spheres;
    double total = 0.0;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        const Vector v = vector_of(spheres.beads.velocity[b]), w = vector_of(spheres.beads.spin[b]);
        total += 0.5 * (dot(v, v) / spheres.beads.velocity[b][3] + dot(w, w) / spheres.beads.spin[b][3]);
    }
    for (std::size_t r = 0; r < spheres.rods.size(); ++r)
        total += dem::energy_kinetic(mover_of(spheres.rods.rod[r], spheres.shape_of_rod(r)));
    return total;
}

const Setup& World::setup() const { return state_->setup; }
double World::dt() const { return state_->dt; }
Counts World::counts() const { return state_->counts; }
Overlap World::worst_overlap() const { return state_->overlap; }

}  // namespace drover::dem
