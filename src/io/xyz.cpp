// io/xyz.cpp: extended XYZ, written frame by frame and read line by line.
#include "io/xyz.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "drover/base/error.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"
#include "io/scene_text.hpp"
#include "io/trajectory.hpp"

namespace drover::io {

namespace {
using Numbers = std::vector<double>;

constexpr const char *of_bead = "B", *of_rod = "Rh";  // chemical elements: ASE accepts no other species

/// The data shared by all frames.
struct Fixed {
    Numbers id, species, body, radius;  // of spheres
    std::size_t beads = 0, rods = 0;    // bodies
    Numbers bead_radius, sphere_at, sphere_radius;
    Numbers sides;  // of the box along x, y, z
    std::array<bool, 3> periodic{};
};

std::string value_of(const char* group, const char* element) { return std::string(group) + "/" + element + "/value"; }
std::string fixed_of(const char* group, const char* name) { return std::string(group) + "/" + name; }

std::size_t bodies_in(const files::ArchiveReader& archive, const char* group) {
    const std::string path = value_of(group, "position");
    return archive.has(path) ? archive.shape(path).at(1) : 0;
}

/// Three numbers for each of `count` particles of a frame.
Numbers vectors(const files::ArchiveReader& archive, const std::string& path, std::size_t frame, std::size_t count,
                const std::string& name) {
    files::Array row = archive.read_row(path, frame);
    require(row.shape == std::vector<std::size_t>{count, 3}, {name}, "{} is not three numbers for each of {} particles",
            path, count);
    return std::move(row.values);
}

Fixed read_fixed(const files::ArchiveReader& archive, const std::string& name) {
    Fixed fixed;
    fixed.id = archive.read(fixed_of(spheres_group, "id")).values;
    fixed.species = archive.read(fixed_of(spheres_group, "species")).values;
    fixed.body = archive.read(fixed_of(spheres_group, "body")).values;
    fixed.radius = archive.read(fixed_of(spheres_group, "radius")).values;
    const files::Array edges = archive.read_row(value_of(spheres_group, "box/edges"), 0);
    require(edges.values.size() == 9, {name}, "box/edges is not three vectors; expected an archive that drover wrote");
    fixed.sides = {edges.values[0], edges.values[4], edges.values[8]};
    for (const std::vector<double>* one : {&fixed.species, &fixed.body, &fixed.radius})
        require(one->size() == fixed.id.size(), {name},
                "the spheres have {} ids and {} values of another array; it is damaged", fixed.id.size(), one->size());
    fixed.beads = bodies_in(archive, beads_group);
    fixed.rods = bodies_in(archive, rods_group);
    if (fixed.beads > 0) fixed.bead_radius = archive.read(fixed_of(beads_group, "radius")).values;
    if (fixed.rods > 0) {
        fixed.sphere_at = archive.read(fixed_of(rods_group, "sphere_at")).values;
        fixed.sphere_radius = archive.read(fixed_of(rods_group, "sphere_radius")).values;
    }
    const bool is_consistent =
        fixed.bead_radius.size() == fixed.beads && fixed.sphere_at.size() == fixed.sphere_radius.size() &&
        (fixed.rods == 0 || (!fixed.sphere_at.empty() && fixed.sphere_at.size() % fixed.rods == 0));
    require(is_consistent, {name}, "its bodies and shapes are inconsistent; it is damaged");
    const Scene scene = archived_scene(archive.text_attribute("scene"), name);
    fixed.periodic = box_of(scene.particles).periodic;
    return fixed;
}

std::string head(const Fixed& fixed, std::size_t count, double time, double step, const char* properties) {
    const auto letter = [&](std::size_t axis) { return fixed.periodic[axis] ? "T" : "F"; };
    return text(
        "{}\nLattice=\"{} 0 0 0 {} 0 0 0 {}\" Origin=\"{} {} 0\" pbc=\"{} {} {}\" Properties={} Time={} Step={}\n",
        count, fixed.sides[0], fixed.sides[1], fixed.sides[2], -0.5 * fixed.sides[0], -0.5 * fixed.sides[1], letter(0),
        letter(1), letter(2), properties, time, static_cast<std::int64_t>(step));
}

/// Numbers, each preceded by a blank.
std::string triple(const Numbers& values, std::size_t i) {
    return text(" {:.9g} {:.9g} {:.9g}", values[3 * i], values[3 * i + 1], values[3 * i + 2]);
}

std::string sphere_lines(const files::ArchiveReader& archive, const std::string& name, const Fixed& fixed,
                         std::size_t frame) {
    const std::size_t count = fixed.id.size();
    const Numbers position = vectors(archive, value_of(spheres_group, "position"), frame, count, name),
                  velocity = vectors(archive, value_of(spheres_group, "velocity"), frame, count, name);
    std::string out;
    for (std::size_t i = 0; i < count; ++i)
        out += text("{}{} {:.9g}{} {} {}\n", fixed.species[i] == 0.0 ? of_bead : of_rod, triple(position, i),
                    fixed.radius[i], triple(velocity, i), static_cast<std::int64_t>(fixed.id[i]),
                    static_cast<std::int64_t>(fixed.body[i]));
    return out;
}

std::string body_lines(const files::ArchiveReader& archive, const std::string& name, const Fixed& fixed,
                       std::size_t frame) {
    std::string out;
    std::size_t number = 0;
    const auto add = [&](const char* group, std::size_t count, const char* letter, auto length_of) {
        if (count == 0) return;
        Numbers position = vectors(archive, value_of(group, "position"), frame, count, name);
        const Numbers velocity = vectors(archive, value_of(group, "velocity"), frame, count, name),
                      spin = vectors(archive, value_of(group, "angular_velocity"), frame, count, name);
        const Numbers axis = group == rods_group ? vectors(archive, value_of(group, "axis"), frame, count, name)
                                                 : Numbers(3 * count, 0.0);
        for (std::size_t i = 0; i < count; ++i) {
            for (std::size_t k = 0; k < 2; ++k)
                if (fixed.periodic[k]) {
                    const double side = fixed.sides[k];
                    double& coordinate = position[3 * i + k];
                    coordinate -= side * std::floor(coordinate / side + 0.5);
                }
            out += text("{}{} {:.9g}{}{}{} {}\n", letter, triple(position, i), length_of(i), triple(axis, i),
                        triple(velocity, i), triple(spin, i), number++);
        }
    };
    const std::size_t spheres = fixed.rods > 0 ? fixed.sphere_at.size() / fixed.rods : 0;
    add(beads_group, fixed.beads, of_bead, [&](std::size_t i) { return 2.0 * fixed.bead_radius[i]; });
    add(rods_group, fixed.rods, of_rod, [&](std::size_t i) {
        const std::size_t first = i * spheres, last = first + spheres - 1;
        return fixed.sphere_at[last] + fixed.sphere_radius[last] - fixed.sphere_at[first] + fixed.sphere_radius[first];
    });
    return out;
}
}  // namespace

std::size_t write_xyz(const files::ArchiveReader& archive, const std::string& name, const XyzPlan& plan,
                      const std::filesystem::path& file, bool overwrite) {
    require(has_trajectory(archive), {name}, "holds no trajectory; expected the archive of a run of particles");
    const std::size_t frames = frame_count(archive);
    require(plan.frame < static_cast<std::int64_t>(frames), {name}, "has no frame {}; expected one of 0 to {}",
            plan.frame, frames == 0 ? 0 : frames - 1);
    require(plan.every >= 1, {name}, "every {} frames; expected at least 1", plan.every);
    std::error_code problem;
    require(!std::filesystem::is_directory(file, problem), {file.string()}, "is a folder; expected the name of a file");
    require(overwrite || !std::filesystem::exists(file, problem), {file.string()},
            "exists; choose another name, or give --overwrite");
    require(!std::filesystem::exists(file, problem) || is_xyz(file), {file.string()},
            "exists and is not an XYZ file; --overwrite replaces only XYZ files: choose another name");
    const Fixed fixed = read_fixed(archive, name);
    const Numbers times = archive.read(std::string(spheres_group) + "/position/time").values,
                  steps = archive.read(std::string(spheres_group) + "/position/step").values;
    require(times.size() >= frames && steps.size() >= frames, {name}, "has fewer times than frames; it is damaged");
    constexpr const char* of_spheres = "species:S:1:pos:R:3:radius:R:1:velo:R:3:id:I:1:body:I:1";
    constexpr const char* of_bodies =
        "species:S:1:pos:R:3:length:R:1:director:R:3:velo:R:3:angular_velocity:R:3:id:I:1";
    const std::size_t count = plan.bodies ? fixed.beads + fixed.rods : fixed.id.size();
    files::NewFile to(file);
    std::size_t written = 0;
    const std::size_t first = plan.frame >= 0 ? static_cast<std::size_t>(plan.frame) : 0,
                      last = plan.frame >= 0 ? first + 1 : frames;
    for (std::size_t frame = first; frame < last; frame += static_cast<std::size_t>(plan.every)) {
        to.write(head(fixed, count, times[frame], steps[frame], plan.bodies ? of_bodies : of_spheres) +
                 (plan.bodies ? body_lines(archive, name, fixed, frame) : sphere_lines(archive, name, fixed, frame)));
        ++written;
    }
    to.finish();
    return written;
}

namespace {
/// Reads a line of digits as a number.
bool read_count(std::string line, std::size_t& count) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const auto [end, problem] = std::from_chars(line.data(), line.data() + line.size(), count);
    return !line.empty() && problem == std::errc() && end == line.data() + line.size();
}

/// The value of key=value or key="value" in a comment line; "" if absent.
std::string value_in(const std::string& line, const std::string& key) {
    for (std::size_t at = line.find(key + "="); at != std::string::npos; at = line.find(key + "=", at + 1)) {
        if (at > 0 && line[at - 1] != ' ') continue;
        const std::size_t start = at + key.size() + 1;
        if (start < line.size() && line[start] == '"')
            return line.substr(start + 1, line.find('"', start + 1) - start - 1);
        return line.substr(start, line.find_first_of(" \r", start) - start);
    }
    return "";
}
}  // namespace

