// io/trajectory.cpp: bodies to rows of H5MD elements, and back.
#include "io/trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "dem/bodies/walls.hpp"

namespace drover::io {

namespace {
using dem::Bodies;
using dem::Setup;
using dem::Vector;
using Row = std::vector<std::vector<double>>;

constexpr const char* unit_position = "mm";
constexpr const char* unit_velocity = "mm s-1";
constexpr const char* unit_angular_velocity = "rad s-1";

void put(const Vector& vector, std::vector<double>& to) { to.insert(to.end(), {vector.x, vector.y, vector.z}); }

Row sphere_row(const Setup& setup, const Bodies& bodies) {
    const Box box = box_of(setup);
    Row row(4);
    for_spheres(bodies, [&](Sphere sphere) {
        for (const double image : wrap(sphere.position, box)) row[2].push_back(image);
        put(sphere.position, row[0]);
        put(sphere.velocity, row[1]);
    });
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) row[3].push_back(i == j ? box.sides[i] : 0.0);
    return row;
}

Row bead_row(const Setup&, const Bodies& bodies) {
    Row row(3);
    for (const dem::Bead& bead : bodies.beads) {
        put(bead.position, row[0]);
        put(bead.velocity, row[1]);
        put(bead.spin, row[2]);
    }
    return row;
}

Row rod_row(const Setup&, const Bodies& bodies) {
    Row row(4);
    for (const dem::Rod& rod : bodies.rods) {
        put(rod.position, row[0]);
        put(rod.velocity, row[1]);
        put(rod.axis, row[2]);
        put(angular_velocity(rod, bodies.shapes[rod.shape]), row[3]);
    }
    return row;
}

/// An axis of this size; a trajectory uses only its size.
files::Axis sized(const std::string& name, std::size_t size) { return {name, "1", name, std::vector<double>(size)}; }

files::FixedArray fixed(const std::string& name, const std::string& unit, const std::string& meaning,
                        bool is_integer = false) {
    return {.name = name, .unit = unit, .meaning = meaning, .is_integer = is_integer};
}

files::Recording sphere_recording(const Setup& setup, const Bodies& bodies) {
    files::FixedArray id = fixed("id", "1", "number of the sphere", true),
                      species = fixed("species", "1", "0: of a bead, 1: of a rod", true),
                      body = fixed("body", "1", "number of the body, beads first, then rods", true),
                      radius = fixed("radius", "mm", "radius of the sphere");
    for_spheres(bodies, [&](const Sphere& sphere) {
        id.values.push_back(static_cast<double>(id.values.size()));
        species.values.push_back(sphere.of_rod ? 1.0 : 0.0);
        body.values.push_back(static_cast<double>(sphere.body));
        radius.values.push_back(sphere.radius);
    });
    const std::vector<std::string> axes{"sphere", "component"};
    return {.group = spheres_group,
            .axes = {sized("sphere", id.values.size()), sized("component", 3), sized("vector", 3)},
            .quantities = {{"position", unit_position, "centre, in the box", axes},
                           {"velocity", unit_velocity, "velocity of the centre", axes},
                           {"image", "1", "sides of the box to add for the path without jumps", axes, true},
                           {"box/edges",
                            unit_position,
                            "vectors along the sides of the box, which is centred on x = y = 0",
                            {"vector", "component"}}},
            .rows_per_chunk = 1,
            .trajectory = files::Trajectory{.fixed = {id, species, body, radius},
                                            .has_box = true,
                                            .periodic = box_of(setup).periodic}};
}

files::Recording bead_recording(const Bodies& bodies) {
    files::FixedArray mass = fixed("mass", "mg", "mass"), radius = fixed("radius", "mm", "radius");
    for (const dem::Bead& bead : bodies.beads) {
        mass.values.push_back(bodies.shapes[bead.shape].mass);
        radius.values.push_back(bodies.shapes[bead.shape].radius.front());
    }
    const std::vector<std::string> axes{"bead", "component"};
    return {.group = beads_group,
            .axes = {sized("bead", bodies.beads.size()), sized("component", 3)},
            .quantities = {{"position", unit_position, "centre, not wrapped", axes},
                           {"velocity", unit_velocity, "velocity", axes},
                           {"angular_velocity", unit_angular_velocity, "angular velocity", axes}},
            .rows_per_chunk = 1,
            .trajectory = files::Trajectory{.fixed = {mass, radius}}};
}

files::Recording rod_recording(const Bodies& bodies) {
    files::FixedArray mass = fixed("mass", "mg", "mass"),
                      along = fixed("inertia_along", "mg mm2", "moment of inertia about the axis"),
                      across = fixed("inertia_across", "mg mm2", "moment of inertia about an axis across it"),
                      at = fixed("sphere_at", "mm",
                                 "positions of its spheres on the axis, relative to the centre of mass"),
                      radius = fixed("sphere_radius", "mm", "radii of its spheres, tail first");
    at.components = radius.components = bodies.shapes[bodies.rods.front().shape].at.size();
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Shape& shape = bodies.shapes[rod.shape];
        mass.values.push_back(shape.mass);
        along.values.push_back(shape.inertia_along);
        across.values.push_back(shape.inertia_across);
        at.values.insert(at.values.end(), shape.at.begin(), shape.at.end());
        radius.values.insert(radius.values.end(), shape.radius.begin(), shape.radius.end());
    }
    const std::vector<std::string> axes{"rod", "component"};
    return {.group = rods_group,
            .axes = {sized("rod", bodies.rods.size()), sized("component", 3)},
            .quantities = {{"position", unit_position, "centre of mass, not wrapped", axes},
                           {"velocity", unit_velocity, "velocity of the centre of mass", axes},
                           {"axis", "1", "direction n, tail to head", axes},
                           {"angular_velocity", unit_angular_velocity, "angular velocity", axes}},
            .rows_per_chunk = 1,
            .trajectory = files::Trajectory{.fixed = {mass, along, across, at, radius}}};
}

