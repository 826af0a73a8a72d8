// app/export.cpp: drover export ARCHIVE: frames of particles as extended XYZ, of fields as VTK or CSV.
#include "io/export.hpp"
#include "app/command.hpp"
#include "run/loop/scene_support.hpp"

namespace drover::app {

namespace {
struct ExportOptions {
    std::string archive, output;
    io::FrameChoice frames;
    bool bodies = false, overwrite = false;
};

int export_frames(const ExportOptions& options) {
    run::require_folder_of({.path = options.output, .where = {}, .name = "--output " + options.output});
    const std::string ending = std::filesystem::path(options.output).extension().string();
    const bool is_of_fields = io::is_field_export(options.output);
    require(is_of_fields || ending == ".xyz" || ending == ".extxyz", {.file = options.output},
            "the name ends with \"{}\"; expected .xyz of particles, or .vtk or .csv of fields", ending);
    require(!is_of_fields || !options.bodies, {.file = options.output},
            "--bodies applies to particles, and a .vtk or .csv file holds fields; omit --bodies");
    const files::ArchiveReader archive(options.archive);
    if (is_of_fields) {
        const std::vector<std::filesystem::path> written =
            io::write_fields(archive, options.archive, options.frames, options.output, options.overwrite);
        const std::string first = written.front().string(), last = written.back().string();
        print(written.size() == 1 ? first + ": fields\n" : text("{} to {}: {} frames\n", first, last, written.size()));
        return run::exit_done;
    }
    const std::size_t frames =
        io::write_xyz(archive, options.archive, options.frames, options.bodies, options.output, options.overwrite);
    print(text("{}: {} frame{} of {}\n", options.output, frames, frames == 1 ? "" : "s",
               options.bodies ? "bodies" : "spheres"));
    return run::exit_done;
}
}  // namespace

void add_export(CLI::App& program, Action& action) {
    const auto options = std::make_shared<ExportOptions>();
    CLI::App* command = program.add_subcommand(
        "export", "Export frames for viewers: particles as extended XYZ, fields as VTK images or a CSV table");
    command->add_option("archive", options->archive, "Archive of a run")->required();
    command
        ->add_option("-o,--output", options->output,
                     "File to write: tapered.xyz of particles; flock.vtk (flock-0000.vtk, ... of several frames) or "
                     "flock.csv of fields")
        ->required();
    CLI::Option* frame = command->add_option("--frame", options->frames.frame, "Export only this frame, counted from 0")
                             ->check(CLI::Range(std::int64_t{0}, std::int64_t{1000000000000}));
    command->add_option("--every", options->frames.every, "Export every k-th frame, starting with the first")
        ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000000000}))
        ->excludes(frame);
    command->add_flag("--bodies", options->bodies,
                      "Of particles: write one line per body, with its direction, instead of one per sphere");
    command->add_flag("--overwrite", options->overwrite, "Replace an existing file");
    when_chosen(*command, action, options, export_frames);
}

}  // namespace drover::app
