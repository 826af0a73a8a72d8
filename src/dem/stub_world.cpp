// dem/stub_world.cpp: a stand-in for the world: free flight in the plane with kicks of the seed, to be deleted at merge.
#include <cmath>

#include "drover/dem/rotation.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

double sum(const Ledger& l) { return l.gravity + l.plates + l.forces + l.kicks + l.impact + l.friction; }

struct World::State {
    Setup setup;
    Bodies bodies;
    double dt = 0.0;
    std::uint64_t seed = 0;
    Ledger ledger;
    Counts counts;
};

World::World(const Setup& setup, Bodies bodies, double dt, std::uint64_t seed, Threads&, const PlaceOf&)
    : state_(new State{setup, std::move(bodies), dt, seed, {}, {}}) {}
World::World(World&&) noexcept = default;
World::~World() = default;

void World::advance(std::int64_t step) {
    const auto noise = [&](std::size_t i, int k) {
        return 10.0 * std::sin(1.7 * static_cast<double>(i + 3 * state_->seed) + 0.01 * static_cast<double>(step) + k);
    };
    const double before = energy_kinetic();
    for (std::size_t i = 0; i < state_->bodies.beads.size(); ++i) {
        Bead& bead = state_->bodies.beads[i];
        bead.velocity = {5.0 * noise(i, 0), 5.0 * noise(i, 1), 0.0};
        bead.position = bead.position + state_->dt * bead.velocity;
    }
    for (std::size_t i = 0; i < state_->bodies.rods.size(); ++i) {
        Rod& rod = state_->bodies.rods[i];
        const Shape& shape = state_->bodies.shapes[rod.shape];
        rod.velocity = {noise(i, 2), noise(i, 3), 0.0};
        rod.angular_momentum = {0.0, 0.0, shape.inertia_across * noise(i, 4)};
        rod.position = rod.position + state_->dt * rod.velocity;
        rod.axis = turned_freely(rod.axis, rod.angular_momentum, shape.inertia_across, state_->dt);
        ++state_->counts.rod_plate;
    }
    state_->ledger.kicks += energy_kinetic() - before;
}

Bodies World::bodies() const { return state_->bodies; }
const Setup& World::setup() const { return state_->setup; }
double World::dt() const { return state_->dt; }
double World::energy_kinetic() const {
    double energy = 0.0;
    for (const Bead& bead : state_->bodies.beads)
        energy += 0.5 * state_->bodies.shapes[bead.shape].mass * dot(bead.velocity, bead.velocity);
    for (const Rod& rod : state_->bodies.rods) {
        const Shape& shape = state_->bodies.shapes[rod.shape];
        energy += 0.5 * shape.mass * dot(rod.velocity, rod.velocity) +
                  rotation_energy(rod.angular_momentum, rod.axis, shape.inertia_along, shape.inertia_across);
    }
    return energy;
}
Ledger World::ledger() const { return state_->ledger; }
Counts World::counts() const { return state_->counts; }
Overlap World::worst_overlap() const { return {}; }

std::vector<double> World::save() const {
    std::vector<double> out{state_->ledger.kicks, static_cast<double>(state_->counts.rod_plate)};
    const auto put = [&](const Vector& v) { out.insert(out.end(), {v.x, v.y, v.z}); };
    for (const Bead& b : state_->bodies.beads) put(b.position), put(b.velocity), put(b.spin);
    for (const Rod& r : state_->bodies.rods) put(r.position), put(r.velocity), put(r.axis), put(r.angular_momentum);
    return out;
}
void World::restore(std::span<const double> in) {
    require(in.size() == save().size(), {}, "the checkpoint holds {} numbers; this world has {}", in.size(),
            save().size());
    std::size_t i = 2;
    state_->ledger.kicks = in[0];
    state_->counts.rod_plate = static_cast<std::int64_t>(in[1]);
    const auto take = [&](Vector& v) { v = {in[i], in[i + 1], in[i + 2]}, i += 3; };
    for (Bead& b : state_->bodies.beads) take(b.position), take(b.velocity), take(b.spin);
    for (Rod& r : state_->bodies.rods) take(r.position), take(r.velocity), take(r.axis), take(r.angular_momentum);
}
double World::bytes() const { return 1e6; }

}  // namespace drover::dem
