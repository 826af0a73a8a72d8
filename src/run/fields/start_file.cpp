// run/fields/start_file.cpp: reads and checks a frame.
#include <algorithm>
#include <cmath>

#include "base/log.hpp"
#include "drover/base/threads.hpp"
#include "drover/numerics/transform.hpp"
#include "files/archive_reader.hpp"
#include "numerics/steppers/coarse_error.hpp"
#include "run/fields/field_problem.hpp"
#include "run/loop/scene_support.hpp"

namespace drover::run {

std::vector<double> cell_corners(int count, double side) {
    std::vector<double> result;
    for (int i = 0; i < count; ++i) result.push_back(side / count * i);
    return result;
}

namespace {
double variance_of(std::span<const double> values) {
    const auto count = static_cast<double>(values.size());
    double mean = 0.0, squares = 0.0;
    for (const double value : values) mean += value / count;
    for (const double value : values) squares += (value - mean) * (value - mean) / count;
    return squares;
}

/// The fields with the modes that both grids have.  degree: that decides which modes `to` keeps.
numerics::Fields resampled(const numerics::Fields& fields, const numerics::Grid& from, const numerics::Grid& to,
                           int degree) {
    Threads one(1);
    const numerics::Transform source(from, 1, one), target(to, degree, one);
    numerics::Spectra given(from, fields.count()), wanted(to, fields.count());
    source.forward(fields, given);
    const numerics::Grid common{.nx = std::min(from.nx, to.nx),
                                .ny = std::min(from.ny, to.ny),
                                .lx = to.lx,
                                .ly = to.ly};
    const std::vector<numerics::ModePair> at_source = numerics::shared_modes({common}, {from}),
                                          at_target = numerics::shared_modes({common}, {to});
    for (int c = 0; c < fields.count(); ++c)
        for (std::size_t k = 0; k < at_source.size(); ++k) wanted[c][at_target[k].fine] = given[c][at_source[k].fine];
    numerics::Fields result(to, fields.count());
    target.backward(wanted, result);
    return result;
}

/// Says that the fields of a frame are on other points, and what is lost.
void tell_resampled(const io::Scene& scene, const std::vector<files::Quantity>& names, const numerics::Grid& from,
                    const numerics::Fields& before, const numerics::Fields& after) {
    log_information("{}: {} by {} points; the fields are taken on {} by {} by their Fourier modes", scene.initial.file,
                    from.nx, from.ny, scene.grid.nx, scene.grid.ny);
    constexpr double much = 0.01;
    for (std::size_t c = 0; c < names.size(); ++c) {
        const double whole = variance_of(before[static_cast<int>(c)]);
        const double lost = 1.0 - variance_of(after[static_cast<int>(c)]) / whole;
        if (whole > 0.0 && lost > much)
            log_warning(
                "{}: {:.2g} % of the variance of {} is in waves that {} by {} points do not have, and is left out; "
                "choose more points to keep it",
                scene.initial.file, 100.0 * lost, names[c].name, scene.grid.nx, scene.grid.ny);
    }
}

/// The grid of a field of frames: any points in the cell of the scene.
numerics::Grid grid_of(const files::ArchiveReader& archive, const std::string& dataset, const io::Scene& scene) {
    const std::vector<std::size_t> shape = archive.shape(dataset);
    const auto points = [&](std::size_t axis) { return shape.size() == 3 ? static_cast<int>(shape[axis]) : 0; };
    numerics::Grid grid = scene.grid;
    grid.nx = points(2);
    grid.ny = points(1);
    require(grid.nx >= 1 && grid.ny >= 1 && archive.read("/x").values == cell_corners(grid.nx, grid.lx) &&
                archive.read("/y").values == cell_corners(grid.ny, grid.ly),
            io::locate(scene, "initial.file"),
            "initial.file = \"{}\" has another cell; expected one of {} by {} mm, with any number of points",
            scene.initial.file, scene.grid.lx, scene.grid.ly);
    const auto is_even = [](int count) { return count >= 4 && count % 2 == 0; };
    require(
        is_even(grid.nx) && (grid.ny == 1 || is_even(grid.ny)), io::locate(scene, "initial.file"),
        "initial.file = \"{}\" has {} by {} points; expected an archive of drover: even numbers of at least 4, or one "
        "row",
        scene.initial.file, grid.nx, grid.ny);
    return grid;
}

/// A frame of an archive as the state; its fields and cell must be those of the scene.
numerics::Fields frame_of(const files::ArchiveReader& archive, const io::Scene& scene,
                          const std::vector<files::Quantity>& names, int degree) {
    const SourceLocation here = io::locate(scene, "initial.file");
    for (const files::Quantity& field : names)
        require(archive.has("/" + field.name), here,
                "initial.file = \"{}\" has no field {}; expected an archive of this model", scene.initial.file,
                field.name);
    const numerics::Grid grid = grid_of(archive, "/" + names.front().name, scene);
    numerics::Fields frame(grid, static_cast<int>(names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) {
        const std::string dataset = "/" + names[c].name;
        require(archive.shape(dataset) == archive.shape("/" + names.front().name), here,
                "initial.file = \"{}\" has {} and {} on different points; expected fields of one run",
                scene.initial.file, names.front().name, names[c].name);
        const auto frames = static_cast<int>(archive.shape(dataset)[0]);
        require(scene.initial.frame < frames && frames >= 1, io::locate(scene, "initial.frame"),
                "initial.frame = {}; expected one of the frames 0 to {} of the archive, or -1 for the last",
                scene.initial.frame, frames - 1);
        const int number = scene.initial.frame < 0 ? frames - 1 : scene.initial.frame;
        const files::Array row = archive.read_row(dataset, static_cast<std::size_t>(number));
        require(std::ranges::all_of(row.values, [](double value) { return std::isfinite(value); }), here,
                "initial.file = \"{}\" has a {} that is not finite in frame {}; expected finite values: choose another "
                "frame",
                scene.initial.file, names[c].name, number);
        std::ranges::copy(row.values, frame[static_cast<int>(c)].begin());
    }
    for (const files::Quantity& field : names) {
        const std::string unit = archive.text_attribute("/" + field.name, "units"),
                          expected = io::renamed(field.unit, scene.units);
        require(unit == expected, here, "initial.file = \"{}\" has {} in {}; expected {}", scene.initial.file,
                field.name, unit, expected);
    }
    if (grid.nx == scene.grid.nx && grid.ny == scene.grid.ny) return frame;
    numerics::Fields result = resampled(frame, grid, scene.grid, degree);
    tell_resampled(scene, names, grid, frame, result);
    return result;
}
}  // namespace

numerics::Fields frame_of_file(const io::Scene& scene, const std::vector<files::Quantity>& fields, int degree) {
    const files::ArchiveReader archive = named_archive(scene, "initial.file", scene.initial.file);
    numerics::Fields frame = frame_of(archive, scene, fields, degree);
    const files::Attribute same{"seed", std::int64_t{scene.run.seed}};
    if (io::has_noise(scene) && std::ranges::count(archive.attributes(), same) > 0)
        log_warning(
            "initial.file = \"{}\" is of a run with the same run.seed = {}: with the same time.dt this run has the "
            "noise of that one again, and is no independent sample; choose another run.seed",
            scene.initial.file, scene.run.seed);
    return frame;
}

}  // namespace drover::run
