// io/field_export.cpp: frames of fields as legacy VTK and as comma-separated values.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "files/new_file.hpp"
#include "io/export.hpp"
#include "io/scene_text.hpp"
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
}  // namespace

std::vector<std::size_t> chosen_frames(const FrameChoice& choice, std::size_t count, const std::string& name) {
    require(count > 0 && choice.frame < static_cast<std::int64_t>(count), {name},
            "has no frame {}; expected one of 0 to {}", choice.frame, count == 0 ? 0 : count - 1);
    require(choice.every >= 1, {name}, "every {} frames; expected at least 1", choice.every);
    if (choice.frame >= 0) return {static_cast<std::size_t>(choice.frame)};
    std::vector<std::size_t> frames;
    for (std::size_t frame = 0; frame < count; frame += static_cast<std::size_t>(choice.every)) frames.push_back(frame);
    return frames;
}

void check_target(const fs::path& file, bool overwrite, bool (*may_replace)(const fs::path&), const char* else_it_is) {
    std::error_code problem;
    require(!fs::is_directory(file, problem), {file.string()}, "is a folder; expected the name of a file");
    require(overwrite || !fs::exists(file, problem), {file.string()},
            "exists; choose another name, or give --overwrite");
    require(!fs::exists(file, problem) || may_replace(file), {file.string()}, "exists and is {}: choose another name",
            else_it_is);
}

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

}  // namespace drover::io
