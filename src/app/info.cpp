// app/info.cpp: drover info ARCHIVE.
#include <array>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/command.hpp"
#include "io/calibration.hpp"
#include "io/export.hpp"
#include "io/trajectory.hpp"
#include "jobs/calibration.hpp"
#include "report/json.hpp"
#include "report/write_result.hpp"
#include "run/simulation_type.hpp"

namespace drover::app {

namespace {
struct InfoOptions {
    std::string archive;
    bool json = false, scene = false;
};

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
        origins.push_back(text("{} {}", counts[i], calibrate::origin_name(static_cast<calibrate::Origin>(i))));
    return {line("coefficients", text("{}: {}", table.rows.size(), joined(origins))), jobs::calibration_text(table)};
}

Shown shown(const files::ArchiveReader& archive) {
    if (report::is_result(archive)) return {"", report::stored_text(archive)};
    if (run::is_start(archive))
        return {trajectory_text(archive, run::archived_scene(archive)) +
                    line("series", "none: other runs start from these frames, by packing.kind = \"file\""),
                ""};
    const run::Report report = run::make_report(archive);
    const bool has_trajectory = report.scene.kind == io::SceneKind::particles && io::has_trajectory(archive);
    const std::vector<std::size_t> frames = archive.has("/time") ? archive.shape("/time") : std::vector<std::size_t>{};
    return {has_trajectory ? trajectory_text(archive, report.scene) : frames_line(frames.empty() ? 0 : frames[0], {}),
            run::report_text(report)};
}

std::string archive_text(const InfoOptions& options) {
    const files::ArchiveReader archive(options.archive);
    const bool is_table = io::is_calibration(archive);
    const Shown found = is_table ? shown(io::read_calibration(archive, options.archive)) : shown(archive);
    std::string out;
    for (const auto& [name, value] : archive.attributes())
        if (name != "scene" && !(is_table && (name == "remarks" || name == "coefficients")))
            out += line(printable(name), std::visit([](const auto& held) { return text("{}", held); }, value));
    out += found.head;
    if (options.scene || !found.results.empty()) out += "\n";
    if (options.scene) out += archive.text_attribute("scene") + "\n";
    return out + found.results;
}

std::string xyz_text(const std::string& file) {
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
}  // namespace

void add_info(CLI::App& program, Action& action) {
    const auto options = std::make_shared<InfoOptions>();
    CLI::App* command = program.add_subcommand(
        "info", "Provenance and results of an archive or a table of coefficients; contents of an XYZ file");
    command->add_option("archive", options->archive, "Archive, such as isotropic.h5")->required();
    command->add_flag("--scene", options->scene, "Print the scene too, every key with its value");
    command->add_flag("--json", options->json, "Print as JSON");
    command->callback([options, &action] {
        action = [options] {
            if (options->json) print_json(report::info_json(options->archive));
            else print(io::is_xyz(options->archive) ? xyz_text(options->archive) : archive_text(*options));
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
