// dem/world/setup_check.cpp: consistency of the parameters of a particle world.
#include "drover/dem/setup.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "base/unread_keys.hpp"
#include "dem/packing/packing.hpp"
#include "drover/base/text.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

namespace {
/// Checks the ranges and choices of a section's rows.  Those of a scene were checked when it was read, those of a setup
/// made in code were not.
template <class Struct>
void check_rows(const Struct& section, const std::string& name, const Locate& locate) {
    const std::vector<std::pair<std::string, Value>> values = values_of(section);
    const std::vector<Description> rows = descriptions<Struct>();
    for (std::size_t i = 0; i < rows.size(); ++i)
        checked_value(rows[i], name, {.value = values[i].second, .where = locate(name + "." + rows[i].name)});
}

/// The location of the first of these conflicting keys that the scene gives.
SourceLocation first_given(const Locate& locate, std::initializer_list<const char*> keys) {
    for (const char* key : keys)
        if (SourceLocation where = locate(key); where.line > 0) return where;
    return locate(*keys.begin());
}

/// Number and dimensions of the bodies of a supply.
struct SupplySize {
    double count = 0.0, area = 0.0;         ///< of all its bodies [mm^2]
    double thickest = 0.0, thinnest = 0.0;  ///< diameters of its spheres, 0 where there are none [mm]
    double length = 0.0;                    ///< [mm]
};

template <class Supply>
SupplySize asked(const Supply& supply, const std::string& name, double area_cell, double area_body,
                 const Locate& locate) {
    const std::string key = name + ".area_fraction";
    require(supply.count == 0 || supply.area_fraction == 0.0, locate(name + ".count"),
            "{}.count = {} and {} = {}; expected one of the two: set the other to 0", name, supply.count, key,
            supply.area_fraction);
    const double count = supply.count > 0 ? supply.count : std::round(supply.area_fraction * area_cell / area_body);
    require(supply.area_fraction == 0.0 || count >= 1.0, locate(key),
            "{} = {} is less than half a body in a cell of {:.4g} mm^2; expected more, a larger cell, or 0 for none",
            key, supply.area_fraction, area_cell);
    constexpr double max_bodies = 1e7;
    require(count <= max_bodies, locate(key), "{} = {} asks for {:.3g} bodies; expected at most {:.0e}", key,
            supply.area_fraction, count, max_bodies);
    if (count == 0.0) return {};
    const auto [min, max] = std::ranges::minmax_element(supply.diameters);
    return {.count = count, .area = count * area_body, .thickest = *max, .thinnest = *min};
}

SupplySize check_beads(const BeadSupply& beads, double area_cell, const Locate& locate) {
    require(!beads.diameters.empty(), locate("beads.diameters"), "beads.diameters is empty; expected at least one");
    require(beads.proportions.size() == beads.diameters.size(),
            first_given(locate, {"beads.proportions", "beads.diameters"}),
            "beads.proportions has {} numbers beside {} of beads.diameters; expected one for each diameter",
            beads.proportions.size(), beads.diameters.size());
    const double sum = std::accumulate(beads.proportions.begin(), beads.proportions.end(), 0.0);
    require(sum > 0.0 && std::isfinite(sum), locate("beads.proportions"),
            "beads.proportions sum to {}; expected at least one number above 0", sum);
    SupplySize result = asked(beads, "beads", area_cell, mean_area(beads), locate);
    result.length = result.thickest;
    return result;
}

SupplySize check_rods(const RodSupply& rods, double area_cell, const Locate& locate) {
    require(!rods.diameters.empty(), locate("rods.diameters"), "rods.diameters is empty; expected at least one");
    require(!rods.densities.empty(), locate("rods.densities"), "rods.densities is empty; expected at least one");
    require(*std::ranges::max_element(rods.densities) > 0.0, locate("rods.densities"),
            "rods.densities holds no number above 0; expected at least one: otherwise rods have no mass");
    const Shape shape = rod_shape(rods, 1.0, locate);
    SupplySize result = asked(rods, "rods", area_cell, shape.projected_area, locate);
    if (result.count > 0.0) result.length = shape.head - shape.tail;
    return result;
}

void check_flower(const Cell& cell, const Locate& locate) {
    if (cell.shape != CellShape::flower) return;
    const double min_radius = cell.radius * std::sin(std::numbers::pi / cell.petals);
    // Allows for rounding of half circles given as decimals.
    require(
        cell.petal_radius >= (1.0 - 1e-9) * min_radius, locate("cell.petal_radius"),
        "cell.petal_radius = {} mm does not span the {:.6g} mm between two inner corners; expected at least {:.6g}, or "
        "more petals",
        cell.petal_radius, 2.0 * min_radius, min_radius);
}

/// Of a periodic cell, the default: --set gives a scene another shape, and the other dimensions stay.
void check_unread(const Cell& cell, const Locate& locate) {
    if (!is_periodic(cell)) return;
    const std::string petals = "cell.shape = \"flower\"";
    reject_unread(cell, "cell", "cell.shape = \"periodic\"",
                  {{"radius", {false, "cell.shape = \"circle\" or \"flower\""}},
                   {"petals", {false, petals}},
                   {"petal_radius", {false, petals}}},
                  locate);
}

/// Checks that bodies fit the cell in every direction.
void check_cell_size(const Setup& setup, double thickest, double longest, const Locate& locate) {
    const Cell& cell = setup.cell;
    const double reach = 2.0 * (thickest + setup.contacts.skin);
    for (const auto& [key, side] : {std::pair{"cell.lx", cell.lx}, std::pair{"cell.ly", cell.ly}}) {
        if (is_periodic(cell) && thickest > 0.0) {
            require(side > reach, locate(key),
                    "{} = {} mm; expected more than {} mm, twice the largest diameter and contacts.skin together: "
                    "otherwise a body could overlap another on both sides of the periodic cell",
                    key, side, reach);
            require(side >= longest, locate(key),
                    "{} = {} mm; expected at least {} mm, the length of a body: otherwise it would overlap itself", key,
                    side, longest);
        }
        require(cell.shape != CellShape::rectangle || side > thickest, locate(key),
                "{} = {} mm between walls, with bodies {} mm thick; expected more", key, side, thickest);
    }
    require(cell.shape != CellShape::rectangle || std::hypot(cell.lx, cell.ly) > longest, locate("cell.lx"),
            "cell.lx = {} mm and cell.ly = {} mm, with bodies {} mm long; expected a cell they fit", cell.lx, cell.ly,
            longest);
    require(cell.shape != CellShape::rectangle || setup.packing.kind != PackingKind::aligned || cell.lx > longest,
            locate("cell.lx"), "cell.lx = {} mm, with bodies {} mm long, aligned with x; expected more", cell.lx,
            longest);
    require(cell.shape != CellShape::circle || 2.0 * cell.radius > longest, locate("cell.radius"),
            "cell.radius = {} mm, with bodies {} mm long; expected more than half of that", cell.radius, longest);
}

void check_forces(const Setup& setup, double beads, const Locate& locate) {
    const BodyForces& forces = setup.forces;
    require(!forces.hold_beads || beads > 0.0, locate("forces.hold_beads"),
            "forces.hold_beads = true without beads; expected beads whose velocity it can hold");
    for (const auto& [key, value] : {std::pair{"forces.bead_velocity_x", forces.bead_velocity_x},
                                     std::pair{"forces.bead_velocity_y", forces.bead_velocity_y},
                                     std::pair{"forces.held_waves", static_cast<double>(forces.held_waves)}})
        require(forces.hold_beads || value == 0.0, locate(key),
                "{} = {} has no effect without forces.hold_beads; set forces.hold_beads = true, or leave it out", key,
                value);
    reject_unread(forces, "forces", "forces.torque = 0", {{"angle", {forces.torque != 0.0, "a forces.torque > 0"}}},
                  locate);
    reject_unread(forces, "forces", "forces.push = 0",
                  {{"push_waves", {forces.push != 0.0, "a forces.push other than 0"}}}, locate);
    for (const auto& [key, on] : {std::pair{"forces.held_waves", forces.hold_beads && forces.held_waves > 0},
                                  std::pair{"forces.push", forces.push != 0.0}})
        require(!on || is_periodic(setup.cell), locate(key),
                "{} asks for waves in a cell of shape \"{}\"; expected \"periodic\", which they fit", key,
                setup.cell.shape);
}

/// Rejects keys of [contacts] that the chosen law does not read, unless they have their default.
void check_unread(const ContactControl& contacts, const Locate& locate) {
    const bool impulse = contacts.model == ContactModel::impulse,
               pairwise = impulse && contacts.law == GroupLaw::pairwise;
    const bool simultaneous = impulse && contacts.law == GroupLaw::simultaneous;
    const bool in_turn = impulse && !pairwise && !simultaneous, groups = simultaneous || in_turn;
    const bool slip_before = in_turn && !contacts.track_slip;
    const std::string chosen = !impulse      ? text("contacts.model = \"{}\"", contacts.model)
                               : slip_before ? "contacts.track_slip = false"
                                             : text("contacts.law = \"{}\"", contacts.law);
    const char* const soft = "a contacts.model of soft bodies";
    const char* const by_groups = "a contacts.law with groups";
    const std::map<std::string, Reading> readings{
        {"law", {impulse, "contacts.model = \"impulse\""}},
        {"restitution", {groups && !slip_before, "a contacts.law with groups that tracks the slip"}},
        {"track_slip", {groups, by_groups}},
        {"increments", {simultaneous, "contacts.law = \"simultaneous\""}},
        {"inelastic_threshold", {simultaneous, "contacts.law = \"simultaneous\""}},
        {"substep", {groups, by_groups}},
        {"simultaneity_gap", {groups, by_groups}},
        {"order", {pairwise, "contacts.law = \"pairwise\""}},
        {"friction", {pairwise, "contacts.law = \"pairwise\""}},
        {"rod_step", {pairwise, "contacts.law = \"pairwise\""}},
        {"stiffness", {!impulse, soft}},
        {"tangential_stiffness_ratio", {!impulse, soft}}};
    reject_unread(contacts, "contacts", chosen, readings, locate);
}

void check_contacts(const Setup& setup, double thinnest, const Locate& locate) {
    check_unread(setup.contacts, locate);
    require(setup.rods.bearing == Bearing::hull || setup.contacts.model != ContactModel::impulse ||
                setup.contacts.law == GroupLaw::pairwise,
            locate("rods.bearing"),
            "rods.bearing = \"{}\" has no effect with contacts.law = \"{}\", where bodies do not overlap a plate; "
            "expected \"hull\", or contacts.law = \"pairwise\"",
            setup.rods.bearing, setup.contacts.law);
    require(thinnest == 0.0 || setup.contacts.simultaneity_gap < 0.5 * thinnest, locate("contacts.simultaneity_gap"),
            "contacts.simultaneity_gap = {} mm with spheres of radius {} mm; expected much less",
            setup.contacts.simultaneity_gap, 0.5 * thinnest);
    constexpr double periods = 0.05;
    for (const auto& [key, step] :
         {std::pair{"contacts.substep", setup.contacts.substep}, {"contacts.rod_step", setup.contacts.rod_step}})
        require(step * setup.plates.frequency <= periods, first_given(locate, {key, "plates.frequency"}),
                "{} = {} s with plates.frequency = {} 1/s; expected at most {} of a period: otherwise rods penetrate "
                "the plates",
                key, step, setup.plates.frequency, periods);
    const Packing& packing = setup.packing;
    require(packing.kind != PackingKind::file || !packing.file.empty(), locate("packing.kind"),
            "packing.kind = \"file\" without packing.file; name the file");
    require(packing.kind == PackingKind::file || packing.file.empty(), locate("packing.file"),
            "packing.file is given with packing.kind = \"{}\"; expected \"file\"", packing.kind);
    reject_unread(packing, "packing", text("packing.kind = \"{}\"", packing.kind),
                  {{"frame", {packing.kind == PackingKind::file, "packing.kind = \"file\""}}}, locate);
}
}  // namespace

