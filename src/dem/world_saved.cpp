// dem/world_saved.cpp: the state of a world as numbers, and back.
#include <cstdint>
#include <type_traits>

#include "world_state.hpp"

namespace drover::dem {

namespace {
/// Visits every number of the state that changes from step to step, in one order for both directions.
template <class Visit>
void for_numbers(EnergyBalance& balance, Visit visit) {
    for (const auto part : balance_parts) visit(balance.*part);
}

template <class Visit>
void for_numbers(Counts& counts, Visit visit) {
    for (std::int64_t* part : {&counts.bead_bead, &counts.rod_bead, &counts.rod_rod, &counts.bead_plate,
                               &counts.rod_plate, &counts.bead_wall, &counts.rod_wall, &counts.groups,
                               &counts.largest_group, &counts.unresolved, &counts.lists})
        visit(*part);
    visit(counts.residual);
    visit(counts.overlap);
}

template <class Visit>
void for_numbers(Overlap& overlap, Visit visit) {
    visit(overlap.depth);
    visit(overlap.of_radius);
    visit(overlap.time);
    for (Name* name : {&overlap.first, &overlap.second}) {
        visit(name->kind);
        visit(name->number);
        visit(name->sphere);
    }
}

template <class Visit>
void for_numbers(Vector& v, Visit visit) {
    visit(v.x);
    visit(v.y);
    visit(v.z);
}

template <class Visit>
void for_numbers(Lane& lane, Visit visit) {
    for (int k = 0; k < 4; ++k) {
        double number = lane[k];
        visit(number);
        lane[k] = number;
    }
}

/// The beads stand in the order of the last neighbour list and keep it, with the places of that time: the list comes out the same.
template <class Visit>
void for_numbers(Spheres& spheres, Visit visit) {
    for (std::size_t s = 0; s < spheres.beads.size(); ++s) {
        for (Lane* lane : {&spheres.place[s], &spheres.beads.velocity[s], &spheres.beads.spin[s]})
            for_numbers(*lane, visit);
        visit(spheres.beads.number[s]);
        visit(spheres.beads.shape[s]);
        for (auto& image : spheres.beads.image[s]) visit(image);
    }
    for (std::size_t r = 0; r < spheres.rods.size(); ++r) {
        Rod& rod = spheres.rods.rod[r];
        for (Vector* v : {&rod.position, &rod.velocity, &rod.axis, &rod.angular_momentum}) for_numbers(*v, visit);
        for (auto& image : spheres.rods.image[r]) visit(image);
        visit(spheres.rods.memory[r].hits);
        visit(spheres.rods.memory[r].signs);
        visit(spheres.rods.memory[r].since_impact);
    }
    for (auto* listed : {&spheres.listed, &spheres.listed_wide})
        for (auto& place : *listed)
            for (double& coordinate : place) visit(coordinate);
}
}  // namespace

/// The whole of it.
template <class Visit>
static void for_state(Spheres& spheres, EnergyBalance& balance, Counts& counts, Overlap& overlap, double& start,
                      Visit visit) {
    for_numbers(spheres, visit);
    for_numbers(balance, visit);
    for_numbers(counts, visit);
    for_numbers(overlap, visit);
    visit(start);
}

std::vector<double> World::save() const {
    std::vector<double> numbers;
    State& s = *state_;
    for_state(s.spheres, s.balance, s.counts, s.overlap, s.bead_potential_start,
              [&](const auto& number) { numbers.push_back(static_cast<double>(number)); });
    return numbers;
}

void World::restore(std::span<const double> numbers) {
    State& s = *state_;
    const std::size_t wanted = save().size();
    require(numbers.size() == wanted, {}, "the checkpoint holds {} numbers; this scene's state has {}", numbers.size(),
            wanted);
    std::size_t next = 0;
    for_state(s.spheres, s.balance, s.counts, s.overlap, s.bead_potential_start,
              [&](auto& number) { number = static_cast<std::remove_reference_t<decltype(number)>>(numbers[next++]); });
    for (std::size_t r = 0; r < s.spheres.rods.size(); ++r) place_spheres(s.spheres, r);
    list_again(s.setup.cell, s.setup.contacts.skin, s.spheres, s.neighbours, s.threads);
}

}  // namespace drover::dem
