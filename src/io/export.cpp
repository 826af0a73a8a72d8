// io/export.cpp: frames of fields as legacy VTK and as comma-separated values; extended XYZ, written frame by frame and
// read line by line.
#include "io/export.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <charconv>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "files/input_file.hpp"
#include "files/new_file.hpp"
#include "io/scene.hpp"
#include "io/trajectory.hpp"
#include "physics/equations.hpp"

namespace drover::io {

namespace {
namespace fs = std::filesystem;

/// A component of a field.
struct Column {
    std::string name, unit;
    std::string vector = {};  ///< of which it is the x component; "": of none
    bool is_second = false;   ///< the y component of the vector before it
};

/// The fields of an archive and the points of their grid.
struct Source {
    const files::ArchiveReader& archive;
    const std::string& name;
    std::vector<double> x, y, times;
    std::vector<Column> columns;

    std::vector<double> row(const std::string& column, std::size_t frame) const {
        files::Array found = archive.read_row("/" + column, frame);
        require(found.shape == std::vector<std::size_t>{y.size(), x.size()}, {name},
                "{} is not an array over y and x; the archive is damaged", column);
        return std::move(found.values);
    }
};

Source source_of(const files::ArchiveReader& archive, const std::string& name) {
    const Scene scene = archived_scene(archive.text_attribute("scene"), name);
    require(has_grid(scene.kind) && archive.has("/time"), {name},
            "holds no fields; expected the archive of a run of fields: particles are exported to a file .xyz");
    Source source{.archive = archive,
                  .name = name,
                  .x = archive.read("/x").values,
                  .y = archive.read("/y").values,
                  .times = archive.read("/time").values};
    const model::Equations equations = scene.kind == SceneKind::model ? model::Equations(model_of(scene.declared))
                                                                      : physics::Equations(scene.model).solver();
    const auto add = [&](const model::StateComponent& one) {
        const model::Field& field = equations.model().fields[one.field];
        Column column{.name = one.name, .unit = archive.text_attribute("/" + one.name, "units")};
        if (field.spin == 1 && one.part == 0) column.vector = field.name;
        column.is_second = field.spin == 1 && one.part == 1;
        source.columns.push_back(std::move(column));
    };
    for (const model::StateComponent& one : model::components_of_state(equations)) add(one);
    for (const model::StateComponent& one : model::components_in_balance(equations))
        if (archive.has("/" + one.name)) add(one);
    return source;
}

/// VTK's binary numbers are big-endian.
void add_number(double value, std::string& out) {
    auto bytes = std::bit_cast<std::array<char, sizeof(double)>>(value);
    if constexpr (std::endian::native == std::endian::little) std::ranges::reverse(bytes);
    out.append(bytes.data(), bytes.size());
}

/// The distance of points; of a single one the side of its cell is unknown, and 1 serves.
double spacing(const std::vector<double>& points) { return points.size() > 1 ? points[1] - points[0] : 1.0; }

/// For a title, which is one line.
std::string title_of(const Source& source) {
    std::string name = fs::path(source.name).filename().string().substr(0, 200);
    std::ranges::replace_if(
        name, [](unsigned char letter) { return std::iscntrl(letter) != 0; }, '_');
    return name;
}

std::string vtk_text(const Source& source, std::size_t frame) {
    std::string out =
        text("# vtk DataFile Version 3.0\n{}, frame {}\nBINARY\nDATASET STRUCTURED_POINTS\n", title_of(source), frame);
    out += "FIELD FieldData 1\nTIME 1 1 double\n";
    add_number(source.times[frame], out);
    out += text("\nDIMENSIONS {} {} 1\nORIGIN {} {} 0\nSPACING {} {} 1\nPOINT_DATA {}\n", source.x.size(),
                source.y.size(), source.x.front(), source.y.front(), spacing(source.x), spacing(source.y),
                source.x.size() * source.y.size());
    const std::size_t points = source.x.size() * source.y.size();
    const auto arrays = std::ranges::count_if(source.columns, [](const Column& column) { return !column.is_second; });
    out += text("FIELD fields {}\n", arrays);  // readers skip all SCALARS but the first unless told otherwise
    for (std::size_t c = 0; c < source.columns.size(); ++c) {
        const auto& [name, unit, vector, is_second] = source.columns[c];
        if (is_second) continue;  // with its x component
        const std::vector<double> first = source.row(name, frame);
        if (vector.empty()) {
            out += text("{} 1 {} double\n", name, points);
            for (const double value : first) add_number(value, out);
        } else {
            const std::vector<double> second = source.row(source.columns[c + 1].name, frame);
            out += text("{} 3 {} double\n", vector, points);
            for (std::size_t i = 0; i < points; ++i)
                for (const double value : {first[i], second[i], 0.0}) add_number(value, out);
        }
        out += '\n';
    }
    return out;
}

std::string csv_head(const Source& source) {
    std::string out;
    for (const char* axis : {"time", "x", "y"})
        out += text("{}{} [{}]", out.empty() ? "" : ",", axis,
                    source.archive.text_attribute(std::string("/") + axis, "units"));
    for (const Column& column : source.columns) out += text(",{} [{}]", column.name, column.unit);
    return out + "\n";
}

std::string csv_text(const Source& source, std::size_t frame) {
    const auto rows = mapped(source.columns, [&](const Column& column) { return source.row(column.name, frame); });
    std::string out;
    for (std::size_t j = 0; j < source.y.size(); ++j)
        for (std::size_t i = 0; i < source.x.size(); ++i) {
            out += text("{},{},{}", source.times[frame], source.x[i], source.y[j]);
            for (const std::vector<double>& row : rows) out += text(",{}", row[j * source.x.size() + i]);
            out += '\n';
        }
    return out;
}

bool is_no_archive(const fs::path& file) { return !files::is_hdf5(file); }

fs::path numbered(const fs::path& file, std::size_t frame) {
    fs::path name = file.stem();
    name += text("-{:04}", frame);
    name += file.extension();  // not replace_extension: the stem may have a dot
    return file.parent_path() / name;
}

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

/// The numbers of the frames, of `count`.  Throws an input Error, at `name`, for a frame that is missing.
std::vector<std::size_t> chosen_frames(const FrameChoice& choice, std::size_t count, const std::string& name) {
    require(count > 0 && choice.frame < static_cast<std::int64_t>(count), {name},
            "has no frame {}; expected one of 0 to {}", choice.frame, count == 0 ? 0 : count - 1);
    require(choice.every >= 1, {name}, "every {} frames; expected at least 1", choice.every);
    if (choice.frame >= 0) return {static_cast<std::size_t>(choice.frame)};
    std::vector<std::size_t> frames;
    for (std::size_t frame = 0; frame < count; frame += static_cast<std::size_t>(choice.every)) frames.push_back(frame);
    return frames;
}

/// Throws an input Error for a folder, and for an existing file unless `overwrite` is set and the file may be replaced.
void check_target(const fs::path& file, bool overwrite, bool (*may_replace)(const fs::path&), const char* else_it_is) {
    std::error_code problem;
    require(!fs::is_directory(file, problem), {file.string()}, "is a folder; expected the name of a file");
    require(overwrite || !fs::exists(file, problem), {file.string()},
            "exists; choose another name, or give --overwrite");
    require(!fs::exists(file, problem) || may_replace(file), {file.string()}, "exists and is {}: choose another name",
            else_it_is);
}
}  // namespace

bool is_field_export(const fs::path& file) { return file.extension() == ".vtk" || file.extension() == ".csv"; }

std::vector<fs::path> write_fields(const files::ArchiveReader& archive, const std::string& name,
                                   const FrameChoice& choice, const fs::path& file, bool overwrite) {
    const Source source = source_of(archive, name);
    const std::vector<std::size_t> frames = chosen_frames(choice, source.times.size(), name);
    const auto check = [&](const fs::path& one) {
        check_target(one, overwrite, is_no_archive, "an archive, which --overwrite does not replace here");
    };
    std::vector<fs::path> written;
    if (file.extension() == ".vtk") {
        for (const std::size_t frame : frames) written.push_back(choice.frame >= 0 ? file : numbered(file, frame));
        std::ranges::for_each(written, check);
        for (std::size_t i = 0; i < frames.size(); ++i) files::replace_file(written[i], vtk_text(source, frames[i]));
        return written;
    }
    check(file);
    files::NewFile table(file);
    table.write(csv_head(source));
    for (const std::size_t frame : frames) table.write(csv_text(source, frame));
    table.finish();
    return {file};
}

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