void check(const Setup& setup, const Locate& locate) {
    for_sections(setup, [&](const char* name, const char*, const auto& section) { check_rows(section, name, locate); });
    check_unread(setup.cell, locate);
    check_flower(setup.cell, locate);
    const double area_cell = area(setup.cell);
    const SupplySize beads = check_beads(setup.beads, area_cell, locate),
                     rods = check_rods(setup.rods, area_cell, locate);
    const double thickest = std::max(beads.thickest, rods.thickest);
    require(!setup.plates.lid || thickest < setup.plates.gap,
            first_given(locate, {"plates.gap", beads.thickest > rods.thickest ? "beads.diameters" : "rods.diameters"}),
            "plates.gap = {} mm, with bodies {} mm thick; expected a larger gap, or plates.lid = false",
            setup.plates.gap, thickest);
    check_cell_size(setup, thickest, std::max(beads.length, rods.length), locate);
    require(beads.area + rods.area <= area_cell,
            beads.area >= rods.area ? first_given(locate, {"beads.area_fraction", "beads.count"})
                                    : first_given(locate, {"rods.area_fraction", "rods.count"}),
            "beads cover {:.4g} and rods {:.4g} of the cell's area; expected no more than 1 together: bodies of one "
            "layer do not fit otherwise",
            beads.area / area_cell, rods.area / area_cell);
    check_forces(setup, beads.count, locate);
    double thinnest = beads.count > 0.0 ? beads.thinnest : rods.thinnest;
    if (rods.count > 0.0) thinnest = std::min(thinnest, rods.thinnest);
    check_contacts(setup, thinnest, locate);
}

}  // namespace drover::dem