bool is_xyz(const std::filesystem::path& file) {
    constexpr std::size_t longest_count = 24;
    const std::string line = files::read_start(file, longest_count);
    std::size_t count = 0;
    return line.find('\n') != std::string::npos && read_count(line.substr(0, line.find('\n')), count);
}

XyzInfo read_xyz_info(const std::filesystem::path& file) {
    files::LineReader from(file, "an extended XYZ file");
    XyzInfo info;
    std::string line;
    int number = 0;
    while (from.next(line)) {
        ++number;
        if (line.find_first_not_of(" \r\t") == std::string::npos) continue;
        std::size_t count = 0;
        require(read_count(line, count), {file.string(), number}, "\"{}\"; expected the number of particles of a frame",
                line.substr(0, 40));
        require(from.next(line), {file.string(), number}, "a frame without its second line; the file is truncated");
        ++number;
        if (info.frames == 0) {
            info.lattice = value_in(line, "Lattice");
            info.origin = value_in(line, "Origin");
            info.periodic = value_in(line, "pbc");
            info.properties = value_in(line, "Properties");
        }
        if (const std::string time = value_in(line, "Time"); !time.empty()) {
            double seconds = 0.0;
            const auto [end, problem] = std::from_chars(time.data(), time.data() + time.size(), seconds);
            require(problem == std::errc() && end == time.data() + time.size(), {file.string(), number},
                    "Time={}; expected a number of seconds", time);
            info.times.push_back(seconds);
        }
        for (std::size_t i = 0; i < count; ++i, ++number)
            require(from.next(line), {file.string(), number}, "frame {} has {} lines of {}; the file is truncated",
                    info.frames, i, count);
        info.min_lines = info.frames == 0 ? count : std::min(info.min_lines, count);
        info.max_lines = std::max(info.max_lines, count);
        ++info.frames;
    }
    return info;
}

}  // namespace drover::io
