// run/start_file.cpp: reads and checks a frame.
#include "run/start_file.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "drover/files/archive_reader.hpp"
#include "drover/run/scene_support.hpp"

namespace drover::run {

std::vector<double> cell_corners(int count, double side) {
    std::vector<double> result;
    for (int i = 0; i < count; ++i) result.push_back(side / count * i);
    return result;
}

namespace {
/// A frame of an archive as the state; its fields, grid and cell must be those of the scene.
numerics::Fields frame_of(const files::ArchiveReader& archive, const io::Scene& scene,
                          const std::vector<FrameField>& names) {
    const SourceLocation here = io::location_of(scene, "initial.file");
    numerics::Fields frame(scene.grid, static_cast<int>(names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string dataset = "/" + names[c].name;
        require(archive.has(dataset), here, "initial.file = \"{}\" has no field {}; expected an archive of this model",
                scene.initial.file, names[c].name);
        const std::vector<std::size_t> shape = archive.shape(dataset);
        require(shape.size() == 3 && shape[1] == static_cast<std::size_t>(scene.grid.ny) &&
                    shape[2] == static_cast<std::size_t>(scene.grid.nx) &&
                    archive.read("/x").values == cell_corners(scene.grid.nx, scene.grid.lx) &&
                    archive.read("/y").values == cell_corners(scene.grid.ny, scene.grid.ly),
                here, "initial.file = \"{}\" has another grid or cell; expected {} by {} points on {} by {} mm",
                scene.initial.file, scene.grid.nx, scene.grid.ny, scene.grid.lx, scene.grid.ly);
        const auto frames = static_cast<int>(shape[0]);
        require(scene.initial.frame < frames && frames >= 1, io::location_of(scene, "initial.frame"),
                "initial.frame = {}; expected one of the frames 0 to {} of the archive, or -1 for the last",
                scene.initial.frame, frames - 1);
        const int number = scene.initial.frame < 0 ? frames - 1 : scene.initial.frame;
        const files::Array row = archive.read_row(dataset, static_cast<std::size_t>(number));
        require(std::all_of(row.values.begin(), row.values.end(), [](double value) { return std::isfinite(value); }),
                here,
                "initial.file = \"{}\" has a {} that is not finite in frame {}; expected finite values: choose another "
                "frame",
                scene.initial.file, names[c].name, number);
        std::copy(row.values.begin(), row.values.end(), frame[static_cast<int>(c)].begin());
    }
    for (const FrameField& field : names) {
        const std::string unit = archive.text_attribute("/" + field.name, "units");
        require(unit == field.unit, here, "initial.file = \"{}\" has {} in {}; expected {}", scene.initial.file,
                field.name, unit, field.unit);
    }
    return frame;
}
}  // namespace

numerics::Fields frame_of_file(const io::Scene& scene, const std::vector<FrameField>& fields) {
    std::optional<files::ArchiveReader> archive;
    try {
        archive.emplace(file_beside(scene, scene.initial.file));
    } catch (const Error& error) {
        throw Error(error.fault(), io::location_of(scene, "initial.file"), text("initial.file: {}", error.what()));
    }
    return frame_of(*archive, scene, fields);
}

}  // namespace drover::run
