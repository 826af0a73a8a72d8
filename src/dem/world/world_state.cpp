// dem/world/world_state.cpp: the time step of a world.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dem/bodies/rotation.hpp"
#include "dem/world/world_state.hpp"

namespace drover::dem {

namespace {
constexpr std::size_t beads_per_chunk = 1024, rods_per_chunk = 16;

/// The shapes of `bodies` have no effect.
Spheres make_spheres(const Setup& setup, const std::vector<Shape>& shapes, const Bodies& bodies) {
    Spheres spheres;
    BeadArrays& beads = spheres.beads;
    for (std::size_t b = 0; b < bodies.beads.size(); ++b) {
        const Bead& bead = bodies.beads[b];
        const Shape& shape = shapes[bead.shape];
        spheres.position.push_back(Vec4d{bead.position.x, bead.position.y, bead.position.z, shape.radius.front()});
        beads.velocity.push_back(Vec4d{bead.velocity.x, bead.velocity.y, bead.velocity.z, 1.0 / shape.mass});
        beads.spin.push_back(Vec4d{bead.spin.x, bead.spin.y, bead.spin.z, 1.0 / shape.inertia_along});
        beads.number.push_back(static_cast<std::uint32_t>(b));
        beads.shape.push_back(bead.shape);
        beads.image.push_back({0, 0});
    }
    RodArrays& rods = spheres.rods;
    for (const Shape& shape : shapes)
        rods.kinds.push_back(make_rod_kind(shape, setup.restitution.rod_plate, setup.friction.rod_plate,
                                           setup.rods.bearing == Bearing::all));
    for (std::size_t r = 0; r < bodies.rods.size(); ++r) {
        const Rod& rod = bodies.rods[r];
        rods.rod.push_back(rod);
        const double size = length(rod.axis);
        require(size != 0.0, {}, "the axis of rod {} is of length 0; expected 1", r);
        if (std::abs(size - 1.0) > 1e-9) rods.rod.back().axis = 1.0 / size * rod.axis;  // else to the same bits
        rods.memory.push_back({.hits = bodies.first_kick});
        rods.kind.push_back(rod.shape);
        rods.image.push_back({0, 0});
        rods.first.push_back(static_cast<std::uint32_t>(spheres.position.size()));
        for (const double radius : shapes[rod.shape].radius) {
            spheres.position.push_back(Vec4d{0.0, 0.0, 0.0, radius});
            rods.owner.push_back(static_cast<std::uint32_t>(r));
        }
        set_rod_spheres(spheres, r);
    }
    rods.first.push_back(static_cast<std::uint32_t>(spheres.position.size()));
    spheres.listed.resize(spheres.position.size());
    spheres.listed_wide.resize(spheres.position.size());
    return spheres;
}

void check_shapes(const Bodies& bodies) {
    const auto check = [&](const char* kind, const auto& list) {
        for (std::size_t i = 0; i < list.size(); ++i)
            require(list[i].shape < bodies.shapes.size(), {},
                    "{} {} has the shape {}; expected less than {}, the number of shapes", kind, i, list[i].shape,
                    bodies.shapes.size());
    };
    check("bead", bodies.beads);
    check("rod", bodies.rods);
}

void check_same_shapes(const Bodies& given, const Bodies& expected) {
    const auto check = [](const char* kind, const auto& found, const auto& own) {
        require(found.size() == own.size(), {}, "{} {}s; expected {}, those of the world", found.size(), kind,
                own.size());
        for (std::size_t i = 0; i < own.size(); ++i)
            require(found[i].shape == own[i].shape, {}, "{} {} has the shape {}; expected {}, as in the world", kind, i,
                    found[i].shape, own[i].shape);
    };
    check("bead", given.beads, expected.beads);
    check("rod", given.rods, expected.rods);
}

/// Adds a change of velocity in the plane; returns its work.
double add_velocity(Vec4d& velocity, const Vec4d& change) {
    const double mass = 1.0 / velocity[3];
    const double work =
        mass * (change[0] * (velocity[0] + 0.5 * change[0]) + change[1] * (velocity[1] + 0.5 * change[1]));
    velocity += change;
    return work;
}

/// The deepest overlap of bodies, side walls and the plates at a time.
OverlapRecord deepest_overlap(const Walls& walls, const PlateMotion& plates, const Spheres& spheres,
                              const Neighbours& neighbours, Threads& threads) {
    OverlapRecord deepest;
    const auto keep = [&](double of_radius, double radius, std::uint32_t first, std::uint32_t second) {
        if (of_radius > deepest.of_radius)
            deepest = {of_radius * radius, of_radius, name_of(spheres, first), name_of(spheres, second)};
    };
    OverlapSearch search;
    for (const Overlap& overlap : search.find(walls, spheres, neighbours, threads))
        keep(relative_depth(overlap, spheres), smaller_radius(overlap, spheres), overlap.first, overlap.second);
    const double base = plates.base().height;
    for (std::uint32_t i = 0; i < spheres.size(); ++i) {
        const double height = spheres.position[i][2], radius = spheres.position[i][3];
        keep((base + radius - height) / radius, radius, i, Overlap::base);
        if (plates.lid()) keep((height + radius - base - plates.gap()) / radius, radius, i, Overlap::lid);
    }
    return deepest;
}
}  // namespace

double counted_plate_speed(const Setup& setup) {
    const double rate = 2.0 * std::numbers::pi * setup.plates.frequency;
    const double acceleration = std::abs(setup.gravity.z) + setup.plates.amplitude * rate * rate;
    return std::max(counted_speed, acceleration / (40.0 * setup.plates.frequency));
}

double sum(const EnergyBalance& balance) {
    double total = 0.0;
    for (const auto part : balance_parts) total += balance.*part;
    return total;
}

World::State::State(const Setup& the_setup, Bodies bodies, double the_dt, std::uint64_t seed, Threads& the_threads)
    : setup(the_setup),
      law(contact_law(the_setup.contacts)),
      dt(the_dt),
      threads(the_threads),
      shapes(std::move(bodies.shapes)),
      plates(the_setup.plates),
      walls(the_setup.cell) {
    spheres = make_spheres(setup, shapes, bodies);
    rules = {.restitution = setup.restitution,
             .friction = setup.friction,
             .law = ImpactLaw::from(setup.contacts),
             .acceleration = {setup.gravity.x, setup.gravity.y, setup.gravity.z},
             .dt = dt,
             .substep = setup.contacts.substep,
             .simultaneity_gap = setup.contacts.simultaneity_gap,
             .counted_plate_speed = counted_plate_speed(setup),
             .skin = near_skin(setup.contacts.skin),
             .kick = setup.kick.strength,
             .seed = seed};
    set_forces(setup.forces);
}

void World::State::set_forces(const BodyForces& forces) {
    const double before = bead_potential();
    setup.forces = forces;
    rules.rod_force = {forces.rod_x, forces.rod_y, 0.0};
    rules.bead_force = {forces.bead_x, forces.bead_y, 0.0};
    bead_potential_start += bead_potential() - before;  // a new zero of the potential does no work
}

/// Runs work(begin, end, result) over chunks and adds the results in the order of the chunks.
template <class Work>
void World::State::run_chunks(std::size_t length, std::size_t chunk, Work work) {
    results.assign(length / chunk + 1, {});
    threads.for_chunks(length, chunk,
                       [&](std::size_t begin, std::size_t end) { work(begin, end, results[begin / chunk]); });
    for (const ChunkResult& result : results) {
        add(result.balance, balance);
        add(result.counts, counts);
        left_skin = left_skin || result.left_skin;
        keep_deepest(result, flight);
    }
}

double World::State::bead_potential() const {
    double total = 0.0;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        const Vector weight = 1.0 / spheres.beads.velocity[b][3] * rules.acceleration + rules.bead_force;
        total += dot(weight, unwrapped(vector_of(spheres.position[b]), spheres.beads.image[b]));
    }
    return total;
}

