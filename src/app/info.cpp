// app/info.cpp: drover info ARCHIVE.
#include <algorithm>
#include <array>
#include <cstdio>
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

constexpr const char* frames_path = "/time";

std::string times_text(double first, double last) { return text("t = {:.6g} to {:.6g} s", first, last); }

/// Trajectory of a particle archive.
void print_trajectory(const files::ArchiveReader& archive, const io::Scene& scene) {
    const std::string spheres = io::spheres_group;
    const std::vector<double> times = archive.read(spheres + "/position/time").values;
    const io::Box box = io::box_of(scene.particles);
    std::printf("%-20s %zu%s\n", "frames", times.size(),
                times.empty() ? "" : (", " + times_text(times.front(), times.back())).c_str());
    std::printf("%-20s %zu\n", "spheres", archive.shape(spheres + "/position/value").at(1));
    for (const auto& [name, group] : {std::pair{"beads", io::beads_group}, {"rods", io::rods_group}})
        if (const std::string path = std::string(group) + "/position/value"; archive.has(path))
            std::printf("%-20s %zu\n", name, archive.shape(path).at(1));
    std::printf("%-20s %s: %g by %g by %g mm\n", "cell", scene.particles.cell.shape.c_str(), box.sides[0], box.sides[1],
                box.sides[2]);
    std::printf("%-20s %s (H5MD), /bodies%s\n", "groups", io::spheres_group,
                run::is_start(archive) ? "" : (std::string(", ") + io::series_group).c_str());
}

void print_attribute(const std::string& name, const decltype(files::Attribute::second)& value) {
    const std::string written = std::visit([](const auto& held) { return text("{}", held); }, value);
    std::printf("%-20s %s\n", printable(name).c_str(), printable(written).c_str());
}

void print_attributes(const files::ArchiveReader& archive, const std::vector<std::string>& without = {"scene"}) {
    for (const auto& [name, value] : archive.attributes())
        if (std::ranges::find(without, name) == without.end()) print_attribute(name, value);
}

/// The scene, where it is asked for, and what an archive says.
void print_content(const files::ArchiveReader& archive, bool scene, const std::string& content) {
    std::printf("\n");
    if (scene) std::printf("%s\n", printable(archive.text_attribute("scene")).c_str());
    std::fputs(printable(content).c_str(), stdout);
}

/// Frames of particles that other runs start from.
void print_start(const files::ArchiveReader& archive, bool scene) {
    print_attributes(archive);
    print_trajectory(archive, run::archived_scene(archive));
    std::printf("%-20s none: other runs start from these frames, by packing.kind = \"file\"\n", "series");
    if (scene) std::printf("\n%s\n", printable(archive.text_attribute("scene")).c_str());
}

void print_report(const files::ArchiveReader& archive, const run::Report& report, bool scene) {
    print_attributes(archive);
    if (report.scene.kind == io::SceneKind::particles && io::has_trajectory(archive)) {
        print_trajectory(archive, report.scene);
    } else {
        const std::vector<std::size_t> frames =
            archive.has(frames_path) ? archive.shape(frames_path) : std::vector<std::size_t>{};
        std::printf("%-20s %zu\n", "frames", frames.empty() ? std::size_t{0} : frames.front());
    }
    print_content(archive, scene, run::report_text(report));
}

/// Provenance and contents of a table of coefficients.
void print_calibration(const files::ArchiveReader& archive, const InfoOptions& options) {
    const calibrate::Table table = io::read_calibration(archive, options.archive);
    print_attributes(archive, {"scene", "remarks", "coefficients"});
    std::array<std::size_t, calibrate::origin_count> origins{};
    for (const calibrate::TableRow& row : table.rows)
        for (const calibrate::TableEntry& known : row.entries) ++origins[static_cast<std::size_t>(known.origin)];
    std::printf("%-20s %zu:", "coefficients", table.rows.size());
    for (std::size_t i = 0; i < origins.size(); ++i)
        std::printf("%s %zu %s", i == 0 ? "" : ",", origins[i],
                    calibrate::origin_name(static_cast<calibrate::Origin>(i)));
    std::printf("\n");
    print_content(archive, options.scene, jobs::calibration_text(table));
}

/// Of drover stability, states or boundary.
void print_result_archive(const files::ArchiveReader& archive, bool scene) {
    print_attributes(archive);
    print_content(archive, scene, report::stored_text(archive));
}

void print_xyz(const std::string& file) {
    const io::XyzInfo info = io::read_xyz_info(file);
    const auto line = [](const char* name, const std::string& value) {
        if (!value.empty()) std::printf("%-20s %s\n", name, printable(value).c_str());
    };
    line("format", "extended XYZ");
    line("frames",
         text("{}{}", info.frames, info.times.empty() ? "" : ", " + times_text(info.times.front(), info.times.back())));
    line("particles", info.min_lines == info.max_lines ? text("{}", info.max_lines)
                                                       : text("{} to {}", info.min_lines, info.max_lines));
    line("lattice", info.lattice);
    line("origin", info.origin);
    line("pbc", info.periodic);
    line("properties", info.properties);
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
            if (options->json) {
                print_json(report::info_json(options->archive));
                return run::exit_done;
            }
            if (io::is_xyz(options->archive)) {
                print_xyz(options->archive);
                return run::exit_done;
            }
            const files::ArchiveReader archive(options->archive);
            if (io::is_calibration(archive)) {
                print_calibration(archive, *options);
                return run::exit_done;
            }
            if (report::is_result(archive)) print_result_archive(archive, options->scene);
            else if (run::is_start(archive)) print_start(archive, options->scene);
            else print_report(archive, run::make_report(archive), options->scene);
            return run::exit_done;
        };
    });
}

}  // namespace drover::app
