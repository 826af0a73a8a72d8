// report/info.cpp: what a file holds, for people and as JSON.
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/mapped.hpp"
#include "io/calibration.hpp"
#include "io/export.hpp"
#include "io/trajectory.hpp"
#include "report/shown.hpp"
#include "run/loop/scene_support.hpp"
#include "run/simulation_type.hpp"

namespace drover::report {

namespace {
/// Whether an archive is that of a result, by its title, and not that of a run or a table.
bool is_result(const files::ArchiveReader& archive) {
    const std::string title = files::text_in(archive.attributes(), "title");
    for (const char* what : {"boundary", "onset", "stability", "states", "sweep"})
        if (title.starts_with(text("drover {} of ", what))) return true;
    return false;
}

std::vector<files::StoredArray> arrays_by_path(const files::ArchiveReader& archive) {
    std::vector<files::StoredArray> arrays = archive.contents().arrays;
    std::ranges::sort(arrays, {}, &files::StoredArray::path);
    return arrays;
}

/// "0.5", "16 by 9: 0 to 2.5, 3 not finite".
std::string content_text(const files::Array& array) {
    std::vector<double> finite;
    for (const double value : array.values)
        if (std::isfinite(value)) finite.push_back(value);
    if (array.shape.empty() && array.values.size() == 1) return text("{:.6g}", array.values.front());
    std::string out = joined(mapped(array.shape, [](std::size_t size) { return text("{}", size); }), " by ");
    if (!finite.empty()) {
        const auto [min, max] = std::ranges::minmax_element(finite);
        out += text(": {:.6g} to {:.6g}", *min, *max);
    }
    if (finite.size() < array.values.size()) out += text(", {} not finite", array.values.size() - finite.size());
    return out;
}

/// All arrays of an archive for people: a single number with its value, others with their shape and range.
std::string stored_text(const files::ArchiveReader& archive) {
    std::string out;
    for (const files::StoredArray& array : arrays_by_path(archive)) {
        const std::string unit = files::text_in(array.attributes, "units"),
                          meaning = files::text_in(array.attributes, "comment");
        out += text("{:<40} {}{}\n", array.path, content_text(archive.read(array.path)),
                    unit == "1" || unit.empty() ? "" : " " + unit);
        if (!meaning.empty()) out += text("    {}\n", meaning);
    }
    return out;
}

/// A file as text: lines of numbers of it, and its results.
struct Shown {
    std::string head, results;
};

std::string line(const std::string& name, const std::string& value) { return text("{:<20} {}\n", name, value); }

std::string frames_line(std::size_t count, const std::vector<double>& times) {
    return line("frames", text("{}{}", count,
                               times.empty() ? "" : text(", t = {:.6g} to {:.6g} s", times.front(), times.back())));
}

/// Trajectory of a particle archive.
std::string trajectory_text(const files::ArchiveReader& archive, const io::Scene& scene) {
    const std::string spheres = io::spheres_group;
    const std::vector<double> times = archive.read(spheres + "/position/time").values;
    const io::Box box = io::box_of(scene.particles);
    std::string out = frames_line(times.size(), times) +
                      line("spheres", text("{}", archive.shape(spheres + "/position/value").at(1)));
    for (const auto& [name, group] : {std::pair{"beads", io::beads_group}, {"rods", io::rods_group}})
        if (const std::string path = std::string(group) + "/position/value"; archive.has(path))
            out += line(name, text("{}", archive.shape(path).at(1)));
    return out +
           line("cell", text("{}: {:g} by {:g} by {:g} mm", scene.particles.cell.shape, box.sides[0], box.sides[1],
                             box.sides[2])) +
           line("groups",
                text("{} (H5MD), /bodies{}", spheres, run::is_start(archive) ? "" : text(", {}", io::series_group)));
}

Shown shown(const calibrate::Table& table) {
    std::array<int, calibrate::origin_count> counts{};
    for (const calibrate::TableRow& row : table.rows)
        for (const calibrate::TableEntry& entry : row.entries) ++counts[static_cast<std::size_t>(entry.origin)];
    std::vector<std::string> origins;
    for (std::size_t i = 0; i < counts.size(); ++i)
        origins.push_back(text("{} {}", counts[i], static_cast<calibrate::Origin>(i)));
    return {line("coefficients", text("{}: {}", table.rows.size(), joined(origins))), text_of(table)};
}

Shown shown(const files::ArchiveReader& archive) {
    if (is_result(archive)) return {"", stored_text(archive)};
    if (run::is_start(archive))
        return {trajectory_text(archive, run::archived_scene(archive)) +
                    line("series", "none: other runs start from these frames, by packing.kind = \"file\""),
                ""};
    const run::Report report = run::make_report(archive);
    const bool has_trajectory = report.scene.kind == io::SceneKind::particles && io::has_trajectory(archive);
    const std::vector<std::size_t> frames = archive.has("/time") ? archive.shape("/time") : std::vector<std::size_t>{};
    return {has_trajectory ? trajectory_text(archive, report.scene) : frames_line(frames.empty() ? 0 : frames[0], {}),
            text_of(report)};
}

std::string archive_text(const std::filesystem::path& file, bool with_scene) {
    const files::ArchiveReader archive(file);
    const bool is_table = io::is_calibration(archive);
    const Shown found = is_table ? shown(io::read_calibration(archive, file)) : shown(archive);
    std::string out;
    for (const auto& [name, value] : archive.attributes())
        if (name != "scene" && !(is_table && (name == "remarks" || name == "coefficients")))
            out += line(printable(name), std::visit([](const auto& held) { return text("{}", held); }, value));
    if (run::is_unfinished(archive)) out += line("state", "not finished: the run has not reached its time.end");
    out += found.head;
    if (with_scene || !found.results.empty()) out += "\n";
    if (with_scene) out += archive.text_attribute("scene") + "\n";
    return out + found.results;
}

std::string xyz_text(const std::filesystem::path& file) {
    const io::XyzInfo info = io::read_xyz_info(file);
    std::string out =
        line("format", "extended XYZ") + frames_line(info.frames, info.times) +
        line("particles", info.min_lines == info.max_lines ? text("{}", info.max_lines)
                                                           : text("{} to {}", info.min_lines, info.max_lines));
    for (const auto& [name, value] : {std::pair{"lattice", info.lattice},
                                      {"origin", info.origin},
                                      {"pbc", info.periodic},
                                      {"properties", info.properties}})
        if (!value.empty()) out += line(name, value);
    return out;
}

/// The provenance of an archive.
nlohmann::json attributes_json(const files::ArchiveReader& archive) {
    nlohmann::json result = nlohmann::json::object();
    for (const auto& [name, value] : archive.attributes())
        std::visit([&](const auto& held) { result[name] = held; }, value);
    return result;
}

nlohmann::json arrays_json(const files::ArchiveReader& archive) {
    return mapped(arrays_by_path(archive), [&](const files::StoredArray& array) {
        return nlohmann::json{{"name", array.path},
                              {"unit", files::text_in(array.attributes, "units")},
                              {"meaning", files::text_in(array.attributes, "comment")},
                              {"shape", array.shape},
                              {"values", archive.read(array.path).values}};
    });
}

nlohmann::json xyz_json(const std::filesystem::path& file) {
    const io::XyzInfo info = io::read_xyz_info(file);
    return {{"frames", info.frames},           {"min_particles", info.min_lines},
            {"max_particles", info.max_lines}, {"lattice", info.lattice},
            {"origin", info.origin},           {"pbc", info.periodic},
            {"properties", info.properties},   {"times", info.times}};
}
}  // namespace

std::string info_text(const std::filesystem::path& file, bool with_scene) {
    return io::is_xyz(file) ? xyz_text(file) : archive_text(file, with_scene);
}

nlohmann::json info_json(const std::filesystem::path& file) {
    if (io::is_xyz(file)) return xyz_json(file);
    const files::ArchiveReader archive(file);
    if (io::is_calibration(archive))
        return {{"attributes", attributes_json(archive)},
                {"coefficients", json_of(io::read_calibration(archive, file.string()))}};
    if (is_result(archive)) return {{"attributes", attributes_json(archive)}, {"arrays", arrays_json(archive)}};
    nlohmann::json result = run::is_start(archive) ? nlohmann::json{{"results", nlohmann::json::object()}}
                                                   : json_of(run::make_report(archive));
    result["attributes"] = attributes_json(archive);
    result["is_finished"] = !run::is_unfinished(archive);
    return result;
}

}  // namespace drover::report
