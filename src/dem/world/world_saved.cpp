// dem/world/world_saved.cpp: the state of a world as numbers, and back.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "dem/world/world_state.hpp"

namespace drover::dem {

namespace {
/// Visits every number that changes from step to step, in the same order for saving and restoring.
template <class Visit>
void for_numbers(EnergyBalance& balance, Visit visit) {
    for (const auto part : balance_parts) visit(balance.*part);
}

template <class Visit>
void for_numbers(Counts& counts, Visit visit) {
    for (const auto part : count_parts) visit(counts.*part);
    visit(counts.residual);
    visit(counts.overlap);
}

template <class Visit>
void for_numbers(OverlapRecord& overlap, Visit visit) {
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
void for_numbers(Vec4d& v, Visit visit) {
    for (int k = 0; k < 4; ++k) {
        double number = v[k];
        visit(number);
        v[k] = number;
    }
}

/// Beads keep the order of the last neighbour list and the positions at which it was made, so that the same list is
/// made again.
template <class Visit>
void for_numbers(Spheres& spheres, Visit visit) {
    for (std::size_t s = 0; s < spheres.beads.size(); ++s) {
        for (Vec4d* v : {&spheres.position[s], &spheres.beads.velocity[s], &spheres.beads.spin[s]})
            for_numbers(*v, visit);
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

template <class Visit>
void for_numbers(SoftRecord& record, Visit visit) {
    visit(record.first);
    visit(record.second);
    for (Vector* v : {&record.normal, &record.arm_first, &record.arm_second, &record.surface_velocity, &record.force,
                      &record.stretch})
        for_numbers(*v, visit);
    for (double* number : {&record.overlap, &record.damping, &record.stored, &record.ahead}) visit(*number);
}

/// The state of a world, without soft contacts.
template <class State, class Visit>
void for_state(State& state, Visit visit) {
    for_numbers(state.spheres, visit);
    for_numbers(state.balance, visit);
    for_numbers(state.counts, visit);
    for_numbers(state.worst_overlap, visit);
    visit(state.bead_potential_start);
}
}  // namespace

std::vector<double> World::save() const {
    std::vector<double> numbers;
    State& s = *state_;
    const auto write = [&](const auto& number) { numbers.push_back(static_cast<double>(number)); };
    for_state(s, write);
    for (SoftRecord& record : s.soft_contacts.records()) for_numbers(record, write);
    return numbers;
}

void World::restore(std::span<const double> numbers) {
    State& s = *state_;
    std::size_t fixed = 0, each = 0;
    SoftRecord blank;
    for_state(s, [&](const auto&) { ++fixed; });
    for_numbers(blank, [&](const auto&) { ++each; });
    const bool soft = std::visit([]<class Law>(const Law&) { return SoftLaw<Law>; }, s.law);
    const std::size_t records = soft && numbers.size() > fixed ? (numbers.size() - fixed) / each : 0;
    require(numbers.size() == fixed + records * each, {},
            "the checkpoint holds {} numbers; the state of this scene has {}", numbers.size(),
            soft ? text("{} and {} for each contact", fixed, each) : text("{}", fixed));
    require(std::ranges::none_of(numbers, [](double number) { return std::isnan(number); }), {},
            "the checkpoint has a NaN; expected the numbers of a state");
    std::size_t next = 0;
    const auto read = [&](auto& number) {
        number = static_cast<std::remove_reference_t<decltype(number)>>(numbers[next++]);
    };
    for_state(s, read);
    s.soft_contacts.records().assign(records, {});
    for (SoftRecord& record : s.soft_contacts.records()) for_numbers(record, read);
    for (std::size_t r = 0; r < s.spheres.rods.size(); ++r) set_rod_spheres(s.spheres, r);
    s.failed = false;
    list_again(s.setup.cell, s.setup.contacts.skin, s.spheres, s.neighbours, s.threads);
}

}  // namespace drover::dem
