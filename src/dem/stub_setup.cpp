// dem/stub_setup.cpp: a stand-in for the rows, bodies, walls and packing of a particle world, to be deleted at merge.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/dem/packing.hpp"
#include "drover/dem/wall.hpp"

namespace drover::dem {

void check(const Setup& setup, const PlaceOf& place) {
    require(setup.beads.diameters.size() == setup.beads.parts.size(), place("beads.parts"),
            "beads.parts has {} numbers for {} diameters; expected one each", setup.beads.parts.size(),
            setup.beads.diameters.size());
}

double area(const Cell& cell) {
    return cell.shape == "periodic" || cell.shape == "rectangle" ? cell.lx * cell.ly
                                                                 : std::numbers::pi * cell.radius * cell.radius;
}
double half_width(const Cell& cell) {
    return cell.shape == "periodic" || cell.shape == "rectangle" ? 0.5 * cell.lx : cell.radius;
}
double half_height(const Cell& cell) {
    return cell.shape == "periodic" || cell.shape == "rectangle" ? 0.5 * cell.ly : cell.radius;
}
int walls_near(const Cell&, double, double, double, WallPoint (&)[4]) { return 0; }

Bodies make_bodies(const Setup& setup, std::uint64_t, const PlaceOf&) {
    Bodies bodies;
    bodies.shapes = {make_ball(setup.beads.diameters.front(), setup.beads.density),
                     make_rod(setup.rods.diameters, setup.rods.length, setup.rods.densities.front())};
    const auto count = [&](int asked, double fraction, const Shape& shape) {
        return static_cast<std::size_t>(asked > 0 ? asked
                                                  : std::lround(fraction * area(setup.cell) / shape.projected_area));
    };
    bodies.beads.assign(count(setup.beads.count, setup.beads.area_fraction, bodies.shapes[0]), Bead{.shape = 0});
    bodies.rods.assign(count(setup.rods.count, setup.rods.area_fraction, bodies.shapes[1]), Rod{.shape = 1});
    return bodies;
}

Packed pack(const Setup& setup, std::uint64_t seed, const PlaceOf& place) {
    Packed packed{.bodies = make_bodies(setup, seed, place)};
    const std::size_t all = packed.bodies.beads.size() + packed.bodies.rods.size();
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(all))));
    std::size_t i = 0;
    const double z = 2.0 * setup.plates.amplitude + 0.6 * setup.plates.gap;
    const auto next = [&] {
        const double x = (static_cast<double>(i % side) + 0.5) / static_cast<double>(side) - 0.5,
                     y = (static_cast<double>(i / side) + 0.5) / static_cast<double>(side) - 0.5;
        ++i;
        return Vector{1.4 * x * half_width(setup.cell), 1.4 * y * half_height(setup.cell), z};
    };
    for (Rod& rod : packed.bodies.rods) {
        rod.position = next();
        const double angle = setup.packing.kind == "aligned" ? 0.0 : 2.4 * static_cast<double>(i + seed);
        rod.axis = {std::cos(angle), std::sin(angle), 0.0};
    }
    for (Bead& bead : packed.bodies.beads) bead.position = next();
    return packed;
}

}  // namespace drover::dem

namespace drover {
using namespace dem;
#define ROW(S, m) \
    { .name = #m, .member = &S::m, .sentence = "a stand-in for one" }
#define ROWS(S, ...)                                        \
    template <>                                             \
    const std::vector<Row<S>>& schema<S>() {                \
        static const std::vector<Row<S>> rows{__VA_ARGS__}; \
        return rows;                                        \
    }
ROWS(Cell,
     {.name = "shape",
      .member = &Cell::shape,
      .choices = {"periodic", "rectangle", "circle", "flower"},
      .sentence = "a stand-in for one"},
     ROW(Cell, lx), ROW(Cell, ly), ROW(Cell, radius), ROW(Cell, petals), ROW(Cell, petal_radius))
ROWS(Plates, ROW(Plates, amplitude), ROW(Plates, frequency), ROW(Plates, gap), ROW(Plates, lid))
ROWS(Gravity, ROW(Gravity, x), ROW(Gravity, y), ROW(Gravity, z))
ROWS(BeadSupply, ROW(BeadSupply, area_fraction), ROW(BeadSupply, count), ROW(BeadSupply, diameters),
     ROW(BeadSupply, parts), ROW(BeadSupply, density))
ROWS(RodSupply, ROW(RodSupply, area_fraction), ROW(RodSupply, count), ROW(RodSupply, diameters), ROW(RodSupply, length),
     ROW(RodSupply, densities), ROW(RodSupply, size_tolerance))
ROWS(Restitution, ROW(Restitution, bead_bead), ROW(Restitution, rod_bead), ROW(Restitution, rod_rod),
     ROW(Restitution, bead_plate), ROW(Restitution, rod_plate), ROW(Restitution, bead_wall), ROW(Restitution, rod_wall))
ROWS(Friction, ROW(Friction, bead_bead), ROW(Friction, rod_bead), ROW(Friction, rod_rod), ROW(Friction, bead_plate),
     ROW(Friction, rod_plate), ROW(Friction, bead_wall), ROW(Friction, rod_wall))
ROWS(Kick, ROW(Kick, strength))
ROWS(BodyForces, ROW(BodyForces, bead_x), ROW(BodyForces, bead_y), ROW(BodyForces, rod_x), ROW(BodyForces, rod_y),
     ROW(BodyForces, torque), ROW(BodyForces, angle), ROW(BodyForces, hold_beads), ROW(BodyForces, bead_velocity_x),
     ROW(BodyForces, bead_velocity_y))
ROWS(ContactControl, ROW(ContactControl, law), ROW(ContactControl, restitution), ROW(ContactControl, track_slip),
     ROW(ContactControl, increments), ROW(ContactControl, substep), ROW(ContactControl, together),
     ROW(ContactControl, skin), ROW(ContactControl, overlap_most))
ROWS(Packing, {.name = "kind", .member = &Packing::kind, .choices = {"random", "aligned", "file"}, .sentence = "a stand-in for one"},
     ROW(Packing, file), ROW(Packing, frame))
#undef ROW
#undef ROWS
}  // namespace drover