/// Reads the arrays of a frame and checks them against the scene.
struct FrameReader {
    const files::ArchiveReader& archive;
    std::size_t frame;
    const std::string& what;
    const SourceLocation& where;

    std::vector<double> row(const std::string& group, const std::string& element, const char* unit,
                            std::size_t count) const {
        const std::string path = group + "/" + element + "/value";
        require(archive.has(path), where, "{} has no {}; expected an archive of a run with the same bodies", what,
                path);
        const std::vector<std::size_t> shape = archive.shape(path);
        require(shape.size() == 3 && shape[1] == count && shape[2] == 3, where,
                "{} contains {} bodies in {}; expected the {} of this scene", what, shape.size() > 1 ? shape[1] : 0,
                group, count);
        const std::string found_unit = archive.text_attribute(path, "units");
        require(found_unit == unit, where, "{} has {} in {}; expected {}", what, path, found_unit, unit);
        const files::Array found = archive.read_row(path, frame);
        require(std::ranges::all_of(found.values, [](double value) { return std::isfinite(value); }), where,
                "{} has a non-finite value in {} in frame {}; choose another frame", what, path, frame);
        return found.values;
    }

    Row rows(const files::Recording& recording, std::size_t count) const {
        Row found;
        for (const files::Quantity& quantity : recording.quantities)
            found.push_back(row(recording.group, quantity.name, quantity.unit.c_str(), count));
        return found;
    }

    void same(const std::string& group, const files::FixedArray& expected) const {
        const std::string path = group + "/" + expected.name;
        require(archive.has(path), where, "{} has no {}; expected an archive of a run with the same bodies", what,
                path);
        const std::vector<double> found = archive.read(path).values;
        const auto alike = [](double a, double b) {
            return std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b));
        };
        require(found.size() == expected.values.size() &&
                    std::equal(found.begin(), found.end(), expected.values.begin(), alike),
                where,
                "{} has other bodies: {} differs from this scene; expected the same shapes (and, with "
                "rods.size_tolerance > 0, the same run.seed)",
                what, path);
    }
};

Vector vector_at(const std::vector<double>& values, std::size_t i) {
    return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}
}  // namespace

Box box_of(const Setup& setup) {
    const double x = 2.0 * dem::half_width(setup.cell), y = 2.0 * dem::half_height(setup.cell);
    const bool periodic = dem::is_periodic(setup.cell);
    return {.sides = {x, y, 2.0 * setup.plates.amplitude + setup.plates.gap},
            .origin = {-0.5 * x, -0.5 * y, 0.0},
            .periodic = {periodic, periodic, false}};
}