Vector World::State::unwrapped(const Vector& position, const std::array<std::int32_t, 2>& image) const {
    if (!is_periodic(setup.cell)) return position;
    return position + Vector{image[0] * setup.cell.lx, image[1] * setup.cell.ly, 0.0};
}

/// move(rod, its kind, acceleration, index, space, result) for each rod.
template <class Move>
void World::State::move_rods(Move move) {
    RodArrays& rods = spheres.rods;
    const double far = 0.25 * rules.skin * rules.skin;
    run_chunks(rods.size(), rods_per_chunk, [&](std::size_t begin, std::size_t end, ChunkResult& result) {
        FlightSpace space;
        for (std::size_t r = begin; r < end; ++r) {
            const RodKind& kind = rods.kinds[rods.kind[r]];
            const Vector acceleration = rules.rod_acceleration(kind.shape.mass);
            move(rods.rod[r], kind, acceleration, r, space, result);
            set_rod_spheres(spheres, r);
            // Spheres between the ends move no further than one of them.
            for (const std::uint32_t s : {rods.first[r], rods.first[r + 1] - 1})
                result.left_skin |= has_left_skin(spheres.position[s], spheres.listed[s], far);
        }
    });
}

void World::State::renew_lists() {
    if (!left_skin) return;
    check_positions();
    if (renew_neighbours(setup.cell, setup.contacts.skin, spheres, neighbours, threads)) ++counts.lists;
    left_skin = false;
}

