// io/xyz.cpp: extended XYZ, written frame by frame and read line by line.
#include <algorithm>
#include <charconv>

#include "drover/base/error.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"
#include "io/export.hpp"
#include "io/scene_text.hpp"
#include "io/trajectory.hpp"

namespace drover::io {

namespace {
using Numbers = std::vector<double>;

constexpr const char *of_bead = "B", *of_rod = "Rh";  // chemical elements: ASE accepts no other species

std::string head(const Box& box, std::size_t count, double time, double step, const char* properties) {
    const auto letter = [&](std::size_t axis) { return box.periodic[axis] ? "T" : "F"; };
    return text(
        "{}\nLattice=\"{} 0 0 0 {} 0 0 0 {}\" Origin=\"{} {} 0\" pbc=\"{} {} {}\" Properties={} Time={} Step={}\n",
        count, box.sides[0], box.sides[1], box.sides[2], box.origin[0], box.origin[1], letter(0), letter(1), letter(2),
        properties, time, static_cast<std::int64_t>(step));
}

/// Numbers, each preceded by a blank.
std::string triple(const dem::Vector& values) { return text(" {:.9g} {:.9g} {:.9g}", values.x, values.y, values.z); }

std::string sphere_lines(const dem::Bodies& bodies, const Box& box) {
    std::string out;
    std::size_t number = 0;
    for_spheres(bodies, [&](Sphere sphere) {
        wrap(sphere.position, box);
        out += text("{}{} {:.9g}{} {} {}\n", sphere.of_rod ? of_rod : of_bead, triple(sphere.position), sphere.radius,
                    triple(sphere.velocity), number++, sphere.body);
    });
    return out;
}

std::string body_lines(const dem::Bodies& bodies, const Box& box) {
    std::string out;
    std::size_t number = 0;
    const auto add = [&](const char* species, const auto& body, double length, const dem::Vector& axis,
                         const dem::Vector& spin) {
        dem::Vector position = body.position;
        wrap(position, box);
        out += text("{}{} {:.9g}{}{}{} {}\n", species, triple(position), length, triple(axis), triple(body.velocity),
                    triple(spin), number++);
    };
    for (const dem::Bead& bead : bodies.beads)
        add(of_bead, bead, 2.0 * bodies.shapes[bead.shape].radius.front(), {}, bead.spin);
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Shape& shape = bodies.shapes[rod.shape];
        add(of_rod, rod, shape.head - shape.tail, rod.axis, angular_velocity(rod, shape));
    }
    return out;
}

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

std::size_t write_xyz(const files::ArchiveReader& archive, const std::string& name, const FrameChoice& choice,
                      bool of_bodies, const std::filesystem::path& file, bool overwrite) {
    require(has_trajectory(archive), {name}, "holds no trajectory; expected the archive of a run of particles");
    const std::vector<std::size_t> frames = chosen_frames(choice, frame_count(archive), name);
    check_target(file, overwrite, is_xyz, "not an XYZ file; --overwrite replaces only XYZ files");
    const Scene scene = archived_scene(archive.text_attribute("scene"), name);
    const Box box = box_of(scene.particles);
    dem::Bodies bodies = dem::make_bodies(scene.particles, static_cast<std::uint64_t>(scene.run.seed));
    const Numbers times = archive.read(std::string(spheres_group) + "/position/time").values,
                  steps = archive.read(std::string(spheres_group) + "/position/step").values;
    require(std::min(times.size(), steps.size()) > frames.back(), {name}, "has fewer times than frames; it is damaged");
    const std::size_t count = of_bodies ? bodies.beads.size() + bodies.rods.size() : sphere_count(bodies);
    const char* properties = of_bodies
                                 ? "species:S:1:pos:R:3:length:R:1:director:R:3:velo:R:3:angular_velocity:R:3:id:I:1"
                                 : "species:S:1:pos:R:3:radius:R:1:velo:R:3:id:I:1:body:I:1";
    files::NewFile to(file);
    for (const std::size_t frame : frames) {
        read_bodies(archive, frame, bodies, "the archive", {name});
        to.write(head(box, count, times[frame], steps[frame], properties) +
                 (of_bodies ? body_lines(bodies, box) : sphere_lines(bodies, box)));
    }
    to.finish();
    return frames.size();
}

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