std::array<double, 3> wrap(Vector& position, const Box& box) {
    std::array<double, 3> images{};
    double* const coordinates[] = {&position.x, &position.y, &position.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!box.periodic[axis]) continue;
        double& coordinate = *coordinates[axis];
        images[axis] = std::floor((coordinate - box.origin[axis]) / box.sides[axis]);
        coordinate -= images[axis] * box.sides[axis];
        if (coordinate >= box.origin[axis] + box.sides[axis]) {  // by rounding
            coordinate -= box.sides[axis];
            images[axis] += 1.0;
        }
    }
    return images;
}

std::size_t sphere_count(const Bodies& bodies) {
    std::size_t count = bodies.beads.size();
    for (const dem::Rod& rod : bodies.rods) count += bodies.shapes[rod.shape].at.size();
    return count;
}

std::vector<BodyRecording> trajectory_recordings(const Setup& setup, const Bodies& bodies) {
    std::vector<BodyRecording> recordings;
    if (sphere_count(bodies) > 0) recordings.push_back({sphere_recording(setup, bodies), sphere_row});
    if (!bodies.beads.empty()) recordings.push_back({bead_recording(bodies), bead_row});
    if (!bodies.rods.empty()) recordings.push_back({rod_recording(bodies), rod_row});
    return recordings;
}

bool has_trajectory(const files::ArchiveReader& archive) {
    return archive.has(std::string(spheres_group) + "/position/value");
}

std::size_t frame_count(const files::ArchiveReader& archive) {
    const std::vector<std::size_t> shape = archive.shape(std::string(spheres_group) + "/position/value");
    return shape.empty() ? 0 : shape.front();
}

void read_bodies(const files::ArchiveReader& archive, std::size_t frame, Bodies& bodies, const std::string& what,
                 const SourceLocation& where) {
    const FrameReader reader{archive, frame, what, where};
    for (const auto& [group, count] : {std::pair{beads_group, bodies.beads.size()}, {rods_group, bodies.rods.size()}})
        require(count > 0 || !archive.has(std::string(group) + "/position/value"), where,
                "{} contains bodies in {}, and this scene has none; expected an archive of a run with the same bodies",
                what, group);
    Row beads, rods;
    if (!bodies.beads.empty()) {
        const files::Recording recording = bead_recording(bodies);
        for (const files::FixedArray& array : recording.trajectory->fixed)
            if (array.name != "mass") reader.same(beads_group, array);  // the mass may differ
        beads = reader.rows(recording, bodies.beads.size());
    }
    if (!bodies.rods.empty()) {
        const files::Recording recording = rod_recording(bodies);
        for (const files::FixedArray& array : recording.trajectory->fixed)
            if (array.name.starts_with("sphere_")) reader.same(rods_group, array);
        rods = reader.rows(recording, bodies.rods.size());
    }
    set_bodies(beads, rods, bodies, what, where);
}

void set_bodies(const Row& beads, const Row& rods, Bodies& bodies, const std::string& what,
                const SourceLocation& where) {
    for (std::size_t i = 0; i < bodies.beads.size(); ++i) {
        dem::Bead& bead = bodies.beads[i];
        bead.position = vector_at(beads[0], i);
        bead.velocity = vector_at(beads[1], i);
        bead.spin = vector_at(beads[2], i);
    }
    for (std::size_t i = 0; i < bodies.rods.size(); ++i) {
        dem::Rod& rod = bodies.rods[i];
        const dem::Shape& shape = bodies.shapes[rod.shape];
        const Vector n = vector_at(rods[2], i), angular_velocity = vector_at(rods[3], i);
        const double size = length(n);
        require(std::abs(size - 1.0) < 1e-6, where, "{} has a rod {} whose axis has the length {}; expected 1", what, i,
                size);
        rod.position = vector_at(rods[0], i);
        rod.velocity = vector_at(rods[1], i);
        rod.axis = std::abs(size - 1.0) < 1e-12 ? n : 1.0 / size * n;  // a normalised axis keeps its bits
        rod.angular_momentum = shape.inertia_across * angular_velocity + (shape.inertia_along - shape.inertia_across) *
                                                                             dot(angular_velocity, rod.axis) * rod.axis;
    }
}

}  // namespace drover::io