ContactReport World::State::step_with(const ImpactLaw&) {
    run_chunks(spheres.beads.size(), beads_per_chunk, [&](std::size_t begin, std::size_t end, ChunkResult& result) {
        result.left_skin = fly_beads(spheres, begin, end, plates, rules, result.balance, result.counts);
    });
    move_rods([&](Rod& rod, const RodKind& kind, const Vector& acceleration, std::size_t r, FlightSpace& space,
                  ChunkResult& result) {
        fly_rod(rod, spheres.rods.memory[r], r, kind, acceleration, plates, rules, space, result.balance,
                result.counts);
    });
    renew_lists();
    rules.base = plates.base(dt);
    rules.lid = plates.lid() ? rules.base.height + plates.gap() : never;
    return pair_impacts.step(walls, spheres, neighbours, rules, threads);
}

ContactReport World::State::step_with(const PairwiseLaw& pairwise) {
    flight = {};
    const PlateState base = plates.base(dt);
    run_chunks(spheres.beads.size(), beads_per_chunk, [&](std::size_t begin, std::size_t end, ChunkResult& result) {
        result.left_skin = step_beads(spheres, begin, end, base, plates, rules, result);
    });
    move_rods(
        [&](Rod&, const RodKind&, const Vector& acceleration, std::size_t r, FlightSpace& space, ChunkResult& result) {
            step_rod(spheres, r, acceleration, plates, step, pairwise, rules, space.overlaps, result);
        });
    renew_lists();
    ContactReport report = resolve_pairs(overlap_search.find(walls, spheres, neighbours, threads), spheres, pairwise,
                                         rules, step % 2 != 0);
    keep_deepest(flight, report);
    return report;
}

template <SoftLaw Law>
ContactReport World::State::step_with(const Law& soft_law) {
    ContactReport report;
    soft_contacts.kick(spheres, rules, true, report.balance);
    run_chunks(spheres.beads.size(), beads_per_chunk, [&](std::size_t begin, std::size_t end, ChunkResult& result) {
        result.left_skin = drift_beads(spheres, begin, end, rules);
    });
    move_rods([&](Rod& rod, const RodKind& kind, const Vector& acceleration, std::size_t, FlightSpace&,
                  ChunkResult& result) { drift_rod(rod, kind.shape, acceleration, dt, result.balance); });
    renew_lists();
    soft_contacts.find(walls, spheres, neighbours, plates, rules, threads, report);
    soft_contacts.apply(soft_law, report);
    soft_contacts.kick(spheres, rules, false, report.balance);
    soft_contacts.kick_rods(spheres, rules, report);
    return report;
}

/// Applies the torque n x h of the orienting field over the step.
void World::State::turn_rods() {
    if (setup.forces.torque == 0.0) return;
    const Vector field{std::cos(setup.forces.angle), std::sin(setup.forces.angle), 0.0};
    for (std::size_t r = 0; r < spheres.rods.size(); ++r) {
        Rod& rod = spheres.rods.rod[r];
        const Shape& shape = spheres.shape_of_rod(r);
        const double before = rotation_energy(rod, shape);
        rod.angular_momentum = rod.angular_momentum + setup.forces.torque * dt * cross(rod.axis, field);
        balance.forces += rotation_energy(rod, shape) - before;
    }
}

