// dem/contact/contact_report.cpp: sums of energies and counts; what became non-finite or overlapped too far, and why,
// for the messages of a failed run.
#include "dem/contact/contact_report.hpp"

#include <cmath>
#include <utility>

#include "dem/contact/contact_law.hpp"
#include "drover/base/text.hpp"

namespace drover::dem {

namespace {
std::string vector_text(const Vector& v) { return text("({:.3g}, {:.3g}, {:.3g})", v.x, v.y, v.z); }

struct Quantity {
    const char* name;
    Vector value;
    const char* unit;
};
/// The first of some quantities of a body that is not finite, in words.
std::string non_finite_of(const std::string& body, std::initializer_list<Quantity> quantities) {
    for (const Quantity& q : quantities)
        if (!std::isfinite(q.value.x + q.value.y + q.value.z))
            return text("the {} of {} is {} {}", q.name, body, vector_text(q.value), q.unit);
    return {};
}

Vector velocity_at(const Spheres& spheres, std::uint32_t sphere, std::uint32_t body) {
    const ImpactBody b = impact_body_of(spheres, body);
    return b.velocity + cross(b.spin, from_centre(spheres, sphere));
}
}  // namespace

Name name_of(const Spheres& spheres, std::uint32_t sphere) {
    if (sphere == Overlap::side_wall) return {.kind = Name::Kind::wall};
    if (sphere == Overlap::lid) return {.kind = Name::Kind::lid};
    if (sphere == Overlap::base) return {.kind = Name::Kind::base};
    if (spheres.is_bead(sphere)) return {.kind = Name::Kind::bead, .number = spheres.beads.number[sphere]};
    const std::uint32_t r = spheres.rod(sphere);
    return {.kind = Name::Kind::rod, .number = r, .sphere = sphere - spheres.rods.first[r]};
}

std::string first_non_finite(const Spheres& spheres) {
    for (std::size_t s = 0; s < spheres.beads.size(); ++s) {
        const std::string found = non_finite_of(text("bead {}", spheres.beads.number[s]),
                                                {{"velocity", vector_of(spheres.beads.velocity[s]), "mm/s"},
                                                 {"spin", vector_of(spheres.beads.spin[s]), "rad/s"},
                                                 {"position", vector_of(spheres.position[s]), "mm"}});
        if (!found.empty()) return found;
    }
    for (std::size_t r = 0; r < spheres.rods.size(); ++r) {
        const Rod& rod = spheres.rods.rod[r];
        const std::string found =
            non_finite_of(text("rod {}", r), {{"velocity", rod.velocity, "mm/s"},
                                              {"angular momentum", rod.angular_momentum, "mg mm^2/s"},
                                              {"axis", rod.axis, ""},
                                              {"position", rod.position, "mm"}});
        if (!found.empty()) return found;
    }
    return {};
}

std::string first_too_fast(const Spheres& spheres, double step) {
    const auto is_too_fast = [&](std::size_t sphere, const Vector& velocity) {
        return length(velocity) * step > spheres.position[sphere][3];
    };
    const auto in_words = [&](std::size_t sphere, double speed) {
        const double radius = spheres.position[sphere][3];
        return text(
            "{} moves by {:.3g} mm in a step, more than its radius of {:.3g} mm, and could pass through others: "
            "its speed is {:.3g} mm/s; choose time.dt <= {:.2g}, or values of the scene that make it slower",
            name_text(name_of(spheres, static_cast<std::uint32_t>(sphere))), speed * step, radius, speed,
            0.1 * radius / speed);
    };
    for (std::size_t b = 0; b < spheres.beads.size(); ++b)
        if (const Vector v = vector_of(spheres.beads.velocity[b]); is_too_fast(b, v)) return in_words(b, length(v));
    for (std::size_t r = 0; r < spheres.rods.size(); ++r)
        if (const Vector v = spheres.rods.rod[r].velocity; is_too_fast(spheres.rods.first[r], v))
            return in_words(spheres.rods.first[r], length(v));
    return {};
}

std::string describe_impact(const Overlap& overlap, const Spheres& spheres, double restitution, double friction,
                            std::size_t contacts) {
    const Vector velocity = velocity_at(spheres, overlap.first, overlap.first_body);
    std::string words =
        text("the impulse of {} and {} is not finite (restitution {}, friction {}, {} contacts in the group; ",
             name_text(name_of(spheres, overlap.first)), name_text(name_of(spheres, overlap.second)), restitution,
             friction, contacts);
    words += text("velocity before {} mm/s", vector_text(velocity));
    if (!overlap.is_with_surface())
        words += text(" and {} mm/s", vector_text(velocity_at(spheres, overlap.second, overlap.second_body)));
    return words + ")";
}

double closing_speed(const Overlap& overlap, const Spheres& spheres) {
    Vector velocity = velocity_at(spheres, overlap.first, overlap.first_body);
    if (!overlap.is_with_surface()) velocity = velocity - velocity_at(spheres, overlap.second, overlap.second_body);
    const Vector direction = overlap.is_with_surface() ? overlap.normal : overlap.apart;
    const double size = length(direction);
    return size > 0.0 ? -dot(velocity, direction) / size : length(velocity);
}

std::string cause_of_overlap(const Setup& setup, double depth, double radius, double closing, const NamedStep& step) {
    // What they approach in the step in which they met, with a share for what the impact of others adds.
    const double covered = closing * step.length;
    if (covered >= 0.5 * depth)
        return text(
            "they approach at {:.3g} mm/s, {:.2g} mm a step: the step of {} = {} s is too long for their speed, choose "
            "{} <= {:.2g}",
            closing, covered, step.key, step.length, step.key, 0.5 * setup.contacts.max_overlap * radius / closing);
    const std::string words = text(
        "they approach at {:.3g} mm/s, {:.2g} mm a step of {} = {} s, so the overlap was "
        "there before, or has grown over many steps: ",
        std::max(0.0, closing), std::max(0.0, covered), step.key, step.length);
    if (PairwiseLaw::is_chosen(setup.contacts))
        return words +
               "contacts.law = \"pairwise\" does not correct overlaps, choose fewer bodies, weaker forces or plates, "
               "or a smaller time.dt, which slows the growth";
    if (setup.contacts.model == ContactModel::impulse)
        return words + "choose fewer bodies, weaker forces or plates, or a smaller time.dt, which slows the growth";
    return words + text("contacts of stiffness {} mg/s^2 are too soft for that, choose a larger contacts.stiffness",
                        setup.contacts.stiffness);
}

std::string cause_of_energy(const EnergyBalance& balance) {
    const std::pair<double EnergyBalance::*, const char*> parts[] = {
        {&EnergyBalance::forces, "forces (forces.*)"},
        {&EnergyBalance::kicks, "kicks (kick.strength)"},
        {&EnergyBalance::plates, "plates (plates.amplitude, plates.frequency)"},
        {&EnergyBalance::gravity, "gravity (gravity.*, forces.*)"},
        {&EnergyBalance::impact, "impacts (restitution.*)"},
        {&EnergyBalance::friction, "friction (friction.*)"}};
    const char* worst = nullptr;
    double largest = -1.0;
    for (const auto& [part, name] : parts) {
        const double size = std::abs(balance.*part);
        if (!std::isfinite(size)) return text("the work of {} is {}", name, balance.*part);
        if (size > largest) {
            largest = size;
            worst = name;
        }
    }
    return text("the largest work is that of {}, {:.3g} mg mm^2/s^2", worst, largest);
}

void add(const EnergyBalance& part, EnergyBalance& total) {
    for (const auto entry : balance_parts) total.*entry += part.*entry;
}

void add(const Counts& part, Counts& total) {
    const std::int64_t largest_group = std::max(total.largest_group, part.largest_group);
    for (const auto entry : count_parts) total.*entry += part.*entry;
    total.largest_group = largest_group;
    total.residual = std::max(total.residual, part.residual);
    total.overlap = std::max(total.overlap, part.overlap);
}

}  // namespace drover::dem