/// Adds to all beads the velocity that their mean lacks, or the part of it that the wave has at their position.
void World::State::hold_beads() {
    const BodyForces& forces = setup.forces;
    if (!forces.hold_beads || spheres.beads.size() == 0) return;
    const double across = 2.0 * std::numbers::pi * forces.held_waves / setup.cell.ly;
    const auto share = [&](std::size_t b) {
        return forces.held_waves == 0 ? 1.0 : std::sin(across * spheres.position[b][1]);
    };
    Vec4d mean{};
    double shares = 0.0;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        const double s = share(b);
        mean += s * spheres.beads.velocity[b];
        shares += s * s;
    }
    if (shares == 0.0) return;
    mean /= shares;
    const Vec4d missing{forces.bead_velocity_x - mean[0], forces.bead_velocity_y - mean[1], 0.0, 0.0};
    for (std::size_t b = 0; b < spheres.beads.size(); ++b)
        balance.forces += add_velocity(spheres.beads.velocity[b], share(b) * missing);
}

/// Applies the force wave over the step.
void World::State::push_beads() {
    if (setup.forces.push == 0.0) return;
    const double along = 2.0 * std::numbers::pi * setup.forces.push_waves / setup.cell.lx;
    for (std::size_t b = 0; b < spheres.beads.size(); ++b) {
        Vec4d& velocity = spheres.beads.velocity[b];
        const double force = setup.forces.push * std::sin(along * spheres.position[b][0]);
        balance.forces += add_velocity(velocity, Vec4d{force * dt * velocity[3], 0.0, 0.0, 0.0});
    }
}

std::string name_text(const Name& name) {
    if (name.kind == Name::Kind::bead) return text("bead {}", name.number);
    if (name.kind == Name::Kind::rod) return text("rod {} (sphere {})", name.number, name.sphere);
    if (name.kind == Name::Kind::base) return "the base";
    return name.kind == Name::Kind::lid ? "the lid" : "the side wall";
}

std::string World::State::non_finite() const {
    const std::string found = first_non_finite(spheres);
    const EnergyBalance now = total_balance();
    if (found.empty() && std::isfinite(sum(now))) return {};
    return found + (found.empty() ? "" : "; ") + cause_of_energy(now);
}

void World::State::fail_non_finite(const std::string& first) const {
    fail_run("step {} (t = {:.6g} s): {}; expected finite values: the cause is a value of the scene that is too large",
             step + 1, static_cast<double>(step + 1) * dt,
             first.empty() ? non_finite() : first + "; " + cause_of_energy(total_balance()));
}

void World::State::check_positions() const {
    constexpr double far = 1e9;  // mm
    for (const Vec4d& p : spheres.position)
        if (!(std::abs(p[0]) < far && std::abs(p[1]) < far && std::abs(p[2]) < far)) {
            const auto sphere = static_cast<std::uint32_t>(&p - spheres.position.data());
            fail_non_finite(text("{} is at ({:.3g}, {:.3g}, {:.3g}) mm, far from the cell",
                                 name_text(name_of(spheres, sphere)), p[0], p[1], p[2]));
        }
    if (const std::string found = first_too_fast(spheres, dt); !found.empty())
        fail_run("step {} (t = {:.6g} s): {}", step + 1, static_cast<double>(step + 1) * dt, found);
}

void World::State::record_overlap(const ContactReport& report) {
    add(report.balance, balance);
    add(report.counts, counts);
    const bool finite = report.failure.empty() && std::isfinite(sum(balance));
    if (!finite) fail_non_finite(report.failure);
    if (report.depth <= counts.overlap) return;
    counts.overlap = report.depth;
    const Overlap& deepest = report.deepest;
    worst_overlap = {.depth = report.depth * smaller_radius(deepest, spheres),
                     .of_radius = report.depth,
                     .first = name_of(spheres, deepest.first),
                     .second = name_of(spheres, deepest.second),
                     .time = static_cast<double>(step + 1) * dt};
    const bool rod_on_plate =
        deepest.is_with_surface() && deepest.second != Overlap::side_wall && !spheres.is_bead(deepest.first);
    const auto* const pairwise = std::get_if<PairwiseLaw>(&law);
    const NamedStep moved = rod_on_plate && pairwise != nullptr
                                ? NamedStep{"contacts.rod_step", pairwise->rod_step_within(dt)}
                                : NamedStep{"time.dt", dt};
    if (report.depth > setup.contacts.max_overlap)
        fail_run(
            "{} and {} overlap by {:.2g} mm, {:.2g} of a radius, at step {} (t = {:.6g} s); contacts.max_overlap = "
            "{}; {}",
            name_text(worst_overlap.first), name_text(worst_overlap.second), worst_overlap.depth,
            worst_overlap.of_radius, step + 1, worst_overlap.time, setup.contacts.max_overlap,
            cause_of_overlap(setup, worst_overlap.depth, smaller_radius(deepest, spheres), report.closing, moved));
}

World::World(const Setup& setup, Bodies bodies, double dt, std::uint64_t seed, Threads& threads, const Locate& locate,
             bool is_start) {
    check(setup, locate);
    check_shapes(bodies);
    check_contact_law(setup, bodies.shapes, dt, locate);
    state_ = std::make_unique<State>(setup, std::move(bodies), dt, seed, threads);
    if (is_start) state_->neighbours = state_->checked_neighbours(state_->spheres, 0);
    else make_neighbours(setup.cell, setup.contacts.skin, state_->spheres, state_->neighbours, threads);
    state_->bead_potential_start = state_->bead_potential();
}
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;
World::~World() = default;

void World::advance(std::int64_t step) {
    State& s = *state_;
    require(!s.failed, {}, "the world failed at step {}; expected set_bodies() or restore() first", s.step + 1);
    s.failed = true;  // unless the step succeeds
    s.step = step;
    s.plates.set_time(static_cast<double>(step) * s.dt);
    s.turn_rods();
    s.hold_beads();
    s.push_beads();
    s.record_overlap(std::visit([&](const auto& chosen) { return s.step_with(chosen); }, s.law));
    s.failed = false;
}

void World::set_forces(const BodyForces& forces) {
    Setup changed = state_->setup;
    changed.forces = forces;
    check(changed);
    state_->set_forces(forces);
}

EnergyBalance World::State::total_balance() const {
    EnergyBalance total = balance;
    total.gravity += bead_potential() - bead_potential_start;
    total.elastic = -soft_contacts.energy();
    return total;
}

EnergyBalance World::balance() const { return state_->total_balance(); }
std::string World::non_finite() const { return state_->non_finite(); }

Neighbours World::State::checked_neighbours(Spheres& placed, std::int64_t at_step) const {
    const std::string wrong = first_non_finite(placed);
    require(wrong.empty(), {}, "{}; expected finite values", wrong);
    Neighbours made;
    make_neighbours(setup.cell, setup.contacts.skin, placed, made, threads);
    PlateMotion moved = plates;
    moved.set_time(static_cast<double>(at_step) * dt);
    const OverlapRecord deepest = deepest_overlap(walls, moved, placed, made, threads);
    require(deepest.of_radius <= setup.contacts.max_overlap, {},
            "{} and {} overlap by {:.2g} mm, {:.2g} of a radius; expected at most contacts.max_overlap = {}",
            name_text(deepest.first), name_text(deepest.second), deepest.depth, deepest.of_radius,
            setup.contacts.max_overlap);
    return made;
}

void World::set_bodies(const Bodies& bodies, std::int64_t step) {
    State& s = *state_;
    check_same_shapes(bodies, this->bodies());
    Spheres spheres = make_spheres(s.setup, s.shapes, bodies);
    Neighbours neighbours = s.checked_neighbours(spheres, step);
    const double energy = energy_kinetic(), potential = s.bead_potential();
    spheres.rods.memory = std::move(s.spheres.rods.memory);  // the kicks go on
    s.spheres = std::move(spheres);
    s.neighbours = std::move(neighbours);
    s.soft_contacts.records().clear();
    if (s.failed) {  // of what the failed step left nothing can be compared
        s.balance = {};
        s.counts.overlap = 0.0;
        s.worst_overlap = {};
        s.bead_potential_start = s.bead_potential();
    } else {
        s.balance.forces += energy_kinetic() - energy;
        s.bead_potential_start += s.bead_potential() - potential;
    }
    s.left_skin = s.failed = false;
}

Bodies World::bodies() const {
    const Spheres& spheres = state_->spheres;
    Bodies bodies{.shapes = state_->shapes, .beads = std::vector<Bead>(spheres.beads.size()), .rods = spheres.rods.rod};
    for (std::size_t s = 0; s < spheres.beads.size(); ++s)
        bodies.beads[spheres.beads.number[s]] = {.position = state_->unwrapped(vector_of(spheres.position[s]),
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
        total += dem::energy_kinetic(impact_body_of(spheres.rods.rod[r], spheres.shape_of_rod(r)));
    return total;
}

const Setup& World::setup() const { return state_->setup; }
double World::dt() const { return state_->dt; }
Counts World::counts() const { return state_->counts; }
OverlapRecord World::worst_overlap() const { return state_->worst_overlap; }

}  // namespace drover::dem
